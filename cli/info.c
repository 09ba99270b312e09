/* cli/info.c: 'penumbra info': what is in a scene, what was supplied, and who can render it. */
#include "commands.h"
#include "session.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const struct cli_command command = {
    .name = "info",
    .operands = "SCENE",
    .summary = "What is in a scene: meshes, objects, lights, camera, and what each method can do",
    .options = CLI_LIGHT | CLI_JSON | CLI_QUIET,
    .least_operands = 1,
    .most_operands = 1,
    .text =
        "A mesh is closed if each edge joins two triangles that agree on its direction; vertices\n"
        "at equal positions count as one.\n\n"
        "examples\n"
        "  penumbra info cow.obj\n"
        "  penumbra info scene.json --json\n",
};

static json_t *vector_json(const double *v, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(array, cli_json_number(v[i]));
    return array;
}

static double length3(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static double distance3(const double a[3], const double b[3])
{
    double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return length3(d);
}

/* Where a light is and how large, in words. */
static void describe_light(const pnb_light *light, char *text, size_t size)
{
    const double *p;
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE:
        p = light->shape.rectangle.center;
        snprintf(text, size, "%g x %g m at (%g, %g, %g)",
                 2 * length3(light->shape.rectangle.half_u),
                 2 * length3(light->shape.rectangle.half_v), p[0], p[1], p[2]);
        break;
    case PNB_LIGHT_DISK:
        p = light->shape.disk.center;
        snprintf(text, size, "radius %g m at (%g, %g, %g)", light->shape.disk.radius, p[0], p[1],
                 p[2]);
        break;
    case PNB_LIGHT_POLYGON:
        p = light->shape.polygon.vertices;
        snprintf(text, size, "%zu vertices, first at (%g, %g, %g)",
                 light->shape.polygon.vertex_count, p[0], p[1], p[2]);
        break;
    case PNB_LIGHT_LINE:
        p = light->shape.line.from;
        snprintf(text, size, "%g m long from (%g, %g, %g)",
                 distance3(light->shape.line.from, light->shape.line.to), p[0], p[1], p[2]);
        break;
    case PNB_LIGHT_POINT:
        p = light->shape.point.position;
        snprintf(text, size, "at (%g, %g, %g)", p[0], p[1], p[2]);
        break;
    case PNB_LIGHT_SUN:
        p = light->shape.sun.direction;
        snprintf(text, size, "%g degrees wide, shining along (%g, %g, %g)",
                 light->shape.sun.angular_diameter_degrees, p[0], p[1], p[2]);
        break;
    default: snprintf(text, size, "?"); break;
    }
}

/* Light types in the scene that the method cannot do; 0: it can do all. */
static unsigned missing_lights(pnb_scene *scene, const pnb_method_info *method)
{
    unsigned present = 0;
    for (size_t i = 0; i < pnb_scene_light_count(scene); i++) {
        pnb_light light;
        pnb_scene_light(scene, i, &light);
        present |= PNB_LIGHT_BIT(light.type);
    }
    return present & ~method->lights;
}

/* Does the method find a plane to receive on? It says so itself. */
static bool has_plane(struct cli_session *session, pnb_scene *scene, const pnb_method_info *method)
{
    pnb_solver *solver;
    pnb_solver_desc desc = {.method = method->name};
    if (pnb_solver_create(session->context, scene, &desc, &solver) != PNB_OK)
        return false;
    pnb_solver_destroy(solver);
    return true;
}

/* "yes", or what stands against it. */
static void describe_method(struct cli_session *session, pnb_scene *scene,
                            const pnb_method_info *method, char *text, size_t size)
{
    unsigned missing = missing_lights(scene, method);
    if (pnb_scene_light_count(scene) == 0) {
        snprintf(text, size, "no: the scene has no light");
    } else if (method->receivers == PNB_RECEIVERS_PLANES && !has_plane(session, scene, method)) {
        snprintf(text, size, "no: it needs a plane as receiver");
    } else if (missing) {
        size_t used = (size_t)snprintf(text, size, "no: not for a light of type");
        for (int type = 0; type < PNB_LIGHT_TYPE_COUNT && used < size; type++)
            if (missing & PNB_LIGHT_BIT(type))
                used += (size_t)snprintf(text + used, size - used, " %s",
                                         pnb_light_type_name((pnb_light_type)type));
    } else if (method->receivers == PNB_RECEIVERS_PLANES) {
        snprintf(text, size, "yes, on planes");
    } else {
        snprintf(text, size, "yes");
    }
}

