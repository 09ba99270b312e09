/* method/dbuffer/draw.c: the D-buffer on the device: its programs, its textures, and the passes
 * that fill it, face by face: the occluders and, behind the first, the next; then umbra and
 * penumbra volumes, one layer after the other, each against the depth buffer of its own distances.
 */
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "method/dbuffer/room.h"

#define FACE_FLOATS 12 /* of a vertex: its place, v1, v2, p, line */

static pnb_status make_program(struct dbuffer *b, const char *vertex, const char *fragment,
                               const char *defines, const char *const *attributes, int count,
                               struct gl_program **out)
{
    struct gl_program_desc desc = {.vertex = vertex,
                                   .fragment = fragment,
                                   .defines = defines,
                                   .attributes = attributes,
                                   .attribute_count = count};
    return gl_program_create(b->device, &desc, out);
}

pnb_status dbuffer_programs_create(pnb_solver *solver, struct dbuffer *b)
{
    static const char *const position[] = {"position"}, *const piece[] = {"v1",       "v2",
                                                                          "p",        "lines",
                                                                          "outline1", "outline2",
                                                                          "outline_p"},
                             *const face[] = {"position", "v1", "v2", "p", "line"};
    const char *layered = b->layers == 2 ? "#define LAYERS2 1\n" : "";
    char defines[256];
    pnb_status status = PNB_OK;
    for (int layer = 0; layer < b->layers && status == PNB_OK; layer++) {
        const char *second = layer == 1 ? "#define SECOND 1\n" : "";
        status = make_program(b, "method/dbuffer/occluder.vert", "method/dbuffer/occluder.frag",
                              second, position, 1, &b->draw[OCCLUDER][layer]);
        for (int i = 0; i < 4 && status == PNB_OK; i++) {
            int kind = i & 1 ? PENUMBRA : UMBRA;
            bool fan = i & 2;
            snprintf(defines, sizeof(defines), "%s%s%s%s", layered, second,
                     kind == PENUMBRA ? "" : "#define UMBRA 1\n",
                     fan                ? "#define FAN 1\n"
                     : kind == PENUMBRA ? ""
                                        : "#define OUTLINE 1\n");
            status =
                make_program(b, "method/dbuffer/volume.vert", "method/dbuffer/volume.frag", defines,
                             piece, 7, fan ? &b->draw_fan[kind][layer] : &b->draw[kind][layer]);
        }
        snprintf(defines, sizeof(defines), "%s%s#define UMBRA 1\n#define FACE 1\n", layered,
                 second);
        if (status == PNB_OK)
            status = make_program(b, "method/dbuffer/face.vert", "method/dbuffer/volume.frag",
                                  defines, face, 5, &b->draw_face[layer]);
    }
    const char *v = solver_param(solver, "v");
    snprintf(defines, sizeof(defines), "%s%s#define V_FORM %d\n", layered,
             strcmp(solver_param(solver, "filter"), "linear") == 0 ? "#define LINEAR 1\n" : "",
             strcmp(v, "paper") == 0  ? 0
             : strcmp(v, "disk") == 0 ? 1
                                      : 2);
    if (status == PNB_OK)
        status = make_program(b, "gl/cover.vert", "method/dbuffer/evaluate.frag", defines, NULL, 0,
                              &b->evaluate);
    if (status == PNB_OK)
        status =
            make_program(b, "gl/cover.vert", "method/dbuffer/point.frag", NULL, NULL, 0, &b->point);
    return status;
}

void dbuffer_textures_destroy(struct dbuffer *b)
{
    for (int kind = 0; kind < KINDS; kind++)
        for (int layer = 0; layer < 2; layer++) {
            for (int i = 0; i < DBUFFER_FACES; i++) {
                gl_target_destroy(b->targets[kind][layer][i]);
                b->targets[kind][layer][i] = NULL;
            }
            gl_texture_destroy(b->textures[kind][layer]);
            b->textures[kind][layer] = NULL;
        }
    gl_texture_destroy(b->depth);
    b->depth = NULL;
    b->face_count = 0;
}

pnb_status dbuffer_textures_reserve(struct dbuffer *b)
{
    int faces = b->map.face_count, size = b->map.size;
    if (faces <= b->face_count && (faces == 0 || size == b->texture_size))
        return PNB_OK;
    dbuffer_textures_destroy(b);
    struct gl_texture_desc depth = {.format = GL_FORMAT_DEPTH32F, .width = size, .height = size};
    pnb_status status = gl_texture_create(b->device, &depth, &b->depth);
    for (int kind = 0; kind < KINDS; kind++)
        for (int layer = 0; layer < b->layers && status == PNB_OK; layer++) {
            struct gl_texture_desc desc = {.kind = GL_TEXTURE_LAYERS,
                                           .format = kind != OCCLUDER ? GL_FORMAT_RGBA32F
                                                     : layer == 0     ? GL_FORMAT_RG32F
                                                                      : GL_FORMAT_R32F,
                                           .width = size,
                                           .height = size,
                                           .layers = faces};
            status = gl_texture_create(b->device, &desc, &b->textures[kind][layer]);
            for (int i = 0; i < faces && status == PNB_OK; i++) {
                struct gl_target_desc target = {.colors = {{b->textures[kind][layer], i}},
                                                .depth = {b->depth, 0}};
                status = gl_target_create(b->device, &target, &b->targets[kind][layer][i]);
            }
        }
    b->texture_size = size;
    if (status == PNB_OK)
        b->face_count = faces;
    else
        dbuffer_textures_destroy(b);
    return status;
}

