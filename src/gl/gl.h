/* gl/gl.h: OpenGL as this library needs it: a device, its resources, and one function that draws.
 * The only folder that calls gl* or egl*.
 *
 * No state leaks from one draw to the next: struct gl_draw says everything, zero means off. So a
 * reader sees at the draw what happens, and a caller's context can be given back as it was.
 *
 *   gl_device_create (headless) or gl_device_adopt (the caller's current context)
 *   gl_device_begin  ->  upload, clear, draw, read  ->  gl_device_end
 *
 * Resources belong to a device, are used between begin and end only, and are destroyed there too
 * (destroy(NULL) is fine; outside, memory is freed and what OpenGL holds stays until the context
 * goes). Errors of the API are gathered by gl_device_end() and by everything that
 * reads back; draws themselves do not wait.
 */
#ifndef GL_GL_H
#define GL_GL_H

#include "base/base.h"

struct gl_device;
struct gl_buffer;
struct gl_texture;
struct gl_program;
struct gl_target;

/* ---- Device ---- */

struct gl_device_info {
    char renderer[192]; /* "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5" */
    bool software;      /* rasterised by the CPU: timer queries mean nothing there */
    bool es;            /* OpenGL ES */
    int version;        /* 33, 45, or 30, 32 of ES */
    int max_texture_size;
    bool depth_bounds; /* EXT_depth_bounds_test */
    bool depth_clamp;
    bool geometry_shaders;
};

/* A headless context: device platform of EGL, then surfaceless, then a pbuffer of the default
 * display; a GPU before a software rasteriser. OpenGL 4.5 core where present, at least 3.3 core.
 * PNB_ERROR_DEVICE with the reasons of all attempts. Built without OpenGL: "built without OpenGL".
 */
pnb_status gl_device_create(pnb_context *context, struct gl_device **out_device);
/* The context that is current in this thread; the caller's, who keeps it current. */
pnb_status gl_device_adopt(pnb_context *context, struct gl_device **out_device);
void gl_device_destroy(struct gl_device *device);
const struct gl_device_info *gl_device_get_info(const struct gl_device *device);
pnb_context *gl_device_context(const struct gl_device *device);

/* Makes the context current (headless), or notes the state that draws touch (adopted). Nests. */
pnb_status gl_device_begin(struct gl_device *device);
/* Gives the state or the earlier context back. Fails with what OpenGL found wrong since begin:
 * out of memory, lost context, an error of ours. */
pnb_status gl_device_end(struct gl_device *device);
/* Waits until all is drawn: take the clock after it. */
void gl_device_finish(struct gl_device *device);

/* ---- Textures and targets ---- */

enum gl_format {
    GL_FORMAT_R8 = 0,
    GL_FORMAT_RGBA8,
    GL_FORMAT_R16F,
    GL_FORMAT_RGBA16F,
    GL_FORMAT_R32F,
    GL_FORMAT_RG32F,
    GL_FORMAT_RGBA32F,
    GL_FORMAT_R32UI,
    GL_FORMAT_RGBA32UI,
    GL_FORMAT_DEPTH24_STENCIL8,
    GL_FORMAT_DEPTH32F_STENCIL8,
    GL_FORMAT_DEPTH32F
};

enum gl_texture_kind { GL_TEXTURE_PLANE = 0, GL_TEXTURE_LAYERS, GL_TEXTURE_FACES };

struct gl_texture_desc {
    enum gl_texture_kind kind;
    enum gl_format format;
    int width, height;
    int layers;         /* of GL_TEXTURE_LAYERS */
    bool linear;        /* filter; else nearest */
    bool compare;       /* depth formats: a sampler2DShadow, less or equal */
    float border[4];    /* GL_TEXTURE_PLANE and LAYERS are clamped to this border if has_border, */
    bool has_border;    /* else to their edge */
    const void *texels; /* tightly packed rows, bottom row first; NULL: undefined. PLANE only */
};
pnb_status gl_texture_create(struct gl_device *device, const struct gl_texture_desc *desc,
                             struct gl_texture **out_texture);
void gl_texture_destroy(struct gl_texture *texture);
/* All texels of a layer (or face), rows as in texels above, the format's own components (floats
 * for 16F). */