static int print_text(struct cli_session *session, pnb_scene *scene)
{
    char text[400];
    printf("%s\n", pnb_scene_name(scene));
    printf("\nmeshes: %zu\n", pnb_scene_mesh_count(scene));
    for (size_t i = 0; i < pnb_scene_mesh_count(scene); i++) {
        pnb_mesh_info info;
        if (pnb_scene_mesh_info(scene, i, &info) != PNB_OK)
            return cli_session_fail(session);
        printf("  %zu %s: %zu vertices (%zu positions), %zu triangles, %zu edges; %s", i,
               info.name ? info.name : "(no name)", info.vertex_count, info.welded_vertex_count,
               info.triangle_count, info.edge_count, info.closed ? "closed" : "not closed:");
        if (!info.closed)
            printf(" %zu open, %zu non-manifold, %zu inconsistent edges", info.open_edge_count,
                   info.non_manifold_edge_count, info.inconsistent_edge_count);
        if (info.degenerate_triangle_count)
            printf("; %zu triangles of no area", info.degenerate_triangle_count);
        printf("\n");
    }

    printf("\nobjects: %zu, together %zu triangles\n", pnb_scene_object_count(scene),
           pnb_scene_triangle_count(scene));
    for (size_t i = 0; i < pnb_scene_object_count(scene); i++) {
        pnb_object object;
        pnb_scene_object(scene, i, &object);
        const double *m = object.world_from_mesh;
        printf("  %zu %s: %s %zu at (%g, %g, %g)%s%s\n", i, object.name ? object.name : "(no name)",
               object.plane ? "plane, mesh" : "mesh", object.mesh, m[3], m[7], m[11],
               object.casts ? "" : ", casts no shadow",
               object.receives ? "" : ", receives no shadow");
    }
    double low[3], high[3];
    if (pnb_scene_bounds(scene, low, high))
        printf("  bounds (%g, %g, %g) to (%g, %g, %g)\n", low[0], low[1], low[2], high[0], high[1],
               high[2]);

    printf("\nlights: %zu\n", pnb_scene_light_count(scene));
    for (size_t i = 0; i < pnb_scene_light_count(scene); i++) {
        pnb_light light;
        pnb_scene_light(scene, i, &light);
        describe_light(&light, text, sizeof(text));
        printf("  %zu %s%s%s, %s, colour (%g, %g, %g)\n", i, pnb_light_type_name(light.type),
               light.name ? " " : "", light.name ? light.name : "", text, light.color[0],
               light.color[1], light.color[2]);
    }

    pnb_camera camera;
    pnb_scene_camera(scene, &camera);
    printf("\ncamera: eye (%g, %g, %g), target (%g, %g, %g), %g degrees high\n", camera.eye[0],
           camera.eye[1], camera.eye[2], camera.target[0], camera.target[1], camera.target[2],
           camera.vertical_fov_degrees);

    if (pnb_scene_note_count(scene))
        printf("\nsupplied or changed while loading\n");
    for (size_t i = 0; i < pnb_scene_note_count(scene); i++)
        printf("  %s\n", pnb_scene_note(scene, i));

    printf("\nmethods\n");
    for (size_t i = 0; i < pnb_method_count(); i++) {
        describe_method(session, scene, pnb_method(i), text, sizeof(text));
        printf("  %-20s %s\n", pnb_method(i)->name, text);
    }
    return cli_flush();
}

static json_t *mesh_json(const pnb_mesh_info *info)
{
    json_t *mesh = json_object();
    json_object_set_new(mesh, "name", cli_json_text(info->name ? info->name : ""));
    json_object_set_new(mesh, "vertices", json_integer((json_int_t)info->vertex_count));
    json_object_set_new(mesh, "positions", json_integer((json_int_t)info->welded_vertex_count));
    json_object_set_new(mesh, "triangles", json_integer((json_int_t)info->triangle_count));
    json_object_set_new(mesh, "edges", json_integer((json_int_t)info->edge_count));
    json_object_set_new(mesh, "open_edges", json_integer((json_int_t)info->open_edge_count));
    json_object_set_new(mesh, "non_manifold_edges",
                        json_integer((json_int_t)info->non_manifold_edge_count));
    json_object_set_new(mesh, "inconsistent_edges",
                        json_integer((json_int_t)info->inconsistent_edge_count));
    json_object_set_new(mesh, "degenerate_triangles",
                        json_integer((json_int_t)info->degenerate_triangle_count));
    json_object_set_new(mesh, "closed", json_boolean(info->closed));
    json_object_set_new(mesh, "bounds_min", vector_json(info->bounds_min, 3));
    json_object_set_new(mesh, "bounds_max", vector_json(info->bounds_max, 3));
    return mesh;
}

static json_t *object_json(const pnb_object *object)
{
    json_t *value = json_object();
    json_object_set_new(value, "name", cli_json_text(object->name ? object->name : ""));
    json_object_set_new(value, "mesh", json_integer((json_int_t)object->mesh));
    json_object_set_new(value, "plane", json_boolean(object->plane));
    json_object_set_new(value, "casts", json_boolean(object->casts));
    json_object_set_new(value, "receives", json_boolean(object->receives));
    json_object_set_new(value, "color", vector_json(object->color, 3));
    json_object_set_new(value, "world_from_mesh", vector_json(object->world_from_mesh, 12));
    return value;
}

