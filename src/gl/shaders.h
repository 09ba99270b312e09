/* gl/shaders.h: the shader files of src/, embedded by the build (embed.c). */
#ifndef GL_SHADERS_H
#define GL_SHADERS_H

#include <stddef.h>

struct gl_shader_file {
    const char *name, *text;
};
extern const struct gl_shader_file gl_shader_files[]; /* ends with a NULL name */
extern const size_t gl_shader_file_count;

#endif
