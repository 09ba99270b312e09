/* bench/bench_planar.c: 'penumbra bench planar': what shadow geometry costs, against Clipper 6.
 *
 * Per mesh and number of light samples K, one thread, processor time, least of ROUNDS alternating
 * runs, each run over SETS different light positions (one input again and again flatters the branch
 * predictor):
 *   outline   one sample: directed silhouette edges to the hard outline, ours over Clipper's
 *   rings     all K silhouettes, outlines, and all winding levels of the K outlines together
 *   fill      triangles of all faces: milliseconds, and over our outlines and rings
 *   area      largest relative difference of a level's area to Clipper's
 * --quality measures what the method's parameters do to error and cost (planar_quality.c); how a
 * moving light moves the shadow is bench planar-tolerance --steady.
 * Silhouettes are part of both sides' time. Clipper gets closed loops linked from the same edges.
 */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <penumbra/penumbra.h>

#include "light/light.h"
#include "method/planar/room.h"
#include "peer_clipper.h"
#include "planar_scenes.h"

#define ROUNDS 5
#define SETS   4

static double cpu_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static void light_of(int set, pnb_light *light)
{
    *light = (pnb_light){.type = PNB_LIGHT_RECTANGLE, .color = {1, 1, 1}};
    double angle = 1.7 * set;
    double center[3] = {0.8 * cos(angle), 7 + 0.3 * set, 0.8 * sin(angle)};
    double u[3] = {0.7, 0, 0}, v[3] = {0, 0, 0.7};
    memcpy(light->shape.rectangle.center, center, sizeof(center));
    memcpy(light->shape.rectangle.half_u, u, sizeof(u));
    memcpy(light->shape.rectangle.half_v, v, sizeof(v));
}

struct setting {
    pnb_context *context;
    struct shadow_builder builder;
    struct shadow_plane plane;
    struct light_shape shapes[SETS];
    struct shadow_cluster *clusters[SETS];
    struct shadow_part part;
    struct shadow_settings settings;
    /* The peer's loops. */
    struct peer_outlines *peer;
    int *xy;
    unsigned *starts;
    uint32_t *first, *next;
    uint8_t *used;
    size_t capacity;
};

/* Closed loops of a silhouette, on the same grid as ours. */
static size_t link_loops(struct setting *s, const struct silhouette_outline *o)
{
    size_t n = o->segment_count > o->point_count ? o->segment_count : o->point_count;
    if (n > s->capacity) {
        s->capacity = 2 * n;
        s->xy = realloc(s->xy, 2 * s->capacity * sizeof(*s->xy));
        s->starts = realloc(s->starts, (s->capacity + 1) * sizeof(*s->starts));
        s->first = realloc(s->first, s->capacity * sizeof(*s->first));
        s->next = realloc(s->next, s->capacity * sizeof(*s->next));
        s->used = realloc(s->used, s->capacity);
    }
    for (size_t i = 0; i < o->point_count; i++)
        s->first[i] = PLANAR_NONE;
    for (uint32_t i = 0; i < o->segment_count; i++) {
        s->next[i] = s->first[o->segments[i].a];
        s->first[o->segments[i].a] = i;
        s->used[i] = 0;
    }
    size_t loops = 0, count = 0;
    s->starts[0] = 0;
    for (uint32_t i = 0; i < o->segment_count; i++) {
        if (s->used[i])
            continue;
        uint32_t begin = o->segments[i].a;
        for (uint32_t at = begin;;) {
            uint32_t e = s->first[at];
            s->first[at] = s->next[e];
            s->used[e] = 1;
            s->xy[2 * count] =
                (int)floor((o->points[2 * at] - s->plane.center[0]) * s->plane.scale + 0.5);
            s->xy[2 * count + 1] =
                (int)floor((o->points[2 * at + 1] - s->plane.center[1]) * s->plane.scale + 0.5);
            count++;
            at = o->segments[e].b;
            if (at == begin)
                break;
        }
        s->starts[++loops] = (unsigned)count;
    }
    return loops;
}

