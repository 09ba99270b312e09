/* method/line_map/opengl.c: soft shadow maps on OpenGL. The same algorithm and the same maps as on
 * the CPU, rows and columns alike; stage by stage:
 *
 *   map.vert, map.frag   each triangle as the rectangle that it may cover, rays against it per
 *                        texel; blending keeps the nearest. Texels see what the CPU's see.
 *   the CPU's own        as in the paper, maps are read back and searched for discontinuities
 * there; so are the surfaces between them cut into pieces (between=spans) skin.vert, skin.frag
 * skins, one instance a discontinuity, into the channels; the least stays look_up.frag         per
 * pixel: which samples see it, their channels, and pieces of its row
 *
 * samples=auto chooses the samples by the CPU path from the receivers read back, then draws here.
 *
 * Differences from the CPU path: rounding at the border of texels, channels in half precision (1e-3
 * of a segment). Memory: 4 size^2 bytes a map (8 where objects cast no shadow), 4 size^2 a segment;
 * up to four times the rows for lights that shadow all around themselves.
 */
#include <stdlib.h>
#include <string.h>

#include "method/line_map/line_map.h"
#include "method/opengl.h"

#define SAMPLES_MOST 128 /* layers of an array texture: 256 at least everywhere */

#define PIECES_WIDE 2048 /* texels a row of the pieces' texture */

#define TEXT_OF(x) #x
#define TEXT(x)    TEXT_OF(x)
static const char look_up_defines[] = "#define LIFT " TEXT(
    LINE_MAP_LIFT) "\n"
                   "#define BESIDE " TEXT(LINE_MAP_BESIDE) "\n"
                                                           "#define PIECES_WIDE " TEXT(
                                                               PIECES_WIDE) "\n";

struct line_map_opengl {
    struct line_map method; /* parameters, geometry */
    struct gl_program *map, *skin, *look_up;
    struct gl_buffer *triangles, *texels;
    /* Kept from frame to frame for their memory: of rows x columns, so many samples. */
    int rows, columns, samples;
    bool passive;
    struct gl_texture *depths, *channels, *nearest;
    struct gl_target *depth_targets[2 * SAMPLES_MOST], *channel_targets[2 * SAMPLES_MOST];
    /* Of one light. */
    struct gl_texture *places, *row_frame, *sectors, *floors, *pieces, *piece_rows;
};

/* One light's frame. */
struct work {
    pnb_solver *solver;
    struct opengl_state *state;
    struct line_map_opengl *room;
    struct map_set *set;
    uint32_t *first; /* 2 per map: where its lists begin in the buffer of texels, and an end */
};

static void release_maps(struct line_map_opengl *room)
{
    for (int i = 0; i < 2 * SAMPLES_MOST; i++) {
        gl_target_destroy(room->depth_targets[i]);
        gl_target_destroy(room->channel_targets[i]);
        room->depth_targets[i] = room->channel_targets[i] = NULL;
    }
    gl_texture_destroy(room->depths);
    gl_texture_destroy(room->channels);
    gl_texture_destroy(room->nearest);
    room->depths = room->channels = room->nearest = NULL;
    room->samples = 0;
}

static void release_light(struct line_map_opengl *room)
{
    gl_texture_destroy(room->places);
    gl_texture_destroy(room->row_frame);
    gl_texture_destroy(room->sectors);
    gl_texture_destroy(room->floors);
    gl_texture_destroy(room->pieces);
    gl_texture_destroy(room->piece_rows);
    room->places = room->row_frame = room->sectors = room->floors = NULL;
    room->pieces = room->piece_rows = NULL;
}

static void destroy(pnb_solver *solver, struct opengl_state *state)
{
    struct line_map_opengl *room = state->room;
    if (!room)
        return;
    release_light(room);
    release_maps(room);
    gl_program_destroy(room->map);
    gl_program_destroy(room->skin);
    gl_program_destroy(room->look_up);
    gl_buffer_destroy(room->triangles);
    gl_buffer_destroy(room->texels);
    map_geometry_destroy(room->method.geometry);
    memory_free(solver->context, room);
    state->room = NULL;
}