void gl_texture_upload(struct gl_texture *texture, int layer, const void *texels);
pnb_status gl_texture_read(struct gl_texture *texture, int layer, void *texels);
int gl_texture_width(const struct gl_texture *texture);
int gl_texture_height(const struct gl_texture *texture);
size_t gl_texture_bytes(const struct gl_texture *texture); /* device memory */
/* Wraps a texture that the caller owns: only sampled from or drawn to, never deleted. */
pnb_status gl_texture_adopt(struct gl_device *device, unsigned name, enum gl_format format,
                            int width, int height, struct gl_texture **out_texture);
/* Whether the caller's texture is a plane with a size; depth: of a depth format. Else
 * PNB_ERROR_ARGUMENT about what. */
pnb_status gl_texture_look(struct gl_device *device, unsigned name, bool depth, const char *what,
                           int *out_width, int *out_height);

#define GL_COLORS_MAX 4
struct gl_attachment {
    struct gl_texture *texture; /* NULL: none */
    int layer;                  /* or face */
};
struct gl_target_desc {
    struct gl_attachment colors[GL_COLORS_MAX]; /* all of one size */
    struct gl_attachment depth;                 /* depth or depth and stencil */
};
/* Does not own the textures. */
pnb_status gl_target_create(struct gl_device *device, const struct gl_target_desc *desc,
                            struct gl_target **out_target);
void gl_target_destroy(struct gl_target *target);

struct gl_clear {
    bool color[GL_COLORS_MAX], depth, stencil; /* which */
    float color_value[GL_COLORS_MAX][4];
    float depth_value;
    int stencil_value;
};
void gl_target_clear(struct gl_target *target, const struct gl_clear *clear);
/* Copies the depth and stencil of one target to another of the same size and format. */
void gl_target_copy_depth(struct gl_target *from, struct gl_target *to);

/* ---- Buffers ---- */

/* data NULL: undefined. stream: written anew about every frame. */
pnb_status gl_buffer_create(struct gl_device *device, const void *data, size_t size, bool stream,
                            struct gl_buffer **out_buffer);
void gl_buffer_destroy(struct gl_buffer *buffer);
/* Replaces the contents; grows (old contents are lost) when size is larger than the buffer. */
pnb_status gl_buffer_write(struct gl_buffer *buffer, const void *data, size_t size);
pnb_status gl_buffer_read(struct gl_buffer *buffer, size_t offset, void *data, size_t size);
size_t gl_buffer_size(const struct gl_buffer *buffer);

/* ---- Programs ---- */

/* Shaders are files of src/, embedded by the build under their path there ("method/pcss/pcss.frag",
 * listed in the room's meson.build). A line  #include "gl/common.glsl"  is replaced by that file.
 * #version and precision are put in front, so the files carry none; they are written for GLSL 3.30
 * and ES 3.00 (PNB_ES is defined there). */
struct gl_program_desc {
    const char *vertex, *geometry,
        *fragment;                 /* names of files; geometry and fragment may be NULL */
    const char *defines;           /* lines "#define X 1\n", or NULL */
    const char *const *captures;   /* outputs of the last stage before rasterisation that are */
    int capture_count;             /* captured, interleaved; 0: none */
    const char *const *attributes; /* names of vertex inputs, in order of location */
    int attribute_count;
};
/* PNB_ERROR_DEVICE with the log's first error, its file and line. */
pnb_status gl_program_create(struct gl_device *device, const struct gl_program_desc *desc,
                             struct gl_program **out_program);
void gl_program_destroy(struct gl_program *program);

/* ---- Drawing ---- */

enum gl_primitive {
    GL_PRIMITIVE_TRIANGLES = 0,
    GL_PRIMITIVE_TRIANGLE_STRIP,
    GL_PRIMITIVE_LINES,
    GL_PRIMITIVE_LINE_STRIP,
    GL_PRIMITIVE_POINTS,
    GL_PRIMITIVE_LINES_ADJACENCY,
    GL_PRIMITIVE_TRIANGLES_ADJACENCY
};

enum gl_compare {
    GL_COMPARE_ALWAYS = 0,
    GL_COMPARE_NEVER,
    GL_COMPARE_LESS,
    GL_COMPARE_LESS_EQUAL,
    GL_COMPARE_EQUAL,
    GL_COMPARE_GREATER_EQUAL,
    GL_COMPARE_GREATER,
    GL_COMPARE_NOT_EQUAL
};

enum gl_stencil_action {
    GL_STENCIL_KEEP = 0,
    GL_STENCIL_ZERO,
    GL_STENCIL_REPLACE,
    GL_STENCIL_INCREMENT_WRAP,
    GL_STENCIL_DECREMENT_WRAP,
    GL_STENCIL_INCREMENT,
    GL_STENCIL_DECREMENT,
    GL_STENCIL_INVERT
};