static void clear(struct dbuffer_pass *pass, int kind, int layer)
{
    struct gl_clear clear = {.color = {true}, .depth = true, .depth_value = 1};
    gl_target_clear(pass->b->targets[kind][layer][pass->face], &clear);
}

static struct gl_draw begin_draw(struct dbuffer_pass *pass, struct gl_program *program, int kind,
                                 int layer)
{
    return (struct gl_draw){.program = program,
                            .target = pass->b->targets[kind][layer][pass->face],
                            .depth_test = true,
                            .depth_write = true,
                            .depth_compare = GL_COMPARE_LESS};
}

static void draw_occluders(struct dbuffer_pass *pass, int layer)
{
    struct dbuffer *b = pass->b;
    const struct gl_occluders *o = pass->occluders;
    double matrix[16];
    dbuffer_map_matrix(&b->map, pass->face, pass->disk, true, matrix);
    clear(pass, OCCLUDER, layer);
    struct gl_draw draw = begin_draw(pass, b->draw[OCCLUDER][layer], OCCLUDER, layer);
    draw.indices = o->index_buffer;
    draw.attributes[0] = (struct gl_attribute){o->position_buffer, 3};
    struct gl_uniform *u = draw.uniforms;
    *u++ = gl_vec3("center", &pass->disk->center.x);
    *u++ = gl_mat4("clip_from_relative", matrix);
    *u++ = gl_float("per_far", pass->per_far);
    *u++ = gl_float("gap", pass->gap);
    *u++ = gl_vec3("axis_u", &pass->disk->u.x);
    *u++ = gl_vec3("axis_v", &pass->disk->v.x);
    *u++ = gl_vec3("axis_n", &pass->disk->normal.x);
    if (layer == 1) {
        *u++ = gl_sampler("first_texture", b->textures[OCCLUDER][0]);
        *u++ = gl_int("face", pass->face);
    }
    /* Neighbours of a kind in one draw. */
    for (size_t i = 0; i < o->object_count;) {
        size_t end = i;
        draw.first = o->objects[i].first_index;
        draw.count = 0;
        for (; end < o->object_count && o->objects[end].closed == o->objects[i].closed &&
               dbuffer_casts(&o->objects[end], pass->disk);
             end++)
            draw.count += o->objects[end].index_count;
        *u = gl_int("closed", o->objects[i].closed);
        gl_draw(b->device, &draw);
        i = end > i ? end : i + 1;
    }
}

static void draw_pieces(struct dbuffer_pass *pass, struct gl_draw *draw, struct gl_program *program,
                        struct gl_buffer *buffer, size_t count)
{
    const size_t stride = sizeof(struct dbuffer_piece);
    static const struct {
        int components;
        size_t offset;
    } attributes[] = {{3, offsetof(struct dbuffer_piece, v1)},
                      {3, offsetof(struct dbuffer_piece, v2)},
                      {4, offsetof(struct dbuffer_piece, p1)},
                      {2, offsetof(struct dbuffer_piece, line)},
                      {3, offsetof(struct dbuffer_piece, outline1)},
                      {3, offsetof(struct dbuffer_piece, outline2)},
                      {2, offsetof(struct dbuffer_piece, outline_p)}};
    if (count == 0)
        return;
    draw->program = program;
    draw->count = 6;
    draw->instances = count;
    for (int i = 0; i < 7; i++)
        draw->attributes[i] = (struct gl_attribute){buffer, attributes[i].components, false,
                                                    stride, attributes[i].offset,     1};
    gl_draw(pass->b->device, draw);
}

static void draw_faces(struct dbuffer_pass *pass, struct gl_draw *draw, struct gl_program *program)
{
    static const int components[] = {3, 3, 3, 2, 1};
    struct dbuffer *b = pass->b;
    size_t stride = FACE_FLOATS * sizeof(float), offset = 0;
    if (b->volumes.face_count == 0)
        return;
    memset(draw->attributes, 0, sizeof(draw->attributes));
    draw->program = program;
    draw->instances = 0;
    draw->count = 3 * b->volumes.face_count;
    for (int i = 0; i < 5; i++) {
        draw->attributes[i] =
            (struct gl_attribute){b->faces, components[i], false, stride, offset, 0};
        offset += (size_t)components[i] * sizeof(float);
    }
    gl_draw(b->device, draw);
}

