/* viewer/worker.c: the thread's mailbox: commands and states in, events out.
 *
 * A state is work in steps (engine.h): while something moves one frame, at rest a rough frame if
 * the whole one will take long, the whole one, then ever better truths. Between steps the mailbox
 * is looked at; within one, the library's progress callback asks whether to go on: steps at rest
 * are given up for anything newer, frames of a movement never (else a slow method would show none).
 */
#include "worker.h"

#include "engine.h"

#define PROGRESS_AFTER_US 300000
#define PROGRESS_EVERY_US 80000

enum command_type {
    COMMAND_OPEN,
    COMMAND_SAVE,
    COMMAND_SCREENSHOT,
    COMMAND_DRAWN, /* this one and the next are news, not work: they end no step */
    COMMAND_GIVEN
};

struct command {
    enum command_type type;
    char *path;
    char **lights;
    struct view_frame *frame;
    double divider;
    bool shown;
    struct view_drawn drawn;
    int side;
};

struct view_worker {
    int references; /* the owner's, and one per event on its way */
    struct view_worker_events events;
    bool dead; /* main thread: no more events */
    GThread *thread;
    int threads;

    GMutex mutex;
    GCond cond;
    GQueue commands;
    struct view_state *wanted; /* NULL: none that is new */
    struct view_frame *front;  /* on its way to the window */
    char stage[64];
    double fraction;
    bool progress_pending;

    int quit, stop, newer; /* atomic */

    /* of the thread */
    struct view_engine *engine;
    bool yielding; /* the step under way may be given up for newer work */
    int64_t step_us, told_us;
    bool told; /* the window shows progress */
    uint64_t next_scene;
};

static void worker_unref(struct view_worker *worker)
{
    if (!g_atomic_int_dec_and_test(&worker->references))
        return;
    g_mutex_clear(&worker->mutex);
    g_cond_clear(&worker->cond);
    g_free(worker);
}

/* ---- events ---- */

enum event_type { EVENT_SCENE, EVENT_FRAME, EVENT_PROGRESS, EVENT_FAILED, EVENT_SAVED, EVENT_REST };

struct event {
    enum event_type type;
    struct view_worker *worker;
    struct view_scene *scene;
    char *text;
    uint64_t serial;
    bool flag;
};

static void deliver_frame(struct view_worker *worker)
{
    g_mutex_lock(&worker->mutex);
    struct view_frame *frame = worker->front;
    worker->front = NULL;
    g_mutex_unlock(&worker->mutex);
    if (frame && !worker->dead)
        worker->events.frame(worker->events.user, frame);
    view_frame_unref(frame);
}

static void deliver_progress(struct view_worker *worker, bool active)
{
    char stage[64];
    g_mutex_lock(&worker->mutex);
    double fraction = worker->fraction;
    g_strlcpy(stage, worker->stage, sizeof(stage));
    worker->progress_pending = false;
    g_mutex_unlock(&worker->mutex);
    if (!worker->dead)
        worker->events.progress(worker->events.user, active ? stage : NULL, fraction);
}

static gboolean deliver(gpointer data)
{
    struct event *event = data;
    struct view_worker *worker = event->worker;
    const struct view_worker_events *events = &worker->events;
    if (event->type == EVENT_FRAME)
        deliver_frame(worker);
    else if (event->type == EVENT_PROGRESS)
        deliver_progress(worker, event->flag);
    else if (worker->dead)
        ;
    else if (event->type == EVENT_SCENE)
        events->scene(events->user, event->scene);
    else if (event->type == EVENT_FAILED)
        events->failed(events->user, event->text);
    else if (event->type == EVENT_SAVED)
        events->saved(events->user, event->text);
    else if (event->type == EVENT_REST)
        events->rest(events->user, event->serial, event->flag);
    view_scene_unref(event->scene);
    g_free(event->text);
    worker_unref(worker);
    g_free(event);
    return G_SOURCE_REMOVE;
}

static void send_event(struct view_worker *worker, struct event event)
{
    event.worker = worker;
    g_atomic_int_inc(&worker->references);
    g_idle_add_full(G_PRIORITY_DEFAULT, deliver, g_memdup2(&event, sizeof(event)), NULL);
}

static void send_frame(struct view_worker *worker, struct view_frame *frame)
{
    g_mutex_lock(&worker->mutex);
    struct view_frame *old = worker->front;
    worker->front = frame;
    g_mutex_unlock(&worker->mutex);
    if (old)
        view_frame_unref(old);
    else
        send_event(worker, (struct event){.type = EVENT_FRAME});
}

