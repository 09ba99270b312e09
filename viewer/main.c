/* viewer/main.c: the program penumbra-view: the window of 'penumbra view'. */
#include <locale.h>
#include <string.h>

#include "app.h"

struct run {
    struct view_options options;
    struct view_app *app;
    int64_t started_us;
};

static void on_activate(GtkApplication *application, gpointer data)
{
    struct run *run = data;
    if (!run->app)
        run->app = view_app_create(application, &run->options, run->started_us);
}

static void on_removed(GtkApplication *application, GtkWindow *window, gpointer data)
{
    struct run *run = data;
    if (run->app && !gtk_application_get_windows(application))
        g_application_quit(G_APPLICATION(application));
}

/* GTK would compile its shaders with llvmpipe, which takes seconds, and then draw slower than cairo
 * does. GSK_RENDERER, if given, has the last word. */
static void choose_renderer(void)
{
    bool device = g_file_test("/dev/nvidiactl", G_FILE_TEST_EXISTS) ||
                  g_file_test("/dev/dxg", G_FILE_TEST_EXISTS);
    GDir *folder = g_dir_open("/dev/dri", 0, NULL);
    for (const char *name; folder && (name = g_dir_read_name(folder));)
        device = device || g_str_has_prefix(name, "renderD");
    if (folder)
        g_dir_close(folder);
    const char *software = g_getenv("LIBGL_ALWAYS_SOFTWARE");
    if (!device || (software && strcmp(software, "1") == 0))
        g_setenv("GSK_RENDERER", "cairo", FALSE);
}

int main(int argc, char **argv)
{
    struct run run = {.started_us = g_get_monotonic_time()};
    int status;
    if (!view_options_read(&run.options, argc, argv, &status)) {
        view_options_finish(&run.options);
        return status;
    }
    choose_renderer();
    if (!gtk_init_check()) {
        const char *display = g_getenv("DISPLAY"), *wayland = g_getenv("WAYLAND_DISPLAY");
        view_complain("display", (display && *display) || (wayland && *wayland)
                                     ? "cannot be opened (DISPLAY, WAYLAND_DISPLAY)"
                                     : "there is none (DISPLAY and WAYLAND_DISPLAY are not set)");
        view_options_finish(&run.options);
        return 1;
    }
    setlocale(LC_NUMERIC, "C"); /* numbers in files and on the command line have a point */
    GtkApplication *application =
        gtk_application_new("io.github.penumbra.View", G_APPLICATION_NON_UNIQUE);
    g_signal_connect(application, "activate", G_CALLBACK(on_activate), &run);
    g_signal_connect(application, "window-removed", G_CALLBACK(on_removed), &run);
    g_application_run(G_APPLICATION(application), 0, NULL);
    status = run.app ? run.app->exit_status : 1;
    view_app_destroy(run.app);
    g_object_unref(application);
    view_options_finish(&run.options);
    return status;
}
