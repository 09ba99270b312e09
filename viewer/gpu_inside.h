/* viewer/gpu_inside.h: what gpu.c and gpu_scene.c share. */
#ifndef VIEWER_GPU_INSIDE_H
#define VIEWER_GPU_INSIDE_H

#include <epoxy/gl.h>

#include "gpu.h"

/* The scene on the device: meshes once, triangles one by one, 108 bytes each. */
struct gpu_mesh {
    GLuint array, buffer;
    GLsizei count; /* corners */
};

struct gpu_solver {
    pnb_solver *solver; /* NULL: none, or it could not be made */
    struct view_method method;
    uint64_t moves;
    pnb_status status; /* of making it */
    char error[256];
    bool tried;
    bool warm; /* has drawn: drivers finish compiling at the first draw */
};

struct gpu_scene {
    struct view_scene *scene; /* whose copy (view_twin) the solvers work on */
    struct gpu_mesh *meshes;
    size_t mesh_count;
    GLuint materials;   /* 2 x objects: colour and receives, emission */
    double (*boxes)[6]; /* of the meshes */
    uint64_t moves;     /* times that an object moved */
    struct gpu_solver solvers[VIEW_SIDES];
};

/* False, and why: it does not fit. */
bool gpu_scene_open(struct gpu_scene *s, struct view_scene *scene, char *why, size_t size);
void gpu_scene_close(struct gpu_scene *s);
/* Objects to where the state has them. */
void gpu_scene_move(struct gpu_scene *s, const struct view_state *state);
/* The distance of the nearest thing that the eye can see, at least; metres. */
double gpu_scene_near(const struct gpu_scene *s, const struct view_state *state, double corner);
pnb_status gpu_scene_solver(struct gpu_scene *s, int side, const struct view_method *method);

#endif
