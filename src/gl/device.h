/* gl/device.h: a headless device of a given kind, so that tests can try the lesser ones. */
#ifndef GL_DEVICE_H
#define GL_DEVICE_H

#include "gl/gl.h"

enum gl_device_api {
    GL_DEVICE_API_BEST = 0,
    GL_DEVICE_API_33, /* asks for OpenGL 3.3 core; drivers may give a later one */
    GL_DEVICE_API_ES  /* OpenGL ES 3.2 */
};
pnb_status gl_device_create_as(pnb_context *context, enum gl_device_api api,
                               struct gl_device **out_device);

#endif
