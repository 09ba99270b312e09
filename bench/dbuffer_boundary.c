/* bench/dbuffer_boundary.c: the boundaries of umbra and penumbra against those of 'exact'.
 *
 * A pixel lies near a boundary when, of itself and 12 places 4 texels around it in the receiver's
 * plane, some are inside and some outside, by 'exact'. It is off when all 12 places at 1.5 texels
 * are on one side and dbuffer says the other: then the boundary that dbuffer drew is more than 1.5
 * texels from the true one. Inside: V < INSIDE (umbra), V < 1 - INSIDE (outer); for a disk that is
 * 1/300 of its diameter. Places are asked for only about pixels with both sides among their
 * neighbours. */
#include "dbuffer_boundary.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define INSIDE 1e-4f
#define PLACES 12
#define REACH  8 /* pixels around one that are looked at */

struct work {
    pnb_context *context;
    pnb_scene *scene;
    pnb_surface *surface;
    pnb_receivers receivers;
    float *truth, *positions, *normals, *values;
    uint8_t *facing;
    uint32_t *pixels;
    size_t count; /* pixels whose places are asked for */
};

static pnb_status solve(const struct work *w, const char *method, const pnb_solver_param *params,
                        size_t param_count, const pnb_light *light, const pnb_receivers *receivers,
                        float *values, double *out_texel)
{
    pnb_solver *solver;
    pnb_solver_desc desc = {method, 0, params, param_count};
    pnb_status status = pnb_solver_create(w->context, w->scene, &desc, &solver);
    if (status != PNB_OK)
        return status;
    status = pnb_solver_visibility(solver, light, receivers, values);
    pnb_solver_report report;
    pnb_solver_get_report(solver, &report);
    for (size_t i = 0; i < report.counter_count && out_texel; i++)
        if (strcmp(report.counters[i].name, "texel") == 0)
            *out_texel = report.counters[i].value;
    pnb_solver_destroy(solver);
    return status;
}

static bool inside(float v, int kind)
{
    return kind == 0 ? v < INSIDE : v < 1 - INSIDE;
}

/* Both sides of a boundary among a pixel's neighbours, and all of them in its plane. */
static bool wanted(const struct work *w, int x, int y)
{
    int width = w->receivers.width, height = w->receivers.height;
    const float *p = w->receivers.positions + 3 * ((size_t)y * (size_t)width + (size_t)x);
    const float *n = w->receivers.normals + 3 * ((size_t)y * (size_t)width + (size_t)x);
    bool found[2][2] = {{false}};
    for (int dy = -REACH; dy <= REACH; dy++)
        for (int dx = -REACH; dx <= REACH; dx++) {
            if (x + dx < 0 || x + dx >= width || y + dy < 0 || y + dy >= height)
                continue;
            size_t i = (size_t)(y + dy) * (size_t)width + (size_t)(x + dx);
            const float *q = w->receivers.positions + 3 * i;
            float over = n[0] * (q[0] - p[0]) + n[1] * (q[1] - p[1]) + n[2] * (q[2] - p[2]);
            if (!(fabsf(over) < 1e-4f)) {
                if (abs(dx) <= 1 && abs(dy) <= 1)
                    return false;
                continue;
            }
            for (int kind = 0; kind < 2; kind++)
                found[kind][inside(w->truth[i], kind)] = true;
        }
    return (found[0][0] && found[0][1]) || (found[1][0] && found[1][1]);
}

static void choose(struct work *w)
{
    for (int y = 0; y < w->receivers.height; y++)
        for (int x = 0; x < w->receivers.width; x++) {
            size_t i = (size_t)y * (size_t)w->receivers.width + (size_t)x;
            if (w->facing[i] && wanted(w, x, y))
                w->pixels[w->count++] = (uint32_t)i;
        }
}

