/* gl/device.c: a headless context by EGL, or the caller's.
 *
 * Attempts, in this order, the first that works is taken:
 *
 *   every hardware device of EGL    EGL_EXT_platform_device, no window system at all
 *   surfaceless                     EGL_MESA_platform_surfaceless: Mesa's choice, GPU first
 *   the default display             X11 or Wayland, as EGL_PLATFORM says
 *   the software devices of EGL     Mesa's llvmpipe
 *
 * each as OpenGL 4.5 core, then 3.3 core, then OpenGL ES 3.2; each of these robust where EGL offers
 * that (it is told when the device was reset), else plain. The surface is none where the context
 * can do without, else a pbuffer of one pixel. Displays are EGL's, one per process and platform,
 * shared with whoever else opened them (GTK does): they are never terminated here.
 *
 * Mesa's llvmpipe draws with vectors of 256 bits by itself. LP_NATIVE_VECTOR_WIDTH=512 in the
 * environment makes Mesa 22.3 crash: that is the user's, and we leave the environment alone.
 */
#include <stdio.h>
#include <string.h>

#include "gl/device.h"
#include "gl/inside.h"

#define DEVICES_MAX 16

struct attempts {
    char text[768];
    size_t used;
};

static void note(struct attempts *attempts, const char *where, const char *why)
{
    if (attempts->used < sizeof(attempts->text))
        attempts->used += (size_t)snprintf(attempts->text + attempts->used,
                                           sizeof(attempts->text) - attempts->used, "%s%s: %s",
                                           attempts->used ? "; " : "", where, why);
}

static const char *egl_error(void)
{
    switch (eglGetError()) {
    case EGL_SUCCESS: return "refused";
    case EGL_NOT_INITIALIZED: return "not initialised";
    case EGL_BAD_ACCESS: return "bad access";
    case EGL_BAD_ALLOC: return "out of memory";
    case EGL_BAD_ATTRIBUTE: return "bad attribute";
    case EGL_BAD_CONFIG: return "bad configuration";
    case EGL_BAD_CONTEXT: return "bad context";
    case EGL_BAD_CURRENT_SURFACE: return "bad current surface";
    case EGL_BAD_DISPLAY: return "bad display";
    case EGL_BAD_MATCH: return "bad match";
    case EGL_BAD_NATIVE_PIXMAP: return "bad native pixmap";
    case EGL_BAD_NATIVE_WINDOW: return "bad native window";
    case EGL_BAD_PARAMETER: return "bad parameter";
    case EGL_BAD_SURFACE: return "bad surface";
    case EGL_CONTEXT_LOST: return "context lost";
    default: return "unknown error";
    }
}

const char *gl_error_name(GLenum error)
{
    switch (error) {
    case GL_INVALID_ENUM: return "invalid enumeration";
    case GL_INVALID_VALUE: return "invalid value";
    case GL_INVALID_OPERATION: return "invalid operation";
    case GL_INVALID_FRAMEBUFFER_OPERATION: return "invalid framebuffer operation";
    case GL_OUT_OF_MEMORY: return "out of device memory";
    case GL_CONTEXT_LOST: return "context lost";
    default: return "unknown error";
    }
}

/* ---- Errors, and contexts that are lost ---- */

static GLenum ask_error(void)
{
    return glGetError();
}

static GLenum ask_reset(void)
{
    return glGetGraphicsResetStatus();
}

static GLenum ask_reset_arb(void)
{
    return glGetGraphicsResetStatusARB();
}

static pnb_status say_lost(struct gl_device *device, const char *why)
{
    return status_fail(device->context, PNB_ERROR_DEVICE, device->info.renderer,
                       "the OpenGL context is lost%s: nothing more can be drawn with it", why);
}

/* The first error since the last call. A lost context may answer with errors for ever. */
static GLenum first_error(struct gl_device *device)
{
    GLenum first = GL_NO_ERROR, error;
    for (int i = 0; i < 16 && (error = device->ask_error()) != GL_NO_ERROR; i++) {
        first = first == GL_NO_ERROR ? error : first;
        device->lost = device->lost || error == GL_CONTEXT_LOST;
    }
    return first;
}

