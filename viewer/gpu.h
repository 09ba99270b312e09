/* viewer/gpu.h: frames by OpenGL in the window's context: the scene's depth into a texture, the
 * visibility of methods on OpenGL by the library's door for engines, shading, the canvas.
 *
 * Everything but view_gpu_supports() needs the context of create to be current, and changes its
 * state as it likes except for the framebuffer that is bound.
 */
#ifndef VIEWER_GPU_H
#define VIEWER_GPU_H

#include "frame.h"

struct view_gpu;

/* NULL, and why (a line), where the context cannot do it. */
struct view_gpu *view_gpu_create(bool es, char *why, size_t size);
void view_gpu_destroy(struct view_gpu *gpu);

/* Draws the sides that the frame leaves to the window (frame->window), with its state, at its size.
 * Nothing is solved again where the frame shows what the last one did. Fills the frame's times,
 * messages and device; at rest also its visibility. False: a side was refused, out_drawn says why:
 * the worker has to do it. */
bool view_gpu_draw(struct view_gpu *gpu, struct view_scene *scene, struct view_frame *frame,
                   struct view_drawn *out_drawn);
/* The sides drawn last, each on its part of the bound framebuffer. */
void view_gpu_show(struct view_gpu *gpu, const struct view_frame *frame, double divider, int width,
                   int height);
/* The sides drawn last, as bytes, into the frame. */
void view_gpu_read(struct view_gpu *gpu, struct view_frame *frame);

#endif
