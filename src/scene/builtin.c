/* scene/builtin.c: the built-in scenes: one table, and the tools that their recipes share.
 *
 * Everything is made by rule, in metres, Y up, with a ground at y = 0; the same scene on every run.
 * All occluders are closed, consistently oriented meshes but for the leaves, which are open quads.
 * The recipes stand in builtin_papers.c, builtin_lines.c and builtin_nasty.c. */
#include "scene/builtin.h"

#include <stdio.h>
#include <string.h>

#define DBUFFER                                                                                    \
    "Jakobsen, Christensen, Larsen, Petersen: Boundary Correct Real-Time Soft Shadows (2004)"
#define WEDGE                                                                                      \
    "Forest, Barthe, Paulin: Realistic Soft Shadows by Penumbra-Wedges Blending (2006), figure 1"
#define LINES  "Heidrich, Brabec, Seidel: Soft Shadow Maps for Linear Lights (2000)"
#define PLANAR "Boehl, Stuerzlinger: Real-Time Computation of Area Shadows (2006)"

static const struct builtin table[] = {
    /* name, title, source, recipe, light, height, counts */
    {{"prism", "a prism under a very large rectangle", DBUFFER ", figures 1 and 7"},
     builtin_prism,
     1.5,
     0.7,
     {0}},
    {{"distance-1", "a ring 2.2 m above the ground", DBUFFER ", figure 8(a)"},
     builtin_ring,
     0.5,
     2.2,
     {14, 8}},
    {{"distance-2", "a ring 1.5 m above the ground", DBUFFER ", figure 8(a)"},
     builtin_ring,
     0.5,
     1.5,
     {14, 8}},
    {{"distance-3", "a ring 0.9 m above the ground", DBUFFER ", figure 8(a)"},
     builtin_ring,
     0.5,
     0.9,
     {14, 8}},
    {{"distance-4", "a ring 0.45 m above the ground", DBUFFER ", figure 8(a)"},
     builtin_ring,
     0.5,
     0.45,
     {14, 8}},
    {{"light-size-1", "a small knot under a disk of 0.05 m", DBUFFER ", figure 8(b)"},
     builtin_small_knot,
     0.05,
     0.9,
     {40, 12}},
    {{"light-size-2", "a small knot under a disk of 0.2 m", DBUFFER ", figure 8(b)"},
     builtin_small_knot,
     0.2,
     0.9,
     {40, 12}},
    {{"light-size-3", "a small knot under a disk of 0.5 m", DBUFFER ", figure 8(b)"},
     builtin_small_knot,
     0.5,
     0.9,
     {40, 12}},
    {{"light-size-4", "a small knot under a disk of 1 m", DBUFFER ", figure 8(b)"},
     builtin_small_knot,
     1.0,
     0.9,
     {40, 12}},
    {{"complex", "a concave occluder of 5,760 triangles over steps", DBUFFER ", figure 8(c)"},
     builtin_complex,
     0.5,
     1.35,
     {120, 24}},
    {{"complex-1440", "the same occluder with 1,440 triangles", DBUFFER ", table 1"},
     builtin_complex,
     0.5,
     1.35,
     {60, 12}},
    {{"spheres-9x9", "81 spheres of 762 triangles in a layer", WEDGE},
     builtin_spheres,
     0.45,
     0.8,
     {9, 1, 9}},
    {{"spheres-3x3x3", "27 spheres of 762 triangles in a cube", WEDGE},
     builtin_spheres,
     0.45,
     0.5,
     {3, 3, 3}},
    {{"spheres-9x9x9", "729 spheres of 762 triangles in a cube", WEDGE},
     builtin_spheres,
     0.45,
     0.4,
     {9, 9, 9}},
    {{"blocker", "one blocker under a linear light", LINES ", figure 2"},
     builtin_blocker,
     1.2,
     1.1,
     {1}},
    {{"overlap", "two blockers with overlapping penumbrae under a linear light",
      LINES ", figure 6"},
     builtin_blocker,
     1.2,
     1.1,
     {2}},
    {{"triangle-light", "a box and a sphere under a triangular light", LINES ", figure 10"},
     builtin_triangle_light,
     0.6,
     0,
     {0}},
    {{"jack-in-the-box", "a clown on a spring, several objects", LINES ", figure 10"},
     builtin_jack,
     0.4,
     0,
     {160, 10}},
    {{"jack-tube", "the jack-in-the-box under a tube", LINES ", figure 10"},
     builtin_jack,
     0.7,
     0,
     {160, 10, 1}},
    {{"slanted-tube", "a ball, a box and a hoop under a tube that slants", ""},
     builtin_slanted_tube,
     0.8,
     2.5,
     {0}},
    {{"tube-inside", "a standing tube with posts and balls all around", ""},
     builtin_tube_inside,
     0.5,
     0.9,
     {7}},
    {{"two-boxes", "two boxes whose shadows overlap", PLANAR}, builtin_two_boxes, 0.5, 0, {0}},
    {{"pole", "a pole standing on the ground", PLANAR}, builtin_pole, 0.5, 0, {16}},
    {{"fence", "a picket fence: 2,474 triangles with the ground", ""},
     builtin_fence,
     0.15,
     0,
     {100, 3}},
    {{"knot", "a (3,7) torus knot of 5,000 vertices", PLANAR}, builtin_knot, 0.5, 1.3, {500, 10}},
    {{"knot-96k", "the knot with 96,000 triangles", ""}, builtin_knot, 0.5, 1.3, {1000, 48}},
    {{"knot-768k", "the knot with 768,000 triangles", ""}, builtin_knot, 0.5, 1.3, {3200, 120}},
    {{"leaves", "a tree of 5,000 leaves, open quads", ""}, builtin_leaves, 0.4, 1.9, {5000}},
    {{"leaves-20k", "a tree of 20,000 leaf triangles, open quads", ""},
     builtin_leaves,
     0.4,
     1.9,
     {10000}},
    {{"thin-wires", "wires of 4 mm between two posts", ""}, builtin_wires, 0.25, 0, {10}},
    {{"caster-through-light-plane", "casters that cross the plane of the light", ""},
     builtin_light_plane,
     0.45,
     1.8,
     {0}},
    {{"light-inside-caster", "a light inside a barred lantern", ""},
     builtin_lantern,
     0.07,
     1.5,
     {4}},
    {{"light-in-solid", "a light whose middle is buried in a solid box", ""},
     builtin_light_in_solid,
     0.7,
     1.9,
     {0}},
    {{"room", "a furnished room under a non-convex, L-shaped light", ""},
     builtin_room,
     0.5,
     0,
     {0}},
    {{"outdoor", "a house and trees in the sun", ""}, builtin_outdoor, 0.53, 0, {0}},
    {{"disk", "a ring, a sphere and a cone under a disk", ""}, builtin_disk, 0.6, 0, {48, 24}},
    {{"three-lights", "one column under a red, a green and a blue rectangle", ""},
     builtin_three_lights,
     0.3,
     0,
     {0}},
};

