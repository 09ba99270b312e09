/* viewer/actions.h: everything that a button, a menu or a key does, as named actions. */
#ifndef VIEWER_ACTIONS_H
#define VIEWER_ACTIONS_H

#include "app.h"

/* Actions and keys for the window; buttons and menus for its header bar. */
void view_actions_install(struct view_app *app, GtkWidget *header, GtkWidget *side);
/* Brings toggles up to date with the state. */
void view_actions_refresh(struct view_app *app);

#endif
