/* scene/builtin_lines.c: recipes of scenes under linear lights that are not in the papers. */
#include "scene/builtin.h"

static const vec3 white = {1, 1, 1};
static const vec3 clay = {0.72, 0.38, 0.22}, steel = {0.3, 0.42, 0.6}, moss = {0.36, 0.5, 0.26};

/* The tube rises by 30 degrees: no surface is parallel to it. */
void builtin_slanted_tube(struct stage *stage, const struct builtin *row)
{
    double placement[12], s = row->light;
    stage_ground(stage, 8);
    shape_sphere_762(&stage->shape, v3(0.75, 0.4, 0.3), 0.4);
    stage_object(stage, "ball", steel);
    shape_box(&stage->shape, v3(-0.3, 0, -0.3), v3(0.3, 0.9, 0.3));
    stage_placement(1, 0, 30, v3(-0.4, 0, 0.1), placement);
    stage_placed(stage, "box", clay, placement);
    shape_torus(&stage->shape, 0.42, 0.07, 60, 16);
    stage_placement(1, 62, -25, v3(0.25, 0.5, -0.75), placement);
    stage_placed(stage, "hoop", moss, placement);
    stage_line(stage, v3(-1.1 - 0.87 * s, row->height - 0.5 * s, 0.5),
               v3(-1.1 + 0.87 * s, row->height + 0.5 * s, 0.9), white);
    stage_camera(stage, v3(0.9, 2.6, 4.4), v3(0.35, 0.35, -0.15), 38);
}

/* A tube that stands among counts[0] posts and as many balls, and leans a little: the shadows run
 * outwards on all sides, and no picture plane holds everything around the light. */
void builtin_tube_inside(struct stage *stage, const struct builtin *row)
{
    stage_ground(stage, 8);
    for (int i = 0; i < row->counts[0]; i++) {
        double angle = 2 * M_PI * (i + 0.3) / row->counts[0];
        vec3 foot = v3(1.15 * cos(angle), 0, 1.15 * sin(angle));
        shape_rod(&stage->shape, foot, v3_add(foot, v3(0, 1.15 + 0.1 * (i % 3), 0)), 0.08, 0.08,
                  24);
    }
    stage_object(stage, "posts", clay);
    for (int i = 0; i < row->counts[0]; i++) {
        double angle = 2 * M_PI * (i + 0.8) / row->counts[0], radius = 0.14 + 0.03 * (i % 4);
        shape_sphere_762(&stage->shape, v3(1.5 * cos(angle), radius, 1.5 * sin(angle)), radius);
    }
    stage_object(stage, "balls", steel);
    stage_line(stage, v3(-0.05, row->height - row->light, 0),
               v3(0.05, row->height + row->light, 0.03), white);
    stage_camera(stage, v3(1.6, 4.2, 5.4), v3(0, 0.1, 0.2), 42);
}