size_t pnb_builtin_count(void)
{
    return sizeof(table) / sizeof(table[0]);
}

void pnb_builtin(size_t index, pnb_builtin_info *out_info)
{
    *out_info = index < pnb_builtin_count() ? table[index].info : (pnb_builtin_info){"", "", ""};
}

pnb_status scene_builtin(pnb_context *context, const char *name, pnb_scene **out_scene)
{
    const struct builtin *row = NULL;
    *out_scene = NULL;
    for (size_t i = 0; i < pnb_builtin_count() && !row; i++)
        if (strcmp(table[i].info.name, name) == 0)
            row = &table[i];
    if (!row) {
        char what[80];
        snprintf(what, sizeof(what), "builtin:%.60s", name);
        return status_fail(context, PNB_ERROR_FILE, what,
                           "no built-in scene of that name; \"penumbra scenes\" lists them");
    }

    struct stage stage = {.context = context, .random = 0x9e3779b97f4a7c15ull};
    shape_init(context, &stage.shape);
    stage.status = pnb_scene_create(context, &stage.scene);
    if (stage.status == PNB_OK) {
        pnb_scene_set_background(stage.scene, (const double[]){0.62, 0.67, 0.72});
        row->make(&stage, row);
    }
    shape_finish(&stage.shape);
    char full[80];
    snprintf(full, sizeof(full), "builtin:%s", name);
    if (stage.status == PNB_OK)
        stage.status = scene_set_name(stage.scene, full);
    if (stage.status != PNB_OK) {
        pnb_scene_destroy(stage.scene);
        return stage.status;
    }
    *out_scene = stage.scene;
    return PNB_OK;
}