static pnb_status make_programs(struct gl_device *device, struct line_map_opengl *room)
{
    static const char *const corners[] = {"corner_a", "corner_b", "corner_c", "rows"};
    static const char *const texel[] = {"texel"};
    static const char *const variants[4] = {"", "#define LINEAR 1\n", "#define NEAREST 1\n",
                                            "#define LINEAR 1\n#define NEAREST 1\n"};
    pnb_status status = gl_program_create(device,
                                          &(struct gl_program_desc){
                                              .vertex = "method/line_map/map.vert",
                                              .fragment = "method/line_map/map.frag",
                                              .attributes = corners,
                                              .attribute_count = 4,
                                          },
                                          &room->map);
    if (status == PNB_OK)
        status = gl_program_create(
            device,
            &(struct gl_program_desc){
                .vertex = "method/line_map/skin.vert",
                .fragment = "method/line_map/skin.frag",
                .defines = variants[room->method.linear + 2 * room->method.nearest],
                .attributes = texel,
                .attribute_count = 1,
            },
            &room->skin);
    if (status == PNB_OK)
        status = gl_program_create(device,
                                   &(struct gl_program_desc){
                                       .vertex = "gl/cover.vert",
                                       .fragment = "method/line_map/look_up.frag",
                                       .defines = look_up_defines,
                                   },
                                   &room->look_up);
    return status;
}

static pnb_status create(pnb_solver *solver, struct opengl_state *state)
{
    struct line_map_opengl *room = state->room = memory_calloc(solver->context, 1, sizeof(*room));
    if (!room)
        return status_no_memory(solver->context, sizeof(*room));
    pnb_status status = line_map_read_params(solver, &room->method);
    if (status == PNB_OK && solver->samples > SAMPLES_MOST)
        status = status_fail(solver->context, PNB_ERROR_ARGUMENT, "samples",
                             "line-map takes %d at most on OpenGL", SAMPLES_MOST);
    if (status == PNB_OK)
        status = map_geometry_create(solver->scene, &room->method.geometry);
    return status == PNB_OK ? make_programs(state->device, room) : status;
}

static pnb_status changed(pnb_solver *solver, struct opengl_state *state)
{
    struct line_map_opengl *room = state->room;
    return map_geometry_update(solver->scene, &room->method.geometry);
}

/* ---- What a light's maps need ---- */

static pnb_status table(struct gl_device *device, const float *texels, int width,
                        struct gl_texture **out)
{
    gl_texture_destroy(*out);
    *out = NULL;
    return gl_texture_create(
        device,
        &(struct gl_texture_desc){
            .format = GL_FORMAT_RGBA32F, .width = width, .height = 1, .texels = texels},
        out);
}

static pnb_status upload_rows(struct work *w)
{
    const struct map_set *set = w->set;
    int most = gl_device_get_info(w->state->device)->max_texture_size;
    if (set->rows > most || set->columns > most)
        return status_fail(w->solver->context, PNB_ERROR_DEVICE, "line-map",
                           "maps of %d x %d texels are larger than the device takes (%d)",
                           set->columns, set->rows, most);
    float *texels = memory_alloc(w->solver->context, (size_t)set->rows, 16);
    if (!texels)
        return status_no_memory(w->solver->context, (size_t)set->rows * 16);
    for (int v = 0; v < set->rows; v++) {
        const float row[4] = {set->row_cos[v], set->row_sin[v], (float)set->row_above[v],
                              (float)set->row_below[v]};
        memcpy(texels + 4 * v, row, sizeof(row));
    }
    pnb_status status = table(w->state->device, texels, set->rows, &w->room->row_frame);
    memory_free(w->solver->context, texels);
    return status;
}

static pnb_status upload_sectors(struct work *w)
{
    const struct map_set *set = w->set;
    float *texels = memory_calloc(w->solver->context, MAP_SECTORS, 16);
    if (!texels)
        return status_no_memory(w->solver->context, (size_t)MAP_SECTORS * 16);
    for (int i = 0; i < MAP_SECTORS; i++) {
        if (set->empty || set->sector_arc[i] == MAP_NO_ARC)
            continue;
        const struct map_arc *arc = &set->arcs[set->sector_arc[i]];
        const float row[4] = {(float)arc->low, (float)(1 / arc->step), (float)arc->first_row,
                              (float)arc->row_count};
        memcpy(texels + 4 * i, row, sizeof(row));
    }
    pnb_status status = table(w->state->device, texels, MAP_SECTORS, &w->room->sectors);
    memory_free(w->solver->context, texels);
    return status;
}

