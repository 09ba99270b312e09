/* scene.h: meshes, objects that place them, lights, a camera. The scene copies what it is given.
 *
 * Placement: world = linear * p_mesh + translation, kept as a row-major 3x4 matrix world_from_mesh.
 */
#ifndef PENUMBRA_SCENE_H
#define PENUMBRA_SCENE_H

#include <penumbra/context.h>
#include <penumbra/light.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pnb_scene pnb_scene;

/* A pinhole that looks from eye to target. */
typedef struct pnb_camera {
    double eye[3], target[3], up[3];
    double vertical_fov_degrees;
} pnb_camera;

typedef struct pnb_mesh_desc {
    const char *name;       /* may be NULL */
    const float *positions; /* vertex_count x 3 floats */
    const float *normals;   /* vertex_count x 3 floats for shading, or NULL: flat */
    size_t vertex_count;
    const uint32_t *indices; /* triangle_count x 3 */
    size_t triangle_count;
} pnb_mesh_desc;

/* What a mesh's edges say about it. Vertices at equal positions count as one here. */
typedef struct pnb_mesh_info {
    const char *name;
    size_t vertex_count, triangle_count;
    size_t welded_vertex_count; /* distinct positions */
    size_t edge_count;
    size_t open_edge_count;              /* one triangle */
    size_t non_manifold_edge_count;      /* three or more */
    size_t inconsistent_edge_count;      /* directed edges along which two or more triangles run */
    size_t degenerate_triangle_count;    /* zero area, or two equal corners */
    bool closed;                         /* no open, non-manifold or inconsistent edge */
    double bounds_min[3], bounds_max[3]; /* mesh space */
} pnb_mesh_info;

typedef struct pnb_object {
    const char *name;
    size_t mesh;
    double world_from_mesh[12];
    double color[3]; /* albedo, linear RGB */
    bool casts, receives;
    bool plane; /* given as a plane in the scene file: two triangles */
    /* Radiance that the surface shows by itself, linear RGB. It lights nothing: that is what lights
     * are for. Imported emissive objects have it. */
    double emission[3];
} pnb_object;

/* From a file or a name: a scene file (.json), a file that the importer reads, or "builtin:NAME".
 *
 * The importer reads .glb .gltf .obj .ply .stl .off .dae .fbx .3ds .x3d .blend .lwo .ac .ms3d .x,
 * in a child process (the program penumbra-import) under limits of memory and time, so that a
 * broken file can end the import only; it is looked for where the environment's PNB_IMPORTER says,
 * beside the library and the program, and in libexec. What it takes over: meshes      triangles
 * (polygons are cut), vertex normals; vertices that agree in position and normal become one.
 * Points, lines, skins, animations are left out. objects     one per node and mesh, placed by the
 * nodes' transforms; instances share their mesh materials   the base colour (textures are left out)
 *   camera      the first perspective camera
 *   lights      EXT_lights_area: rectangles and disks; KHR_lights_punctual: points, spots as
 *               points, directional lights as suns of 0.53 degrees; flat connected parts of objects
 *               with an emissive material (KHR_materials_emissive_strength counts), as rectangles
 * or polygons that shine along the front of their triangles: such an object stays visible but casts
 * no shadow. Colours are colour x intensity, without photometric factors. What the file lacks is
 * supplied: a camera that frames it, a rectangular light, a ground plane under it (unless there is
 * a floor, or both camera and lights). pnb_scene_note() says what was supplied, changed or left
 * out. */
PNB_API pnb_status pnb_scene_load(pnb_context *context, const char *path, pnb_scene **out_scene);

/* A scene file's text; meshes are looked for relative to folder (NULL: the current one). */
PNB_API pnb_status pnb_scene_parse(pnb_context *context, const char *text, size_t length,
                                   const char *folder, pnb_scene **out_scene);

/* An empty scene: no object, no light, camera at (0,2,6) towards (0,0.5,0) with 45 degrees,
 * ambient 0.15, background 1. */
PNB_API pnb_status pnb_scene_create(pnb_context *context, pnb_scene **out_scene);
PNB_API void pnb_scene_destroy(pnb_scene *scene);

/* Indices in range, positions finite, else PNB_ERROR_SCENE. */
PNB_API pnb_status pnb_scene_add_mesh(pnb_scene *scene, const pnb_mesh_desc *mesh,
                                      size_t *out_index);
