/* viewer/team.c: threads that share a loop. They sleep between loops; who is free takes the next
 * piece. */
#include "team.h"

#include <glib.h>
#include <stdatomic.h>

struct view_team {
    GThread **threads;
    int thread_count;
    GMutex mutex;
    GCond start, done;
    unsigned round; /* of the loop under way */
    int busy;
    gboolean quit;
    size_t count, grain;
    atomic_size_t next;
    void (*body)(void *user, size_t begin, size_t end);
    void *user;
};

static void take_pieces(struct view_team *team)
{
    for (;;) {
        size_t begin = atomic_fetch_add(&team->next, team->grain);
        if (begin >= team->count)
            return;
        team->body(team->user, begin, MIN(begin + team->grain, team->count));
    }
}

static gpointer member(gpointer data)
{
    struct view_team *team = data;
    unsigned seen = 0;
    g_mutex_lock(&team->mutex);
    for (;;) {
        while (team->round == seen && !team->quit)
            g_cond_wait(&team->start, &team->mutex);
        if (team->quit)
            break;
        seen = team->round;
        g_mutex_unlock(&team->mutex);
        take_pieces(team);
        g_mutex_lock(&team->mutex);
        if (--team->busy == 0)
            g_cond_signal(&team->done);
    }
    g_mutex_unlock(&team->mutex);
    return NULL;
}

struct view_team *view_team_create(int threads)
{
    struct view_team *team = g_new0(struct view_team, 1);
    g_mutex_init(&team->mutex);
    g_cond_init(&team->start);
    g_cond_init(&team->done);
    team->thread_count = MAX(threads - 1, 0);
    team->threads = g_new0(GThread *, (gsize)team->thread_count + 1);
    for (int i = 0; i < team->thread_count; i++)
        team->threads[i] = g_thread_new("shade", member, team);
    return team;
}

void view_team_destroy(struct view_team *team)
{
    if (!team)
        return;
    g_mutex_lock(&team->mutex);
    team->quit = TRUE;
    g_cond_broadcast(&team->start);
    g_mutex_unlock(&team->mutex);
    for (int i = 0; i < team->thread_count; i++)
        g_thread_join(team->threads[i]);
    g_mutex_clear(&team->mutex);
    g_cond_clear(&team->start);
    g_cond_clear(&team->done);
    g_free(team->threads);
    g_free(team);
}

void view_team_run(struct view_team *team, size_t count, size_t grain,
                   void (*body)(void *user, size_t begin, size_t end), void *user)
{
    team->count = count;
    team->grain = grain;
    team->body = body;
    team->user = user;
    atomic_store(&team->next, 0);
    if (team->thread_count > 0 && count > grain) {
        g_mutex_lock(&team->mutex);
        team->round++;
        team->busy = team->thread_count;
        g_cond_broadcast(&team->start);
        g_mutex_unlock(&team->mutex);
        take_pieces(team);
        g_mutex_lock(&team->mutex);
        while (team->busy > 0)
            g_cond_wait(&team->done, &team->mutex);
        g_mutex_unlock(&team->mutex);
    } else {
        take_pieces(team);
    }
}