static pnb_status upload_floors(struct work *w)
{
    const struct map_geometry *g = w->room->method.geometry;
    const struct map_set *set = w->set;
    size_t first = g->floor_count ? g->floors[0].first_triangle : 0, count = 0;
    for (size_t k = 0; k < g->floor_count; k++)
        count += g->floors[k].triangle_count;
    if (3 * count > (size_t)gl_device_get_info(w->state->device)->max_texture_size)
        return status_fail(w->solver->context, PNB_ERROR_UNSUPPORTED, "line-map",
                           "floors of %zu triangles are too many for the OpenGL path", count);
    float *texels = memory_calloc(w->solver->context, 3 * count + 1, 16);
    if (!texels)
        return status_no_memory(w->solver->context, 3 * count * 16);
    for (size_t i = 0; i < 3 * count; i++)
        memcpy(texels + 4 * i, set->points + 3 * (size_t)g->indices[3 * first + i], 12);
    pnb_status status = table(w->state->device, texels, (int)(3 * count + 1), &w->room->floors);
    memory_free(w->solver->context, texels);
    return status;
}

static pnb_status upload_places(struct work *w)
{
    const struct map_set *set = w->set;
    float texels[4 * SAMPLES_MOST] = {0};
    for (size_t i = 0; i < set->count; i++) {
        texels[4 * i] = (float)set->maps[i].at;
        texels[4 * i + 1] = set->maps[i].low;
        texels[4 * i + 2] = set->maps[i].scale;
    }
    return table(w->state->device, texels, set->count ? (int)set->count : 1, &w->room->places);
}

#define TRIANGLE_FLOATS 11

struct triangle_job {
    const struct map_set *set;
    float *data;
};

static void triangle_body(void *user, size_t begin, size_t end, int worker)
{
    const struct triangle_job *job = user;
    const struct map_set *set = job->set;
    for (size_t t = begin; t < end; t++) {
        float *to = job->data + TRIANGLE_FLOATS * t;
        for (size_t k = 0; k < 3; k++)
            memcpy(to + 3 * k, set->points + 3 * (size_t)set->geometry->indices[3 * t + k], 12);
        bool none = set->first_row[t] > set->last_row[t];
        to[9] = none ? 0 : (float)set->first_row[t];
        to[10] = none ? 0 : (float)(set->last_row[t] + 1);
    }
}

static pnb_status upload_triangles(struct work *w)
{
    size_t count = w->room->method.geometry->triangle_count;
    size_t size = count * TRIANGLE_FLOATS * sizeof(float);
    struct triangle_job job = {w->set, memory_alloc(w->solver->context, size, 1)};
    if (!job.data)
        return status_no_memory(w->solver->context, size);
    parallel_for(w->solver->context, count, 4096, triangle_body, &job);
    pnb_status status = PNB_OK;
    if (!w->room->triangles)
        status = gl_buffer_create(w->state->device, NULL, size, true, &w->room->triangles);
    if (status == PNB_OK)
        status = gl_buffer_write(w->room->triangles, job.data, size);
    memory_free(w->solver->context, job.data);
    return status;
}

/* ---- Memory ---- */

static pnb_status layers(struct gl_device *device, enum gl_format format, int columns, int rows,
                         int count, struct gl_texture **out, struct gl_target **targets,
                         struct gl_texture *depth)
{
    pnb_status status = gl_texture_create(device,
                                          &(struct gl_texture_desc){.kind = GL_TEXTURE_LAYERS,
                                                                    .format = format,
                                                                    .width = columns,
                                                                    .height = rows,
                                                                    .layers = count},
                                          out);
    for (int i = 0; i < count && status == PNB_OK; i++)
        status = gl_target_create(
            device, &(struct gl_target_desc){.colors = {{*out, i}}, .depth = {depth, 0}},
            &targets[i]);
    return status;
}

