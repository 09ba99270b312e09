/* bench/bench_reference.c: 'penumbra bench reference': what the truth costs.
 *
 * Printed as ratios from one run, so that they mean the same on every machine:
 *   throughput  rays a second of the method's frame, over a bare Embree loop tracing the same rays
 *               (made beforehand, only the tracing calls timed, same threads), both by processor
 *               time; at least 0.9
 *   packets     the same rays in other forms, one thread; the method's form is the first row
 *   memory      peak of a process that loads spheres-9x9x9 (554k triangles) and renders it 800x600
 *               with 64 samples; at most 1.5 GB
 *   loading     a file of some 100k triangles over one 64-sample 800x600 frame of it; below 1
 * Best of ROUNDS runs each, alternating, because machines are rarely idle.
 */
#define _GNU_SOURCE
#include <embree3/rtcore.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "method/reference/reference.h"

#define ROUNDS 3
#define CHUNK  64 /* packets of a receiver that are traced in one go */

struct setting {
    pnb_context *context;
    pnb_scene *scene;
    pnb_surface *surface;
    pnb_solver *solver;
    pnb_receivers receivers;
    pnb_light light;
    float *visibility;
};

static int threads;
static bool as_json;

static void die(pnb_context *context)
{
    fprintf(stderr, "penumbra: error: %s\n", context ? pnb_context_error(context) : "no context");
    exit(1);
}