pnb_status gl_check(struct gl_device *device, const char *what)
{
    GLenum first = first_error(device);
    if (device->lost)
        return say_lost(device, "");
    if (first == GL_NO_ERROR)
        return PNB_OK;
    pnb_status status =
        status_fail(device->context, PNB_ERROR_DEVICE, what, "OpenGL: %s%s%s", gl_error_name(first),
                    device->error[0] ? ": " : "", device->error);
    device->error[0] = 0;
    return status;
}

/* Asked once a frame. */
static pnb_status check_reset(struct gl_device *device)
{
    GLenum reset = device->ask_reset ? device->ask_reset() : GL_NO_ERROR;
    if (reset == GL_NO_ERROR)
        return PNB_OK;
    device->lost = true;
    return say_lost(device, reset == GL_GUILTY_CONTEXT_RESET
                                ? " (the device was reset, for what was drawn with it)"
                            : reset == GL_INNOCENT_CONTEXT_RESET
                                ? " (the device was reset, for what others drew)"
                                : " (the device was reset)");
}

static void APIENTRY heard(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                           const GLchar *message, const void *user)
{
    struct gl_device *device = (struct gl_device *)user;
    if (type == GL_DEBUG_TYPE_ERROR && !device->error[0])
        snprintf(device->error, sizeof(device->error), "%s", message);
}

/* The context is current: what it is, and the objects that every device has. */
static pnb_status look(struct gl_device *device)
{
    struct gl_device_info *info = &device->info;
    device->ask_error = ask_error;
    const char *renderer = (const char *)glGetString(GL_RENDERER);
    if (!renderer)
        return status_fail(device->context, PNB_ERROR_DEVICE, "OpenGL",
                           "the context does not answer");
    info->es = !epoxy_is_desktop_gl();
    info->version = epoxy_gl_version();
    if (info->version < (info->es ? 32 : 33))
        return status_fail(device->context, PNB_ERROR_DEVICE, renderer,
                           "OpenGL %s%d.%d; 3.3 core or ES 3.2 is needed", info->es ? "ES " : "",
                           info->version / 10, info->version % 10);
    GLint profile = GL_CONTEXT_CORE_PROFILE_BIT;
    if (!info->es)
        glGetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
    snprintf(info->renderer, sizeof(info->renderer), "%s, OpenGL %s%d.%d", renderer,
             info->es ? "ES " : "", info->version / 10, info->version % 10);
    static const char *const software[] = {"llvmpipe", "softpipe", "swrast", "SWR", "Software"};
    for (size_t i = 0; i < sizeof(software) / sizeof(*software); i++)
        info->software = info->software || strstr(renderer, software[i]);
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &info->max_texture_size);
    info->depth_bounds = epoxy_has_gl_extension("GL_EXT_depth_bounds_test");
    info->depth_clamp = !info->es || epoxy_has_gl_extension("GL_EXT_depth_clamp");
    info->geometry_shaders = true; /* core of both */
    if (info->version >= (info->es ? 32 : 45) || epoxy_has_gl_extension("GL_KHR_robustness"))
        device->ask_reset = ask_reset;
    else if (epoxy_has_gl_extension("GL_ARB_robustness"))
        device->ask_reset = ask_reset_arb;

    glGenVertexArrays(1, &device->vertex_array);
    glGenFramebuffers(1, &device->framebuffer);
    glGenSamplers(1, &device->sampler);
    glSamplerParameteri(device->sampler, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glSamplerParameteri(device->sampler, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glSamplerParameteri(device->sampler, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glSamplerParameteri(device->sampler, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glGenQueries(1, &device->query);
    if (info->es || info->version >= 40)
        glGenTransformFeedbacks(1, &device->feedback);
    GLint draw, read, renderbuffer;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw);
    glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read);
    glGetIntegerv(GL_RENDERBUFFER_BINDING, &renderbuffer);
    glGenRenderbuffers(1, &device->discard_buffer);
    glBindRenderbuffer(GL_RENDERBUFFER, device->discard_buffer);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, 1, 1);
    glGenFramebuffers(1, &device->discard_target);
    glBindFramebuffer(GL_FRAMEBUFFER, device->discard_target);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                              device->discard_buffer);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)draw);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, (GLuint)read);
    glBindRenderbuffer(GL_RENDERBUFFER, (GLuint)renderbuffer);
    return gl_check(device, "device");
}