static pnb_status reserve_maps(struct work *w)
{
    struct line_map_opengl *room = w->room;
    const struct map_set *set = w->set;
    const struct map_geometry *g = room->method.geometry;
    int samples = (int)set->count;
    bool passive = g->passive_first < g->triangle_count;
    if (room->rows == set->rows && room->columns == set->columns && room->samples == samples &&
        room->passive == passive)
        return PNB_OK;
    release_maps(room);
    struct gl_device *device = w->state->device;
    pnb_status status =
        layers(device, GL_FORMAT_R32F, set->columns, set->rows, passive ? 2 * samples : samples,
               &room->depths, room->depth_targets, NULL);
    const struct gl_texture_desc depth = {
        .format = GL_FORMAT_DEPTH32F, .width = set->columns, .height = set->rows};
    if (status == PNB_OK && room->method.nearest)
        status = gl_texture_create(device, &depth, &room->nearest);
    if (status == PNB_OK)
        status = layers(device, GL_FORMAT_R16F, set->columns, set->rows, 2 * (samples - 1),
                        &room->channels, room->channel_targets, room->nearest);
    if (status != PNB_OK) {
        release_maps(room);
        return status;
    }
    room->rows = set->rows;
    room->columns = set->columns;
    room->samples = samples;
    room->passive = passive;
    return PNB_OK;
}

/* ---- Stages ---- */

static struct gl_uniform place_of(const char *name, const struct map *map)
{
    const double place[3] = {map->at, (double)map->low, (double)map->scale};
    return gl_vec3(name, place);
}

/* The uniforms of frame.glsl; returns how many. */
static int frame_uniforms(const struct map_set *set, struct gl_uniform *uniforms)
{
    uniforms[0] = gl_int("wide", set->wide);
    uniforms[1] = gl_vec2("map_size", set->columns, set->rows);
    return 2;
}

static void draw_maps(struct work *w)
{
    struct line_map_opengl *room = w->room;
    const struct map_set *set = w->set;
    const struct map_geometry *g = room->method.geometry;
    const size_t stride = TRIANGLE_FLOATS * sizeof(float);
    for (int i = 0; i < (room->passive ? 2 : 1) * room->samples; i++) {
        bool passive = i >= room->samples;
        size_t first = passive ? g->passive_first : 0;
        struct gl_clear clear = {.color = {true}};
        gl_target_clear(room->depth_targets[i], &clear);
        struct gl_draw draw = {
            .program = room->map,
            .target = room->depth_targets[i],
            .primitive = GL_PRIMITIVE_TRIANGLE_STRIP,
            .count = 4,
            .instances = (passive ? g->triangle_count : g->passive_first) - first,
            .blend = GL_BLEND_MAX,
        };
        if (draw.instances == 0)
            continue;
        for (size_t k = 0; k < 4; k++)
            draw.attributes[k] =
                (struct gl_attribute){.buffer = room->triangles,
                                      .components = k < 3 ? 3 : 2,
                                      .stride = stride,
                                      .offset = first * stride + k * 3 * sizeof(float),
                                      .divisor = 1};
        int n = frame_uniforms(set, draw.uniforms);
        draw.uniforms[n++] = place_of("place", &set->maps[i % room->samples]);
        draw.uniforms[n++] = gl_float("near_r", set->near_r);
        draw.uniforms[n++] = gl_sampler("row_frame", room->row_frame);
        gl_draw(w->state->device, &draw);
    }
}

/* Depths back to the CPU's maps. */
static pnb_status read_maps(struct work *w)
{
    struct map_set *set = w->set;
    size_t texels = (size_t)set->rows * (size_t)set->columns;
    pnb_status status = PNB_OK;
    for (size_t i = 0; i < set->count && status == PNB_OK; i++) {
        set->maps[i].q = memory_alloc(w->solver->context, texels, sizeof(float));
        if (!set->maps[i].q)
            return status_no_memory(w->solver->context, texels * sizeof(float));
        status = gl_texture_read(w->room->depths, (int)i, set->maps[i].q);
    }
    return status;
}