/* SplitMix64 (Steele, Lea, Flood 2014; public domain). */
double stage_random(struct stage *stage)
{
    uint64_t z = stage->random += 0x9e3779b97f4a7c15ull;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ z >> 27) * 0x94d049bb133111ebull;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

void stage_camera(struct stage *stage, vec3 eye, vec3 target, double vertical_fov_degrees)
{
    pnb_camera camera = {.up = {0, 1, 0}, .vertical_fov_degrees = vertical_fov_degrees};
    v3_store(camera.eye, eye);
    v3_store(camera.target, target);
    if (stage->status == PNB_OK)
        stage->status = pnb_scene_set_camera(stage->scene, &camera);
}

void stage_ground(struct stage *stage, double half_size)
{
    static const double color[3] = {0.72, 0.72, 0.7};
    if (stage->status == PNB_OK)
        stage->status = scene_add_plane(stage->scene, "ground", v3(0, 0, 0), v3(0, 1, 0), half_size,
                                        color, NULL);
}

void stage_instance(struct stage *stage, const char *name, vec3 color, const double placement[12])
{
    if (stage->status != PNB_OK)
        return;
    pnb_object object = {.name = name,
                         .mesh = pnb_scene_mesh_count(stage->scene) - 1,
                         .casts = true,
                         .receives = true};
    memcpy(object.world_from_mesh, placement, sizeof(object.world_from_mesh));
    v3_store(object.color, color);
    stage->status = pnb_scene_add_object(stage->scene, &object, NULL);
}

void stage_placed(struct stage *stage, const char *name, vec3 color, const double placement[12])
{
    pnb_mesh_desc mesh = shape_desc(&stage->shape, name);
    if (stage->shape.failed && stage->status == PNB_OK)
        stage->status = status_no_memory(stage->context, mesh.triangle_count * 12);
    if (stage->status == PNB_OK)
        stage->status = pnb_scene_add_mesh(stage->scene, &mesh, NULL);
    shape_finish(&stage->shape);
    stage_instance(stage, name, color, placement);
}

void stage_object(struct stage *stage, const char *name, vec3 color)
{
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    stage_placed(stage, name, color, identity);
}

void stage_placement(double scale, double turn_x, double turn_y, vec3 shift, double placement[12])
{
    double sx = sin(turn_x * M_PI / 180), cx = cos(turn_x * M_PI / 180);
    double sy = sin(turn_y * M_PI / 180), cy = cos(turn_y * M_PI / 180);
    const double m[12] = {cy * scale,  sy * sx * scale, sy * cx * scale, shift.x,
                          0,           cx * scale,      -sx * scale,     shift.y,
                          -sy * scale, cy * sx * scale, cy * cx * scale, shift.z};
    memcpy(placement, m, sizeof(m));
}

void stage_light(struct stage *stage, const pnb_light *light)
{
    if (stage->status == PNB_OK)
        stage->status = pnb_scene_add_light(stage->scene, light, NULL);
}

void stage_line(struct stage *stage, vec3 from, vec3 to, vec3 color)
{
    pnb_light light = {.type = PNB_LIGHT_LINE};
    v3_store(light.color, color);
    v3_store(light.shape.line.from, from);
    v3_store(light.shape.line.to, to);
    stage_light(stage, &light);
}

void stage_rectangle(struct stage *stage, vec3 center, vec3 target, double half_u, double half_v,
                     vec3 color)
{
    pnb_light light = {.type = PNB_LIGHT_RECTANGLE};
    vec3 n = v3_normalize(v3_sub(target, center));
    /* Straight down: sides along x and z. Else: one side level. */
    vec3 u = fabs(n.y) > 0.999 ? v3(1, 0, 0) : v3_normalize(v3_cross(v3(0, 1, 0), n));
    v3_store(light.color, color);
    v3_store(light.shape.rectangle.center, center);
    v3_store(light.shape.rectangle.half_u, v3_scale(u, half_u));
    v3_store(light.shape.rectangle.half_v, v3_scale(v3_cross(n, u), half_v));
    stage_light(stage, &light);
}

void stage_disk(struct stage *stage, vec3 center, vec3 target, double radius, vec3 color)
{
    pnb_light light = {.type = PNB_LIGHT_DISK};
    v3_store(light.color, color);
    v3_store(light.shape.disk.center, center);
    v3_store(light.shape.disk.normal, v3_normalize(v3_sub(target, center)));
    light.shape.disk.radius = radius;
    stage_light(stage, &light);
}
