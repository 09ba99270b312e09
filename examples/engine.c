/* examples/engine.c: penumbra inside an engine that has its own meshes, its own frame and its own
 * vertices: soft shadows per vertex of a ground grid, while the light moves and an object falls.
 *
 * Once:        the engine's meshes -> scene, solver
 * Each frame:  placements that changed -> scene, pnb_solver_update()
 *              light, points and normals -> pnb_solver_visibility() -> one float per point
 *
 * The points may be anything: vertices, texels of a light map, probes, particles, the pixels of a
 * G-buffer. Prints the time of each frame, and fails if the shadow is not where it belongs.
 *
 * Build: cc engine.c $(pkg-config --cflags --libs penumbra)
 */
#include <penumbra/penumbra.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 128, POINTS = SIDE * SIDE, FRAMES = 5 };

/* What an engine has of a mesh: positions and indices. Here a box of one metre. */
static const float box_positions[8][3] = {
    {-0.5f, -0.5f, -0.5f}, {0.5f, -0.5f, -0.5f}, {-0.5f, 0.5f, -0.5f}, {0.5f, 0.5f, -0.5f},
    {-0.5f, -0.5f, 0.5f},  {0.5f, -0.5f, 0.5f},  {-0.5f, 0.5f, 0.5f},  {0.5f, 0.5f, 0.5f}};
static const uint32_t box_indices[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                            {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                            {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};

static pnb_context *context;

static void check(pnb_status status)
{
    if (status == PNB_OK)
        return;
    fprintf(stderr, "engine: %s: %s\n", pnb_status_name(status), pnb_context_error(context));
    exit(1);
}

/* Once per mesh: the scene copies the arrays. */
static pnb_scene *make_scene(size_t *box)
{
    pnb_scene *scene;
    pnb_mesh_desc mesh = {.name = "box",
                          .positions = box_positions[0],
                          .vertex_count = 8,
                          .indices = box_indices[0],
                          .triangle_count = 12};
    pnb_object object = {.world_from_mesh = {1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1, 0},
                         .color = {1, 1, 1},
                         .casts = true,
                         .receives = true};
    check(pnb_scene_create(context, &scene));
    check(pnb_scene_add_mesh(scene, &mesh, &object.mesh));
    check(pnb_scene_add_object(scene, &object, box));
    return scene;
}

int main(void)
{
    static float positions[POINTS][3], normals[POINTS][3], visibility[POINTS];
    for (int i = 0; i < POINTS; i++) {
        positions[i][0] = 8.0f * (float)(i % SIDE) / (SIDE - 1) - 4;
        positions[i][2] = 8.0f * (float)(i / SIDE) / (SIDE - 1) - 4;
        normals[i][1] = 1;
    }
    pnb_receivers receivers = {.count = POINTS, .positions = positions[0], .normals = normals[0]};

    check(pnb_context_create(NULL, &context));
    size_t box;
    pnb_scene *scene = make_scene(&box);
    pnb_solver *solver;
    check(pnb_solver_create(context, scene, NULL, &solver)); /* NULL: the default method */

    int result = 0;
    for (int frame = 0; frame < FRAMES; frame++) {
        double t = frame / (double)(FRAMES - 1);
        /* The engine moved the box and the light. */
        double place[12] = {1, 0, 0, 0, 0, 1, 0, 3 - 2 * t, 0, 0, 1, 0};
        check(pnb_scene_set_placement(scene, box, place));
        check(pnb_solver_update(solver, PNB_UPDATE_PLACEMENTS));
        pnb_light light = {.type = PNB_LIGHT_RECTANGLE,
                           .color = {1, 1, 1},
                           .shape.rectangle = {.center = {2 * t - 1, 6, 0},
                                               .half_u = {0.5, 0, 0},
                                               .half_v = {0, 0, 0.5}}};
        check(pnb_solver_visibility(solver, &light, &receivers, visibility));

        pnb_solver_report report;
        pnb_solver_get_report(solver, &report);
        double x = 0, weight = 0;
        int umbra = 0, penumbra = 0;
        for (int i = 0; i < POINTS; i++) {
            umbra += visibility[i] == 0;
            penumbra += visibility[i] > 0 && visibility[i] < 1;
            x += positions[i][0] * (1 - visibility[i]);
            weight += 1 - visibility[i];
        }
        /* The shadow's middle lies about where the light throws the middle of the top face. */
        double height = 3.5 - 2 * t, expected = (2 * t - 1) * (1 - 6 / (6 - height));
        printf("frame %d: %.2f ms for %d points, %d in umbra, %d in penumbra, middle at x = %+.2f "
               "(%+.2f)\n",
               frame, report.visibility_ms, POINTS, umbra, penumbra, x / weight, expected);
        if (!(fabs(x / weight - expected) < 0.25))
            result = 1;
    }
    pnb_solver_destroy(solver);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
    return result;
}
