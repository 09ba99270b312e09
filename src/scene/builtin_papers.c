/* scene/builtin_papers.c: recipes of the scenes that stand for the papers' figures. */
#include "scene/builtin.h"

#include <stdio.h>

static const vec3 white = {1, 1, 1};
static const vec3 clay = {0.72, 0.38, 0.22}, steel = {0.3, 0.42, 0.6}, moss = {0.36, 0.5, 0.26},
                  sand = {0.8, 0.68, 0.46};

/* A roof-shaped bar. From the light's centre its ridge hides nothing, from the light's rim it does:
 * silhouettes taken from one point give it the shadow of a flat plate. */
void builtin_prism(struct stage *stage, const struct builtin *row)
{
    double y = row->height;
    const vec3 points[6] = {{-0.3, y, 0.6},  {0.3, y, 0.6},  {0, y + 0.5, 0.6},
                            {-0.3, y, -0.6}, {0.3, y, -0.6}, {0, y + 0.5, -0.6}};
    /* The second ring lies behind the first: counter-clockwise seen from it means reversed. */
    const vec3 rings[6] = {points[3], points[4], points[5], points[0], points[1], points[2]};
    double turn[12];
    stage_ground(stage, 8);
    shape_loft(&stage->shape, rings, 2, 3, false);
    stage_placement(1, 0, 35, v3(0, 0, 0), turn);
    stage_placed(stage, "prism", clay, turn);
    stage_rectangle(stage, v3(0, 3.2, 0), v3(0, 0, 0), row->light, row->light, white);
    stage_camera(stage, v3(0.4, 2.6, 4.6), v3(0, 0.35, 0), 36);
}

/* 14 x 8: 224 triangles, as the paper's table has it. */
void builtin_ring(struct stage *stage, const struct builtin *row)
{
    double placement[12];
    stage_ground(stage, 8);
    shape_torus(&stage->shape, 0.5, 0.17, (size_t)row->counts[0], (size_t)row->counts[1]);
    stage_placement(1, 22, 20, v3(0, row->height, 0), placement);
    stage_placed(stage, "ring", clay, placement);
    stage_disk(stage, v3(-0.6, 4.2, 0.4), v3(0, 0, 0), row->light, white);
    stage_camera(stage, v3(0.6, 3.4, 5.4), v3(0.1, 0.95, 0), 38);
}

struct knot {
    int p, q;
    double major, minor, tube;
};

static vec3 knot_curve(const void *user, double t)
{
    const struct knot *knot = user;
    double a = 2 * M_PI * knot->p * t, b = 2 * M_PI * knot->q * t;
    double r = knot->major + knot->minor * cos(b);
    return v3(r * cos(a), knot->minor * sin(b), -r * sin(a));
}

static double knot_section(const void *user, double t, double angle)
{
    return ((const struct knot *)user)->tube;
}

static void knot_shape(struct stage *stage, const struct knot *knot, const int *counts)
{
    shape_tube(&stage->shape, &(struct shape_tube){knot_curve, knot_section, knot,
                                                   (size_t)counts[0], (size_t)counts[1], false});
}

/* A trefoil of 40 x 12: 960 triangles, as the paper's table has it. */
void builtin_small_knot(struct stage *stage, const struct builtin *row)
{
    struct knot knot = {2, 3, 0.42, 0.2, 0.11};
    double placement[12];
    stage_ground(stage, 8);
    knot_shape(stage, &knot, row->counts);
    stage_placement(1, 25, 0, v3(0, row->height, 0), placement);
    stage_placed(stage, "knot", steel, placement);
    stage_disk(stage, v3(-0.9, 3.4, 0.7), v3(0, 0, 0), row->light, white);
    stage_camera(stage, v3(0.5, 2.7, 4.4), v3(0.25, 0.45, 0), 36);
}

void builtin_knot(struct stage *stage, const struct builtin *row)
{
    struct knot knot = {3, 7, 0.75, 0.3, 0.07};
    double placement[12];
    stage_ground(stage, 10);
    knot_shape(stage, &knot, row->counts);
    stage_placement(1, 55, 0, v3(0, row->height, 0), placement);
    stage_placed(stage, "knot", steel, placement);
    stage_rectangle(stage, v3(-1.6, 4.2, 1.4), v3(0, 0.6, 0), row->light, row->light, white);
    stage_camera(stage, v3(0.9, 2.9, 5.6), v3(0.35, 0.75, -0.1), 38);
}

/* A ring that rises and dips, with a fluted, twisted section: concave everywhere. */
static vec3 garland_curve(const void *user, double t)
{
    double a = 2 * M_PI * t, r = 0.7 * (1 + 0.22 * cos(5 * a));
    return v3(r * cos(a), 0.2 * sin(5 * a), -r * sin(a));
}

static double garland_section(const void *user, double t, double angle)
{
    return 0.2 * (1 + 0.28 * cos(3 * angle + 2 * M_PI * 4 * t));
}