static void draw_volume(struct dbuffer_pass *pass, int kind, int layer)
{
    struct dbuffer *b = pass->b;
    double matrix[16];
    dbuffer_map_matrix(&b->map, pass->face, pass->disk, false, matrix);
    clear(pass, kind, layer);
    struct gl_draw draw = begin_draw(pass, NULL, kind, layer);
    struct gl_uniform *u = draw.uniforms;
    *u++ = gl_mat4("clip_from_light", matrix);
    *u++ = gl_float("radius", pass->disk->radius);
    *u++ = gl_float("far_z", pass->far_z);
    *u++ = gl_int("map_face_count", b->map.face_count);
    *u++ = gl_float("per_far", pass->per_far);
    *u++ = gl_int("face", pass->face);
    *u++ = gl_floats("map_axes", GL_UNIFORM_VEC3, pass->axes, 3 * b->map.face_count);
    *u++ = gl_vec4("map_fit", b->map.shift[0], b->map.shift[1], b->map.reach[0], b->map.reach[1]);
    *u++ = gl_float("map_size", b->map.size);
    *u++ = gl_sampler("occluder_texture", b->textures[OCCLUDER][0]);
    if (b->layers == 2)
        *u++ = gl_sampler("behind_texture", b->textures[OCCLUDER][1]);
    if (layer == 1)
        *u++ = gl_sampler("first_texture", b->textures[kind][0]),
        *u++ = gl_sampler("lines", b->lines);
    int which = kind == PENUMBRA;
    draw_pieces(pass, &draw, b->draw[kind][layer], b->quads[which], b->volumes.quads[which].count);
    draw_pieces(pass, &draw, b->draw_fan[kind][layer], b->fans[which],
                b->volumes.fans[which].count);
    if (kind == UMBRA)
        draw_faces(pass, &draw, b->draw_face[layer]);
}

/* Lines as a picture that pixels fetch from, two texels each. */
static pnb_status upload_lines(pnb_solver *solver, struct dbuffer *b)
{
    struct dbuffer_volumes *v = &b->volumes;
    size_t rows = v->line_count / DBUFFER_LINES + 1, capacity = rows * DBUFFER_LINES;
    pnb_status status = PNB_OK;
    if (!b->lines || (size_t)gl_texture_height(b->lines) < rows) {
        rows += rows / 2;
        struct gl_texture_desc desc = {
            .format = GL_FORMAT_RGBA32F, .width = 2 * DBUFFER_LINES, .height = (int)rows};
        gl_texture_destroy(b->lines);
        b->lines = NULL;
        status = gl_texture_create(b->device, &desc, &b->lines);
    }
    if (status != PNB_OK)
        return status;
    capacity = (size_t)gl_texture_height(b->lines) * DBUFFER_LINES;
    if (!memory_reserve(solver->context, (void **)&v->lines, &v->line_capacity, v->line_count,
                        capacity - v->line_count, sizeof(*v->lines)))
        return status_no_memory(solver->context, capacity * sizeof(*v->lines));
    memset(v->lines + v->line_count, 0, (capacity - v->line_count) * sizeof(*v->lines));
    gl_texture_upload(b->lines, 0, v->lines);
    return PNB_OK;
}

pnb_status dbuffer_volumes_upload(pnb_solver *solver, struct dbuffer *b)
{
    const struct dbuffer_volumes *v = &b->volumes;
    pnb_status status = PNB_OK;
    for (int i = 0; i < 4 && status == PNB_OK; i++) {
        const struct dbuffer_pieces *p = i < 2 ? &v->quads[i] : &v->fans[i - 2];
        if (p->count > 0)
            status = gl_buffer_write(i < 2 ? b->quads[i] : b->fans[i - 2], p->pieces,
                                     p->count * sizeof(*p->pieces));
    }
    if (status == PNB_OK)
        status = upload_lines(solver, b);
    if (status != PNB_OK || v->face_count == 0)
        return status;
    if (!memory_reserve(solver->context, (void **)&b->face_vertices, &b->face_capacity, 0,
                        3 * FACE_FLOATS * v->face_count, sizeof(float)))
        return status_no_memory(solver->context, 3 * FACE_FLOATS * v->face_count * sizeof(float));
    float *out = b->face_vertices;
    for (size_t i = 0; i < v->face_count; i++)
        for (int k = 0; k < 3; k++, out += FACE_FLOATS) {
            const struct dbuffer_face *face = &v->faces[i];
            memcpy(out, face->corners[k], 3 * sizeof(float));
            memcpy(out + 3, face->v1, 3 * sizeof(float));
            memcpy(out + 6, face->v2, 3 * sizeof(float));
            memcpy(out + 9, face->p, 2 * sizeof(float));
            out[11] = face->line;
        }
    return gl_buffer_write(b->faces, b->face_vertices,
                           3 * FACE_FLOATS * v->face_count * sizeof(float));
}

void dbuffer_draw_faces(struct dbuffer_pass *pass)
{
    struct dbuffer *b = pass->b;
    /* The occluders of all faces first: volumes look beside outlines, on any of them. */
    for (pass->face = 0; pass->face < b->map.face_count; pass->face++)
        for (int layer = 0; layer < b->layers; layer++)
            draw_occluders(pass, layer);
    for (pass->face = 0; pass->face < b->map.face_count; pass->face++)
        for (int kind = UMBRA; kind <= PENUMBRA; kind++)
            for (int layer = 0; layer < b->layers; layer++)
                draw_volume(pass, kind, layer);
}
