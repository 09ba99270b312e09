/* opengl.h: OpenGL methods inside your own program: your current context, your depth texture, your
 * matrices; a texture with the visibility comes out. No context is created, nothing is read back,
 * and the state that is touched is given back as it was.
 *
 *   pnb_gl_solver_create (context current)  ->  pnb_gl_solver_visibility (each frame)
 *   ->  pnb_solver_destroy (context current)
 *
 * Occluders are the casting objects of a pnb_scene that you fill with your meshes
 * (pnb_scene_create(), pnb_scene_add_mesh(), pnb_scene_add_object()); move them by
 * pnb_scene_set_placement() and pnb_solver_update(). Needs OpenGL 3.3 core, or OpenGL ES 3.2. */
#ifndef PENUMBRA_OPENGL_H
#define PENUMBRA_OPENGL_H

#include <penumbra/method.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pnb_gl_view {
    unsigned depth_texture;  /* GL_TEXTURE_2D, a depth format, at least x + width by y + height */
    unsigned normal_texture; /* GL_TEXTURE_2D of world-space normals, or 0: from the depth */
    bool normals_biased;     /* normals are stored as 0.5 n + 0.5 */
    int x, y, width, height; /* the viewport, pixels; width 0: the whole depth texture */
    /* World to clip space of the picture in the depth texture, column-major (as glUniformMatrix
     * takes it), depth range [0,1] in the window, perspective. */
    float clip_from_world[16];
    /* How your projection fills the depth, where it is not OpenGL's own way. */
    bool clip_zero_to_one; /* clip z runs from 0 to w: glClipControl(..., GL_ZERO_TO_ONE) */
    bool depth_reversed;   /* near is 1 in the depth texture and far 0 */
    /* A box around all surfaces in the depth texture, world space, if you know one; all zero:
     * unknown. `dbuffer` then spends its texels on it alone. Surfaces outside of it may lack their
     * shadow. */
    float low[3], high[3];
} pnb_gl_view;

/* Like pnb_solver_create(), in the OpenGL context that is current in this thread.
 * PNB_ERROR_ARGUMENT for methods that are not on OpenGL (pnb_method_info.processor),
 * PNB_ERROR_DEVICE where no context is current or it cannot do the method. */
PNB_API pnb_status pnb_gl_solver_create(pnb_context *context, pnb_scene *scene,
                                        const pnb_solver_desc *desc, pnb_solver **out_solver);

/* Draws the light's visibility into visibility_texture: GL_TEXTURE_2D of format GL_R8, GL_R16F or
 * GL_R32F and of the viewport's size; 1 where the depth texture shows no surface. Same context as
 * at create. */
PNB_API pnb_status pnb_gl_solver_visibility(pnb_solver *solver, const pnb_light *light,
                                            const pnb_gl_view *view, unsigned visibility_texture);

#ifdef __cplusplus
}
#endif
#endif