static void silhouettes(struct setting *s, int set, int k)
{
    vec3 samples[SILHOUETTE_SAMPLES_MAX];
    shadow_samples(s->clusters[set], SHADOW_OPTIMISED, k, s->plane.frame.origin, 1e7, samples);
    for (int i = 0; i < k; i++) {
        samples[i] = silhouette_to_plane(&s->plane.frame, samples[i]);
        s->builder.outlines[i].point_count = s->builder.outlines[i].segment_count = 0;
    }
    for (size_t i = 0; i < s->plane.occluder_count; i++)
        if (silhouette_from_points(s->context, &s->plane.occluders[i], samples, (size_t)k,
                                   s->builder.outlines))
            bench_die(s->context);
}

static double run_peer(struct setting *s, int k, bool levels)
{
    double begin = cpu_ms();
    for (int set = 0; set < SETS; set++) {
        peer_clear(s->peer);
        silhouettes(s, set, k);
        for (int i = 0; i < k; i++) {
            size_t loops = link_loops(s, &s->builder.outlines[i]);
            peer_add_outline(s->peer, s->xy, s->starts, loops);
        }
        if (levels)
            peer_levels(s->peer);
    }
    return (cpu_ms() - begin) / SETS;
}

static double run_ours(struct setting *s, int k, bool fill)
{
    s->settings.samples = k;
    s->settings.fill = fill ? PLANAR_RULE_NEAREST : PLANAR_RULE_SWEEP;
    s->settings.rings_only = !fill;
    memset(&s->builder.times, 0, sizeof(s->builder.times));
    double begin = cpu_ms();
    for (int set = 0; set < SETS; set++)
        if (shadow_build(&s->builder, &s->plane, &s->shapes[set], s->clusters[set], &s->settings,
                         &s->part))
            bench_die(s->context);
    return (cpu_ms() - begin) / SETS;
}

