/* scene/supply.c: what a bare mesh lacks to make a picture: ground, light, camera.
 *
 * Measures follow from the extent e of what is there, the largest side of its bounds:
 *
 *          light, 0.6 e square, 2.6 e from the middle, facing it
 *         __
 *           \  .
 *                .                     camera to the front, above,
 *               +---+  e               framing the mesh and its shadow
 *               |   |
 *   ------------+---+------------      ground, 6 e square, at the lowest point
 *
 * The penumbra of the mesh's top is then about a quarter of e wide. O(triangles), for the question
 * whether there is a floor already. */
#include "scene/scene.h"

/* Triangles that look up, lie in the lowest tenth of the scene and together cover most of its
 * ground plan are a floor, as long as something rises above them. */
static bool has_floor(const pnb_scene *scene, vec3 low, vec3 high)
{
    double height = high.y - low.y, plan = (high.x - low.x) * (high.z - low.z), covered = 0;
    if (!(height > 0.05 * fmax(high.x - low.x, high.z - low.z)))
        return false;
    for (size_t i = 0; i < scene->object_count; i++) {
        const pnb_object *object = &scene->objects[i].info;
        const struct mesh *mesh = &scene->meshes[object->mesh];
        double front = m34_det(object->world_from_mesh) < 0 ? -1 : 1;
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            vec3 p[3];
            for (int c = 0; c < 3; c++)
                p[c] = m34_point(object->world_from_mesh,
                                 v3_loadf(mesh->positions + 3 * (size_t)mesh->indices[3 * t + c]));
            if (fmax(p[0].y, fmax(p[1].y, p[2].y)) > low.y + 0.1 * height)
                continue;
            vec3 n = v3_cross(v3_sub(p[1], p[0]), v3_sub(p[2], p[0]));
            if (front * n.y > 0.98 * v3_length(n))
                covered += 0.5 * front * n.y;
        }
    }
    return covered > 0.6 * plan;
}

pnb_status scene_supply(pnb_scene *scene, bool has_camera)
{
    double bounds[2][3];
    pnb_status status = PNB_OK;
    if (!pnb_scene_bounds(scene, bounds[0], bounds[1]))
        return PNB_OK;
    vec3 low = v3_load(bounds[0]), high = v3_load(bounds[1]), size = v3_sub(high, low);
    vec3 middle = v3_scale(v3_add(low, high), 0.5);
    double e = v3_max_abs(size);
    if (!(e > 0))
        e = fmax(1, v3_max_abs(middle)) * 1e-3;
    bool has_light = scene->light_count > 0;

    if (!(has_light && has_camera) && !has_floor(scene, low, high)) {
        /* What is flat itself floats above the ground, or it would show no shadow. */
        double ground = size.y > 0.01 * e ? low.y : low.y - 0.3 * e;
        static const double color[3] = {0.8, 0.8, 0.8};
        status = scene_add_plane(scene, "ground", v3(middle.x, ground, middle.z), v3(0, 1, 0),
                                 3 * e, color, NULL);
        if (status != PNB_OK)
            return status;
        scene_note(scene, "supplied: a ground plane at y = %g, %g x %g", ground, 6 * e, 6 * e);
    }

    const vec3 to_light = v3_normalize(v3(-0.7, 1.2, 0.35));
    if (!has_light) {
        vec3 center = v3_mad(middle, to_light, 2.6 * e), u, v;
        v3_frame(v3_scale(to_light, -1), &u, &v);
        pnb_light light = {.type = PNB_LIGHT_RECTANGLE, .name = "supplied", .color = {1, 1, 1}};
        v3_store(light.shape.rectangle.center, center);
        v3_store(light.shape.rectangle.half_u, v3_scale(u, 0.3 * e));
        v3_store(light.shape.rectangle.half_v, v3_scale(v, 0.3 * e));
        status = pnb_scene_add_light(scene, &light, NULL);
        if (status != PNB_OK)
            return status;
        scene_note(scene, "supplied: a rectangular light, %g x %g, at (%g, %g, %g)", 0.6 * e,
                   0.6 * e, center.x, center.y, center.z);
    }

    if (!has_camera) {
        /* The shadow falls to the right and back: leave room for it. */
        pnb_camera camera;
        vec3 shown = has_light ? high : v3_add(high, v3(0.35 * e, 0, 0));
        scene_frame_camera(low, shown, v3(0.25, 0.5, 1), &camera);
        status = pnb_scene_set_camera(scene, &camera);
        if (status == PNB_OK)
            scene_note(scene, "supplied: a camera at (%g, %g, %g)", camera.eye[0], camera.eye[1],
                       camera.eye[2]);
    }
    return status;
}
