/* viewer/gpu_scene.c: the scene in the window's context: vertex buffers, materials, solvers.
 *
 * Solvers of the library's door for engines work on the scene's copy (view_twin), which belongs to
 * the window's thread. Triangles are stored one by one with their plane's normal, so that it is
 * exact: 108 bytes each.
 */
#include "gpu_inside.h"

#include <penumbra/opengl.h>
#include <stdlib.h>
#include <string.h>

/* ---- meshes ---- */

static bool fill_mesh(const pnb_mesh_desc *mesh, float *to, double box[6])
{
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        vec3 p[3];
        for (int k = 0; k < 3; k++) {
            const float *q = mesh->positions + 3 * (size_t)mesh->indices[3 * t + (size_t)k];
            p[k] = v3(q[0], q[1], q[2]);
            for (int c = 0; c < 3; c++) {
                box[c] = fmin(box[c], q[c]);
                box[3 + c] = fmax(box[3 + c], q[c]);
            }
        }
        vec3 n = v3_unit(v3_cross(v3_sub(p[1], p[0]), v3_sub(p[2], p[0])), v3(0, 0, 0));
        for (int k = 0; k < 3; k++, to += 9) {
            const uint32_t index = mesh->indices[3 * t + (size_t)k];
            const float values[6] = {(float)p[k].x, (float)p[k].y, (float)p[k].z,
                                     (float)n.x,    (float)n.y,    (float)n.z};
            memcpy(to, values, sizeof(values));
            for (int c = 0; c < 3; c++)
                to[6 + c] = mesh->normals ? mesh->normals[3 * (size_t)index + (size_t)c] : 0;
        }
    }
    return true;
}

static bool open_mesh(const pnb_scene *scene, size_t index, struct gpu_mesh *mesh, double box[6])
{
    pnb_mesh_desc desc;
    pnb_scene_mesh(scene, index, &desc);
    for (int c = 0; c < 3; c++) {
        box[c] = INFINITY;
        box[3 + c] = -INFINITY;
    }
    if (desc.triangle_count == 0)
        return true;
    size_t bytes = desc.triangle_count * 27 * sizeof(float);
    float *values = malloc(bytes);
    if (!values || desc.triangle_count > INT32_MAX / 3) {
        free(values);
        return false;
    }
    fill_mesh(&desc, values, box);
    mesh->count = (GLsizei)(3 * desc.triangle_count);
    glGenVertexArrays(1, &mesh->array);
    glBindVertexArray(mesh->array);
    glGenBuffers(1, &mesh->buffer);
    glBindBuffer(GL_ARRAY_BUFFER, mesh->buffer);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)bytes, values, GL_STATIC_DRAW);
    for (GLuint i = 0; i < 3; i++) {
        glEnableVertexAttribArray(i);
        glVertexAttribPointer(i, 3, GL_FLOAT, GL_FALSE, 36, (const char *)NULL + 12 * i);
    }
    glBindVertexArray(0);
    free(values);
    return true;
}

static void open_materials(struct gpu_scene *s, const pnb_scene *scene)
{
    size_t count = s->scene->object_count;
    float *texels = g_new0(float, 8 * (count + 1));
    for (size_t i = 0; i < count; i++) {
        pnb_object object;
        pnb_scene_object(scene, i, &object);
        for (int c = 0; c < 3; c++) {
            texels[8 * i + (size_t)c] = (float)object.color[c];
            texels[8 * i + 4 + (size_t)c] = (float)object.emission[c];
        }
        texels[8 * i + 3] = object.receives;
    }
    glGenTextures(1, &s->materials);
    glBindTexture(GL_TEXTURE_2D, s->materials);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, 2, (GLsizei)MAX(count, 1), 0, GL_RGBA, GL_FLOAT,
                 texels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    g_free(texels);
}

bool gpu_scene_open(struct gpu_scene *s, struct view_scene *scene, char *why, size_t size)
{
    GLint most = 0;
    gpu_scene_close(s);
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    if (!scene->twin || scene->object_count > (size_t)most) {
        g_strlcpy(why, scene->twin ? "too many objects" : "no memory for its copy", size);
        return false;
    }
    while (glGetError() != GL_NO_ERROR)
        ;
    const pnb_scene *twin = scene->twin->scene;
    s->scene = view_scene_ref(scene);
    s->mesh_count = pnb_scene_mesh_count(twin);
    s->meshes = g_new0(struct gpu_mesh, s->mesh_count + 1);
    s->boxes = g_malloc0_n(s->mesh_count + 1, sizeof(*s->boxes));
    bool good = true;
    for (size_t i = 0; i < s->mesh_count && good; i++)
        good = open_mesh(twin, i, &s->meshes[i], s->boxes[i]);
    open_materials(s, twin);
    if (good && glGetError() == GL_NO_ERROR)
        return true;
    gpu_scene_close(s);
    g_strlcpy(why, "no memory for its triangles", size);
    return false;
}

