/* examples/engine_gl.c: a program with a window of its own (GLFW, OpenGL 3.3 core) that draws a
 * scene with its own shaders and takes the shadow from penumbra: depth texture in, visibility
 * texture out, in this program's own context.
 *
 *   example-engine_gl [--method NAME] [--light rectangle|disk] [--size WxH]
 *                     [--frames N] [--screenshot FILE.png] [--check]
 *
 * Each frame: (1) depth of the scene into a texture, (2) pnb_gl_solver_visibility(), (3) the scene
 * again, shaded and multiplied by the visibility. --frames ends after N frames, --screenshot writes
 * the last one, --check compares its visibility with the CPU door of the same method and fails if
 * the two differ. The light circles above the occluders unless --check holds it still.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <penumbra/opengl.h>
#include <penumbra/penumbra.h>

struct options {
    const char *method, *light, *screenshot;
    int width, height, frames;
    bool check;
};

/* ---- What the engine has anyway: a mesh on the GPU, two programs, a depth texture ---- */

struct engine {
    GLuint depth, visibility, framebuffer;
    GLuint array, buffer, depth_program, shade_program;
    GLsizei vertex_count;
    int width, height;
    float clip_from_world[16];
};

static const char depth_vertex[] = "#version 330 core\n"
                                   "layout(location = 0) in vec3 position;\n"
                                   "uniform mat4 clip_from_world;\n"
                                   "void main() { gl_Position = clip_from_world * "
                                   "vec4(position, 1.0); }\n";
static const char depth_fragment[] = "#version 330 core\nvoid main() {}\n";
static const char shade_vertex[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 normal;\n"
    "layout(location = 2) in vec3 color;\n"
    "uniform mat4 clip_from_world;\n"
    "out vec3 at, n, albedo;\n"
    "void main() { at = position; n = normal; albedo = color;\n"
    "              gl_Position = clip_from_world * vec4(position, 1.0); }\n";
static const char shade_fragment[] =
    "#version 330 core\n"
    "in vec3 at, n, albedo;\n"
    "uniform vec3 light;\n"
    "uniform sampler2D visibility;\n"
    "out vec4 color;\n"
    "void main() {\n"
    "    vec3 to = light - at;\n"
    "    float v = texelFetch(visibility, ivec2(gl_FragCoord.xy), 0).r;\n"
    "    float lit = max(dot(normalize(n), normalize(to)), 0.0) * 16.0 / dot(to, to);\n"
    "    color = vec4(pow(albedo * (0.12 + v * lit), vec3(1.0 / 2.2)), 1.0);\n"
    "}\n";

static GLuint link_program(const char *vertex, const char *fragment)
{
    const char *const sources[2] = {vertex, fragment};
    GLuint program = glCreateProgram();
    for (int i = 0; i < 2; i++) {
        GLuint shader = glCreateShader(i == 0 ? GL_VERTEX_SHADER : GL_FRAGMENT_SHADER);
        glShaderSource(shader, 1, &sources[i], NULL);
        glCompileShader(shader);
        glAttachShader(program, shader);
        glDeleteShader(shader);
    }
    glLinkProgram(program);
    GLint linked = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (!linked) {
        char log[512];
        glGetProgramInfoLog(program, sizeof(log), NULL, log);
        fprintf(stderr, "engine_gl: %s\n", log);
        exit(1);
    }
    return program;
}

/* Triangles one by one: position, flat normal, colour. */
static void upload_scene(const pnb_scene *scene, struct engine *engine)
{
    float *vertices = malloc(pnb_scene_triangle_count(scene) * 27 * sizeof(float)), *to = vertices;
    for (size_t i = 0; i < pnb_scene_object_count(scene); i++) {
        pnb_object object;
        pnb_mesh_desc mesh;
        pnb_scene_object(scene, i, &object);
        pnb_scene_mesh(scene, object.mesh, &mesh);
        const double *m = object.world_from_mesh;
        for (size_t t = 0; t < mesh.triangle_count; t++) {
            double p[3][3], e[2][3];
            for (int k = 0; k < 3; k++) {
                const float *q = mesh.positions + 3 * (size_t)mesh.indices[3 * t + (size_t)k];
                for (int c = 0; c < 3; c++)
                    p[k][c] =
                        m[4 * c] * q[0] + m[4 * c + 1] * q[1] + m[4 * c + 2] * q[2] + m[4 * c + 3];
            }
            for (int c = 0; c < 3; c++) {
                e[0][c] = p[1][c] - p[0][c];
                e[1][c] = p[2][c] - p[0][c];
            }
            for (int k = 0; k < 3; k++) {
                for (int c = 0; c < 3; c++) {
                    int a = (c + 1) % 3, b = (c + 2) % 3;
                    to[c] = (float)p[k][c];
                    to[3 + c] = (float)(e[0][a] * e[1][b] - e[0][b] * e[1][a]);
                    to[6 + c] = (float)object.color[c];
                }
                to += 9;
            }
        }
    }
    engine->vertex_count = (GLsizei)((to - vertices) / 9);
    glGenVertexArrays(1, &engine->array);
    glBindVertexArray(engine->array);
    glGenBuffers(1, &engine->buffer);
    glBindBuffer(GL_ARRAY_BUFFER, engine->buffer);
    glBufferData(GL_ARRAY_BUFFER, (to - vertices) * (GLsizeiptr)sizeof(float), vertices,
                 GL_STATIC_DRAW);
    for (GLuint i = 0; i < 3; i++) {
        glEnableVertexAttribArray(i);
        glVertexAttribPointer(i, 3, GL_FLOAT, GL_FALSE, 36, (const char *)NULL + 12 * i);
    }
    free(vertices);
}

static void normalize(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int c = 0; c < 3; c++)
        v[c] /= length;
}

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