/* ---- Headless ---- */

static EGLContext make_context(EGLDisplay display, EGLConfig config, enum gl_device_api api)
{
    static const struct {
        EGLenum api;
        EGLint major, minor;
    } versions[] = {{EGL_OPENGL_API, 4, 5}, {EGL_OPENGL_API, 3, 3}, {EGL_OPENGL_ES_API, 3, 2}};
    for (size_t i = 0; i < sizeof(versions) / sizeof(*versions); i++) {
        if ((api == GL_DEVICE_API_33 && i != 1) || (api == GL_DEVICE_API_ES && i != 2))
            continue;
        if (!eglBindAPI(versions[i].api))
            continue;
        for (int plain = 0; plain < 2; plain++) {
            EGLint attributes[16];
            int n = 0;
            attributes[n++] = EGL_CONTEXT_MAJOR_VERSION;
            attributes[n++] = versions[i].major;
            attributes[n++] = EGL_CONTEXT_MINOR_VERSION;
            attributes[n++] = versions[i].minor;
            if (versions[i].api == EGL_OPENGL_API) {
                attributes[n++] = EGL_CONTEXT_OPENGL_PROFILE_MASK;
                attributes[n++] = EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT;
            }
            if (!plain && epoxy_egl_version(display) >= 15) {
                attributes[n++] = EGL_CONTEXT_OPENGL_ROBUST_ACCESS;
                attributes[n++] = EGL_TRUE;
                attributes[n++] = EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY;
                attributes[n++] = EGL_LOSE_CONTEXT_ON_RESET;
            } else if (!plain &&
                       epoxy_has_egl_extension(display, "EGL_EXT_create_context_robustness")) {
                attributes[n++] = EGL_CONTEXT_OPENGL_ROBUST_ACCESS_EXT;
                attributes[n++] = EGL_TRUE;
                attributes[n++] = EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY_EXT;
                attributes[n++] = EGL_LOSE_CONTEXT_ON_RESET_EXT;
            }
            attributes[n] = EGL_NONE;
            EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
            if (context != EGL_NO_CONTEXT)
                return context;
        }
    }
    return EGL_NO_CONTEXT;
}

static bool try_display(struct gl_device *device, EGLDisplay display, enum gl_device_api api,
                        const char *where, struct attempts *attempts)
{
    if (display == EGL_NO_DISPLAY) {
        note(attempts, where, "no display");
        return false;
    }
    if (!eglInitialize(display, NULL, NULL)) {
        note(attempts, where, egl_error());
        return false;
    }
    EGLConfig config = EGL_NO_CONFIG_KHR;
    bool surfaceless = epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context");
    if (!surfaceless || !epoxy_has_egl_extension(display, "EGL_KHR_no_config_context")) {
        static const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                        EGL_OPENGL_BIT, EGL_NONE};
        EGLint count = 0;
        if (!eglChooseConfig(display, wanted, &config, 1, &count) || count < 1) {
            note(attempts, where, "no configuration for OpenGL");
            return false;
        }
    }
    EGLContext egl = make_context(display, config, api);
    if (egl == EGL_NO_CONTEXT) {
        note(attempts, where, "no context of OpenGL 3.3 core or ES 3.2");
        return false;
    }
    EGLSurface surface = EGL_NO_SURFACE;
    if (!surfaceless) {
        static const EGLint size[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
        surface = eglCreatePbufferSurface(display, config, size);
    }
    if ((!surfaceless && surface == EGL_NO_SURFACE) ||
        !eglMakeCurrent(display, surface, surface, egl)) {
        note(attempts, where, egl_error());
        eglDestroyContext(display, egl);
        return false;
    }
    device->display = display;
    device->egl = egl;
    device->surface = surface;
    return true;
}