void builtin_complex(struct stage *stage, const struct builtin *row)
{
    double placement[12];
    stage_ground(stage, 8);
    shape_box(&stage->shape, v3(0.45, 0, -1.2), v3(1.15, 0.22, 1.2));
    stage_object(stage, "low step", sand);
    shape_box(&stage->shape, v3(1.16, 0, -1.2), v3(1.9, 0.5, 1.2));
    stage_object(stage, "high step", sand);
    shape_tube(&stage->shape,
               &(struct shape_tube){garland_curve, garland_section, NULL, (size_t)row->counts[0],
                                    (size_t)row->counts[1], false});
    stage_placement(1, 20, 15, v3(0, row->height, 0), placement);
    stage_placed(stage, "occluder", clay, placement);
    stage_disk(stage, v3(-1.5, 4, 0.9), v3(0, 0.5, 0), row->light, white);
    stage_camera(stage, v3(-0.6, 3.2, 5), v3(0.35, 0.6, 0), 40);
}

void builtin_spheres(struct stage *stage, const struct builtin *row)
{
    const int *n = row->counts;
    int most = n[0] > n[1] ? n[0] : n[1];
    double step = 2.4 / most, radius = 0.38 * step, placement[12];
    stage_ground(stage, 10);
    shape_sphere_762(&stage->shape, v3(0, 0, 0), radius);
    for (int y = 0; y < n[1]; y++)
        for (int z = 0; z < n[2]; z++)
            for (int x = 0; x < n[0]; x++) {
                char name[48];
                vec3 at = v3((x - 0.5 * (n[0] - 1)) * step, row->height + y * step,
                             (z - 0.5 * (n[2] - 1)) * step);
                vec3 color = v3(0.35 + 0.4 * x / (n[0] - 1), 0.4, 0.35 + 0.4 * z / (n[2] - 1));
                snprintf(name, sizeof(name), "sphere %d %d %d", x, y, z);
                stage_placement(1, 0, 0, at, placement);
                if (x + y + z == 0)
                    stage_placed(stage, name, color, placement);
                else
                    stage_instance(stage, name, color, placement);
            }
    double top = row->height + (n[1] - 1) * step;
    stage_rectangle(stage, v3(-1.8, top + 3, 1.2), v3(0, 0, 0), row->light, row->light, white);
    if (n[1] == 1)
        stage_camera(stage, v3(1.6, 3, 4.9), v3(0.3, 0.35, 0), 40);
    else
        stage_camera(stage, v3(2.8, 4.2, 6.8), v3(0.55, 1.0, -0.15), 38);
}

/* One plate; or two with a gap, through which the middle of the light reaches where both of its
 * ends are hidden. */
void builtin_blocker(struct stage *stage, const struct builtin *row)
{
    double y = row->height;
    stage_ground(stage, 8);
    if (row->counts[0] == 1) {
        shape_box(&stage->shape, v3(-0.5, y, -0.45), v3(0.5, y + 0.06, 0.45));
        stage_object(stage, "blocker", clay);
    } else {
        /* Through the gap the ground sees some 1.3 m of the light, less than its length and more than
         * half of it: two samples at its ends miss what three do not. */
        shape_box(&stage->shape, v3(-0.9, y, -0.45), v3(-0.3, y + 0.06, 0.45));
        stage_object(stage, "left blocker", clay);
        shape_box(&stage->shape, v3(0.3, y, -0.45), v3(0.9, y + 0.06, 0.45));
        stage_object(stage, "right blocker", steel);
    }
    stage_line(stage, v3(-row->light, 2.6, 0), v3(row->light, 2.6, 0), white);
    stage_camera(stage, v3(0.6, 3.4, 4.6), v3(0, 0.25, 0), 42);
}

void builtin_triangle_light(struct stage *stage, const struct builtin *row)
{
    /* Counter-clockwise seen from below: it lights downwards. */
    double s = row->light;
    const double vertices[9] = {-1.2 - s, 3.2, 0.8 - s, -1.2 + s, 3.2, 0.8 - s, -1.2, 3.2, 0.8 + s};
    pnb_light light = {.type = PNB_LIGHT_POLYGON, .color = {1, 1, 1}};
    double placement[12];
    light.shape.polygon.vertices = vertices;
    light.shape.polygon.vertex_count = 3;
    stage_ground(stage, 8);
    shape_box(&stage->shape, v3(-0.35, 0, -0.35), v3(0.35, 1.1, 0.35));
    stage_placement(1, 0, 28, v3(-0.45, 0, -0.2), placement);
    stage_placed(stage, "box", clay, placement);
    shape_sphere_762(&stage->shape, v3(0.65, 0.42, 0.35), 0.42);
    stage_object(stage, "sphere", steel);
    stage_light(stage, &light);
    stage_camera(stage, v3(0.9, 2.5, 4.6), v3(0.35, 0.4, 0), 38);
}