/* Two rings of places about each pixel. */
static void place(struct work *w, const double *center, double texel)
{
    for (size_t pixel = 0; pixel < w->count; pixel++) {
        size_t i = w->pixels[pixel];
        const float *p = w->receivers.positions + 3 * i, *n = w->receivers.normals + 3 * i;
        double distance =
            sqrt(pow(p[0] - center[0], 2) + pow(p[1] - center[1], 2) + pow(p[2] - center[2], 2));
        /* u, v span the plane. */
        int least = fabsf(n[0]) < fabsf(n[1]) ? 0 : 1;
        least = fabsf(n[2]) < fabsf(n[least]) ? 2 : least;
        double axis[3] = {least == 0, least == 1, least == 2};
        double u[3] = {n[1] * axis[2] - n[2] * axis[1], n[2] * axis[0] - n[0] * axis[2],
                       n[0] * axis[1] - n[1] * axis[0]};
        double size = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        for (int c = 0; c < 3; c++)
            u[c] /= size;
        double v[3] = {n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2],
                       n[0] * u[1] - n[1] * u[0]};
        for (int k = 0; k < 2 * PLACES; k++) {
            double step = (k < PLACES ? 1.5 : 4) * texel * distance;
            double angle = 2 * 3.14159265358979 * (k % PLACES) / PLACES;
            size_t at = 3 * (pixel * 2 * PLACES + (size_t)k);
            for (int c = 0; c < 3; c++) {
                w->positions[at + (size_t)c] =
                    (float)(p[c] + step * (cos(angle) * u[c] + sin(angle) * v[c]));
                w->normals[at + (size_t)c] = n[c];
            }
        }
    }
}

static void judge(const struct work *w, const float *visibility, struct boundary *out,
                  uint8_t *mark)
{
    for (size_t k = 0; k < w->count; k++) {
        const float *near = w->values + k * 2 * PLACES, *far = near + PLACES;
        uint32_t i = w->pixels[k];
        for (int kind = 0; kind < 2; kind++) {
            size_t close = 0, about = inside(w->truth[i], kind);
            for (int j = 0; j < PLACES; j++) {
                close += inside(near[j], kind);
                about += inside(far[j], kind);
            }
            if (about == 0 || about == PLACES + 1)
                continue;
            out->near[kind]++;
            bool is = inside(visibility[i], kind), off = close == (is ? 0 : PLACES);
            out->off[kind] += off;
            if (mark)
                mark[i] |= (uint8_t)((1 + 4 * off) << kind);
        }
    }
}

pnb_status boundary_measure(pnb_context *context, pnb_scene *scene, const pnb_light *light,
                            int width, int height, int size, struct boundary *out, uint8_t *mark,
                            float *visibility)
{
    struct work w = {.context = context, .scene = scene};
    size_t pixels = (size_t)width * (size_t)height;
    char text[16];
    snprintf(text, sizeof(text), "%d", size);
    pnb_solver_param params[] = {{"size", text}};
    memset(out, 0, sizeof(*out));
    out->size = size;
    w.truth = malloc(pixels * sizeof(float));
    w.facing = malloc(pixels);
    w.pixels = malloc(pixels * sizeof(*w.pixels));
    pnb_status status = PNB_ERROR_MEMORY;
    if (w.truth && w.facing && w.pixels)
        status = pnb_surface_create(context, scene, NULL, width, height, &w.surface);
    if (status == PNB_OK) {
        pnb_surface_receivers(w.surface, &w.receivers);
        pnb_measure_facing(light, &w.receivers, w.facing);
        status = solve(&w, "dbuffer", params, 1, light, &w.receivers, visibility, &out->texel);
    }
    if (status == PNB_OK)
        status = solve(&w, "exact", NULL, 0, light, &w.receivers, w.truth, NULL);
    if (status == PNB_OK) {
        choose(&w);
        size_t places = w.count * 2 * PLACES + 1;
        w.positions = malloc(3 * places * sizeof(float));
        w.normals = malloc(3 * places * sizeof(float));
        w.values = malloc(places * sizeof(float));
        status = w.positions && w.normals && w.values ? PNB_OK : PNB_ERROR_MEMORY;
    }
    if (status == PNB_OK) {
        place(&w, light->shape.disk.center, out->texel);
        pnb_receivers about = {
            .positions = w.positions, .normals = w.normals, .count = w.count * 2 * PLACES};
        status = solve(&w, "exact", NULL, 0, light, &about, w.values, NULL);
    }
    if (mark)
        memset(mark, 0, pixels);
    if (status == PNB_OK)
        judge(&w, visibility, out, mark);
    pnb_surface_destroy(w.surface);
    free(w.truth);
    free(w.facing);
    free(w.pixels);
    free(w.positions);
    free(w.normals);
    free(w.values);
    return status;
}
