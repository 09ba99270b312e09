/* gl/current.c: the context that is current in this thread, of EGL or GLX, to give it back.
 *
 * A thread has one current context, and libraries beside us (GTK, SDL, GLFW) may have made it by
 * GLX, which EGL does not know of and refuses to replace. GLX is asked only where the process has
 * it loaded already, so that we need no X11.
 */
#include <dlfcn.h>
#include <string.h>

#include "gl/inside.h"

struct glx {
    void *library;
    void *(*get_context)(void);
    void *(*get_display)(void);
    unsigned long (*get_draw)(void);
    unsigned long (*get_read)(void);
    int (*make_current)(void *display, unsigned long draw, unsigned long read, void *context);
};

static void *symbol(void *library, const char *name)
{
    return library ? dlsym(library, name) : NULL;
}

/* A void pointer to a function pointer, without a cast that ISO C forbids. */
#define LOOK_UP(glx, member, name)                                                                 \
    do {                                                                                           \
        void *found = symbol((glx)->library, name);                                                \
        memcpy(&(glx)->member, &found, sizeof(found));                                             \
    } while (0)

/* False where GLX is not loaded. Ends with glx_close(). */
static bool glx_open(struct glx *glx)
{
    static const char *const names[] = {"libGLX.so.0", "libGL.so.1"};
    for (size_t i = 0; i < sizeof(names) / sizeof(*names); i++) {
        glx->library = dlopen(names[i], RTLD_LAZY | RTLD_NOLOAD);
        if (!glx->library)
            continue;
        LOOK_UP(glx, get_context, "glXGetCurrentContext");
        LOOK_UP(glx, get_display, "glXGetCurrentDisplay");
        LOOK_UP(glx, get_draw, "glXGetCurrentDrawable");
        LOOK_UP(glx, get_read, "glXGetCurrentReadDrawable");
        LOOK_UP(glx, make_current, "glXMakeContextCurrent");
        if (glx->get_context && glx->get_display && glx->get_draw && glx->get_read &&
            glx->make_current)
            return true;
        dlclose(glx->library);
    }
    return false;
}

static void glx_close(struct glx *glx)
{
    dlclose(glx->library);
}

void gl_current_get(struct gl_current *out_current)
{
    memset(out_current, 0, sizeof(*out_current));
    struct glx glx;
    if (glx_open(&glx)) {
        out_current->glx_context = glx.get_context();
        if (out_current->glx_context) {
            out_current->glx_display = glx.get_display();
            out_current->glx_draw = glx.get_draw();
            out_current->glx_read = glx.get_read();
        }
        glx_close(&glx);
    }
    if (!epoxy_has_egl())
        return;
    out_current->api = eglQueryAPI();
    out_current->context = eglGetCurrentContext();
    if (out_current->context != EGL_NO_CONTEXT) {
        out_current->display = eglGetCurrentDisplay();
        out_current->draw = eglGetCurrentSurface(EGL_DRAW);
        out_current->read = eglGetCurrentSurface(EGL_READ);
    }
}

bool gl_current_any(const struct gl_current *current)
{
    return current->context != EGL_NO_CONTEXT || current->glx_context;
}

bool gl_current_same(const struct gl_current *a, const struct gl_current *b)
{
    return a->context == b->context && a->glx_context == b->glx_context;
}

static void glx_make(const struct gl_current *current, bool ours)
{
    struct glx glx;
    if (!current->glx_context || !glx_open(&glx))
        return;
    if (ours)
        glx.make_current(current->glx_display, current->glx_draw, current->glx_read,
                         current->glx_context);
    else
        glx.make_current(current->glx_display, 0, 0, NULL);
    glx_close(&glx);
}

void gl_current_release(const struct gl_current *current)
{
    glx_make(current, false);
}

void gl_current_restore(const struct gl_current *current, EGLDisplay ours)
{
    if (current->context != EGL_NO_CONTEXT)
        eglMakeCurrent(current->display, current->draw, current->read, current->context);
    else
        eglMakeCurrent(ours, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (current->api != EGL_NONE && current->api != 0)
        eglBindAPI(current->api);
    glx_make(current, true);
}
