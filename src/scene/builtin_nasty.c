/* scene/builtin_nasty.c: recipes of the scenes that methods fail on, and of larger settings. */
#include "scene/builtin.h"

#include <stdio.h>

static const vec3 white = {1, 1, 1};
static const vec3 clay = {0.72, 0.38, 0.22}, steel = {0.3, 0.42, 0.6}, moss = {0.36, 0.5, 0.26},
                  wood = {0.5, 0.33, 0.2}, plaster = {0.8, 0.78, 0.72};

/* Two wings of counts[0] pickets and counts[1] rails: 206 boxes, 2,472 triangles; the ground makes
 * 2,474. Rails pass behind the pickets at a finger's breadth: no two boxes touch. */
void builtin_fence(struct stage *stage, const struct builtin *row)
{
    const double pitch = 0.05;
    double length = row->counts[0] * pitch, turn[12];
    stage_ground(stage, 10);
    for (int wing = 0; wing < 2; wing++) {
        size_t first = stage->shape.vertex_count;
        for (int i = 0; i < row->counts[0]; i++)
            shape_box(&stage->shape, v3(i * pitch + 0.012, 0.02, -0.009),
                      v3(i * pitch + 0.038, 0.9 + 0.05 * (i % 2), 0.009));
        for (int i = 0; i < row->counts[1]; i++)
            shape_box(&stage->shape, v3(0, 0.15 + 0.3 * i, -0.035),
                      v3(length, 0.2 + 0.3 * i, -0.015));
        stage_placement(1, 0, wing ? -78 : 0, v3(wing ? -2.58 : -2.5, 0, wing ? -0.7 : -0.8), turn);
        shape_transform(&stage->shape, first, turn);
    }
    stage_object(stage, "fence", wood);
    stage_rectangle(stage, v3(-3.6, 3.4, -3.2), v3(0, 0, 0.4), row->light, row->light, white);
    stage_camera(stage, v3(1.9, 2.1, 4), v3(-0.45, 0.25, 0.1), 40);
}

/* Leaves in a ball, tilted by chance; counts[0] open quads. Their area altogether is the same
 * whatever the count. */
void builtin_leaves(struct stage *stage, const struct builtin *row)
{
    double size = 0.021 * sqrt(5000.0 / row->counts[0]);
    stage_ground(stage, 10);
    for (int i = 0; i < row->counts[0]; i++) {
        /* In the ball by rejection, denser outside. */
        vec3 p;
        do {
            double x = stage_random(stage), y = stage_random(stage), z = stage_random(stage);
            p = v3(2 * x - 1, 2 * y - 1, 2 * z - 1);
        } while (v3_length(p) > 1 || v3_length(p) < 0.35);
        double cosine = 2 * stage_random(stage) - 1, angle = 2 * M_PI * stage_random(stage);
        double sine = sqrt(1 - cosine * cosine), spin = 2 * M_PI * stage_random(stage);
        vec3 n = v3(sine * cos(angle), cosine, sine * sin(angle)), u, v;
        v3_frame(n, &u, &v);
        vec3 a = v3_mad(v3_scale(u, cos(spin)), v, sin(spin)), b = v3_cross(n, a);
        shape_quad(&stage->shape, v3(0.95 * p.x, row->height + 0.85 * p.y, 0.95 * p.z),
                   v3_scale(a, 1.4 * size), v3_scale(b, size));
    }
    stage_object(stage, "leaves", v3(0.28, 0.46, 0.16));
    shape_rod(&stage->shape, v3(0, 0, 0), v3(0.05, row->height + 0.3, 0), 0.09, 0.05, 12);
    stage_object(stage, "trunk", wood);
    stage_rectangle(stage, v3(-2.4, 5, 1.8), v3(0, 0.8, 0), row->light, row->light, white);
    stage_camera(stage, v3(1.4, 3.2, 7.2), v3(0.5, 1.15, -0.3), 38);
}

