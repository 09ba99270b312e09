/* examples/points.c: visibility at any points: the door for bakers and light-mapping programs.
 *
 * A square of one metre hangs half-way between a square light and the ground. We ask along a line
 * on the ground how much of the light each point sees, and compare with what geometry says: seen
 * from the ground, the light and the square's shadow on it are axis-aligned rectangles.
 *
 * Build: cc points.c $(pkg-config --cflags --libs penumbra)
 */
#include <penumbra/penumbra.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define POINTS 11

static void check(pnb_context *context, pnb_status status)
{
    if (status == PNB_OK)
        return;
    fprintf(stderr, "points: %s: %s\n", pnb_status_name(status), pnb_context_error(context));
    exit(1);
}

static double overlap(double a0, double a1, double b0, double b1)
{
    double low = a0 > b0 ? a0 : b0, high = a1 < b1 ? a1 : b1;
    return high > low ? high - low : 0;
}

/* From (x, 0, 0), an occluder at half the light's height covers twice its own extent on the light,
 * moved by -x. */
static double expected(double x)
{
    double covered = overlap(-0.5, 0.5, -1 - x, 1 - x) * overlap(-0.5, 0.5, -1, 1);
    return 1 - covered;
}

int main(void)
{
    pnb_context *context;
    if (pnb_context_create(NULL, &context) != PNB_OK)
        return 1;
    pnb_scene *scene;
    check(context, pnb_scene_create(context, &scene));

    static const float corners[4][3] = {
        {-0.5f, 1, -0.5f}, {0.5f, 1, -0.5f}, {0.5f, 1, 0.5f}, {-0.5f, 1, 0.5f}};
    static const uint32_t triangles[2][3] = {{0, 1, 2}, {0, 2, 3}};
    pnb_mesh_desc mesh = {.positions = corners[0],
                          .vertex_count = 4,
                          .indices = triangles[0],
                          .triangle_count = 2};
    pnb_object object = {.world_from_mesh = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                         .color = {1, 1, 1},
                         .casts = true,
                         .receives = true};
    check(context, pnb_scene_add_mesh(scene, &mesh, &object.mesh));
    check(context, pnb_scene_add_object(scene, &object, NULL));

    /* Half_u x half_v points down: the side that shines. */
    pnb_light light = {.type = PNB_LIGHT_RECTANGLE,
                       .color = {1, 1, 1},
                       .shape.rectangle = {
                           .center = {0, 2, 0}, .half_u = {0.5, 0, 0}, .half_v = {0, 0, 0.5}}};

    float positions[POINTS][3], normals[POINTS][3], visibility[POINTS];
    for (int i = 0; i < POINTS; i++) {
        positions[i][0] = 0.2f * (float)i;
        positions[i][1] = positions[i][2] = 0;
        normals[i][0] = normals[i][2] = 0;
        normals[i][1] = 1;
    }
    pnb_receivers receivers = {.count = POINTS, .positions = positions[0], .normals = normals[0]};

    pnb_solver *solver;
    pnb_solver_desc desc = {.method = "reference", .samples = 4096};
    check(context, pnb_solver_create(context, scene, &desc, &solver));
    check(context, pnb_solver_visibility(solver, &light, &receivers, visibility));

    double worst = 0;
    printf("   x  visibility  expected\n");
    for (int i = 0; i < POINTS; i++) {
        double truth = expected(positions[i][0]);
        printf("%4.1f  %10.4f  %8.4f\n", positions[i][0], visibility[i], truth);
        worst = fmax(worst, fabs(visibility[i] - truth));
    }
    pnb_solver_destroy(solver);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
    return worst < 0.01 ? 0 : 1;
}
