/* viewer/shade.c: from visibility to bytes.
 *
 * picture = albedo x (ambient + exposure x sum of irradiance x visibility) + exposure x pi x
 * emission, as pnb_surface_shade() has it, in single precision and straight to 8-bit sRGB: some
 * 4 ms for 800x600 on two threads, where the library's, made for files, takes ten times that.
 * Pictures at rest are shaded by the library.
 *
 * sRGB bytes come from a table of 4,096 cells and the exact thresholds between codes, so that
 * encoding agrees with the library's to the bit.
 */
#include "shade.h"

#include <glib.h>
#include <math.h>
#include <string.h>

#include "lights.h"

enum { CELLS = 4096 };

struct encoder {
    uint8_t code[CELLS];  /* of a cell's lower end */
    float threshold[258]; /* the least value of each code */
};

static double encoded(double linear)
{
    return (linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055) * 255 +
           0.5;
}

static gpointer make_encoder(gpointer unused)
{
    struct encoder *encoder = g_new0(struct encoder, 1);
    for (int k = 1; k < 256; k++) {
        double e = (k - 0.5) / 255;
        float x = (float)(e <= 0.04045 ? e / 12.92 : pow((e + 0.055) / 1.055, 2.4));
        while (encoded(x) >= k)
            x = nextafterf(x, 0);
        while (encoded(x) < k)
            x = nextafterf(x, 2);
        encoder->threshold[k] = x;
    }
    encoder->threshold[256] = encoder->threshold[257] = INFINITY;
    for (int i = 0; i < CELLS; i++)
        encoder->code[i] = (uint8_t)encoded((double)i / CELLS);
    return encoder;
}

static const struct encoder *get_encoder(void)
{
    static GOnce once = G_ONCE_INIT;
    return g_once(&once, make_encoder, NULL);
}

static inline uint8_t encode(const struct encoder *encoder, float x)
{
    if (!(x > 0))
        return 0;
    if (x >= 1)
        return 255;
    unsigned code = encoder->code[(int)(x * CELLS)];
    code += x >= encoder->threshold[code + 1];
    code += x >= encoder->threshold[code + 1];
    return (uint8_t)code;
}

/* ---- lights ---- */

static void set3(float *out, vec3 a)
{
    out[0] = (float)a.x;
    out[1] = (float)a.y;
    out[2] = (float)a.z;
}

void view_emitter_init(struct view_emitter *emitter, const pnb_light *light)
{
    struct view_light copy;
    view_light_copy(&copy, light);
    struct view_frame_axes axes = view_light_axes(&copy, v3(0, 0, 0), 0);
    *emitter = (struct view_emitter){.type = light->type, .sum_scale = 1};
    for (int c = 0; c < 3; c++)
        emitter->color[c] = (float)light->color[c];
    set3(emitter->center, axes.center);
    set3(emitter->normal, axes.n);
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE:
    case PNB_LIGHT_POLYGON: {
        vec3 *outline =
            g_new(vec3, light->type == PNB_LIGHT_POLYGON ? light->shape.polygon.vertex_count + 4
                                                         : VIEW_OUTLINE_MAX);
        if (light->type == PNB_LIGHT_POLYGON) {
            emitter->count = (int)light->shape.polygon.vertex_count;
            for (int i = 0; i < emitter->count; i++)
                outline[i] = v3_load(copy.vertices + 3 * i);
        } else {
            emitter->count = view_light_outline(&copy, v3(0, 0, 0), 0, outline);
        }
        emitter->vertices = g_new(float, 3 * (gsize)emitter->count);
        for (int i = 0; i < emitter->count; i++)
            set3(emitter->vertices + 3 * i, outline[i]);
        g_free(outline);
        break;
    }
    case PNB_LIGHT_DISK: emitter->radius = (float)light->shape.disk.radius; break;
    case PNB_LIGHT_LINE:
        emitter->count = 2;
        emitter->vertices = g_new(float, 6);
        set3(emitter->vertices, v3_load(light->shape.line.from));
        set3(emitter->vertices + 3, v3_load(light->shape.line.to));
        break;
    case PNB_LIGHT_POINT: break;
    case PNB_LIGHT_SUN: {
        double radius = tan(0.5 * light->shape.sun.angular_diameter_degrees * M_PI / 180);
        emitter->radius = (float)radius;
        set3(emitter->normal, v3_scale(axes.n, -1));
        emitter->sum_scale = (float)((1 + radius * radius) / (M_PI * radius * radius));
        break;
    }
    }
    view_light_finish(&copy);
}

void view_emitter_finish(struct view_emitter *emitter)
{
    g_free(emitter->vertices);
    *emitter = (struct view_emitter){0};
}

view_irradiance_fn *view_irradiance_best(void)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
        return view_irradiance_avx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        return view_irradiance_avx2;
#endif
    return view_irradiance_plain;
}

/* ---- shading ---- */

struct job {
    const struct view_shading *shading;
    const struct encoder *encoder;
    view_irradiance_fn *irradiance;
    const float *rgb, *visibility, *truth;
    float scale;
    const uint8_t (*map)[4];
    uint8_t *bgra;
};

static void gather(const pnb_surface_view *view, size_t first, int count, struct view_points *at)
{
    for (int i = 0; i < VIEW_LANES; i++) {
        size_t pixel = first + (size_t)(i < count ? i : 0);
        for (int c = 0; c < 3; c++) {
            at->p[c][i] = view->positions[3 * pixel + (size_t)c];
            at->n[c][i] = view->shading_normals[3 * pixel + (size_t)c];
        }
    }
}

