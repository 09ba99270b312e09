/* gl/inside.h: what the files of this folder share. Includes OpenGL: for no other folder. */
#ifndef GL_INSIDE_H
#define GL_INSIDE_H

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include "gl/gl.h"
#include "gl/shaders.h"

#define GL_UNITS      16 /* texture units that draws may use: what OpenGL 3.3 promises */
#define GL_LOCATIONS  64 /* uniforms of a program */
#define GL_ERROR_SIZE 256

struct gl_state; /* state.c */

/* A context of whatever window system, current in a thread. */
struct gl_current {
    EGLenum api;
    EGLDisplay display;
    EGLSurface draw, read;
    EGLContext context;
    /* GLX, looked up where the process has it loaded. */
    void *glx_display, *glx_context;
    unsigned long glx_draw, glx_read;
};

struct gl_device {
    pnb_context *context;
    struct gl_device_info info;
    bool adopted;
    int begun; /* nested begins */
    bool lost; /* the context: nothing is drawn any more */
    /* glGetError(), and whether the context was lost: NULL where OpenGL cannot be asked. Tests put
     * faults here. */
    GLenum (*ask_error)(void);
    GLenum (*ask_reset)(void);
    /* Headless. */
    EGLDisplay display;
    EGLContext egl;
    EGLSurface surface;
    struct gl_current earlier;
    /* Adopted: the context that must be current, and what draws touch in it. */
    struct gl_current owner;
    struct gl_state *state;
    GLuint vertex_array;
    GLuint framebuffer;    /* scratch: reading, and the 1x1 target of draws that discard */
    GLuint discard_buffer; /* renderbuffer of the latter */
    GLuint discard_target;
    GLuint sampler;  /* nearest, no comparison: for textures of the caller */
    GLuint feedback; /* transform feedback object, where there are such */
    GLuint query;
    char error[GL_ERROR_SIZE]; /* the first one that OpenGL described since begin */
};

struct gl_format_info {
    GLenum internal, format, type;
    int texel_bytes; /* on the device */
    int components;  /* of an array handed in or out */
    int component_bytes;
    bool depth, stencil, integer;
};
const struct gl_format_info *gl_format_info(enum gl_format format);

struct gl_texture {
    struct gl_device *device;
    GLuint name;
    GLenum target;
    enum gl_format format;
    enum gl_texture_kind kind;
    int width, height, layers;
    bool adopted;
};

struct gl_target {
    struct gl_device *device;
    GLuint name;
    int width, height, color_count;
    struct gl_target_desc desc;
};

struct gl_buffer {
    struct gl_device *device;
    GLuint name;
    size_t size, capacity;
    GLenum usage;
};

struct gl_program {
    struct gl_device *device;
    GLuint name;
    struct {
        char text[48];
        GLint at;
    } locations[GL_LOCATIONS];
    int location_count;
};

/* current.c: which context is current in this thread, whatever made it. */
void gl_current_get(struct gl_current *out_current);
bool gl_current_any(const struct gl_current *current);
bool gl_current_same(const struct gl_current *a, const struct gl_current *b);
/* Makes room for an EGL context: a current GLX context is let go. */
void gl_current_release(const struct gl_current *current);
void gl_current_restore(const struct gl_current *current, EGLDisplay ours);

/* state.c: notes the state of the caller's context that draws touch, sets what draws rely on, and
 * gives it back. */
pnb_status gl_state_save(struct gl_device *device);
void gl_state_restore(struct gl_device *device);
void gl_state_destroy(struct gl_device *device);
/* Before unit k is used first since begin. */
void gl_state_save_unit(struct gl_device *device, int unit);
/* What draws rely on and never change. */
void gl_state_baseline(const struct gl_device *device);

void gl_texture_bind(struct gl_texture *texture, int unit);
/* Attaches to the bound framebuffer. */
void gl_texture_attach(GLenum target, GLenum point, const struct gl_attachment *attachment);
GLint gl_program_location(struct gl_program *program, const char *name);
/* Whether something went wrong since the last look: fails with what and OpenGL's word for it. */
pnb_status gl_check(struct gl_device *device, const char *what);
const char *gl_error_name(GLenum error);

#endif