static void end_progress(struct view_worker *worker)
{
    if (worker->told)
        send_event(worker, (struct event){.type = EVENT_PROGRESS, .flag = false});
    worker->told = false;
}

/* The library's progress callback. */
static bool on_progress(void *user, const char *stage, double fraction)
{
    struct view_worker *worker = user;
    if (g_atomic_int_get(&worker->quit) || g_atomic_int_get(&worker->stop))
        return false;
    if (worker->yielding && g_atomic_int_get(&worker->newer))
        return false;
    int64_t now = g_get_monotonic_time();
    if (now - worker->step_us < PROGRESS_AFTER_US || now - worker->told_us < PROGRESS_EVERY_US)
        return true;
    g_mutex_lock(&worker->mutex);
    const char *label = worker->engine ? view_engine_label(worker->engine) : NULL;
    g_strlcpy(worker->stage, label ? label : stage, sizeof(worker->stage));
    worker->fraction = fraction;
    bool pending = worker->progress_pending;
    worker->progress_pending = true;
    g_mutex_unlock(&worker->mutex);
    if (!pending)
        send_event(worker, (struct event){.type = EVENT_PROGRESS, .flag = true});
    worker->told = true;
    worker->told_us = now;
    return true;
}

/* ---- commands ---- */

static void free_command(struct command *command)
{
    view_frame_unref(command->frame);
    g_strfreev(command->lights);
    g_free(command->path);
    g_free(command);
}

static void run_command(struct view_worker *worker, struct command *command)
{
    struct view_engine *engine = worker->engine;
    struct view_scene *scene = NULL;
    bool good = false;
    if (command->type == COMMAND_DRAWN || command->type == COMMAND_GIVEN) {
        const struct view_frame *frame = command->frame;
        if (command->type == COMMAND_DRAWN)
            view_engine_drawn(engine, &command->drawn);
        else
            view_engine_given(engine, frame->content, command->side,
                              frame->visibility[command->side],
                              (size_t)frame->width * (size_t)frame->height);
        free_command(command);
        return;
    }
    worker->yielding = false;
    worker->step_us = g_get_monotonic_time();
    switch (command->type) {
    case COMMAND_OPEN:
        good =
            view_engine_open(engine, command->path, command->lights, ++worker->next_scene, &scene);
        if (good)
            send_event(worker, (struct event){.type = EVENT_SCENE, .scene = scene});
        break;
    case COMMAND_SAVE: good = view_engine_save(engine, command->path); break;
    case COMMAND_DRAWN:
    case COMMAND_GIVEN: break;
    case COMMAND_SCREENSHOT:
        good = view_engine_screenshot(engine, command->frame, command->divider, command->shown,
                                      command->path);
        break;
    }
    end_progress(worker);
    if (!good)
        send_event(worker,
                   (struct event){.type = EVENT_FAILED,
                                  .text = g_utf8_make_valid(view_engine_error(engine), -1)});
    else if (command->type != COMMAND_OPEN)
        send_event(worker, (struct event){.type = EVENT_SAVED, .text = g_strdup(command->path)});
    free_command(command);
}

/* ---- the thread ---- */

static void run_step(struct view_worker *worker)
{
    struct view_frame *frame = NULL;
    worker->step_us = g_get_monotonic_time();
    worker->yielding = view_engine_yields(worker->engine);
    bool good = view_engine_step(worker->engine, &frame);
    end_progress(worker);
    if (frame)
        send_frame(worker, frame);
    if (!good)
        send_event(worker, (struct event){
                               .type = EVENT_FAILED,
                               .text = g_utf8_make_valid(view_engine_error(worker->engine), -1)});
    /* A request to stop that met nothing to stop ends what would follow. */
    bool stopped = g_atomic_int_get(&worker->stop) != 0;
    if (stopped)
        view_engine_give_up(worker->engine);
    if (!view_engine_busy(worker->engine))
        send_event(worker, (struct event){.type = EVENT_REST,
                                          .serial = view_engine_serial(worker->engine),
                                          .flag = stopped});
}