/* gluLookAt and gluPerspective, near 0.5 m, far 200 m. */
static void look(const pnb_camera *camera, struct engine *engine)
{
    const double near = 0.5, far = 200,
                 slope = tan(camera->vertical_fov_degrees * 3.14159265358979 / 360);
    double f[3], r[3], u[3];
    for (int c = 0; c < 3; c++)
        f[c] = camera->target[c] - camera->eye[c];
    normalize(f);
    cross(f, camera->up, r);
    normalize(r);
    cross(r, f, u);
    const double scale[3] = {1 / (slope * engine->width / engine->height), 1 / slope,
                             (far + near) / (far - near)};
    const double *axes[3] = {r, u, f};
    float *m = engine->clip_from_world;
    for (int row = 0; row < 4; row++) {
        const double *axis = axes[row < 3 ? row : 2];
        double factor = row < 3 ? scale[row] : 1, moved = 0;
        for (int c = 0; c < 3; c++) {
            m[4 * c + row] = (float)(factor * axis[c]);
            moved -= factor * axis[c] * camera->eye[c];
        }
        m[12 + row] = (float)(row == 2 ? moved - 2 * far * near / (far - near) : moved);
    }
}

static void create_engine(const pnb_scene *scene, int width, int height, struct engine *engine)
{
    engine->width = width;
    engine->height = height;
    engine->depth_program = link_program(depth_vertex, depth_fragment);
    engine->shade_program = link_program(shade_vertex, shade_fragment);
    upload_scene(scene, engine);
    GLuint textures[2];
    glGenTextures(2, textures);
    engine->depth = textures[0];
    engine->visibility = textures[1];
    glBindTexture(GL_TEXTURE_2D, engine->depth);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, width, height, 0, GL_DEPTH_COMPONENT,
                 GL_UNSIGNED_INT, NULL);
    glBindTexture(GL_TEXTURE_2D, engine->visibility);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_R16F, width, height, 0, GL_RED, GL_FLOAT, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glGenFramebuffers(1, &engine->framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, engine->framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, engine->depth, 0);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

static void draw_scene(const struct engine *engine, GLuint program)
{
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "clip_from_world"), 1, GL_FALSE,
                       engine->clip_from_world);
    glViewport(0, 0, engine->width, engine->height);
    glEnable(GL_DEPTH_TEST);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glBindVertexArray(engine->array);
    glDrawArrays(GL_TRIANGLES, 0, engine->vertex_count);
}

/* ---- One frame ---- */

static pnb_status draw_frame(const struct engine *engine, pnb_solver *solver,
                             const pnb_light *light)
{
    glBindFramebuffer(GL_FRAMEBUFFER, engine->framebuffer);
    draw_scene(engine, engine->depth_program);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);

    pnb_gl_view view = {.depth_texture = engine->depth};
    memcpy(view.clip_from_world, engine->clip_from_world, sizeof(view.clip_from_world));
    pnb_status status = pnb_gl_solver_visibility(solver, light, &view, engine->visibility);
    if (status != PNB_OK)
        return status;

    glUseProgram(engine->shade_program);
    const double *at =
        light->type == PNB_LIGHT_DISK ? light->shape.disk.center : light->shape.rectangle.center;
    glUniform3f(glGetUniformLocation(engine->shade_program, "light"), (float)at[0], (float)at[1],
                (float)at[2]);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, engine->visibility);
    glClearColor(0.8f, 0.85f, 0.9f, 1);
    draw_scene(engine, engine->shade_program);
    return PNB_OK;
}

/* ---- The scene, the light, the command line ---- */

