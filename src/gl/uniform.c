/* gl/uniform.c: uniforms as values, to be listed in a draw. */
#include <string.h>

#include "gl/gl.h"

struct gl_uniform gl_int(const char *name, int value)
{
    return (struct gl_uniform){name, GL_UNIFORM_INT, .count = 1, .integer = {value}};
}

struct gl_uniform gl_float(const char *name, double value)
{
    return (struct gl_uniform){name, GL_UNIFORM_FLOAT, .count = 1, .value = {(float)value}};
}

struct gl_uniform gl_vec2(const char *name, double x, double y)
{
    return (struct gl_uniform){name, GL_UNIFORM_VEC2, .count = 1, .value = {(float)x, (float)y}};
}

struct gl_uniform gl_vec3(const char *name, const double *v)
{
    return (struct gl_uniform){name, GL_UNIFORM_VEC3, .count = 1,
                               .value = {(float)v[0], (float)v[1], (float)v[2]}};
}

struct gl_uniform gl_vec4(const char *name, double x, double y, double z, double w)
{
    return (struct gl_uniform){name, GL_UNIFORM_VEC4, .count = 1,
                               .value = {(float)x, (float)y, (float)z, (float)w}};
}

struct gl_uniform gl_mat4(const char *name, const double column_major[16])
{
    struct gl_uniform uniform = {name, GL_UNIFORM_MAT4, .count = 1};
    for (int i = 0; i < 16; i++)
        uniform.value[i] = (float)column_major[i];
    return uniform;
}

struct gl_uniform gl_floats(const char *name, enum gl_uniform_type type, const float *data,
                            int count)
{
    return (struct gl_uniform){name, type, .count = count, .data = data};
}

struct gl_uniform gl_sampler(const char *name, struct gl_texture *texture)
{
    return (struct gl_uniform){name, GL_UNIFORM_TEXTURE, .count = 1, .texture = texture};
}