/* Area of {level >= i} of the last part. */
static double level_area(const struct shadow_part *part, int level)
{
    double sum = 0;
    for (size_t i = 0; i < part->edge_count; i++) {
        const struct planar_edge *e = &part->edges[i];
        int way = (e->below >= level) - (e->above >= level);
        const double *a = part->points + 2 * (size_t)e->left,
                     *b = part->points + 2 * (size_t)e->right;
        sum -= way * 0.5 * (a[0] * b[1] - a[1] * b[0]);
    }
    return sum;
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        enum bench_shape shape;
        int rows, columns;
    } meshes[] = {
        {"sphere", BENCH_SPHERE, 100, 50},  {"torus", BENCH_TORUS, 100, 50},
        {"knot", BENCH_KNOT, 500, 10},      {"blob", BENCH_BLOB, 100, 50},
        {"blob-50k", BENCH_BLOB, 316, 158},
    };
    static const int counts[] = {1, 3, 8, 16};
    if (argc > 1 && strcmp(argv[1], "--quality") == 0) {
        bench_planar_quality();
        return 0;
    }
    bool json = argc > 1 && strcmp(argv[1], "--json") == 0;
    if (argc > 1 && !json) {
        printf("usage: penumbra bench planar [--json | --quality]\n");
        return strcmp(argv[1], "--help") ? 2 : 0;
    }
    if (json)
        printf("{\"suite\": \"planar\", \"rows\": [");
    else
        printf("%-9s %3s | %8s %8s %8s %8s %8s | %9s %7s %8s | %9s\n", "mesh", "K", "silh. ms",
               "outlines", "rings", "fill", "all", "Clipper", "faster", "fill/rgs", "area diff");
    for (size_t m = 0; m < sizeof(meshes) / sizeof(meshes[0]); m++) {
        struct setting s = {0};
        if (pnb_context_create(&(pnb_context_desc){.threads = 1}, &s.context))
            return 1;
        pnb_scene *scene =
            bench_scene(s.context, meshes[m].shape, meshes[m].rows, meshes[m].columns);
        if (shadow_builder_init(s.context, scene, &s.builder) ||
            shadow_plane_init(s.context, scene, NULL, 0, v3(0, 9, 0), &s.plane))
            bench_die(s.context);
        pnb_mesh_info info;
        pnb_scene_mesh_info(scene, 1, &info);
        for (int set = 0; set < SETS; set++) {
            pnb_light light;
            size_t count;
            light_of(set, &light);
            if (light_shape_init(s.context, &light, &s.shapes[set]) ||
                shadow_clusters(s.context, &s.shapes[set], &s.clusters[set], &count))
                bench_die(s.context);
            s.shapes[set].light = light;
        }
        s.settings.mend = SHADOW_MEND_EVEN;
        s.peer = peer_create();
        for (size_t c = 0; c < sizeof(counts) / sizeof(counts[0]); c++) {
            int k = counts[c];
            double ours = 1e30, peer = 1e30, filled = 1e30, seen = 1e30;
            struct shadow_times best = {0};
            int rounds = k > 3 ? ROUNDS : 4 * ROUNDS;
            for (int round = 0; round < rounds; round++) {
                double t = run_ours(&s, k, false);
                if (t < ours)
                    best = s.builder.times;
                ours = fmin(ours, t);
                if (round < ROUNDS - (k > 8 ? 3 : 0))
                    peer = fmin(peer, run_peer(&s, k, k > 1));
                filled = fmin(filled, run_ours(&s, k, true));
                double begin = cpu_ms();
                for (int set = 0; set < SETS; set++)
                    silhouettes(&s, set, k);
                seen = fmin(seen, (cpu_ms() - begin) / SETS);
            }
            double worst = 0;
            if (k > 1)
                for (int i = 1; i <= k; i++) {
                    double a = level_area(&s.part, i);
                    double b =
                        fabs(peer_level_area(s.peer, (size_t)i)) / (s.plane.scale * s.plane.scale);
                    worst = fmax(worst, fabs(a - b) / level_area(&s.part, 1));
                }
            double fill = filled - ours, made = ours - seen; /* outlines and rings */
            if (json)
                printf(
                    "%s\n {\"mesh\": \"%s\", \"closed\": %s, \"samples\": %d, \"silhouettes_ms\": "
                    "%.4f, \"outlines_ms\": %.4f, \"rings_ms\": %.4f, \"total_ms\": %.4f, "
                    "\"with_fill_ms\": %.4f, \"clipper_ms\": %.4f, \"faster\": %.2f, "
                    "\"area_difference\": %.2g, \"careful\": %zu}",
                    m + c ? "," : "", meshes[m].name, info.closed ? "true" : "false", k,
                    best.silhouettes_ms / SETS, best.outlines_ms / SETS, best.rings_ms / SETS, ours,
                    filled, peer, peer / ours, worst, best.careful);
            else
                printf(
                    "%-9s %3d | %8.3f %8.3f %8.3f %8.3f %8.3f | %9.3f %6.1fx %8.2f | %9.1e%s%s\n",
                    meshes[m].name, k, best.silhouettes_ms / SETS, best.outlines_ms / SETS,
                    best.rings_ms / SETS, fill, ours, peer, peer / ours, fill / made, worst,
                    info.closed ? "" : " open!", best.careful ? " careful" : "");
            fflush(stdout);
        }
        peer_destroy(s.peer);
        for (int set = 0; set < SETS; set++) {
            memory_free(s.context, s.clusters[set]);
            light_shape_finish(s.context, &s.shapes[set]);
        }
        free(s.xy);
        free(s.starts);
        free(s.first);
        free(s.next);
        free(s.used);
        shadow_part_finish(s.context, &s.part);
        shadow_plane_finish(s.context, &s.plane);
        shadow_builder_finish(&s.builder);
        pnb_scene_destroy(scene);
        pnb_context_destroy(s.context);
    }
    if (json)
        printf("\n]}\n");
    return 0;
}