/* counts[0] wires of 4 mm, and three that cross them. */
void builtin_wires(struct stage *stage, const struct builtin *row)
{
    stage_ground(stage, 8);
    shape_rod(&stage->shape, v3(-1.2, 0, 0), v3(-1.2, 1.5, 0), 0.04, 0.04, 12);
    stage_object(stage, "left post", wood);
    shape_rod(&stage->shape, v3(1.2, 0, 0), v3(1.2, 1.5, 0), 0.04, 0.04, 12);
    stage_object(stage, "right post", wood);
    for (int i = 0; i < row->counts[0]; i++) {
        double y = 0.2 + 1.2 * i / (row->counts[0] - 1);
        shape_rod(&stage->shape, v3(-1.2, y, 0.003 * (i % 3)), v3(1.2, y, -0.004 * (i % 2)), 0.002,
                  0.002, 6);
    }
    for (int i = 0; i < 3; i++)
        shape_rod(&stage->shape, v3(-0.8 + 0.7 * i, 0.05, 0.02), v3(-0.6 + 0.7 * i, 1.48, 0.02),
                  0.002, 0.002, 6);
    stage_object(stage, "wires", v3(0.2, 0.2, 0.22));
    stage_rectangle(stage, v3(-0.8, 3, -2.2), v3(0, 0.3, 0.4), row->light, row->light, white);
    stage_camera(stage, v3(0.5, 1.9, 3.9), v3(0.05, 0.5, 0.25), 40);
}

/* The light's plane is y = height; a tower and a leaning slab stand through it. */
void builtin_light_plane(struct stage *stage, const struct builtin *row)
{
    double placement[12];
    stage_ground(stage, 10);
    shape_box(&stage->shape, v3(0.8, 0, -0.3), v3(1.2, 2.6, 0.3));
    stage_object(stage, "tower", clay);
    shape_box(&stage->shape, v3(-0.5, 0, -0.04), v3(0.5, 2.5, 0.04));
    stage_placement(1, 12, -50, v3(-1.0, 0.009, 0.1), placement);
    stage_placed(stage, "leaning slab", steel, placement);
    shape_sphere_762(&stage->shape, v3(0.1, 0.35, 0.5), 0.35);
    stage_object(stage, "sphere", moss);
    stage_rectangle(stage, v3(0, row->height, 0), v3(0, 0, 0), row->light, row->light, white);
    stage_camera(stage, v3(0.3, 4.1, 5.7), v3(0, 0.45, 0), 42);
}

/* A roof, a square ring below and bars between them, counts[0] to a side, all one mesh; the light
 * shines down from inside. Bars end within roof and ring. */
void builtin_lantern(struct stage *stage, const struct builtin *row)
{
    static const double half[4] = {0.4, 0.4, 0.33, 0.33}, level[4] = {-0.25, -0.2, -0.2, -0.25};
    static const double side[4][2] = {{-1, 1}, {1, 1}, {1, -1}, {-1, -1}};
    vec3 rings[16];
    double y = row->height, placement[12];
    stage_ground(stage, 10);
    shape_box(&stage->shape, v3(-0.4, y + 0.2, -0.4), v3(0.4, y + 0.26, 0.4));
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 4; i++)
            rings[4 * k + i] = v3(half[k] * side[i][0], y + level[k], half[k] * side[i][1]);
    shape_loft(&stage->shape, rings, 4, 4, true);
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < row->counts[0]; i++) {
            double along = -0.365 + 0.73 * i / row->counts[0];
            double x = k == 0 ? along : k == 1 ? 0.365 : k == 2 ? -along : -0.365;
            double z = k == 0 ? 0.365 : k == 1 ? -along : k == 2 ? -0.365 : along;
            shape_box(&stage->shape, v3(x - 0.028, y - 0.22, z - 0.028),
                      v3(x + 0.028, y + 0.23, z + 0.028));
        }
    stage_object(stage, "lantern", v3(0.25, 0.24, 0.22));
    shape_box(&stage->shape, v3(-0.3, 0, -0.3), v3(0.3, 0.5, 0.3));
    stage_placement(1, 0, 30, v3(0.9, 0, -0.2), placement);
    stage_placed(stage, "box", clay, placement);
    shape_sphere_762(&stage->shape, v3(-0.8, 0.3, 0.3), 0.3);
    stage_object(stage, "sphere", steel);
    stage_rectangle(stage, v3(0, y + 0.15, 0), v3(0, 0, 0), row->light, row->light, white);
    stage_camera(stage, v3(1.5, 3, 5.2), v3(0, 0.55, 0), 40);
}

