/* viewer/team.h: threads that share a loop over rows of pixels. */
#ifndef VIEWER_TEAM_H
#define VIEWER_TEAM_H

#include <stddef.h>

struct view_team;

/* The caller is one of the threads. */
struct view_team *view_team_create(int threads);
void view_team_destroy(struct view_team *team);
/* body is called with pieces [begin, end) of [0, count), of at most `grain`, from all threads. */
void view_team_run(struct view_team *team, size_t count, size_t grain,
                   void (*body)(void *user, size_t begin, size_t end), void *user);

#endif
