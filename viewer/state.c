/* viewer/state.c: copies of what a scene holds and of what is wanted of it. */
#include "state.h"

#include <string.h>

static bool twin_progress(void *user, const char *stage, double fraction)
{
    const struct view_twin *twin = user;
    return twin->stop_us == 0 || g_get_monotonic_time() < twin->stop_us;
}

static void free_twin(struct view_twin *twin)
{
    if (!twin)
        return;
    pnb_scene_destroy(twin->scene);
    pnb_context_destroy(twin->context);
    g_free(twin);
}

/* Meshes, objects and surroundings; lights and cameras are arguments of a frame. */
static struct view_twin *make_twin(const pnb_scene *from)
{
    struct view_twin *twin = g_new0(struct view_twin, 1);
    pnb_context_desc desc = {.progress = twin_progress, .user = twin};
    pnb_status status = pnb_context_create(&desc, &twin->context);
    if (status == PNB_OK)
        status = pnb_scene_create(twin->context, &twin->scene);
    for (size_t i = 0; status == PNB_OK && i < pnb_scene_mesh_count(from); i++) {
        pnb_mesh_desc mesh;
        pnb_scene_mesh(from, i, &mesh);
        status = pnb_scene_add_mesh(twin->scene, &mesh, NULL);
    }
    for (size_t i = 0; status == PNB_OK && i < pnb_scene_object_count(from); i++) {
        pnb_object object;
        pnb_scene_object(from, i, &object);
        status = pnb_scene_add_object(twin->scene, &object, NULL);
    }
    if (status != PNB_OK) {
        free_twin(twin);
        return NULL;
    }
    double color[3];
    pnb_scene_ambient(from, color);
    pnb_scene_set_ambient(twin->scene, color);
    pnb_scene_background(from, color);
    pnb_scene_set_background(twin->scene, color);
    return twin;
}

struct view_scene *view_scene_ref(struct view_scene *scene)
{
    g_atomic_int_inc(&scene->references);
    return scene;
}

void view_scene_unref(struct view_scene *scene)
{
    if (!scene || !g_atomic_int_dec_and_test(&scene->references))
        return;
    for (size_t i = 0; i < scene->object_count; i++)
        g_free(scene->objects[i].name);
    for (size_t i = 0; i < scene->light_count; i++)
        view_light_finish(&scene->lights[i]);
    free_twin(scene->twin);
    g_free(scene->objects);
    g_free(scene->lights);
    g_strfreev(scene->notes);
    g_free(scene->path);
    g_free(scene->name);
    g_free(scene);
}

static vec3 place(const double m[12], vec3 p)
{
    return v3(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
              m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
              m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]);
}

vec3 view_object_middle(const struct view_object *object, const double world_from_mesh[12])
{
    return place(world_from_mesh, v3_load(object->mesh_middle));
}

static void include(double low[3], double high[3], const double *p)
{
    for (int c = 0; c < 3; c++) {
        low[c] = fmin(low[c], p[c]);
        high[c] = fmax(high[c], p[c]);
    }
}

struct box {
    double low[3], high[3];
};

static const struct box empty_box = {{INFINITY, INFINITY, INFINITY},
                                     {-INFINITY, -INFINITY, -INFINITY}};

static struct box mesh_box(const pnb_scene *scene, size_t index)
{
    struct box box = empty_box;
    pnb_mesh_desc mesh;
    pnb_scene_mesh(scene, index, &mesh);
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        double p[3] = {mesh.positions[3 * i], mesh.positions[3 * i + 1], mesh.positions[3 * i + 2]};
        include(box.low, box.high, p);
    }
    if (mesh.vertex_count == 0)
        memset(&box, 0, sizeof(box));
    return box;
}

static struct box placed_box(const struct box *box, const double m[12])
{
    struct box out = empty_box;
    for (int corner = 0; corner < 8; corner++) {
        double p[3];
        v3_store(p, place(m, v3(corner & 1 ? box->high[0] : box->low[0],
                                corner & 2 ? box->high[1] : box->low[1],
                                corner & 4 ? box->high[2] : box->low[2])));
        include(out.low, out.high, p);
    }
    return out;
}

static void middle_and_radius(const struct box *box, double middle[3], double *radius)
{
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        middle[c] = 0.5 * (box->low[c] + box->high[c]);
        sum += (box->high[c] - box->low[c]) * (box->high[c] - box->low[c]);
    }
    *radius = 0.5 * sqrt(sum);
}

struct view_scene *view_scene_describe(const pnb_scene *from, const char *path, uint64_t id)
{
    struct view_scene *scene = g_new0(struct view_scene, 1);
    scene->references = 1;
    scene->id = id;
    scene->path = g_strdup(path);
    scene->name = g_utf8_make_valid(pnb_scene_name(from), -1);
    pnb_scene_camera(from, &scene->camera);
    scene->triangle_count = pnb_scene_triangle_count(from);

    size_t mesh_count = pnb_scene_mesh_count(from);
    struct box *boxes = g_new(struct box, mesh_count + 1);
    for (size_t i = 0; i < mesh_count; i++)
        boxes[i] = mesh_box(from, i);