void builtin_light_in_solid(struct stage *stage, const struct builtin *row)
{
    double y = row->height, placement[12];
    stage_ground(stage, 8);
    shape_box(&stage->shape, v3(-0.4, -0.15, -0.4), v3(0.4, 0.15, 0.4));
    stage_placement(1, 0, 20, v3(0, y, 0), placement);
    stage_placed(stage, "box around the light", clay, placement);
    shape_rod(&stage->shape, v3(0, 0, 0), v3(0, 1, 0), 0.3, 0, 32);
    stage_object(stage, "cone", steel);
    shape_sphere_762(&stage->shape, v3(0.9, 0.3, 0.4), 0.3);
    stage_object(stage, "sphere", moss);
    stage_rectangle(stage, v3(0, y, 0), v3(0, 0, 0), row->light, row->light, white);
    stage_camera(stage, v3(0.8, 3.0, 5.3), v3(0.1, 0.5, 0), 46);
}

static void room_walls(struct stage *stage)
{
    /* 4 x 2.6 x 5 m inside; walls 10 cm thick that end 1 cm apart, so that none touches another. */
    static const struct {
        const char *name;
        vec3 low, high, color;
    } walls[] = {
        {"floor", {-2.1, -0.1, -2.6}, {2.1, 0, 2.6}, {0.55, 0.45, 0.36}},
        {"ceiling", {-2.1, 2.6, -2.6}, {2.1, 2.7, 2.6}, {0.82, 0.82, 0.8}},
        {"left wall", {-2.1, 0.0005, -2.6}, {-2, 2.5995, 2.6}, {0.62, 0.2, 0.14}},
        {"right wall", {2, 0.0005, -2.6}, {2.1, 2.5995, 2.6}, {0.2, 0.4, 0.5}},
        {"back wall", {-1.9995, 0.0005, -2.6}, {1.9995, 2.5995, -2.5}, {0.8, 0.78, 0.72}},
        {"front wall", {-1.9995, 0.0005, 2.5}, {1.9995, 2.5995, 2.6}, {0.8, 0.78, 0.72}},
    };
    for (size_t i = 0; i < sizeof(walls) / sizeof(walls[0]); i++) {
        shape_box(&stage->shape, walls[i].low, walls[i].high);
        stage_object(stage, walls[i].name, walls[i].color);
    }
}

