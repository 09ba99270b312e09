/* scene/exposure.c: the factor from irradiance to the picture. */
#include "scene/scene.h"

/* A point in the middle of the light, or for the sun one far towards it. */
static vec3 light_middle(const pnb_light *light, vec3 from)
{
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE: return v3_load(light->shape.rectangle.center);
    case PNB_LIGHT_DISK: return v3_load(light->shape.disk.center);
    case PNB_LIGHT_POLYGON: {
        vec3 sum = v3(0, 0, 0);
        size_t count = light->shape.polygon.vertex_count;
        for (size_t i = 0; i < count; i++)
            sum = v3_add(sum, v3_load(light->shape.polygon.vertices + 3 * i));
        return v3_scale(sum, 1.0 / (double)count);
    }
    case PNB_LIGHT_LINE:
        return v3_scale(v3_add(v3_load(light->shape.line.from), v3_load(light->shape.line.to)),
                        0.5);
    case PNB_LIGHT_POINT: return v3_load(light->shape.point.position);
    case PNB_LIGHT_SUN: return v3_sub(from, v3_load(light->shape.sun.direction));
    }
    return from;
}

double pnb_scene_exposure(const pnb_scene *scene)
{
    if (scene->exposure > 0)
        return scene->exposure;
    vec3 target = v3_load(scene->camera.target);
    double sum[3] = {0};
    for (size_t i = 0; i < scene->light_count; i++) {
        float position[3], normal[3], irradiance[3];
        vec3 towards = v3_sub(light_middle(&scene->lights[i], target), target);
        if (!(v3_length(towards) > 0))
            continue;
        v3_storef(position, target);
        v3_storef(normal, v3_normalize(towards));
        if (pnb_light_irradiance(scene->context, &scene->lights[i], position, normal, 1,
                                 irradiance) != PNB_OK)
            continue;
        for (int c = 0; c < 3; c++)
            sum[c] += isfinite(irradiance[c]) ? irradiance[c] : 0;
    }
    double brightest = fmax(sum[0], fmax(sum[1], sum[2]));
    return brightest > 0 && isfinite(1 / brightest) ? 1 / brightest : 1;
}