/* The texels of discontinuities as (column, row): of each map those with the occluder on the left,
 * then the others. */
static pnb_status upload_jumps(struct work *w, const struct line_map_light *light)
{
    pnb_context *context = w->solver->context;
    size_t rows = (size_t)w->set->rows, total = 0, at = 0;
    for (size_t k = 0; k < light->view_count; k++)
        total += light->views[k].jump_start[rows];
    float *texels = memory_alloc(context, total, 2 * sizeof(float));
    if (!texels)
        return status_no_memory(context, total * 2 * sizeof(float));
    for (size_t k = 0; k < light->view_count; k++)
        for (int side = 0; side < 2; side++) {
            const struct line_map_view *view = &light->views[k];
            w->first[2 * k + (size_t)side] = (uint32_t)at;
            for (size_t row = 0; row < rows; row++)
                for (uint32_t i = view->jump_start[row]; i < view->jump_start[row + 1]; i++) {
                    if (view->jumps[i].near_left != (side == 0))
                        continue;
                    texels[2 * at] = (float)view->jumps[i].column;
                    texels[2 * at++ + 1] = (float)row;
                }
        }
    w->first[2 * light->view_count] = (uint32_t)at;
    pnb_status status = PNB_OK;
    if (total > 0 && !w->room->texels)
        status = gl_buffer_create(w->state->device, NULL, total * 8, true, &w->room->texels);
    if (status == PNB_OK && total > 0)
        status = gl_buffer_write(w->room->texels, texels, total * 8);
    memory_free(context, texels);
    return status;
}

/* Pieces of all maps, and where each row of each map begins. */
static pnb_status upload_pieces(struct work *w, const struct line_map_light *light)
{
    pnb_context *context = w->solver->context;
    size_t rows = (size_t)w->set->rows, total = 0, at = 0;
    for (size_t k = 0; k < light->view_count; k++)
        total += light->views[k].piece_start[rows];
    size_t high = total / PIECES_WIDE + 1;
    int most = gl_device_get_info(w->state->device)->max_texture_size;
    if (high > (size_t)most || rows + 1 > (size_t)most)
        return status_fail(
            context, PNB_ERROR_DEVICE, "line-map",
            "%zu pieces of surfaces are too many for the device; -p between=dark does "
            "without",
            total);
    float *texels = memory_calloc(context, high * PIECES_WIDE, 16);
    float *starts = memory_alloc(context, (rows + 1) * light->view_count, sizeof(float));
    pnb_status status = PNB_OK;
    if (!texels || !starts)
        status = status_no_memory(context, high * PIECES_WIDE * 16);
    for (size_t k = 0; k < light->view_count && status == PNB_OK; k++) {
        const struct line_map_view *view = &light->views[k];
        for (size_t row = 0; row <= rows; row++)
            starts[k * (rows + 1) + row] = (float)(at + view->piece_start[row]);
        memcpy(texels + 4 * at, view->pieces, view->piece_start[rows] * sizeof(*view->pieces));
        at += view->piece_start[rows];
    }
    if (status == PNB_OK)
        status = gl_texture_create(w->state->device,
                                   &(struct gl_texture_desc){.format = GL_FORMAT_RGBA32F,
                                                             .width = PIECES_WIDE,
                                                             .height = (int)high,
                                                             .texels = texels},
                                   &w->room->pieces);
    if (status == PNB_OK)
        status = gl_texture_create(w->state->device,
                                   &(struct gl_texture_desc){.format = GL_FORMAT_R32F,
                                                             .width = (int)rows + 1,
                                                             .height = (int)light->view_count,
                                                             .texels = starts},
                                   &w->room->piece_rows);
    memory_free(context, texels);
    memory_free(context, starts);
    return status;
}

static pnb_status scan_maps(struct work *w)
{
    struct line_map_light light = {
        .method = &w->room->method, .context = w->solver->context, .set = w->set};
    pnb_status status = read_maps(w);
    if (status == PNB_OK)
        status = line_map_scan(&light);
    if (status == PNB_OK)
        status = upload_jumps(w, &light);
    if (status == PNB_OK && w->room->method.spans)
        status = upload_pieces(w, &light);
    line_map_forget_views(&light);
    return status;
}

