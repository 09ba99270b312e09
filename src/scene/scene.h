/* scene/scene.h: the scene's inside. */
#ifndef SCENE_SCENE_H
#define SCENE_SCENE_H

#include <penumbra/scene.h>

#include "base/base.h"
#include "geom/vec.h"
#include "mesh/mesh.h"

struct scene_object {
    pnb_object info; /* name is scene memory */
};

struct pnb_scene {
    pnb_context *context;
    char *name;
    struct mesh *meshes;
    size_t mesh_count, mesh_capacity;
    struct scene_object *objects;
    size_t object_count, object_capacity;
    pnb_light *lights; /* names and polygon vertices are scene memory */
    size_t light_count, light_capacity;
    char **notes;
    size_t note_count, note_capacity;
    pnb_camera camera;
    double ambient[3], background[3];
    double exposure; /* 0: automatic */
    /* Counts changes, so that who keeps something made from the scene can see that it is stale. */
    unsigned long geometry_version, placement_version;
    struct trace *shared_trace; /* of those who keep one, who own it (trace/trace.h); or NULL */
};

/* One formatted line; never fails (a note that finds no memory is lost). */
void scene_note(pnb_scene *scene, const char *format, ...) __attribute__((format(printf, 2, 3)));
pnb_status scene_set_name(pnb_scene *scene, const char *name);

/* How far receivers are lifted off their surface, metres: TOLERANCE_RECEIVER_LIFT x the largest
 * absolute coordinate of the scene's bounds. */
double scene_receiver_lift(const pnb_scene *scene);

/* Camera that frames the given bounds: direction from target to eye (any length), 45 degrees. */
void scene_frame_camera(vec3 bounds_min, vec3 bounds_max, vec3 direction, pnb_camera *out_camera);

/* Files: each makes a scene or fails. */
pnb_status scene_builtin(pnb_context *context, const char *name, pnb_scene **out_scene);
pnb_status scene_import(pnb_context *context, const char *path, pnb_scene **out_scene);
/* All triangles of a mesh file merged as one mesh, node transforms applied: what "mesh": "cow.obj"
 * of a scene file means. Adds it to the scene. */
pnb_status scene_import_mesh(pnb_scene *scene, const char *path, size_t *out_mesh);
/* Adds the ground plane, light and camera that an imported scene lacks, with a note for each.
 * has_camera: the camera in the scene was given. */
pnb_status scene_supply(pnb_scene *scene, bool has_camera);

/* A plane object: two triangles, half_size to each side of point, facing normal. */
pnb_status scene_add_plane(pnb_scene *scene, const char *name, vec3 point, vec3 normal,
                           double half_size, const double color[3], size_t *out_object);

#endif