static const char scene_text[] =
    "{\"camera\": {\"eye\": [1.5, 4, 7], \"target\": [0, 0.6, 0], \"vertical_fov_degrees\": 45},"
    "\"objects\": [{\"name\": \"ground\", \"plane\": {\"half_size\": 9}, \"color\": [0.8, 0.8, "
    "0.8]},"
    "{\"name\": \"shelf\", \"plane\": {\"point\": [1.2, 1.4, 0], \"normal\": [0.2, 1, 0.1], "
    "\"half_size\": 0.6}, \"color\": [0.3, 0.5, 0.8]}]}";

/* A box: 8 corners, 12 triangles, counter-clockwise from outside. */
static pnb_status add_box(pnb_scene *scene, const double low[3], const double high[3])
{
    static const uint32_t faces[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                       2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    float corners[24];
    for (int i = 0; i < 8; i++)
        for (int c = 0; c < 3; c++)
            corners[3 * i + c] = (float)(i >> c & 1 ? high[c] : low[c]);
    pnb_mesh_desc mesh = {"box", corners, NULL, 8, faces, 12};
    pnb_object object = {.name = "box", .color = {0.8, 0.5, 0.3}, .casts = true, .receives = true};
    pnb_status status = pnb_scene_add_mesh(scene, &mesh, &object.mesh);
    return status == PNB_OK ? pnb_scene_add_object(scene, &object, NULL) : status;
}

static void place_light(const char *kind, double angle, pnb_light *light)
{
    double x = 1.5 * cos(angle), z = 1.5 * sin(angle);
    memset(light, 0, sizeof(*light));
    for (int c = 0; c < 3; c++)
        light->color[c] = 1;
    if (strcmp(kind, "disk") == 0) {
        light->type = PNB_LIGHT_DISK;
        light->shape.disk.center[0] = x;
        light->shape.disk.center[1] = 4;
        light->shape.disk.center[2] = z;
        light->shape.disk.normal[1] = -1;
        light->shape.disk.radius = 0.5;
        return;
    }
    light->type = PNB_LIGHT_RECTANGLE;
    light->shape.rectangle.center[0] = x;
    light->shape.rectangle.center[1] = 4;
    light->shape.rectangle.center[2] = z;
    light->shape.rectangle.half_u[0] = 0.5;
    light->shape.rectangle.half_v[2] = 0.5;
}

/* Rows from OpenGL start at the bottom, those of pictures at the top. */
static void turn_rows(float *rows, int width, int height, int channels)
{
    size_t row = (size_t)width * (size_t)channels;
    for (int y = 0; y < height / 2; y++)
        for (size_t i = 0; i < row; i++) {
            float *a = &rows[(size_t)y * row + i], *b = &rows[(size_t)(height - 1 - y) * row + i];
            float swap = *a;
            *a = *b;
            *b = swap;
        }
}

static pnb_status write_screenshot(pnb_context *context, const struct engine *engine,
                                   const char *path)
{
    size_t count = (size_t)engine->width * (size_t)engine->height * 3;
    float *rgb = malloc(count * sizeof(*rgb));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, engine->width, engine->height, GL_RGB, GL_FLOAT, rgb);
    turn_rows(rgb, engine->width, engine->height, 3);
    for (size_t i = 0; i < count; i++) /* the picture is sRGB already; the file wants linear */
        rgb[i] = powf(rgb[i], 2.2f);
    pnb_status status =
        pnb_image_write(context, path, &(pnb_image){engine->width, engine->height, 3, rgb});
    free(rgb);
    return status;
}

/* The same method through the door of the CPU: rays find the points, arrays go in and out. */
static bool check(pnb_context *context, pnb_scene *scene, const struct engine *engine,
                  const pnb_solver_desc *desc, const pnb_light *light)
{
    size_t count = (size_t)engine->width * (size_t)engine->height, wrong = 0;
    float *ours = malloc(count * sizeof(*ours)), *theirs = malloc(count * sizeof(*theirs));
    glBindTexture(GL_TEXTURE_2D, engine->visibility);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTexImage(GL_TEXTURE_2D, 0, GL_RED, GL_FLOAT, ours);
    turn_rows(ours, engine->width, engine->height, 1);

    pnb_surface *surface = NULL;
    pnb_solver *solver = NULL;
    pnb_receivers receivers;
    pnb_status status =
        pnb_surface_create(context, scene, NULL, engine->width, engine->height, &surface);
    if (status == PNB_OK)
        status = pnb_solver_create(context, scene, desc, &solver);
    if (status == PNB_OK) {
        pnb_surface_receivers(surface, &receivers);
        status = pnb_solver_visibility(solver, light, &receivers, theirs);
    }
    double sum = 0;
    for (size_t i = 0; i < count && status == PNB_OK; i++) {
        double difference = ours[i] - (isnan(theirs[i]) ? 1 : theirs[i]);
        sum += difference * difference;
        wrong += fabs(difference) > 0.25;
    }
    double rmse = sqrt(sum / (double)count);
    if (status == PNB_OK)
        printf("%s: RMSE between the doors %.4f, %.2f %% of the pixels differ by more than 0.25\n",
               desc->method, rmse, 100 * (double)wrong / (double)count);
    pnb_solver_destroy(solver);
    pnb_surface_destroy(surface);
    free(ours);
    free(theirs);
    return status == PNB_OK && rmse < 0.05;
}