static void shade_block(const struct job *job, size_t first, int count)
{
    const struct view_shading *s = job->shading;
    const uint32_t *objects = s->view->objects + first;
    float sum[VIEW_LANES][3], light[VIEW_LANES];
    struct view_points at;
    bool any = false;
    for (int i = 0; i < VIEW_LANES; i++) {
        memcpy(sum[i], s->ambient, sizeof(sum[i]));
        any = any || (i < count && objects[i] != PNB_NO_OBJECT);
    }
    if (any)
        gather(s->view, first, count, &at);
    for (size_t k = 0; any && k < s->emitter_count; k++) {
        const struct view_emitter *e = &s->emitters[k];
        const float *visibility = s->visibility ? s->visibility[k] : NULL;
        float exposure = (float)s->exposure;
        job->irradiance(e, &at, light);
        for (int i = 0; i < count; i++) {
            float v = visibility ? visibility[first + (size_t)i] : 1;
            if (isnan(v) || objects[i] == PNB_NO_OBJECT || !s->materials[objects[i]].receives)
                v = 1;
            float amount = light[i] * v * exposure;
            for (int c = 0; c < 3; c++)
                sum[i][c] += amount * e->color[c];
        }
    }
    uint8_t *out = job->bgra + 4 * first;
    for (int i = 0; i < count; i++, out += 4) {
        for (int c = 0; c < 3; c++) {
            float value = s->background[c];
            if (objects[i] != PNB_NO_OBJECT) {
                const struct view_material *material = &s->materials[objects[i]];
                value = material->color[c] * sum[i][c] + material->emission[c];
            }
            out[2 - c] = encode(job->encoder, value);
        }
        out[3] = 255;
    }
}

static void shade_body(void *user, size_t begin, size_t end)
{
    for (size_t i = begin; i < end; i += VIEW_LANES)
        shade_block(user, i, (int)MIN((size_t)VIEW_LANES, end - i));
}

enum { GRAIN = 16384 };

void view_shade(struct view_team *team, const struct view_shading *shading, uint8_t *bgra)
{
    struct job job = {.shading = shading,
                      .encoder = get_encoder(),
                      .irradiance = view_irradiance_best(),
                      .bgra = bgra};
    size_t count = (size_t)shading->view->width * (size_t)shading->view->height;
    view_team_run(team, count, GRAIN, shade_body, &job);
}

static void encode_body(void *user, size_t begin, size_t end)
{
    const struct job *job = user;
    for (size_t i = begin; i < end; i++) {
        for (size_t c = 0; c < 3; c++)
            job->bgra[4 * i + 2 - c] = encode(job->encoder, job->rgb[3 * i + c]);
        job->bgra[4 * i + 3] = 255;
    }
}

void view_encode(struct view_team *team, const float *rgb, size_t count, uint8_t *bgra)
{
    struct job job = {.encoder = get_encoder(), .rgb = rgb, .bgra = bgra};
    view_team_run(team, count, GRAIN, encode_body, &job);
}

static void visibility_body(void *user, size_t begin, size_t end)
{
    static const uint8_t none[4] = {92, 66, 62, 255};
    const struct job *job = user;
    for (size_t i = begin; i < end; i++) {
        float v = job->visibility[i];
        uint8_t *out = job->bgra + 4 * i;
        if (isnan(v)) {
            memcpy(out, none, 4);
        } else {
            out[0] = out[1] = out[2] = encode(job->encoder, v);
            out[3] = 255;
        }
    }
}

void view_show_visibility(struct view_team *team, const float *visibility, size_t count,
                          uint8_t *bgra)
{
    struct job job = {.encoder = get_encoder(), .visibility = visibility, .bgra = bgra};
    view_team_run(team, count, GRAIN, visibility_body, &job);
}

enum { MAP_SIZE = 512 }; /* and one entry for NaN */

static void error_body(void *user, size_t begin, size_t end)
{
    const struct job *job = user;
    for (size_t i = begin; i < end; i++) {
        float t = 0.5f + (job->visibility[i] - job->truth[i]) * job->scale;
        int index = isnan(t) ? MAP_SIZE : (int)(fminf(fmaxf(t, 0), 1) * (MAP_SIZE - 1) + 0.5f);
        memcpy(job->bgra + 4 * i, job->map[index], 4);
    }
}

void view_show_error(struct view_team *team, const float *visibility, const float *truth,
                     size_t count, double scale, uint8_t *bgra)
{
    uint8_t map[MAP_SIZE + 1][4];
    struct job job = {.encoder = get_encoder(),
                      .visibility = visibility,
                      .truth = truth,
                      .scale = (float)(0.5 / scale),
                      .map = (const uint8_t(*)[4])map,
                      .bgra = bgra};
    for (int i = 0; i <= MAP_SIZE; i++) {
        double rgb[3] = {0.03, 0.03, 0.03};
        if (i < MAP_SIZE)
            pnb_colormap_diverging((double)i / (MAP_SIZE - 1), rgb);
        for (int c = 0; c < 3; c++)
            map[i][2 - c] = encode(job.encoder, (float)rgb[c]);
        map[i][3] = 255;
    }
    view_team_run(team, count, GRAIN, error_body, &job);
}