PNB_API pnb_status pnb_scene_add_object(pnb_scene *scene, const pnb_object *object,
                                        size_t *out_index);
PNB_API pnb_status pnb_scene_add_light(pnb_scene *scene, const pnb_light *light, size_t *out_index);
/* A light object of the scene file, as JSON text. */
PNB_API pnb_status pnb_scene_add_light_json(pnb_scene *scene, const char *text, size_t *out_index);
PNB_API void pnb_scene_clear_lights(pnb_scene *scene);
/* Eye, target and up must be finite and span a view; field of view in (0, 180). */
PNB_API pnb_status pnb_scene_set_camera(pnb_scene *scene, const pnb_camera *camera);
PNB_API void pnb_scene_set_ambient(pnb_scene *scene, const double ambient[3]);
PNB_API void pnb_scene_set_background(pnb_scene *scene, const double background[3]);
/* Factor from irradiance to the picture; 0: automatic (see pnb_scene_exposure). */
PNB_API void pnb_scene_set_exposure(pnb_scene *scene, double exposure);

/* Moving and deforming. Solvers learn of it by pnb_solver_update(). */
PNB_API pnb_status pnb_scene_set_light(pnb_scene *scene, size_t index, const pnb_light *light);
PNB_API pnb_status pnb_scene_set_placement(pnb_scene *scene, size_t object,
                                           const double world_from_mesh[12]);
/* Same vertex count, new positions: count x 3 floats; normals may be NULL (then flat). */
PNB_API pnb_status pnb_scene_set_vertices(pnb_scene *scene, size_t mesh, const float *positions,
                                          const float *normals);

PNB_API const char *pnb_scene_name(const pnb_scene *scene); /* base name, or "builtin:NAME" */
PNB_API size_t pnb_scene_mesh_count(const pnb_scene *scene);
PNB_API size_t pnb_scene_object_count(const pnb_scene *scene);
PNB_API size_t pnb_scene_light_count(const pnb_scene *scene);
/* Views of the scene's own data, valid until the scene changes. All zero beyond the last one. */
PNB_API void pnb_scene_mesh(const pnb_scene *scene, size_t index, pnb_mesh_desc *out_mesh);
PNB_API void pnb_scene_object(const pnb_scene *scene, size_t index, pnb_object *out_object);
PNB_API void pnb_scene_light(const pnb_scene *scene, size_t index, pnb_light *out_light);
PNB_API void pnb_scene_camera(const pnb_scene *scene, pnb_camera *out_camera);
PNB_API void pnb_scene_ambient(const pnb_scene *scene, double out_ambient[3]);
PNB_API void pnb_scene_background(const pnb_scene *scene, double out_background[3]);
/* The factor in use. Automatic: such that a surface at the camera's target which faces all lights
 * receives 1 in its brightest channel. */
PNB_API double pnb_scene_exposure(const pnb_scene *scene);
/* Counts from the edge structure; O(n) hashing the first time, kept after that. */
PNB_API pnb_status pnb_scene_mesh_info(pnb_scene *scene, size_t mesh, pnb_mesh_info *out_info);
/* World bounds of the objects; false if there is none. */
PNB_API bool pnb_scene_bounds(const pnb_scene *scene, double out_min[3], double out_max[3]);
/* Triangles of all objects, instances counted each. */
PNB_API size_t pnb_scene_triangle_count(const pnb_scene *scene);

/* Lines that say what was supplied, repaired or left out while loading. */
PNB_API size_t pnb_scene_note_count(const pnb_scene *scene);
PNB_API const char *pnb_scene_note(const pnb_scene *scene, size_t index);

/* Writers; to a temporary name, then renamed. The scene file refers to meshes written beside it as
 * NAME-MESH.obj; the GLB holds everything, with area lights as EXT_lights_area (shapes that the
 * extension lacks become emissive faces; lines and non-convex polygons too). */
PNB_API pnb_status pnb_scene_write_json(pnb_scene *scene, const char *path);
PNB_API pnb_status pnb_scene_write_glb(pnb_scene *scene, const char *path);

typedef struct pnb_builtin_info {
    const char *name, *title;
    const char *source; /* the paper and figure that it stands for, or "" */
} pnb_builtin_info;

/* The built-in scenes, loaded as "builtin:NAME". */
PNB_API size_t pnb_builtin_count(void);
PNB_API void pnb_builtin(size_t index, pnb_builtin_info *out_info);

#ifdef __cplusplus
}
#endif
#endif