enum gl_blend {
    GL_BLEND_OFF = 0,
    GL_BLEND_ADD,              /* source + target */
    GL_BLEND_REVERSE_SUBTRACT, /* target - source */
    GL_BLEND_MULTIPLY,         /* source x target */
    GL_BLEND_MIN,
    GL_BLEND_MAX,
    GL_BLEND_OVER /* source alpha */
};

enum gl_cull { GL_CULL_NONE = 0, GL_CULL_BACK, GL_CULL_FRONT }; /* counter-clockwise is front */

struct gl_attribute {
    struct gl_buffer *buffer;
    int components;        /* 1 to 4 floats; 0: attribute unused */
    bool integer;          /* unsigned 32-bit integers instead */
    size_t stride, offset; /* bytes; stride 0: tightly packed */
    unsigned divisor;      /* 0: per vertex; n: advances every n instances */
};

enum gl_uniform_type {
    GL_UNIFORM_NONE = 0,
    GL_UNIFORM_INT,
    GL_UNIFORM_FLOAT,
    GL_UNIFORM_VEC2,
    GL_UNIFORM_VEC3,
    GL_UNIFORM_VEC4,
    GL_UNIFORM_IVEC2,
    GL_UNIFORM_MAT4, /* 16 floats, column-major */
    GL_UNIFORM_TEXTURE
};

/* By name; one the program does not use is skipped. Made by the functions below. */
struct gl_uniform {
    const char *name;
    enum gl_uniform_type type;
    int count;        /* elements of an array */
    const void *data; /* NULL: value */
    float value[16];
    int integer[2];
    struct gl_texture *texture;
};
struct gl_uniform gl_int(const char *name, int value);
struct gl_uniform gl_float(const char *name, double value);
struct gl_uniform gl_vec2(const char *name, double x, double y);
struct gl_uniform gl_vec3(const char *name, const double *v); /* 3; &vec.x does */
struct gl_uniform gl_vec4(const char *name, double x, double y, double z, double w);
struct gl_uniform gl_mat4(const char *name, const double column_major[16]);
struct gl_uniform gl_floats(const char *name, enum gl_uniform_type type, const float *data,
                            int count); /* an array; data stays the caller's until the draw */
struct gl_uniform gl_sampler(const char *name, struct gl_texture *texture);

#define GL_ATTRIBUTES_MAX 8
#define GL_UNIFORMS_MAX   48

struct gl_stencil_face {
    enum gl_stencil_action fail, depth_fail, pass;
};

struct gl_draw {
    struct gl_program *program;
    struct gl_target *target; /* NULL only with capture and discard */
    int viewport[4];          /* x, y, width, height; width 0: all of the target */
    int scissor[4];           /* width 0: none */
    enum gl_primitive primitive;
    size_t first, count;       /* vertices, or indices where there are any */
    size_t instances;          /* 0: not instanced */
    struct gl_buffer *indices; /* 32-bit, or NULL */
    struct gl_attribute attributes[GL_ATTRIBUTES_MAX];
    struct gl_uniform uniforms[GL_UNIFORMS_MAX]; /* up to the first of type NONE */
    enum gl_cull cull;
    bool depth_test, depth_write, depth_clamp;
    enum gl_compare depth_compare;
    bool depth_bounds; /* only where the device has them */
    float depth_low, depth_high;
    float offset_factor, offset_units; /* polygon offset; both 0: none */
    bool stencil;
    enum gl_compare stencil_compare;
    int stencil_reference;
    unsigned stencil_read_mask, stencil_write_mask; /* 0 and 0: all bits */
    struct gl_stencil_face stencil_front, stencil_back;
    enum gl_blend blend; /* for color and alpha alike */
    bool color_off;      /* writes no color */
    bool channels[4];    /* all false: all four are written */
    /* Transform feedback into a buffer (of triangles, lines or points, as the last stage says). */
    struct gl_buffer *capture;
    enum gl_primitive capture_primitive;
    bool discard; /* no rasterisation */
};
void gl_draw(struct gl_device *device, const struct gl_draw *draw);
/* The same, and how many primitives were captured (waits). */
size_t gl_draw_captured(struct gl_device *device, const struct gl_draw *draw);
/* One triangle that covers the target; the vertex shader is "gl/cover.vert", which passes
 * vec2 at_px's [0,1]^2 equivalent as  uv. */
void gl_draw_cover(struct gl_device *device, const struct gl_draw *draw);

#endif