static bool parse(int argc, char **argv, struct options *options)
{
    *options = (struct options){"hard-volume", "rectangle", NULL, 640, 480, 0, false};
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        if (strcmp(argv[i], "--check") == 0) {
            options->check = true;
            continue;
        }
        i++;
        if (strcmp(argv[i - 1], "--method") == 0)
            options->method = value;
        else if (strcmp(argv[i - 1], "--light") == 0)
            options->light = value;
        else if (strcmp(argv[i - 1], "--screenshot") == 0)
            options->screenshot = value;
        else if (strcmp(argv[i - 1], "--frames") == 0)
            options->frames = atoi(value);
        else if (strcmp(argv[i - 1], "--size") != 0 ||
                 sscanf(value, "%dx%d", &options->width, &options->height) != 2)
            return false;
    }
    return options->width > 0 && options->height > 0;
}

static GLFWwindow *open_window(const struct options *options)
{
    if (!glfwInit())
        return NULL;
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_RESIZABLE, GLFW_FALSE);
    GLFWwindow *window =
        glfwCreateWindow(options->width, options->height, "penumbra in an engine", NULL, NULL);
    if (window)
        glfwMakeContextCurrent(window);
    return window;
}

int main(int argc, char **argv)
{
    struct options options;
    if (!parse(argc, argv, &options)) {
        fprintf(stderr, "usage: engine_gl [--method NAME] [--light rectangle|disk] [--size WxH] "
                        "[--frames N] [--screenshot FILE.png] [--check]\n");
        return 2;
    }
    GLFWwindow *window = open_window(&options);
    if (!window) {
        fprintf(stderr, "engine_gl: no window with OpenGL 3.3 here\n");
        return 77;
    }
    const pnb_method_info *method = pnb_method_find(options.method);
    pnb_solver_param path = {"path", "opengl"}; /* for check(); methods that have both */
    pnb_solver_desc desc = {.method = options.method,
                            .params = &path,
                            .param_count = method && method->opengl_path ? 1 : 0};
    struct engine engine = {0};
    pnb_context *context = NULL;
    pnb_scene *scene = NULL;
    pnb_solver *solver = NULL;
    pnb_camera camera;
    pnb_light light;
    pnb_status status = pnb_context_create(NULL, &context);
    if (status == PNB_OK)
        status = pnb_scene_parse(context, scene_text, strlen(scene_text), NULL, &scene);
    if (status == PNB_OK)
        status =
            add_box(scene, (const double[3]){-1.6, 0, -0.6}, (const double[3]){-0.8, 1.6, 0.2});
    if (status == PNB_OK)
        status = add_box(scene, (const double[3]){0.2, 0, 0.8}, (const double[3]){0.9, 0.5, 1.5});
    if (status == PNB_OK) /* this context is current: the solver moves in */
        status = pnb_gl_solver_create(context, scene, &desc, &solver);
    if (status == PNB_OK) {
        pnb_scene_camera(scene, &camera);
        glfwGetFramebufferSize(window, &options.width, &options.height);
        create_engine(scene, options.width, options.height, &engine);
        look(&camera, &engine);
    }
    for (int frame = 0; status == PNB_OK && !glfwWindowShouldClose(window) &&
                        (options.frames == 0 || frame < options.frames);
         frame++) {
        place_light(options.light, options.check ? 0.4 : 0.4 + glfwGetTime(), &light);
        status = draw_frame(&engine, solver, &light);
        if (frame + 1 != options.frames)
            glfwSwapBuffers(window);
        glfwPollEvents();
    }
    if (status == PNB_OK && options.screenshot)
        status = write_screenshot(context, &engine, options.screenshot);
    bool good = status == PNB_OK;
    if (good && options.check)
        good = check(context, scene, &engine, &desc, &light);
    const char *said = context ? pnb_context_error(context) : "";
    if (!good)
        fprintf(stderr, "engine_gl: %s\n", *said ? said : "the doors differ");
    pnb_solver_destroy(solver);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
    glfwTerminate();
    return good ? 0 : 1;
}