    struct box casters = empty_box, all = empty_box;
    scene->object_count = pnb_scene_object_count(from);
    scene->objects = g_new0(struct view_object, scene->object_count + 1);
    for (size_t i = 0; i < scene->object_count; i++) {
        struct view_object *object = &scene->objects[i];
        pnb_object info;
        pnb_scene_object(from, i, &info);
        object->name = info.name && *info.name ? g_utf8_make_valid(info.name, -1)
                                               : g_strdup_printf("object %zu", i + 1);
        memcpy(object->world_from_mesh, info.world_from_mesh, sizeof(object->world_from_mesh));
        memcpy(object->color, info.color, sizeof(object->color));
        object->casts = info.casts;
        object->receives = info.receives;
        object->plane = info.plane;
        double radius, middle[3];
        middle_and_radius(&boxes[info.mesh], object->mesh_middle, &radius);
        struct box box = placed_box(&boxes[info.mesh], info.world_from_mesh);
        middle_and_radius(&box, middle, &object->mesh_radius);
        include(all.low, all.high, box.low);
        include(all.low, all.high, box.high);
        if (info.casts && !info.plane) {
            include(casters.low, casters.high, box.low);
            include(casters.low, casters.high, box.high);
        }
    }
    g_free(boxes);
    const struct box unit = {{-1, -1, -1}, {1, 1, 1}};
    const struct box *of = casters.low[0] <= casters.high[0] ? &casters
                           : all.low[0] <= all.high[0]       ? &all
                                                             : &unit;
    middle_and_radius(of, scene->middle, &scene->radius);
    scene->floor = all.low[1] <= all.high[1] ? all.low[1] : 0;
    if (!(scene->radius > 0))
        scene->radius = 1;

    scene->light_count = pnb_scene_light_count(from);
    scene->lights = g_new0(struct view_light, scene->light_count + 1);
    for (size_t i = 0; i < scene->light_count; i++) {
        pnb_light light;
        pnb_scene_light(from, i, &light);
        view_light_copy(&scene->lights[i], &light);
    }
    size_t note_count = pnb_scene_note_count(from);
    scene->notes = g_new0(char *, note_count + 1);
    for (size_t i = 0; i < note_count; i++)
        scene->notes[i] = g_utf8_make_valid(pnb_scene_note(from, i), -1);
    scene->twin = make_twin(from);
    return scene;
}

/* ---- methods ---- */

void view_method_init(struct view_method *method, const pnb_method_info *info)
{
    *method = (struct view_method){.info = info};
    method->values = g_new0(char *, info->param_count + 1);
}

void view_method_copy(struct view_method *to, const struct view_method *from)
{
    view_method_init(to, from->info);
    to->samples = from->samples;
    for (size_t i = 0; i < from->info->param_count; i++)
        to->values[i] = g_strdup(from->values[i]);
}

void view_method_finish(struct view_method *method)
{
    for (size_t i = 0; method->info && i < method->info->param_count; i++)
        g_free(method->values[i]);
    g_free(method->values);
    *method = (struct view_method){0};
}

bool view_method_equal(const struct view_method *a, const struct view_method *b)
{
    if (a->info != b->info || a->samples != b->samples)
        return false;
    for (size_t i = 0; a->info && i < a->info->param_count; i++)
        if (g_strcmp0(a->values[i], b->values[i]) != 0)
            return false;
    return true;
}

bool view_method_on_opengl(const struct view_method *method)
{
    const pnb_method_info *info = method->info;
    if (info->processor == PNB_PROCESSOR_OPENGL)
        return true;
    for (size_t i = 0; info->opengl_path && i < info->param_count; i++)
        if (strcmp(info->params[i].key, "path") == 0)
            return strcmp(method->values[i] ? method->values[i] : info->params[i].default_value,
                          "opengl") == 0;
    return false;
}

/* ---- the state ---- */

void view_state_init(struct view_state *state)
{
    *state = (struct view_state){.error_scale = 0.1, .truth_samples = 1024, .patience_ms = 250};
    const char *second = pnb_method_find("hard-map") ? "hard-map" : pnb_method(0)->name;
    view_method_init(&state->methods[0], pnb_method_find(pnb_default_method()));
    view_method_init(&state->methods[1], pnb_method_find(second));
}

static void free_scene_part(struct view_state *state)
{
    for (size_t i = 0; i < state->light_count; i++)
        view_light_finish(&state->lights[i]);
    g_free(state->lights);
    g_free(state->placements);
    state->lights = NULL;
    state->placements = NULL;
    state->light_count = state->object_count = 0;
}

static struct view_light *copy_lights(const struct view_light *from, size_t count)
{
    struct view_light *lights = g_new0(struct view_light, count + 1);
    for (size_t i = 0; i < count; i++)
        view_light_copy(&lights[i], &from[i].light);
    return lights;
}

void view_state_enter(struct view_state *state, const struct view_scene *scene)
{
    free_scene_part(state);
    state->scene_id = scene->id;
    state->camera = scene->camera;
    state->exposure = scene->exposure;
    state->light = 0;
    state->light_count = scene->light_count;
    state->lights = copy_lights(scene->lights, scene->light_count);
    state->object_count = scene->object_count;
    state->placements = g_malloc0_n(scene->object_count + 1, sizeof(*state->placements));
    for (size_t i = 0; i < scene->object_count; i++)
        memcpy(state->placements[i], scene->objects[i].world_from_mesh, sizeof(*state->placements));
}

void view_state_copy(struct view_state *to, const struct view_state *from)
{
    *to = *from;
    to->lights = copy_lights(from->lights, from->light_count);
    to->placements = g_memdup2(from->placements, from->object_count * sizeof(*from->placements));
    for (int side = 0; side < VIEW_SIDES; side++)
        view_method_copy(&to->methods[side], &from->methods[side]);
}

void view_state_finish(struct view_state *state)
{
    free_scene_part(state);
    for (int side = 0; side < VIEW_SIDES; side++)
        view_method_finish(&state->methods[side]);
    *state = (struct view_state){0};
}