struct spring {
    double radius, height, turns, wire;
};

static vec3 spring_curve(const void *user, double t)
{
    const struct spring *spring = user;
    double a = 2 * M_PI * spring->turns * t;
    return v3(spring->radius * cos(a), spring->height * t, -spring->radius * sin(a));
}

static double spring_section(const void *user, double t, double angle)
{
    return ((const struct spring *)user)->wire;
}

void builtin_jack(struct stage *stage, const struct builtin *row)
{
    /* The box is a skin over four squares: outside up, over the rim, inside down. */
    static const double half[4] = {0.5, 0.5, 0.44, 0.44}, level[4] = {0, 0.7, 0.7, 0.06};
    static const double side[4][2] = {{-1, 1}, {1, 1}, {1, -1}, {-1, -1}};
    vec3 rings[16];
    double placement[12];
    stage_ground(stage, 8);
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 4; i++)
            rings[4 * k + i] = v3(half[k] * side[i][0], level[k], half[k] * side[i][1]);
    shape_loft(&stage->shape, rings, 4, 4, false);
    stage_placement(1, 0, 25, v3(0, 0, 0), placement);
    stage_placed(stage, "box", v3(0.2, 0.35, 0.62), placement);
    /* The lid stands open behind the box, leaning back. */
    shape_box(&stage->shape, v3(-0.5, 0, -0.03), v3(0.5, 0.98, 0.03));
    double yaw = 25 * M_PI / 180;
    stage_placement(1, -20, 25, v3(-0.53 * sin(yaw), 0.7, -0.53 * cos(yaw)), placement);
    stage_placed(stage, "lid", v3(0.2, 0.35, 0.62), placement);

    struct spring spring = {0.2, 0.95, 6, 0.035};
    shape_tube(&stage->shape,
               &(struct shape_tube){spring_curve, spring_section, &spring, (size_t)row->counts[0],
                                    (size_t)row->counts[1], true});
    stage_placement(1, 0, 0, v3(0, 0.1, 0), placement);
    stage_placed(stage, "spring", v3(0.62, 0.62, 0.66), placement);
    shape_sphere_762(&stage->shape, v3(0, 1.36, 0), 0.32);
    stage_object(stage, "head", v3(0.85, 0.62, 0.48));
    shape_sphere_762(&stage->shape, v3(0.14, 1.34, 0.31), 0.08);
    stage_object(stage, "nose", v3(0.75, 0.1, 0.08));
    shape_rod(&stage->shape, v3(0, 1.57, 0), v3(-0.1, 2.15, -0.05), 0.27, 0, 32);
    stage_object(stage, "hat", v3(0.75, 0.16, 0.12));
    shape_sphere_762(&stage->shape, v3(-0.1, 2.15, -0.05), 0.07);
    stage_object(stage, "bobble", v3(0.85, 0.8, 0.3));
    if (row->counts[2] == 0)
        stage_rectangle(stage, v3(-1.7, 3.6, 1.9), v3(0, 0.6, 0), row->light, row->light, white);
    else
        stage_line(stage, v3(-1.7 - row->light, 3.6, 1.9 - row->light),
                   v3(-1.7 + row->light, 3.6, 1.9 + row->light), white);
    stage_camera(stage, v3(1.2, 2.5, 5.2), v3(0.4, 0.85, -0.1), 38);
}

void builtin_two_boxes(struct stage *stage, const struct builtin *row)
{
    double placement[12];
    stage_ground(stage, 8);
    shape_box(&stage->shape, v3(-0.22, 0, -0.22), v3(0.22, 1.5, 0.22));
    stage_placement(1, 0, 15, v3(-0.75, 0, 0.35), placement);
    stage_placed(stage, "tall box", clay, placement);
    shape_box(&stage->shape, v3(-0.4, 0, -0.25), v3(0.4, 0.75, 0.25));
    stage_placement(1, 0, -30, v3(-0.35, 0, -0.75), placement);
    stage_placed(stage, "wide box", steel, placement);
    stage_rectangle(stage, v3(-2.4, 3.3, 0.3), v3(0, 0, 0), row->light, row->light, white);
    stage_camera(stage, v3(1.1, 3, 4.6), v3(0.35, 0.3, -0.15), 40);
}

void builtin_pole(struct stage *stage, const struct builtin *row)
{
    stage_ground(stage, 8);
    shape_rod(&stage->shape, v3(0, 0, 0), v3(0, 1.8, 0), 0.07, 0.07, (size_t)row->counts[0]);
    stage_object(stage, "pole", moss);
    stage_rectangle(stage, v3(-1.8, 3.4, 1.2), v3(0, 0.5, 0), row->light, row->light, white);
    stage_camera(stage, v3(1, 2.5, 5), v3(0.7, 0.6, -0.3), 36);
}
