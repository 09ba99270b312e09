/* surface.h: the visible surface of each pixel. Also the door for points of any other origin: fill
 * a pnb_receivers with your own arrays and ask a solver for their visibility. */
#ifndef PENUMBRA_SURFACE_H
#define PENUMBRA_SURFACE_H

#include <penumbra/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Points that receive light. All arrays belong to the caller (or to a pnb_surface). A point whose
 * position is NaN is none: its visibility is NaN. */
typedef struct pnb_receivers {
    size_t count;
    const float *positions; /* count x 3, world */
    const float *normals;   /* count x 3, world, unit length: the geometric normal */
    /* If the points are the pixels of an image, row-major from the top left: its size, else 0.
     * Methods use it to share work among neighbours. */
    int width, height;
    const uint32_t *objects;  /* count, index of the scene's object, or NULL: unknown */
    const pnb_camera *camera; /* from which the image was seen, or NULL; OpenGL methods need it */
} pnb_receivers;

typedef struct pnb_surface pnb_surface;

#define PNB_NO_OBJECT 0xffffffffu

/* Arrays of width x height pixels, row-major from the top left. Pixel (i, j) looks through
 * ((i + 0.5)/width, (j + 0.5)/height) of a pinhole camera. Normals are turned towards the eye.
 * Where the camera sees nothing: positions, normals and depth are NaN, objects PNB_NO_OBJECT. */
typedef struct pnb_surface_view {
    int width, height;
    const float *positions;       /* x 3, world */
    const float *normals;         /* x 3, world, geometric */
    const float *shading_normals; /* x 3, world, interpolated where the mesh has normals */
    const float *depth;           /* x 1, distance along the view axis, metres */
    const uint32_t *objects;      /* x 1 */
    double primary_ms;            /* what finding it took */
} pnb_surface_view;

/* One primary ray per pixel through Embree, all threads. camera NULL: the scene's. Every object is
 * visible, whether it receives or not. The hierarchy over the scene is built for it, O(triangles),
 * and dropped at the end. The scene must outlive the surface. */
PNB_API pnb_status pnb_surface_create(pnb_context *context, pnb_scene *scene,
                                      const pnb_camera *camera, int width, int height,
                                      pnb_surface **out_surface);

/* The same scene as it is now, from this camera and at this size: what create would give, to the
 * bit. The hierarchy is kept, some 100 bytes a triangle, by all surfaces of the scene together,
 * until the last that was updated is destroyed: the first update builds it, later ones cost
 * O(pixels), whatever the camera and the size, until an object or a vertex changes. Objects that
 * move are followed, O(their vertices), by a hierarchy built for that at the first movement; where
 * two triangles lie at the same distance on a ray it may name the other one than create would. An
 * update that finds nothing moved since this surface's last builds it anew. Arrays are reused:
 * views taken before are void. Where camera, size or memory are refused the surface stays as it
 * was; cancelled, it shows nothing. */
PNB_API pnb_status pnb_surface_update(pnb_surface *surface, const pnb_camera *camera, int width,
                                      int height);
PNB_API void pnb_surface_destroy(pnb_surface *surface);
PNB_API void pnb_surface_get(const pnb_surface *surface, pnb_surface_view *out_view);
/* The pixels as receivers. */
PNB_API void pnb_surface_receivers(const pnb_surface *surface, pnb_receivers *out_receivers);

/* picture = albedo x (ambient + exposure x sum of irradiance x visibility) + exposure x pi x
 * emission, background elsewhere.
 * visibility: one array of width x height per light of the scene (NULL entry: 1 everywhere; NaN
 * counts as 1); objects with receives = false are lit without shadow. rgb: width x height x 3
 * floats, linear. */
PNB_API pnb_status pnb_surface_shade(const pnb_surface *surface, const float *const *visibility,
                                     float *rgb);

#ifdef __cplusplus
}
#endif
#endif
