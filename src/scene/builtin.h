/* scene/builtin.h: what a built-in scene is made with. */
#ifndef SCENE_BUILTIN_H
#define SCENE_BUILTIN_H

#include "mesh/shape.h"
#include "scene/scene.h"

struct builtin;

/* A scene under construction. The first failure stays in status; every call after that does
 * nothing, so recipes need no checks. */
struct stage {
    pnb_context *context;
    pnb_scene *scene;
    pnb_status status;
    struct shape shape; /* what stage_object() turns into an object */
    uint64_t random;
};

/* One row of the table: all that tells the scenes of a series apart. */
struct builtin {
    pnb_builtin_info info;
    void (*make)(struct stage *stage, const struct builtin *row);
    double light;  /* the light's half side or radius, metres */
    double height; /* of the occluder above the ground, metres */
    int counts[3]; /* tessellation, or how many */
};

/* [0, 1), the same numbers on every run. */
double stage_random(struct stage *stage);
void stage_camera(struct stage *stage, vec3 eye, vec3 target, double vertical_fov_degrees);
void stage_ground(struct stage *stage, double half_size);
/* The stage's shape becomes a mesh with one object at the origin; the shape is empty afterwards. */
void stage_object(struct stage *stage, const char *name, vec3 color);
/* The same, placed: world = linear p + translation. */
void stage_placed(struct stage *stage, const char *name, vec3 color, const double placement[12]);
/* One more object of the last mesh. */
void stage_instance(struct stage *stage, const char *name, vec3 color, const double placement[12]);
/* Turn about x, then y, degrees; uniform scale; shift. */
void stage_placement(double scale, double turn_x, double turn_y, vec3 shift, double placement[12]);

/* Area lights that look from center towards target; up is the direction of half_v. */
void stage_rectangle(struct stage *stage, vec3 center, vec3 target, double half_u, double half_v,
                     vec3 color);
void stage_disk(struct stage *stage, vec3 center, vec3 target, double radius, vec3 color);
void stage_line(struct stage *stage, vec3 from, vec3 to, vec3 color);
void stage_light(struct stage *stage, const pnb_light *light);

/* The recipes. */
void builtin_prism(struct stage *stage, const struct builtin *row);
void builtin_ring(struct stage *stage, const struct builtin *row);
void builtin_small_knot(struct stage *stage, const struct builtin *row);
void builtin_complex(struct stage *stage, const struct builtin *row);
void builtin_spheres(struct stage *stage, const struct builtin *row);
void builtin_blocker(struct stage *stage, const struct builtin *row);
void builtin_triangle_light(struct stage *stage, const struct builtin *row);
void builtin_jack(struct stage *stage, const struct builtin *row);
void builtin_slanted_tube(struct stage *stage, const struct builtin *row);
void builtin_tube_inside(struct stage *stage, const struct builtin *row);
void builtin_two_boxes(struct stage *stage, const struct builtin *row);
void builtin_pole(struct stage *stage, const struct builtin *row);
void builtin_fence(struct stage *stage, const struct builtin *row);
void builtin_knot(struct stage *stage, const struct builtin *row);
void builtin_leaves(struct stage *stage, const struct builtin *row);
void builtin_wires(struct stage *stage, const struct builtin *row);
void builtin_light_plane(struct stage *stage, const struct builtin *row);
void builtin_lantern(struct stage *stage, const struct builtin *row);
void builtin_light_in_solid(struct stage *stage, const struct builtin *row);
void builtin_room(struct stage *stage, const struct builtin *row);
void builtin_outdoor(struct stage *stage, const struct builtin *row);
void builtin_disk(struct stage *stage, const struct builtin *row);
void builtin_three_lights(struct stage *stage, const struct builtin *row);

#endif