static bool try_devices(struct gl_device *device, enum gl_device_api api, bool software,
                        struct attempts *attempts)
{
    if (!epoxy_has_egl_extension(NULL, "EGL_EXT_platform_base") ||
        !epoxy_has_egl_extension(NULL, "EGL_EXT_platform_device") ||
        !(epoxy_has_egl_extension(NULL, "EGL_EXT_device_enumeration") ||
          epoxy_has_egl_extension(NULL, "EGL_EXT_device_base"))) {
        if (!software)
            note(attempts, "EGL devices", "not offered");
        return false;
    }
    EGLDeviceEXT devices[DEVICES_MAX];
    EGLint count = 0;
    if (!eglQueryDevicesEXT(DEVICES_MAX, devices, &count))
        count = 0;
    for (EGLint i = 0; i < count; i++) {
        const char *extensions = eglQueryDeviceStringEXT(devices[i], EGL_EXTENSIONS);
        bool soft = extensions && strstr(extensions, "EGL_MESA_device_software");
        char where[32];
        snprintf(where, sizeof(where), "EGL device %d", (int)i);
        if (soft == software &&
            try_display(device, eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], NULL),
                        api, where, attempts))
            return true;
    }
    return false;
}

static bool try_all(struct gl_device *device, enum gl_device_api api, struct attempts *attempts)
{
    if (try_devices(device, api, false, attempts))
        return true;
    if (epoxy_has_egl_extension(NULL, "EGL_MESA_platform_surfaceless") &&
        try_display(
            device,
            eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL), api,
            "surfaceless", attempts))
        return true;
    return try_display(device, eglGetDisplay(EGL_DEFAULT_DISPLAY), api, "default display",
                       attempts) ||
           try_devices(device, api, true, attempts);
}

static struct gl_device *device_alloc(pnb_context *context)
{
    struct gl_device *device = memory_calloc(context, 1, sizeof(*device));
    if (device)
        device->context = context;
    return device;
}

pnb_status gl_device_create_as(pnb_context *context, enum gl_device_api api,
                               struct gl_device **out_device)
{
    *out_device = NULL;
    if (!epoxy_has_egl())
        return status_fail(context, PNB_ERROR_DEVICE, "OpenGL", "no EGL library on this machine");
    struct gl_device *device = device_alloc(context);
    if (!device)
        return status_no_memory(context, sizeof(*device));
    struct attempts attempts = {.used = 0};
    gl_current_get(&device->earlier);
    gl_current_release(&device->earlier);
    pnb_status status = PNB_OK;
    if (!try_all(device, api, &attempts)) {
        status = status_fail(context, PNB_ERROR_DEVICE, "OpenGL", "no device: %s", attempts.text);
        gl_current_restore(&device->earlier, eglGetCurrentDisplay());
        memory_free(context, device);
        return status;
    }
    device->begun = 1;
    status = look(device);
    if (status == PNB_OK) {
        gl_state_baseline(device);
        if ((device->info.es && device->info.version >= 32) || device->info.version >= 43) {
            glEnable(GL_DEBUG_OUTPUT);
            glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
            glDebugMessageCallback(heard, device);
        }
        status = gl_device_end(device);
    } else {
        device->begun = 0;
        gl_current_restore(&device->earlier, device->display);
    }
    if (status != PNB_OK) {
        gl_device_destroy(device);
        return status;
    }
    *out_device = device;
    return PNB_OK;
}

pnb_status gl_device_create(pnb_context *context, struct gl_device **out_device)
{
    return gl_device_create_as(context, GL_DEVICE_API_BEST, out_device);
}

