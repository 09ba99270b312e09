/* viewer/history.c: undo and redo of what a hand does to lights and objects.
 *
 * An entry is all lights and placements as they were at rest, so that going to one needs no inverse
 * of what was done: a drag, a burst of a spin button, an animation from its start to its pause are
 * one entry each. The camera and how things are shown are not part of it. At most ENTRIES_MAX, the
 * oldest is forgotten first; an entry is 96 bytes an object and some 250 a light.
 */
#include "history.h"

#include <string.h>

enum { ENTRIES_MAX = 200 };

struct entry {
    struct view_light *lights;
    size_t light_count, light; /* light: the one shown */
    double (*placements)[12];
    size_t object_count;
};

struct view_history {
    GPtrArray *entries;
    guint now; /* the entry that is the state at rest */
};

static void free_entry(gpointer data)
{
    struct entry *entry = data;
    for (size_t i = 0; i < entry->light_count; i++)
        view_light_finish(&entry->lights[i]);
    g_free(entry->lights);
    g_free(entry->placements);
    g_free(entry);
}

static struct view_light *copy_lights(const struct view_light *from, size_t count)
{
    struct view_light *lights = g_new0(struct view_light, count + 1);
    for (size_t i = 0; i < count; i++)
        view_light_copy(&lights[i], &from[i].light);
    return lights;
}

static struct entry *entry_of(const struct view_state *state)
{
    struct entry *entry = g_new0(struct entry, 1);
    entry->lights = copy_lights(state->lights, state->light_count);
    entry->light_count = state->light_count;
    entry->light = state->light;
    entry->placements =
        g_memdup2(state->placements, state->object_count * sizeof(*state->placements));
    entry->object_count = state->object_count;
    return entry;
}

static bool same(const struct entry *entry, const struct view_state *state)
{
    bool same =
        entry->light_count == state->light_count && entry->object_count == state->object_count &&
        (entry->object_count == 0 || memcmp(entry->placements, state->placements,
                                            entry->object_count * sizeof(*entry->placements)) == 0);
    for (size_t i = 0; same && i < entry->light_count; i++)
        same = view_light_equal(&entry->lights[i].light, &state->lights[i].light);
    return same;
}

struct view_history *view_history_create(void)
{
    struct view_history *history = g_new0(struct view_history, 1);
    history->entries = g_ptr_array_new_with_free_func(free_entry);
    return history;
}

void view_history_destroy(struct view_history *history)
{
    if (!history)
        return;
    g_ptr_array_free(history->entries, TRUE);
    g_free(history);
}

void view_history_enter(struct view_history *history, const struct view_state *state)
{
    g_ptr_array_set_size(history->entries, 0);
    g_ptr_array_add(history->entries, entry_of(state));
    history->now = 0;
}

void view_history_note(struct view_history *history, const struct view_state *state)
{
    GPtrArray *entries = history->entries;
    if (entries->len == 0 || same(g_ptr_array_index(entries, history->now), state))
        return;
    g_ptr_array_set_size(entries, (gint)history->now + 1);
    g_ptr_array_add(entries, entry_of(state));
    if (entries->len > ENTRIES_MAX)
        g_ptr_array_remove_index(entries, 0);
    history->now = entries->len - 1;
}

bool view_history_can(const struct view_history *history, int by)
{
    return by < 0 ? history->now > 0 : history->now + 1 < history->entries->len;
}

bool view_history_go(struct view_history *history, int by, struct view_state *state)
{
    if (!view_history_can(history, by))
        return false;
    history->now = by < 0 ? history->now - 1 : history->now + 1;
    const struct entry *entry = g_ptr_array_index(history->entries, history->now);
    for (size_t i = 0; i < state->light_count; i++)
        view_light_finish(&state->lights[i]);
    g_free(state->lights);
    state->lights = copy_lights(entry->lights, entry->light_count);
    state->light_count = entry->light_count;
    state->light = MIN(entry->light, entry->light_count ? entry->light_count - 1 : 0);
    memcpy(state->placements, entry->placements, entry->object_count * sizeof(*entry->placements));
    return true;
}
