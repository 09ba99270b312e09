/* drag-source FILE...: a small window from which the files can be dragged, one after the other, as
 * from a file manager: real drops need somebody who drags. Prints "dragging FILE" when a drag
 * begins, "dropped FILE" when it was taken, "refused FILE" when it was not, which can then be tried
 * again. Ends after the last one. */
#include <stdbool.h>
#include <stdio.h>

#include <gtk/gtk.h>

struct source {
    char **files; /* NULL at the end */
    GMainLoop *loop;
    bool refused;
};

static GdkContentProvider *on_prepare(GtkDragSource *drag, double x, double y, gpointer data)
{
    struct source *source = data;
    if (!*source->files)
        return NULL;
    GFile *file = g_file_new_for_commandline_arg(*source->files);
    GSList *list = g_slist_append(NULL, file);
    GdkFileList *files = gdk_file_list_new_from_list(list);
    GdkContentProvider *content = gdk_content_provider_new_typed(GDK_TYPE_FILE_LIST, files);
    printf("dragging %s\n", *source->files);
    fflush(stdout);
    source->refused = false;
    g_boxed_free(GDK_TYPE_FILE_LIST, files);
    g_slist_free_full(list, g_object_unref);
    return content;
}

static gboolean on_cancel(GtkDragSource *drag, GdkDrag *which, GdkDragCancelReason reason,
                          gpointer data)
{
    struct source *source = data;
    source->refused = true;
    return FALSE;
}

static void on_end(GtkDragSource *drag, GdkDrag *which, gboolean moved, gpointer data)
{
    struct source *source = data;
    printf("%s %s\n", source->refused ? "refused" : "dropped", *source->files);
    fflush(stdout);
    if (!source->refused && !*++source->files)
        g_main_loop_quit(source->loop);
}

int main(int argc, char **argv)
{
    if (argc < 2 || !gtk_init_check())
        return 2;
    struct source source = {argv + 1, g_main_loop_new(NULL, FALSE), false};
    GtkWidget *window = gtk_window_new();
    GtkDragSource *drag = gtk_drag_source_new();
    gtk_window_set_title(GTK_WINDOW(window), "drag-source");
    gtk_window_set_decorated(GTK_WINDOW(window), FALSE);
    gtk_window_set_default_size(GTK_WINDOW(window), 120, 120);
    g_signal_connect(drag, "prepare", G_CALLBACK(on_prepare), &source);
    g_signal_connect(drag, "drag-end", G_CALLBACK(on_end), &source);
    g_signal_connect(drag, "drag-cancel", G_CALLBACK(on_cancel), &source);
    gtk_widget_add_controller(window, GTK_EVENT_CONTROLLER(drag));
    gtk_window_present(GTK_WINDOW(window));
    g_main_loop_run(source.loop);
    g_main_loop_unref(source.loop);
    return 0;
}