pnb_status gl_device_adopt(pnb_context *context, struct gl_device **out_device)
{
    *out_device = NULL;
    struct gl_current current;
    gl_current_get(&current);
    if (!gl_current_any(&current))
        return status_fail(context, PNB_ERROR_DEVICE, "OpenGL",
                           "no context is current in this thread");
    struct gl_device *device = device_alloc(context);
    if (!device)
        return status_no_memory(context, sizeof(*device));
    device->adopted = true;
    device->owner = current;
    pnb_status status = look(device);
    if (status != PNB_OK) {
        gl_device_destroy(device);
        return status;
    }
    *out_device = device;
    return PNB_OK;
}

static void destroy_objects(struct gl_device *device)
{
    glDeleteVertexArrays(1, &device->vertex_array);
    glDeleteFramebuffers(1, &device->framebuffer);
    glDeleteFramebuffers(1, &device->discard_target);
    glDeleteRenderbuffers(1, &device->discard_buffer);
    glDeleteSamplers(1, &device->sampler);
    glDeleteQueries(1, &device->query);
    if (device->feedback)
        glDeleteTransformFeedbacks(1, &device->feedback);
}

void gl_device_destroy(struct gl_device *device)
{
    if (!device)
        return;
    if (device->adopted) {
        struct gl_current current;
        gl_current_get(&current);
        if (gl_current_same(&current, &device->owner))
            destroy_objects(device);
    } else if (device->egl != EGL_NO_CONTEXT) {
        /* What it holds goes with the context. */
        if (device->surface != EGL_NO_SURFACE)
            eglDestroySurface(device->display, device->surface);
        eglDestroyContext(device->display, device->egl);
    }
    gl_state_destroy(device);
    memory_free(device->context, device);
}

const struct gl_device_info *gl_device_get_info(const struct gl_device *device)
{
    return &device->info;
}

pnb_context *gl_device_context(const struct gl_device *device)
{
    return device->context;
}

static void leave(struct gl_device *device)
{
    if (device->adopted)
        gl_state_restore(device);
    else
        gl_current_restore(&device->earlier, device->display);
}

pnb_status gl_device_begin(struct gl_device *device)
{
    if (device->lost)
        return say_lost(device, "");
    if (device->begun++ > 0)
        return PNB_OK;
    pnb_status status = PNB_OK;
    if (device->adopted) {
        struct gl_current current;
        gl_current_get(&current);
        if (!gl_current_same(&current, &device->owner))
            status = status_fail(device->context, PNB_ERROR_DEVICE, "OpenGL",
                                 "the context of the solver is not current in this thread");
        else
            status = gl_state_save(device);
    } else {
        gl_current_get(&device->earlier);
        gl_current_release(&device->earlier);
        eglBindAPI(device->info.es ? EGL_OPENGL_ES_API : EGL_OPENGL_API);
        if (!eglMakeCurrent(device->display, device->surface, device->surface, device->egl)) {
            status = status_fail(device->context, PNB_ERROR_DEVICE, device->info.renderer,
                                 "its context cannot be made current: %s", egl_error());
            gl_current_restore(&device->earlier, device->display);
        }
    }
    if (status != PNB_OK) {
        device->begun = 0;
        return status;
    }
    /* Errors from before are not ours to report, but for a context that is gone. */
    first_error(device);
    device->error[0] = 0;
    if (!device->lost)
        return PNB_OK;
    device->begun = 0;
    leave(device);
    return say_lost(device, "");
}

pnb_status gl_device_end(struct gl_device *device)
{
    if (device->begun == 0)
        return PNB_OK;
    if (--device->begun > 0)
        return PNB_OK;
    /* The reset's reason says more than the errors that it makes. */
    pnb_status status = check_reset(device);
    if (status == PNB_OK)
        status = gl_check(device, device->info.renderer);
    leave(device);
    return status;
}

void gl_device_finish(struct gl_device *device)
{
    glFinish();
}
