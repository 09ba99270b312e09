/* viewer/history.h: undo and redo of what a hand does to lights and objects. */
#ifndef VIEWER_HISTORY_H
#define VIEWER_HISTORY_H

#include "state.h"

struct view_history;

struct view_history *view_history_create(void);
void view_history_destroy(struct view_history *history);

/* Of another scene: nothing to undo. */
void view_history_enter(struct view_history *history, const struct view_state *state);
/* The state at rest: a new entry if its lights or objects differ from the last one's. What had been
 * undone is forgotten then. */
void view_history_note(struct view_history *history, const struct view_state *state);
/* One entry back (by = -1) or forth (1): lights and placements of the state. False: there is none.
 */
bool view_history_go(struct view_history *history, int by, struct view_state *state);
bool view_history_can(const struct view_history *history, int by);

#endif