/* Processor time, so that what else the machine does stays out of the ratios. */
static double cpu_ms(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static void setting_init(struct setting *s, const char *path, int width, int height, int samples,
                         int thread_count)
{
    memset(s, 0, sizeof(*s));
    if (pnb_context_create(&(pnb_context_desc){.threads = thread_count}, &s->context) != PNB_OK)
        die(NULL);
    pnb_solver_desc desc = {.method = "reference", .samples = samples};
    if (pnb_scene_load(s->context, path, &s->scene) != PNB_OK ||
        pnb_surface_create(s->context, s->scene, NULL, width, height, &s->surface) != PNB_OK ||
        pnb_solver_create(s->context, s->scene, &desc, &s->solver) != PNB_OK)
        die(s->context);
    pnb_surface_receivers(s->surface, &s->receivers);
    pnb_scene_light(s->scene, 0, &s->light);
    s->visibility = malloc(s->receivers.count * sizeof(float));
    if (!s->visibility)
        exit(1);
}

static void setting_finish(struct setting *s)
{
    free(s->visibility);
    pnb_solver_destroy(s->solver);
    pnb_surface_destroy(s->surface);
    pnb_scene_destroy(s->scene);
    pnb_context_destroy(s->context);
}

/* Wall-clock milliseconds of one frame; its rays per millisecond of processor time. */
static double method_frame(struct setting *s, double *out_rate)
{
    pnb_solver_report report;
    double started = cpu_ms(CLOCK_PROCESS_CPUTIME_ID);
    if (pnb_solver_visibility(s->solver, &s->light, &s->receivers, s->visibility) != PNB_OK)
        die(s->context);
    double spent = cpu_ms(CLOCK_PROCESS_CPUTIME_ID) - started;
    pnb_solver_get_report(s->solver, &report);
    *out_rate = report.counters[0].value / spent;
    return report.visibility_ms;
}

enum form { FORM_METHOD, FORM_OTHER_FLAG, FORM_PIXELS, FORM_EIGHT, FORM_SINGLE, FORM_STREAM };
static const char *const form_names[] = {"16 samples of a pixel (method)",
                                         "same, other coherence flag",
                                         "16 pixels, same cell",
                                         "8 samples of a pixel",
                                         "single rays",
                                         "stream of single rays"};

struct bare_worker {
    double ms;
    uint64_t rays;
    char padding[112];
};
struct bare {
    const struct reference_frame *frame;
    RTCScene scene;
    enum form form;
    struct bare_worker *workers;
};

struct bundle {
    struct trace_rays rays[CHUNK];
    int32_t valid[CHUNK][TRACE_WIDTH] __attribute__((aligned(64)));
    bool coherent[CHUNK];
    struct RTCRay8 eight[CHUNK * 2];
    struct RTCRay single[CHUNK * TRACE_WIDTH];
};

#define SPLIT(out, e, in, lane)                                                                    \
    do {                                                                                           \
        (out).org_x e = (in)->org_x[lane];                                                         \
        (out).org_y e = (in)->org_y[lane];                                                         \
        (out).org_z e = (in)->org_z[lane];                                                         \
        (out).dir_x e = (in)->dir_x[lane];                                                         \
        (out).dir_y e = (in)->dir_y[lane];                                                         \
        (out).dir_z e = (in)->dir_z[lane];                                                         \
        (out).tnear e = 0;                                                                         \
        (out).tfar e = (in)->tfar[lane];                                                           \
        (out).time e = 0;                                                                          \
        (out).mask e = 0xffffffffu;                                                                \
        (out).id e = (out).flags e = 0;                                                            \
    } while (0)

/* Puts the bundle's rays into the form, then traces them by the clock. */
static void bare_trace(const struct bare *job, struct bundle *b, int packets,
                       struct bare_worker *worker)
{
    struct RTCIntersectContext contexts[2];
    for (int i = 0; i < 2; i++) {
        rtcInitIntersectContext(&contexts[i]);
        contexts[i].flags = i != (job->form == FORM_OTHER_FLAG)
                                ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    }
    unsigned singles = 0;
    for (int k = 0; k < packets; k++)
        for (int lane = 0; lane < TRACE_WIDTH; lane++) {
            worker->rays += (uint64_t)-b->valid[k][lane];
            if (job->form == FORM_EIGHT)
                SPLIT(b->eight[2 * k + lane / 8], [lane % 8], &b -> rays[k], lane);
            else if (job->form >= FORM_SINGLE && b->valid[k][lane]) {
                SPLIT(b->single[singles], , &b->rays[k], lane);
                singles++;
            }
        }
    double started = cpu_ms(CLOCK_THREAD_CPUTIME_ID);
    switch (job->form) {
    case FORM_EIGHT:
        for (int k = 0; k < 2 * packets; k++)
            rtcOccluded8(b->valid[k / 2] + 8 * (k % 2), job->scene, &contexts[b->coherent[k / 2]],
                         &b->eight[k]);
        break;
    case FORM_SINGLE:
        for (unsigned k = 0; k < singles; k++)
            rtcOccluded1(job->scene, &contexts[0], &b->single[k]);
        break;
    case FORM_STREAM:
        rtcOccluded1M(job->scene, &contexts[b->coherent[0]], b->single, singles,
                      sizeof(b->single[0]));
        break;
    default:
        for (int k = 0; k < packets; k++)
            rtcOccluded16(b->valid[k], job->scene, &contexts[b->coherent[k]],
                          (struct RTCRay16 *)&b->rays[k]);
    }
    worker->ms += cpu_ms(CLOCK_THREAD_CPUTIME_ID) - started;
}

/* Lane p of packet i is sample i of the tile's receiver p. */
static void bare_pixels(const struct bare *job, const struct reference_tile *t, struct bundle *b,
                        struct bare_worker *worker)
{
    const struct reference_frame *frame = job->frame;
    for (size_t first = 0; first < frame->samples; first += CHUNK) {
        int packets = (int)(frame->samples - first < CHUNK ? frame->samples - first : CHUNK);
        memset(b->valid, 0, sizeof(b->valid));
        for (int k = 0; k < packets; k++) {
            trace_rays_init(&b->rays[k]);
            b->coherent[k] = true;
        }
        for (int p = 0; p < t->count; p++)
            for (int k = 0; k < packets; k += TRACE_WIDTH) {
                struct trace_rays row;
                int32_t valid[TRACE_WIDTH];
                reference_packet(frame, &t->receivers[p], first + (size_t)k, &row, valid);
                for (int i = 0; i < TRACE_WIDTH; i++) {
                    struct trace_rays *to = &b->rays[k + i];
                    to->org_x[p] = row.org_x[i], to->dir_x[p] = row.dir_x[i];
                    to->org_y[p] = row.org_y[i], to->dir_y[p] = row.dir_y[i];
                    to->org_z[p] = row.org_z[i], to->dir_z[p] = row.dir_z[i];
                    to->tfar[p] = row.tfar[i];
                    b->valid[k + i][p] = valid[i];
                }
            }
        bare_trace(job, b, packets, worker);
    }
}

static void bare_body(void *user, size_t begin, size_t end, int number)
{
    const struct bare *job = user;
    const struct reference_frame *frame = job->frame;
    struct bundle *b = aligned_alloc(64, sizeof(*b));
    if (!b)
        abort();
    for (size_t tile = begin; tile < end; tile++) {
        struct reference_tile t;
        reference_tile_begin(frame, tile, &t);
        if (job->form == FORM_PIXELS) {
            bare_pixels(job, &t, b, &job->workers[number]);
            continue;
        }
        int packets = 0;
        for (int p = 0; p < t.count; p++)
            for (size_t sample = 0; sample < frame->samples; sample += TRACE_WIDTH) {
                trace_rays_init(&b->rays[packets]);
                reference_packet(frame, &t.receivers[p], sample, &b->rays[packets],
                                 b->valid[packets]);
                b->coherent[packets] = t.receivers[p].coherent;
                if (++packets == CHUNK) {
                    bare_trace(job, b, packets, &job->workers[number]);
                    packets = 0;
                }
            }
        if (packets > 0)
            bare_trace(job, b, packets, &job->workers[number]);
    }
    free(b);
}

/* Rays per millisecond of processor time in the bare loop's tracing calls. */
static double bare_rate(struct setting *s, enum form form)
{
    struct light_shape shape;
    struct reference_frame frame;
    struct reference *r = s->solver->state;
    int count = pnb_context_threads(s->context);
    if (reference_frame_init(s->solver, &s->light, &s->receivers, s->visibility, &shape, &frame) !=
        PNB_OK)
        die(s->context);
    struct bare job = {&frame, trace_embree_scene(r->trace), form,
                       calloc((size_t)count, sizeof(*job.workers))};
    parallel_for(s->context, frame.tiles, 16, bare_body, &job);
    double ms = 0, rays = 0;
    for (int i = 0; i < count; i++) {
        ms += job.workers[i].ms;
        rays += (double)job.workers[i].rays;
    }
    free(job.workers);
    reference_frame_finish(s->solver, &frame);
    return rays / ms;
}

static void throughput(void)
{
    static const char *const scenes[] = {"prism", "fence", "spheres-9x9", "spheres-9x9x9"};
    if (as_json)
        printf("\"throughput\": [");
    else
        printf("throughput, 400x300, million rays a second and core  method   bare loop   ratio\n");
    for (size_t k = 0; k < sizeof(scenes) / sizeof(*scenes); k++)
        for (int samples = 64; samples <= 1024; samples *= 4) {
            char path[64];
            struct setting s;
            double method = 0, bare = 0, rate;
            if (k == 3 && samples == 1024)
                continue; /* half a minute that says nothing new */
            snprintf(path, sizeof(path), "builtin:%s", scenes[k]);
            setting_init(&s, path, 400, 300, samples, threads);
            for (int round = 0; round < ROUNDS; round++) {
                method_frame(&s, &rate);
                method = fmax(method, rate / 1e3);
                bare = fmax(bare, bare_rate(&s, FORM_METHOD) / 1e3);
            }
            if (as_json)
                printf("%s{\"scene\": \"%s\", \"samples\": %d, \"method_mrays\": %.3f, "
                       "\"bare_mrays\": %.3f, \"ratio\": %.3f}",
                       k + (size_t)samples > 64 ? ", " : "", scenes[k], samples, method, bare,
                       method / bare);
            else
                printf("  %-16s %5d samples %28.1f %11.1f   %5.2f\n", scenes[k], samples, method,
                       bare, method / bare);
            fflush(stdout);
            setting_finish(&s);
        }
    printf(as_json ? "],\n" : "\n");
}

static void packets(void)
{
    static const char *const scenes[] = {"fence", "spheres-9x9", "spheres-3x3x3"};
    const size_t forms = sizeof(form_names) / sizeof(*form_names);
    if (as_json)
        printf("\"packets\": [");
    else
        printf("packets, one thread, 200x150, million rays a second and core (share of the "
               "method's)\n");
    for (size_t k = 0; k < sizeof(scenes) / sizeof(*scenes); k++)
        for (int samples = 64; samples <= 1024; samples *= 16) {
            char path[64];
            struct setting s;
            double rate[16] = {0};
            snprintf(path, sizeof(path), "builtin:%s", scenes[k]);
            setting_init(&s, path, 200, 150, samples, 1);
            for (int round = 0; round < ROUNDS; round++)
                for (size_t f = 0; f < forms; f++)
                    rate[f] = fmax(rate[f], bare_rate(&s, (enum form)f) / 1e3);
            if (!as_json)
                printf("  %s, %d samples\n", scenes[k], samples);
            for (size_t f = 0; f < forms; f++)
                if (as_json)
                    printf("%s{\"scene\": \"%s\", \"samples\": %d, \"form\": \"%s\", "
                           "\"mrays\": %.3f}",
                           k + f + (size_t)samples > 64 ? ", " : "", scenes[k], samples,
                           form_names[f], rate[f]);
                else
                    printf("    %-34s %8.1f   %5.2f\n", form_names[f], rate[f], rate[f] / rate[0]);
            fflush(stdout);
            setting_finish(&s);
        }
    printf(as_json ? "],\n" : "\n");
}

/* In a process of its own, before this one has threads: its peak is the scene's alone. */
static double peak_bytes(void)
{
    struct rusage usage;
    int status;
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        struct setting s;
        double rate;
        setting_init(&s, "builtin:spheres-9x9x9", 800, 600, 64, threads);
        method_frame(&s, &rate);
        const float *visibility[16] = {s.visibility};
        float *rgb = malloc(s.receivers.count * 3 * sizeof(float));
        if (!rgb || pnb_scene_light_count(s.scene) > 16 ||
            pnb_surface_shade(s.surface, visibility, rgb) != PNB_OK)
            die(s.context);
        _exit(0);
    }
    if (child < 0 || wait4(child, &status, 0, &usage) != child || status != 0)
        return NAN;
    return (double)usage.ru_maxrss * 1024;
}