void builtin_room(struct stage *stage, const struct builtin *row)
{
    double placement[12], s = row->light;
    room_walls(stage);
    /* A table: a top, and legs that end within it. */
    shape_box(&stage->shape, v3(-0.8, 0.7, -0.45), v3(0.8, 0.76, 0.45));
    for (int i = 0; i < 4; i++) {
        double x = i & 1 ? 0.7 : -0.7, z = i & 2 ? 0.36 : -0.36;
        shape_box(&stage->shape, v3(x - 0.03, 0.001, z - 0.03), v3(x + 0.03, 0.72, z + 0.03));
    }
    stage_placement(1, 0, 20, v3(0.1, 0, -0.7), placement);
    stage_placed(stage, "table", wood, placement);
    shape_sphere_762(&stage->shape, v3(0.4, 0.94, -0.85), 0.18);
    stage_object(stage, "ball", v3(0.75, 0.6, 0.2));
    shape_torus(&stage->shape, 0.2, 0.07, 40, 20);
    stage_placement(1, 65, 30, v3(-0.25, 0.99, -0.6), placement);
    stage_placed(stage, "ring", steel, placement);
    /* A shelf against the left wall, a stool, a column. */
    for (int i = 0; i < 3; i++)
        shape_box(&stage->shape, v3(-1.998, 0.6 + 0.5 * i, -1.9), v3(-1.65, 0.63 + 0.5 * i, -0.5));
    stage_object(stage, "shelf", wood);
    shape_rod(&stage->shape, v3(1.0, 0.001, 0.1), v3(1.0, 0.45, 0.1), 0.16, 0.2, 32);
    stage_object(stage, "stool", moss);
    shape_rod(&stage->shape, v3(1.45, 0.001, -1.7), v3(1.45, 2.599, -1.7), 0.15, 0.13, 32);
    stage_object(stage, "column", plaster);

    /* An L just below the ceiling, counter-clockwise seen from below. */
    const double y = 2.58, x0 = -1.1, z0 = -1.4;
    const double corners[6][2] = {{0, 0}, {4 * s, 0},   {4 * s, s},
                                  {s, s}, {s, 3.6 * s}, {0, 3.6 * s}};
    double vertices[18];
    pnb_light light = {.type = PNB_LIGHT_POLYGON, .color = {1, 1, 1}};
    for (int i = 0; i < 6; i++)
        v3_store(vertices + 3 * i, v3(x0 + corners[i][0], y, z0 + corners[i][1]));
    light.shape.polygon.vertices = vertices;
    light.shape.polygon.vertex_count = 6;
    stage_light(stage, &light);
    stage_camera(stage, v3(0.55, 1.6, 2.45), v3(-0.05, 0.95, -0.8), 62);
}

static void tree(struct stage *stage, vec3 foot, double size)
{
    shape_rod(&stage->shape, foot, v3_mad(foot, v3(0, 1, 0), 0.5 * size), 0.06 * size, 0.05 * size,
              16);
    stage_object(stage, "trunk", wood);
    for (int i = 0; i < 3; i++) {
        double low = (0.35 + 0.28 * i) * size, width = (0.36 - 0.09 * i) * size;
        shape_rod(&stage->shape, v3_mad(foot, v3(0, 1, 0), low),
                  v3_mad(foot, v3(0, 1, 0), low + 0.45 * size), width, 0, 24);
        stage_object(stage, "branches", v3(0.16, 0.32, 0.12));
    }
}