/* The edges of map `source` (on the side `near_left`), into the channel of map `into` that ends at
 * map `other`. */
static void draw_skins(struct work *w, int source, int into, int other, int channel)
{
    struct line_map_opengl *room = w->room;
    const struct map_set *set = w->set;
    bool near_left = set->maps[into].at > set->maps[other].at;
    uint32_t first = w->first[2 * source + !near_left];
    size_t count = w->first[2 * source + !near_left + 1] - first;
    struct gl_draw draw = {
        .program = room->skin,
        .target = room->channel_targets[channel],
        .primitive = GL_PRIMITIVE_TRIANGLE_STRIP,
        .count = 4,
        .instances = count,
        .attributes = {{.buffer = room->texels,
                        .components = 2,
                        .stride = 8,
                        .offset = 8 * (size_t)first,
                        .divisor = 1}},
        .blend = room->method.nearest ? GL_BLEND_OFF : GL_BLEND_MIN,
        .depth_test = room->method.nearest,
        .depth_write = room->method.nearest,
        .depth_compare = GL_COMPARE_GREATER,
    };
    if (count == 0)
        return;
    int n = frame_uniforms(set, draw.uniforms);
    draw.uniforms[n++] = gl_sampler("depths", room->depths);
    draw.uniforms[n++] = gl_int("source_layer", source);
    draw.uniforms[n++] = gl_int("into_layer", into);
    draw.uniforms[n++] = gl_int("passive_layer", room->passive ? into + room->samples : -1);
    draw.uniforms[n++] = place_of("source", &set->maps[source]);
    draw.uniforms[n++] = place_of("into", &set->maps[into]);
    draw.uniforms[n++] = gl_float("shift", set->maps[other].at - set->maps[into].at);
    draw.uniforms[n++] = gl_int("own", source == into);
    draw.uniforms[n++] = gl_float("far_q", set->far_q);
    draw.uniforms[n++] = gl_float("slack_texels", LINE_MAP_SLACK);
    gl_draw(w->state->device, &draw);
    room->method.skins += (double)count;
}

static void draw_channels(struct work *w)
{
    struct line_map_opengl *room = w->room;
    for (int channel = 0; channel < 2 * (room->samples - 1); channel++) {
        int left = channel / 2, right = left + 1;
        int into = channel % 2 ? right : left, other = channel % 2 ? left : right;
        struct gl_clear clear = {.color = {true},
                                 .color_value = {{2, 2, 2, 2}}, /* no skin */
                                 .depth = room->method.nearest,
                                 .depth_value = 0};
        gl_target_clear(room->channel_targets[channel], &clear);
        draw_skins(w, other, into, other, channel);
        if (room->method.own_edges)
            draw_skins(w, into, into, other, channel);
    }
}