static gpointer thread_main(gpointer data)
{
    struct view_worker *worker = data;
    worker->engine = view_engine_create(worker->threads, on_progress, worker);
    g_mutex_lock(&worker->mutex);
    while (!g_atomic_int_get(&worker->quit)) {
        struct command *command = g_queue_pop_head(&worker->commands);
        struct view_state *state = NULL;
        if (!command) {
            state = worker->wanted;
            worker->wanted = NULL;
        }
        bool work = worker->engine && view_engine_busy(worker->engine) &&
                    !view_engine_waits(worker->engine);
        if (!command && !state && !work) {
            g_cond_wait(&worker->cond, &worker->mutex);
            continue;
        }
        if (!command)
            g_atomic_int_set(&worker->newer, 0);
        bool news = command && command->type >= COMMAND_DRAWN;
        if ((command && !news) || state)
            g_atomic_int_set(&worker->stop, 0);
        g_mutex_unlock(&worker->mutex);

        if (!worker->engine) {
            if (command)
                free_command(command);
            send_event(worker,
                       (struct event){.type = EVENT_FAILED, .text = g_strdup("memory: none left")});
        } else if (command) {
            run_command(worker, command);
        } else {
            if (state)
                view_engine_want(worker->engine, state);
            run_step(worker);
        }
        if (state) {
            view_state_finish(state);
            g_free(state);
        }
        g_mutex_lock(&worker->mutex);
    }
    g_mutex_unlock(&worker->mutex);
    view_engine_destroy(worker->engine);
    return NULL;
}

struct view_worker *view_worker_create(int threads, const struct view_worker_events *events)
{
    struct view_worker *worker = g_new0(struct view_worker, 1);
    worker->references = 1;
    worker->events = *events;
    worker->threads = threads;
    g_mutex_init(&worker->mutex);
    g_cond_init(&worker->cond);
    g_queue_init(&worker->commands);
    worker->thread = g_thread_new("worker", thread_main, worker);
    return worker;
}

void view_worker_destroy(struct view_worker *worker)
{
    if (!worker)
        return;
    g_atomic_int_set(&worker->quit, 1);
    g_mutex_lock(&worker->mutex);
    g_cond_signal(&worker->cond);
    g_mutex_unlock(&worker->mutex);
    g_thread_join(worker->thread);
    worker->dead = true;
    for (struct command *c; (c = g_queue_pop_head(&worker->commands));)
        free_command(c);
    if (worker->wanted)
        view_state_finish(worker->wanted);
    g_free(worker->wanted);
    worker->wanted = NULL;
    worker_unref(worker);
}

static void push(struct view_worker *worker, struct command command)
{
    g_mutex_lock(&worker->mutex);
    g_queue_push_tail(&worker->commands, g_memdup2(&command, sizeof(command)));
    if (command.type < COMMAND_DRAWN)
        g_atomic_int_set(&worker->newer, 1);
    g_cond_signal(&worker->cond);
    g_mutex_unlock(&worker->mutex);
}

void view_worker_open(struct view_worker *worker, const char *path, const char *const *lights)
{
    push(worker, (struct command){.type = COMMAND_OPEN,
                                  .path = g_strdup(path),
                                  .lights = g_strdupv((char **)lights)});
}

void view_worker_save(struct view_worker *worker, const char *path)
{
    push(worker, (struct command){.type = COMMAND_SAVE, .path = g_strdup(path)});
}

void view_worker_screenshot(struct view_worker *worker, struct view_frame *frame, double divider,
                            bool shown, const char *path)
{
    push(worker, (struct command){.type = COMMAND_SCREENSHOT,
                                  .path = g_strdup(path),
                                  .frame = view_frame_ref(frame),
                                  .divider = divider,
                                  .shown = shown});
}

void view_worker_drawn(struct view_worker *worker, const struct view_drawn *drawn)
{
    push(worker, (struct command){.type = COMMAND_DRAWN, .drawn = *drawn});
}

void view_worker_given(struct view_worker *worker, struct view_frame *frame, int side)
{
    push(worker,
         (struct command){.type = COMMAND_GIVEN, .frame = view_frame_ref(frame), .side = side});
}

void view_worker_show(struct view_worker *worker, const struct view_state *state)
{
    struct view_state *copy = g_new(struct view_state, 1), *old;
    view_state_copy(copy, state);
    g_mutex_lock(&worker->mutex);
    old = worker->wanted;
    worker->wanted = copy;
    g_atomic_int_set(&worker->newer, 1);
    g_cond_signal(&worker->cond);
    g_mutex_unlock(&worker->mutex);
    if (old)
        view_state_finish(old);
    g_free(old);
}

void view_worker_stop(struct view_worker *worker)
{
    g_atomic_int_set(&worker->stop, 1);
}