/* The keys of the scene file. */
static json_t *light_json(const pnb_light *light)
{
    json_t *value = json_object(), *vertices;
    json_object_set_new(value, "type", cli_json_text(pnb_light_type_name(light->type)));
    if (light->name)
        json_object_set_new(value, "name", cli_json_text(light->name));
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE:
        json_object_set_new(value, "center", vector_json(light->shape.rectangle.center, 3));
        json_object_set_new(value, "half_u", vector_json(light->shape.rectangle.half_u, 3));
        json_object_set_new(value, "half_v", vector_json(light->shape.rectangle.half_v, 3));
        break;
    case PNB_LIGHT_DISK:
        json_object_set_new(value, "center", vector_json(light->shape.disk.center, 3));
        json_object_set_new(value, "normal", vector_json(light->shape.disk.normal, 3));
        json_object_set_new(value, "radius", cli_json_number(light->shape.disk.radius));
        break;
    case PNB_LIGHT_POLYGON:
        vertices = json_array();
        for (size_t i = 0; i < light->shape.polygon.vertex_count; i++)
            json_array_append_new(vertices, vector_json(light->shape.polygon.vertices + 3 * i, 3));
        json_object_set_new(value, "vertices", vertices);
        break;
    case PNB_LIGHT_LINE:
        json_object_set_new(value, "from", vector_json(light->shape.line.from, 3));
        json_object_set_new(value, "to", vector_json(light->shape.line.to, 3));
        break;
    case PNB_LIGHT_POINT:
        json_object_set_new(value, "position", vector_json(light->shape.point.position, 3));
        break;
    case PNB_LIGHT_SUN:
        json_object_set_new(value, "direction", vector_json(light->shape.sun.direction, 3));
        json_object_set_new(value, "angular_diameter_degrees",
                            cli_json_number(light->shape.sun.angular_diameter_degrees));
        break;
    default: break;
    }
    json_object_set_new(value, "color", vector_json(light->color, 3));
    return value;
}

static int print_info_json(struct cli_session *session, pnb_scene *scene)
{
    json_t *meshes = json_array(), *objects = json_array(), *lights = json_array();
    json_t *notes = json_array(), *methods = json_array(), *value = json_object();
    json_object_set_new(value, "scene", cli_json_text(session->options->operands[0]));
    json_object_set_new(value, "meshes", meshes);
    json_object_set_new(value, "objects", objects);
    json_object_set_new(value, "triangles",
                        json_integer((json_int_t)pnb_scene_triangle_count(scene)));
    json_object_set_new(value, "lights", lights);
    for (size_t i = 0; i < pnb_scene_mesh_count(scene); i++) {
        pnb_mesh_info info;
        if (pnb_scene_mesh_info(scene, i, &info) != PNB_OK) {
            json_decref(value);
            json_decref(notes);
            json_decref(methods);
            return cli_session_fail(session);
        }
        json_array_append_new(meshes, mesh_json(&info));
    }
    for (size_t i = 0; i < pnb_scene_object_count(scene); i++) {
        pnb_object object;
        pnb_scene_object(scene, i, &object);
        json_array_append_new(objects, object_json(&object));
    }
    for (size_t i = 0; i < pnb_scene_light_count(scene); i++) {
        pnb_light light;
        pnb_scene_light(scene, i, &light);
        json_array_append_new(lights, light_json(&light));
    }
    double low[3], high[3];
    if (pnb_scene_bounds(scene, low, high)) {
        json_object_set_new(value, "bounds_min", vector_json(low, 3));
        json_object_set_new(value, "bounds_max", vector_json(high, 3));
    }
    pnb_camera camera;
    pnb_scene_camera(scene, &camera);
    json_object_set_new(value, "camera",
                        json_pack("{s:o, s:o, s:o, s:o}", "eye", vector_json(camera.eye, 3),
                                  "target", vector_json(camera.target, 3), "up",
                                  vector_json(camera.up, 3), "vertical_fov_degrees",
                                  cli_json_number(camera.vertical_fov_degrees)));
    for (size_t i = 0; i < pnb_scene_note_count(scene); i++)
        json_array_append_new(notes, cli_json_text(pnb_scene_note(scene, i)));
    json_object_set_new(value, "notes", notes);
    for (size_t i = 0; i < pnb_method_count(); i++) {
        char text[400];
        describe_method(session, scene, pnb_method(i), text, sizeof(text));
        json_array_append_new(methods,
                              json_pack("{s:s, s:b, s:s}", "name", pnb_method(i)->name, "can",
                                        strncmp(text, "yes", 3) == 0, "answer", text));
    }
    json_object_set_new(value, "methods", methods);
    json_object_set_new(value, "warnings", cli_json_warnings(session));
    return cli_json_print(value);
}

int command_info(int argc, char **argv)
{
    struct cli_options options;
    int result = cli_options_init(&command, argc, argv, &options);
    if (result != CLI_GO_ON)
        return result;
    struct cli_session session;
    pnb_scene *scene = NULL;
    result = cli_session_init(&session, &options);
    if (result == CLI_GO_ON)
        result = cli_scene_load(&session, options.operands[0], &scene);
    cli_session_clear_bar(&session);
    if (result == CLI_GO_ON)
        result = options.json ? print_info_json(&session, scene) : print_text(&session, scene);
    pnb_scene_destroy(scene);
    cli_session_finish(&session);
    cli_options_finish(&options);
    return result;
}