static void look_up(struct work *w, const struct gl_frame *frame, struct gl_target *target,
                    double weight)
{
    struct line_map_opengl *room = w->room;
    const struct map_set *set = w->set;
    const struct map_geometry *g = room->method.geometry;
    float planes[MAP_FLOORS_MOST][4], ranges[MAP_FLOORS_MOST][2];
    struct gl_draw draw = {.program = room->look_up, .target = target, .blend = GL_BLEND_ADD};
    struct gl_uniform *u = draw.uniforms;
    int n = frame_uniforms(set, u), open = 0;
    u[n++] = gl_sampler("frame_position", frame->position);
    u[n++] = gl_sampler("frame_normal", frame->normal);
    u[n++] = gl_sampler("row_frame", room->row_frame);
    u[n++] = gl_sampler("sectors", room->sectors);
    u[n++] = gl_sampler("floors", room->floors);
    u[n++] = gl_sampler("places", room->places);
    u[n++] = gl_sampler("depths", room->depths);
    u[n++] = gl_sampler("channels", room->channels);
    if (room->pieces) {
        u[n++] = gl_sampler("pieces", room->pieces);
        u[n++] = gl_sampler("piece_rows", room->piece_rows);
    }
    u[n++] = gl_int("spans", room->pieces != NULL);
    u[n++] = gl_int("sample_count", set->empty ? 0 : room->samples);
    u[n++] = gl_int("no_maps", set->empty);
    u[n++] = gl_int("round_rows", set->round);
    u[n++] = gl_vec3("start", (const double[3]){set->origin.x, set->origin.y, set->origin.z});
    u[n++] = gl_vec3("axis", (const double[3]){set->axis.x, set->axis.y, set->axis.z});
    u[n++] = gl_vec3("axis_y", (const double[3]){set->y.x, set->y.y, set->y.z});
    u[n++] = gl_vec3("axis_z", (const double[3]){set->z.x, set->z.y, set->z.z});
    u[n++] = gl_float("line_length", set->length);
    u[n++] = gl_float("near_r", set->near_r);
    u[n++] = gl_float("phi_step", set->phi_step);
    u[n++] = gl_float("bias", room->method.bias);
    u[n++] = gl_float("weight", weight);
    for (size_t k = 0; k < g->floor_count && open < MAP_FLOORS_MOST; k++) {
        if (!set->floor_open[k])
            continue;
        memcpy(planes[open], set->floors[open], sizeof(planes[open]));
        ranges[open][0] = (float)(g->floors[k].first_triangle - g->floors[0].first_triangle);
        ranges[open][1] = (float)g->floors[k].triangle_count;
        open++;
    }
    u[n++] = gl_int("floor_count", open);
    if (open > 0) {
        u[n++] = gl_floats("floor_planes", GL_UNIFORM_VEC4, planes[0], open);
        u[n++] = gl_floats("floor_triangles", GL_UNIFORM_VEC2, ranges[0], open);
    }
    gl_draw_cover(w->state->device, &draw);
}

/* ---- A frame ---- */

/* The frame's receivers, read back, from the top as on the CPU: samples=auto asks for the
 * visibility of some of them. */
static pnb_status read_receivers(struct work *w, const struct gl_frame *frame,
                                 pnb_receivers *receivers, float **out_memory)
{
    size_t width = (size_t)frame->width, height = (size_t)frame->height, count = width * height;
    float *memory = *out_memory = memory_alloc(w->solver->context, count, 14 * sizeof(float));
    if (!memory)
        return status_no_memory(w->solver->context, count * 14 * sizeof(float));
    float *read[2] = {memory, memory + 4 * count}, *kept[2] = {memory + 8 * count, NULL};
    kept[1] = kept[0] + 3 * count;
    pnb_status status = gl_texture_read(frame->position, 0, read[0]);
    if (status == PNB_OK)
        status = gl_texture_read(frame->normal, 0, read[1]);
    for (size_t i = 0; i < count && status == PNB_OK; i++) {
        size_t from = (height - 1 - i / width) * width + i % width;
        bool none = !(read[0][4 * from + 3] > 0);
        for (size_t k = 0; k < 6; k++)
            kept[k / 3][3 * i + k % 3] = none ? NAN : read[k / 3][4 * from + k % 3];
    }
    *receivers = (pnb_receivers){.count = count, .positions = kept[0], .normals = kept[1]};
    return status;
}

static int by_place(const void *a, const void *b)
{
    const struct map_sample *p = a, *q = b;
    return (p->at > q->at) - (p->at < q->at);
}

/* The places of samples=auto, in order. */
static pnb_status choose_places(struct work *w, const struct gl_frame *frame, vec3 from, vec3 to,
                                struct map_sample *places, size_t *count)
{
    struct line_map_opengl *room = w->room;
    struct line_map_light *light;
    pnb_receivers receivers;
    float *memory = NULL;
    double estimate = 0;
    pnb_status status = line_map_light_create(&room->method, from, to, *count, &light);
    if (status != PNB_OK)
        return status;
    status = read_receivers(w, frame, &receivers, &memory);
    if (status == PNB_OK)
        status = line_map_refine(light, &receivers, SAMPLES_MOST, &estimate);
    if (status == PNB_OK && light->set->count > 0) {
        *count = light->set->count;
        for (size_t i = 0; i < *count; i++)
            places[i].at = light->set->maps[i].at;
        qsort(places, *count, sizeof(*places), by_place);
    }
    room->method.estimate = fmax(room->method.estimate, estimate);
    if (status == PNB_OK && estimate > room->method.target)
        solver_warn(w->solver,
                    "samples=auto stopped at %zu samples with an estimated error of %.3g", *count,
                    estimate);
    memory_free(w->solver->context, memory);
    line_map_light_destroy(light);
    return status;
}

