/* gl/program.c: programs from the shader files that the build embedded.
 *
 * A line  #include "NAME"  is replaced by that file, once per shader: a second time is skipped. The
 * pieces carry #line with a number for each file, so that the compiler's log, which knows numbers
 * only, can be told again by file and line.
 */
#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "gl/inside.h"

#define FILES_MAX 16
#define DEPTH_MAX 8

struct text {
    pnb_context *context;
    char *bytes;
    size_t used, capacity;
    const char *files[FILES_MAX]; /* by number */
    int file_count;
    pnb_status status;
};

static void append(struct text *text, const char *bytes, size_t count)
{
    if (text->status != PNB_OK)
        return;
    if (!memory_reserve(text->context, (void **)&text->bytes, &text->capacity, text->used,
                        count + 1, 1)) {
        text->status = status_no_memory(text->context, text->used + count);
        return;
    }
    memcpy(text->bytes + text->used, bytes, count);
    text->used += count;
    text->bytes[text->used] = 0;
}

static void append_line_number(struct text *text, int line, int file)
{
    char number[48];
    append(text, number, (size_t)snprintf(number, sizeof(number), "#line %d %d\n", line, file));
}

static const char *find_file(const char *name, size_t length)
{
    for (size_t i = 0; i < gl_shader_file_count; i++)
        if (strlen(gl_shader_files[i].name) == length &&
            memcmp(gl_shader_files[i].name, name, length) == 0)
            return gl_shader_files[i].name;
    return NULL;
}

static const char *file_text(const char *name)
{
    for (size_t i = 0; i < gl_shader_file_count; i++)
        if (gl_shader_files[i].name == name)
            return gl_shader_files[i].text;
    return "";
}

/* "#include "NAME"": the name, or NULL for other lines. */
static const char *included(const char *line, const char *end, size_t *out_length)
{
    static const char word[] = "#include";
    while (line < end && (*line == ' ' || *line == '\t'))
        line++;
    if ((size_t)(end - line) < sizeof(word) - 1 || memcmp(line, word, sizeof(word) - 1) != 0)
        return NULL;
    const char *open = memchr(line, '"', (size_t)(end - line));
    const char *close = open ? memchr(open + 1, '"', (size_t)(end - open - 1)) : NULL;
    *out_length = close ? (size_t)(close - open - 1) : 0;
    return open ? open + 1 : line;
}

static void append_file(struct text *text, const char *name, const char *from, int depth)
{
    const char *known = find_file(name, strlen(name));
    if (!known || depth == DEPTH_MAX || text->file_count == FILES_MAX) {
        if (text->status == PNB_OK)
            text->status = status_fail(text->context, PNB_ERROR_DEVICE, from,
                                       known ? "includes too many files at '%s'"
                                             : "no shader file '%s' was built in",
                                       name);
        return;
    }
    int number = text->file_count++;
    text->files[number] = known;
    append_line_number(text, 1, number);
    int line_number = 1;
    for (const char *line = file_text(known); *line; line_number++) {
        const char *end = strchr(line, '\n');
        const char *next = end ? end + 1 : line + strlen(line);
        size_t length;
        const char *other = included(line, end ? end : next, &length);
        if (other) {
            char file[128];
            snprintf(file, sizeof(file), "%.*s", (int)length, other);
            bool seen = false;
            for (int i = 0; i < text->file_count; i++)
                seen = seen || strcmp(text->files[i], file) == 0;
            if (!seen)
                append_file(text, file, known, depth + 1);
            append_line_number(text, line_number + 1, number);
        } else {
            append(text, line, (size_t)(next - line));
            if (!end)
                append(text, "\n", 1);
        }
        line = next;
    }
}

static const char header_desktop[] = "#version 330 core\n";
static const char header_es[] =
    "#version 320 es\n"
    "#define PNB_ES 1\n"
    "precision highp float;\nprecision highp int;\n"
    "precision highp sampler2D;\nprecision highp sampler2DArray;\nprecision highp samplerCube;\n"
    "precision highp sampler2DShadow;\nprecision highp sampler2DArrayShadow;\n"
    "precision highp samplerCubeShadow;\nprecision highp usampler2D;\n";

/* The log's first error, by file and line. Mesa: "0:12(3): error: ...", others: "0(12) : error
 * ...", "ERROR: 0:12: ...". */