void builtin_outdoor(struct stage *stage, const struct builtin *row)
{
    stage_ground(stage, 60);
    /* A house: walls to the gable in one pentagonal loft, a roof of two slabs, a chimney. */
    static const double section[5][2] = {{-2.5, 0}, {2.5, 0}, {2.5, 2.6}, {0, 4.4}, {-2.5, 2.6}};
    vec3 rings[10];
    for (int i = 0; i < 5; i++) {
        rings[i] = v3(section[i][0], section[i][1], -3.2);
        rings[5 + i] = v3(section[i][0], section[i][1], 3.2);
    }
    double placement[12], yaw = 35;
    vec3 at = v3(-1.5, 0, -3);
    stage_placement(1, 0, yaw, at, placement);
    shape_loft(&stage->shape, rings, 2, 5, false);
    stage_placed(stage, "house", plaster, placement);
    double tilt = atan2(1.8, 2.5), run = 0.5 * hypot(2.5, 1.8) + 0.25;
    for (int i = 0; i < 2; i++) {
        double s = i ? 1 : -1;
        vec3 along = v3(s * cos(tilt), -sin(tilt), 0), up = v3(s * sin(tilt), cos(tilt), 0);
        vec3 center = v3_mad(v3_mad(v3(0, 4.4, 0), along, run - 0.03), up, 0.075);
        /* along x up points to -z for s = 1 and to +z for s = -1 when along is the first axis. */
        vec3 w = v3_cross(v3_scale(along, run), v3_scale(up, 0.07));
        shape_beam(&stage->shape, center, v3_scale(along, run), v3_scale(up, 0.07),
                   v3_scale(v3_normalize(w), 3.5));
    }
    stage_placed(stage, "roof", v3(0.5, 0.2, 0.14), placement);
    shape_box(&stage->shape, v3(0.9, 3, -1.6), v3(1.5, 5, -1));
    stage_placed(stage, "chimney", v3(0.45, 0.25, 0.2), placement);

    tree(stage, v3(4.2, 0, -1.5), 5.2);
    tree(stage, v3(6.4, 0, -5.5), 6.5);
    tree(stage, v3(-7.2, 0, -2.2), 5.8);
    tree(stage, v3(1.2, 0, 3.4), 2.6);
    for (int i = 0; i < 24; i++)
        shape_box(&stage->shape, v3(-6 + 0.3 * i, 0.01, 3.96), v3(-5.88 + 0.3 * i, 1, 4));
    shape_box(&stage->shape, v3(-6.05, 0.3, 3.91), v3(1, 0.38, 3.95));
    shape_box(&stage->shape, v3(-6.05, 0.7, 3.91), v3(1, 0.78, 3.95));
    stage_object(stage, "garden fence", wood);

    pnb_light light = {.type = PNB_LIGHT_SUN, .color = {1, 0.93, 0.82}};
    v3_store(light.shape.sun.direction, v3(0.85, -0.8, -0.25));
    light.shape.sun.angular_diameter_degrees = row->light;
    stage_light(stage, &light);
    if (stage->status == PNB_OK) {
        pnb_scene_set_background(stage->scene, (const double[]){0.45, 0.66, 0.92});
        pnb_scene_set_ambient(stage->scene, (const double[]){0.14, 0.17, 0.22});
    }
    stage_camera(stage, v3(5.5, 6.5, 16), v3(0.3, 1, -0.5), 42);
}

void builtin_disk(struct stage *stage, const struct builtin *row)
{
    double placement[12];
    stage_ground(stage, 8);
    shape_torus(&stage->shape, 0.5, 0.16, (size_t)row->counts[0], (size_t)row->counts[1]);
    stage_placement(1, 70, 25, v3(-0.3, 0.95, -0.3), placement);
    stage_placed(stage, "ring", clay, placement);
    shape_sphere_762(&stage->shape, v3(0.7, 0.35, 0.5), 0.35);
    stage_object(stage, "sphere", steel);
    shape_rod(&stage->shape, v3(-0.85, 0, 0.8), v3(-0.85, 0.8, 0.8), 0.28, 0, 40);
    stage_object(stage, "cone", moss);
    stage_disk(stage, v3(-1.6, 3.4, 1.2), v3(0, 0.4, 0), row->light, white);
    stage_camera(stage, v3(0.8, 2.5, 5), v3(0.15, 0.5, 0), 40);
}

void builtin_three_lights(struct stage *stage, const struct builtin *row)
{
    static const vec3 colors[3] = {{1, 0.08, 0.05}, {0.06, 0.9, 0.1}, {0.08, 0.15, 1}};
    double s = row->light;
    stage_ground(stage, 8);
    shape_rod(&stage->shape, v3(0, 0, 0), v3(0, 1.1, 0), 0.2, 0.2, 48);
    stage_object(stage, "column", v3(0.8, 0.8, 0.8));
    shape_sphere_762(&stage->shape, v3(0, 1.38, 0), 0.28);
    stage_object(stage, "ball", v3(0.8, 0.8, 0.8));
    for (int i = 0; i < 3; i++) {
        double angle = 2 * M_PI * i / 3 + 0.6;
        stage_rectangle(stage, v3(2.2 * cos(angle), 3, -2.2 * sin(angle)), v3(0, 0.3, 0), s, s,
                        colors[i]);
    }
    stage_camera(stage, v3(0.2, 3.3, 4.6), v3(0, 0.4, 0), 42);
}