/* Maps and channels of one linear light. */
static pnb_status prepare_light(struct work *w, const struct gl_frame *frame, vec3 from, vec3 to)
{
    struct line_map_opengl *room = w->room;
    struct line_map *m = &room->method;
    struct map_sample places[SAMPLES_MOST];
    double started = clock_ms();
    vec3 along = v3_sub(to, from);
    size_t count = (size_t)w->solver->samples;
    if (m->automatic && count < LINE_MAP_AUTO_START)
        count = LINE_MAP_AUTO_START;
    struct map_set_desc desc = {.geometry = m->geometry,
                                .origin = from,
                                .axis = v3_normalize(along),
                                .length = v3_length(along),
                                .rows = m->rows,
                                .columns = m->columns,
                                .laid_out = true};
    for (size_t i = 0; i < count; i++)
        places[i].at = desc.length * (double)i / (double)(count - 1);
    pnb_status status = m->automatic ? choose_places(w, frame, from, to, places, &count) : PNB_OK;
    if (status == PNB_OK)
        status = map_set_create(&desc, &w->set);
    for (size_t i = 0; i < count; i++) {
        places[i].neighbour_low = places[i > 0 ? i - 1 : 0].at;
        places[i].neighbour_high = places[i + 1 < count ? i + 1 : i].at;
    }
    if (status == PNB_OK && !w->set->empty)
        status = map_set_lay_out(w->set, places, count);
    if (status == PNB_OK)
        status = upload_rows(w);
    if (status == PNB_OK)
        status = upload_sectors(w);
    if (status == PNB_OK)
        status = upload_floors(w);
    if (status == PNB_OK)
        status = upload_places(w);
    if (status != PNB_OK || w->set->empty)
        return status;
    status = upload_triangles(w);
    if (status == PNB_OK)
        status = reserve_maps(w);
    if (status != PNB_OK)
        return status;
    draw_maps(w);
    gl_device_finish(w->state->device);
    m->map_ms += clock_ms() - started;
    started = clock_ms();
    w->first = memory_calloc(w->solver->context, 2 * count + 1, sizeof(*w->first));
    status = w->first ? scan_maps(w) : status_no_memory(w->solver->context, count * 8);
    if (status == PNB_OK) {
        draw_channels(w);
        gl_device_finish(w->state->device);
    }
    m->skin_ms += clock_ms() - started;
    m->maps += (double)count;
    return status;
}

static pnb_status draw(pnb_solver *solver, struct opengl_state *state,
                       const struct light_shape *shape, const pnb_light *light,
                       const struct gl_frame *frame, struct gl_texture *visibility)
{
    struct line_map_opengl *room = state->room;
    struct gl_target *target;
    pnb_status status = gl_target_create(
        state->device, &(struct gl_target_desc){.colors = {{visibility, 0}}}, &target);
    if (status != PNB_OK)
        return status;
    struct gl_clear clear = {.color = {true}};
    gl_target_clear(target, &clear);
    line_map_reset_counters(&room->method);
    size_t edges = line_map_edge_count(light);
    for (size_t k = 0; k < edges && status == PNB_OK; k++) {
        struct work w = {solver, state, room, NULL, NULL};
        vec3 from, to;
        double weight = line_map_edge(light, shape, k, &from, &to);
        status = prepare_light(&w, frame, from, to);
        if (status == PNB_OK) {
            double started = clock_ms();
            look_up(&w, frame, target, weight);
            gl_device_finish(state->device);
            room->method.look_up_ms += clock_ms() - started;
        }
        release_light(room);
        map_set_destroy(w.set);
        memory_free(solver->context, w.first);
    }
    gl_target_destroy(target);
    line_map_report(solver, &room->method, light);
    return status;
}

const struct opengl_method line_map_opengl = {create, destroy, changed, draw};