static void explain(const struct text *text, const char *log, char *out, size_t size)
{
    const char *line = log, *found = log;
    while (*line) {
        size_t length = strcspn(line, "\n");
        for (size_t i = 0; i + 5 <= length; i++)
            if (strncasecmp(line + i, "error", 5) == 0) {
                found = line;
                line = "";
                break;
            }
        if (*line)
            line += length + (line[length] == '\n');
    }
    int file = -1, number = 0, column, used = 0;
    if (sscanf(found, "%d:%d(%d):%n", &file, &number, &column, &used) < 3 || used == 0) {
        used = 0;
        if (sscanf(found, "ERROR: %d:%d:%n", &file, &number, &used) < 2 || used == 0) {
            used = 0;
            if (sscanf(found, "%d(%d) :%n", &file, &number, &used) < 2 || used == 0)
                file = -1, used = 0;
        }
    }
    const char *message = found + used;
    while (isspace((unsigned char)*message))
        message++;
    size_t length = strcspn(message, "\n");
    if (file >= 0 && file < text->file_count)
        snprintf(out, size, "%s:%d: %.*s", text->files[file], number, (int)length, message);
    else
        snprintf(out, size, "%s: %.*s", text->files[0], (int)length, message);
}

static pnb_status compile(struct gl_device *device, GLenum stage, const char *name,
                          const char *defines, GLuint *out_shader)
{
    struct text text = {.context = device->context};
    if (device->info.es)
        append(&text, header_es, sizeof(header_es) - 1);
    else
        append(&text, header_desktop, sizeof(header_desktop) - 1);
    if (defines)
        append(&text, defines, strlen(defines));
    append_file(&text, name, name, 0);
    *out_shader = 0;
    if (text.status != PNB_OK) {
        memory_free(device->context, text.bytes);
        return text.status;
    }
    GLuint shader = glCreateShader(stage);
    const GLchar *source = text.bytes;
    glShaderSource(shader, 1, &source, NULL);
    glCompileShader(shader);
    memory_free(device->context, text.bytes);
    GLint compiled = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled) {
        *out_shader = shader;
        return PNB_OK;
    }
    char log[4096] = "", what[512];
    glGetShaderInfoLog(shader, sizeof(log), NULL, log);
    glDeleteShader(shader);
    explain(&text, log, what, sizeof(what));
    return status_fail(device->context, PNB_ERROR_DEVICE, "shader", "%s", what);
}

static pnb_status link_program(struct gl_device *device, const struct gl_program_desc *desc,
                               GLuint program)
{
    for (int i = 0; i < desc->attribute_count; i++)
        glBindAttribLocation(program, (GLuint)i, desc->attributes[i]);
    if (desc->capture_count > 0)
        glTransformFeedbackVaryings(program, desc->capture_count, desc->captures,
                                    GL_INTERLEAVED_ATTRIBS);
    glLinkProgram(program);
    GLint linked = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked)
        return PNB_OK;
    char log[1024] = "";
    glGetProgramInfoLog(program, sizeof(log), NULL, log);
    return status_fail(device->context, PNB_ERROR_DEVICE, "shader", "%s with %s: %s", desc->vertex,
                       desc->fragment ? desc->fragment : "no fragment shader", log);
}

/* OpenGL ES links no program without a fragment shader. */
static const char *fragment_name(const struct gl_device *device, const char *name)
{
    return name || !device->info.es ? name : "gl/nothing.frag";
}

pnb_status gl_program_create(struct gl_device *device, const struct gl_program_desc *desc,
                             struct gl_program **out_program)
{
    *out_program = NULL;
    struct gl_program *program = memory_calloc(device->context, 1, sizeof(*program));
    if (!program)
        return status_no_memory(device->context, sizeof(*program));
    program->device = device;
    program->name = glCreateProgram();
    const struct {
        GLenum stage;
        const char *name;
    } stages[] = {{GL_VERTEX_SHADER, desc->vertex},
                  {GL_GEOMETRY_SHADER, desc->geometry},
                  {GL_FRAGMENT_SHADER, fragment_name(device, desc->fragment)}};
    pnb_status status = PNB_OK;
    for (size_t i = 0; i < sizeof(stages) / sizeof(*stages) && status == PNB_OK; i++) {
        GLuint shader;
        if (!stages[i].name)
            continue;
        status = compile(device, stages[i].stage, stages[i].name, desc->defines, &shader);
        if (status == PNB_OK) {
            glAttachShader(program->name, shader);
            glDeleteShader(shader); /* lives as long as the program */
        }
    }
    if (status == PNB_OK)
        status = link_program(device, desc, program->name);
    if (status == PNB_OK)
        status = gl_check(device, desc->vertex);
    if (status != PNB_OK) {
        gl_program_destroy(program);
        return status;
    }
    *out_program = program;
    return PNB_OK;
}

void gl_program_destroy(struct gl_program *program)
{
    if (!program)
        return;
    if (program->device->begun > 0)
        glDeleteProgram(program->name);
    memory_free(program->device->context, program);
}

GLint gl_program_location(struct gl_program *program, const char *name)
{
    for (int i = 0; i < program->location_count; i++)
        if (strcmp(program->locations[i].text, name) == 0)
            return program->locations[i].at;
    GLint at = glGetUniformLocation(program->name, name);
    if (program->location_count < GL_LOCATIONS &&
        strlen(name) < sizeof(program->locations[0].text)) {
        strcpy(program->locations[program->location_count].text, name);
        program->locations[program->location_count++].at = at;
    }
    return at;
}