static void drop_solver(struct gpu_solver *solver)
{
    pnb_solver_destroy(solver->solver);
    view_method_finish(&solver->method);
    *solver = (struct gpu_solver){0};
}

void gpu_scene_close(struct gpu_scene *s)
{
    for (int side = 0; side < VIEW_SIDES; side++)
        drop_solver(&s->solvers[side]);
    for (size_t i = 0; i < s->mesh_count; i++) {
        glDeleteVertexArrays(1, &s->meshes[i].array);
        glDeleteBuffers(1, &s->meshes[i].buffer);
    }
    glDeleteTextures(1, &s->materials);
    g_free(s->meshes);
    g_free(s->boxes);
    view_scene_unref(s->scene);
    *s = (struct gpu_scene){0};
}

/* ---- placements ---- */

void gpu_scene_move(struct gpu_scene *s, const struct view_state *state)
{
    pnb_scene *scene = s->scene->twin->scene;
    bool moved = false;
    for (size_t i = 0; i < state->object_count; i++) {
        pnb_object object;
        pnb_scene_object(scene, i, &object);
        if (memcmp(object.world_from_mesh, state->placements[i], sizeof(*state->placements)) != 0 &&
            pnb_scene_set_placement(scene, i, state->placements[i]) == PNB_OK)
            moved = true;
    }
    if (moved)
        s->moves++;
}

/* The eye's distance from the objects' boxes, along the view's axis in the picture's corner. */
double gpu_scene_near(const struct gpu_scene *s, const struct view_state *state, double corner)
{
    double nearest = INFINITY, farthest = 0;
    vec3 eye = v3_load(state->camera.eye);
    for (size_t i = 0; i < state->object_count; i++) {
        pnb_object object;
        pnb_scene_object(s->scene->twin->scene, i, &object);
        const double *m = object.world_from_mesh, *box = s->boxes[object.mesh];
        if (!(box[0] <= box[3]))
            continue;
        double apart = 0, away = 0;
        for (int c = 0; c < 3; c++) {
            double low = m[4 * c + 3], high = low, at = c == 0 ? eye.x : c == 1 ? eye.y : eye.z;
            for (int k = 0; k < 3; k++) {
                double a = m[4 * c + k] * box[k], b = m[4 * c + k] * box[3 + k];
                low += fmin(a, b);
                high += fmax(a, b);
            }
            double gap = fmax(fmax(low - at, at - high), 0), end = fmax(high - at, at - low);
            apart += gap * gap;
            away += end * end;
        }
        nearest = fmin(nearest, sqrt(apart));
        farthest = fmax(farthest, sqrt(away));
    }
    return fmax(fmax(0.99 * nearest * corner, 1e-4 * farthest), 1e-20);
}

/* ---- solvers ---- */

pnb_status gpu_scene_solver(struct gpu_scene *s, int side, const struct view_method *method)
{
    struct gpu_solver *solver = &s->solvers[side];
    if (solver->tried && view_method_equal(&solver->method, method)) {
        if (!solver->solver || solver->moves == s->moves)
            return solver->status;
        pnb_status status = pnb_solver_update(solver->solver, PNB_UPDATE_PLACEMENTS);
        solver->moves = s->moves;
        if (status == PNB_OK)
            return PNB_OK;
    }
    drop_solver(solver);
    const pnb_method_info *info = method->info;
    pnb_solver_param *params = g_new0(pnb_solver_param, info->param_count + 1);
    pnb_solver_desc desc = {
        .method = info->name, .samples = info->samples ? method->samples : 0, .params = params};
    for (size_t i = 0; i < info->param_count; i++)
        if (method->values[i])
            params[desc.param_count++] = (pnb_solver_param){info->params[i].key, method->values[i]};
    struct view_twin *twin = s->scene->twin;
    solver->status = pnb_gl_solver_create(twin->context, twin->scene, &desc, &solver->solver);
    g_free(params);
    if (solver->status != PNB_OK)
        g_strlcpy(solver->error, pnb_context_error(twin->context), sizeof(solver->error));
    view_method_copy(&solver->method, method);
    solver->moves = s->moves;
    solver->tried = true;
    return solver->status;
}
