/* gl/frame.h: what every OpenGL method draws with: the receivers of a frame and the occluders of a
 * scene, on the device. */
#ifndef GL_FRAME_H
#define GL_FRAME_H

#include <penumbra/surface.h>

#include "geom/vec.h"
#include "gl/gl.h"
#include "scene/scene.h"

/* The receivers as a G-buffer, row 0 at the bottom (OpenGL's), pixel (i, j) of an image seen from a
 * pinhole. Made from pnb_receivers, or from an engine's depth texture. */
struct gl_frame {
    int width, height;
    unsigned generation;         /* another one: the textures are new */
    struct gl_texture *position; /* RGBA32F: world position, not lifted; w = 1, or 0: no receiver */
    struct gl_texture *normal;   /* RGBA16F or 32F: geometric, world, unit, towards the eye */
    struct gl_texture *depth;    /* DEPTH24_STENCIL8 or 32F: window depth through clip_from_world */
    double
        clip_from_world[16]; /* column-major, OpenGL's clip space; finite or infinite far plane */
    vec3 eye;
    double near_m;
    bool bounded; /* all receivers are known to lie in low to high */
    vec3 low, high;
    double lift; /* how far methods lift receivers off their surface, metres; each receiver's own
                    is the alpha of its normal (more than this for a depth texture's) */
    /* frame.c's own. */
    struct gl_device *device;
    struct gl_target *depth_target, *surface_target;
    struct gl_program *depth_program, *surface_program;
};

/* Shaders fetch a receiver by  #include "gl/receiver.glsl"  with the samplers
 * gl_sampler("frame_position", frame->position), gl_sampler("frame_normal", frame->normal). */

/* From arrays with an image and a camera: uploads, and draws the depth. near and far are chosen
 * from the points. PNB_ERROR_UNSUPPORTED where receivers have no image or no camera. */
pnb_status gl_frame_from_receivers(struct gl_device *device, const pnb_scene *scene,
                                   const pnb_receivers *receivers, struct gl_frame **out_frame);
/* Reuses textures of the same size. */
pnb_status gl_frame_update(struct gl_frame *frame, const pnb_scene *scene,
                           const pnb_receivers *receivers);

/* The same from an engine's depth texture. */
struct gl_frame_source {
    struct gl_texture *depth, *normal; /* adopted; normal NULL: from the depth */
    bool normals_biased;               /* 0.5 n + 0.5 */
    int x, y, width, height;
    double clip_from_world[16]; /* column-major */
    bool zero_to_one;           /* clip z from 0 to w, as glClipControl() may say; else -w to w */
    bool reversed;              /* near is 1 in the window, far 0 */
    bool bounded;               /* what the depth shows lies in low to high */
    vec3 low, high;
};
pnb_status gl_frame_create(struct gl_device *device, struct gl_frame **out_frame); /* empty */
pnb_status gl_frame_from_depth(struct gl_frame *frame, const pnb_scene *scene,
                               const struct gl_frame_source *source);
void gl_frame_destroy(struct gl_frame *frame);

/* All casters of a scene in world space, once per mesh or placement: positions for drawing (maps,
 * volume caps), and edges with their two faces for silhouettes on the device or the CPU. */
struct gl_occluder {
    size_t object;
    size_t first_index, index_count;       /* triangles in indices */
    size_t first_edge, edge_count;         /* in edges */
    size_t open_count, non_manifold_count; /* edges of the mesh */
    bool closed; /* every edge has two faces that run along it in opposite directions */
    vec3 low, high;
    /* Flat, with everything else of the scene on one side (normal points there): shadows nothing
     * for lights on that side, so that maps need not cover it. */
    bool floor;
    vec3 floor_normal;
    double floor_offset; /* normal . p - offset >= 0 on the scene's side */
};
/* An edge and its faces: a to b runs counter-clockwise around the first face. An edge of n uses
 * becomes ceil(n / 2) of these; second is MESH_NONE where there is no partner (open). */
struct gl_edge {
    uint32_t a, b;          /* vertices */
    uint32_t first, second; /* triangles */
    bool same_way;          /* second runs along the edge as first does (inconsistent faces) */
};
struct gl_occluders {
    pnb_context *context;
    bool with_edges;
    float *positions;  /* vertex_count x 3, world, welded per object */
    uint32_t *indices; /* triangle_count x 3; faces counter-clockwise from outside in world space */
    float *planes;     /* triangle_count x 4: unit normal, d; n.p + d; zeros: degenerate */
    struct gl_edge *edges;
    struct gl_occluder *objects;
    size_t vertex_count, triangle_count, edge_count, object_count;
    vec3 low, high; /* of the casters */
    vec3 scene_low, scene_high;
    /* On the device (NULL until gl_occluders_upload). */
    struct gl_buffer *position_buffer, *index_buffer;
};
/* Without edges (and then nothing welded, nothing known to be closed) for methods that only draw
 * triangles. */
pnb_status gl_occluders_create(pnb_scene *scene, bool with_edges,
                               struct gl_occluders **out_occluders);
void gl_occluders_destroy(struct gl_occluders *occluders); /* buffers need begin */
/* Made anew after the scene changed; on failure the old one stays. */
pnb_status gl_occluders_update(pnb_scene *scene, struct gl_occluders **occluders);
pnb_status gl_occluders_upload(struct gl_device *device, struct gl_occluders *occluders);

#endif