/* 100k triangles: a wavy grid, where the real mesh is absent. */
static void write_grid(const char *path)
{
    FILE *file = fopen(path, "w");
    const int side = 224;
    if (!file)
        exit(1);
    for (int y = 0; y < side; y++)
        for (int x = 0; x < side; x++)
            fprintf(file, "v %.6f %.6f %.6f\n", x / 50., 0.3 * sin(x * 0.1) * cos(y * 0.13),
                    y / 50.);
    for (int y = 0; y + 1 < side; y++)
        for (int x = 0; x + 1 < side; x++) {
            int a = y * side + x + 1;
            fprintf(file, "f %d %d %d\nf %d %d %d\n", a, a + side, a + 1, a + 1, a + side,
                    a + side + 1);
        }
    fclose(file);
}

static void loading(void)
{
    char path[4096], made[] = "/tmp/penumbra-bench-XXXXXX.obj";
    const char *models = getenv("PNB_MODELS");
    int descriptor = -1;
    snprintf(path, sizeof(path), "%s/nefertiti.obj", models ? models : PNB_MODELS_DEFAULT);
    if (access(path, R_OK) != 0) {
        descriptor = mkstemps(made, 4);
        if (descriptor < 0)
            exit(1);
        write_grid(made);
        snprintf(path, sizeof(path), "%s", made);
    }
    double load = INFINITY, frame = INFINITY, rate;
    size_t triangles = 0;
    for (int round = 0; round < ROUNDS; round++) {
        pnb_context *context;
        pnb_scene *scene;
        struct setting s;
        if (pnb_context_create(&(pnb_context_desc){.threads = threads}, &context) != PNB_OK)
            die(NULL);
        double started = clock_ms();
        if (pnb_scene_load(context, path, &scene) != PNB_OK)
            die(context);
        load = fmin(load, clock_ms() - started);
        triangles = pnb_scene_triangle_count(scene);
        pnb_scene_destroy(scene);
        pnb_context_destroy(context);
        setting_init(&s, path, 800, 600, 64, threads);
        frame = fmin(frame, method_frame(&s, &rate));
        setting_finish(&s);
    }
    if (descriptor >= 0) {
        close(descriptor);
        unlink(made);
    }
    if (as_json)
        printf("\"loading\": {\"triangles\": %zu, \"load_ms\": %.2f, \"frame_ms\": %.2f, "
               "\"ratio\": %.3f}",
               triangles, load, frame, load / frame);
    else
        printf("loading %zu triangles: %.0f ms; a 64-sample 800x600 frame: %.0f ms; ratio %.2f\n",
               triangles, load, frame, load / frame);
}

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--json") == 0) {
            as_json = true;
        } else if (strcmp(argv[i], "--threads") == 0 && i + 1 < argc) {
            threads = atoi(argv[++i]);
        } else if (strcmp(argv[i], "--help") == 0) {
            printf("usage: penumbra bench reference [--json] [--threads N]\n\n"
                   "The truth's throughput against a bare Embree loop, packet forms, memory and\n"
                   "loading time, as ratios from one run (some three minutes).\n");
            return 0;
        } else {
            fprintf(stderr, "penumbra: error: %s: unknown option\n", argv[i]);
            return 2;
        }
    }
    double peak = peak_bytes();
    if (as_json)
        printf("{\"suite\": \"reference\",\n\"memory\": {\"scene\": \"spheres-9x9x9\", "
               "\"peak_bytes\": %.0f, \"ratio_to_limit\": %.3f},\n",
               peak, peak / 1.5e9);
    else
        printf("memory, spheres-9x9x9 loaded and rendered: %.0f MB, %.2f of the 1.5 GB allowed\n\n",
               peak / 1e6, peak / 1.5e9);
    throughput();
    packets();
    loading();
    if (as_json)
        printf("}\n");
    return 0;
}
