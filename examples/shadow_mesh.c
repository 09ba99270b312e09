/* examples/shadow_mesh.c: the planar shadow as an asset: a few hundred triangles with an intensity
 * per vertex, that any engine draws with blending and no shader of its own.
 *
 *     example-shadow_mesh [FILE.glb]
 *
 * Takes a built-in scene, makes the shadow on its ground, checks that it is what it says (indices
 * in range, intensities in [0,1], triangles counter-clockwise), and writes it if a file is named:
 * .glb .obj .ply .svg .pdf .geojson.
 */
#include <penumbra/penumbra.h>

#include <math.h>
#include <stdio.h>

int main(int argc, char **argv)
{
    pnb_context *context;
    pnb_scene *scene = NULL;
    pnb_shadow *shadow = NULL;
    pnb_light light;
    pnb_shadow_view view = {0};
    if (pnb_context_create(NULL, &context) != PNB_OK)
        return 1;
    pnb_status status = pnb_scene_load(context, "builtin:two-boxes", &scene);
    if (status == PNB_OK) {
        pnb_solver_desc desc = {.samples = 8};
        pnb_scene_light(scene, 0, &light);
        status = pnb_shadow_create(context, scene, &light, &desc, &shadow);
    }
    bool good = status == PNB_OK;
    if (good) {
        pnb_shadow_get(shadow, &view);
        double area = 0, dark = 0;
        for (size_t t = 0; t < view.triangle_count; t++) {
            const uint32_t *i = view.indices + 3 * t;
            const float *p = view.coordinates;
            for (int k = 0; k < 3; k++)
                good = good && i[k] < view.vertex_count && view.intensities[i[k]] >= 0 &&
                       view.intensities[i[k]] <= 1;
            if (!good)
                break;
            double a = 0.5 * ((p[2 * i[1]] - p[2 * i[0]]) * (p[2 * i[2] + 1] - p[2 * i[0] + 1]) -
                              (p[2 * i[2]] - p[2 * i[0]]) * (p[2 * i[1] + 1] - p[2 * i[0] + 1]));
            good = good && a >= -1e-6; /* counter-clockwise */
            area += a;
            dark +=
                a * (view.intensities[i[0]] + view.intensities[i[1]] + view.intensities[i[2]]) / 3;
        }
        printf("%zu vertices, %zu triangles, %.3f square metres of shadow, %.0f %% dark\n",
               view.vertex_count, view.triangle_count, area, 100 * dark / area);
        good = good && area > 0 && dark > 0 && dark < area;
    }
    if (good && argc > 1)
        status = pnb_shadow_write(shadow, argv[1], -1);
    if (status != PNB_OK)
        fprintf(stderr, "shadow_mesh: %s\n", pnb_context_error(context));
    pnb_shadow_destroy(shadow);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
    return good && status == PNB_OK ? 0 : 1;
}
