/* scene/load.c: from a path or a name to a scene: "builtin:NAME", a scene file, or the importer. */
#define _GNU_SOURCE
#include "scene/scene.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "scene/scene_file.h"

/* Reads a regular file of at most SCENE_FILE_LIMIT bytes; *out_text is the caller's to free. */
static pnb_status read_file(pnb_context *context, const char *path, char **out_text,
                            size_t *out_length)
{
    *out_text = NULL;
    *out_length = 0;
    /* Not to hang on a pipe that nobody writes to. */
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0)
        return status_fail(context, PNB_ERROR_FILE, path, "%s", strerror(errno));
    struct stat info;
    pnb_status status = PNB_OK;
    if (fstat(file, &info) != 0)
        status = status_fail(context, PNB_ERROR_FILE, path, "%s", strerror(errno));
    else if (S_ISDIR(info.st_mode))
        status = status_fail(context, PNB_ERROR_FILE, path, "is a folder");
    else if (!S_ISREG(info.st_mode))
        status = status_fail(context, PNB_ERROR_FILE, path, "is not a regular file");
    else if (info.st_size == 0)
        status = status_fail(context, PNB_ERROR_FORMAT, path, "is empty");
    else if ((unsigned long long)info.st_size > SCENE_FILE_LIMIT)
        status =
            status_fail(context, PNB_ERROR_FORMAT, path,
                        "larger than %zu MB, the limit of scene files", SCENE_FILE_LIMIT >> 20);
    size_t size = status == PNB_OK ? (size_t)info.st_size : 0, used = 0;
    if (status == PNB_OK && !(*out_text = memory_alloc(context, size, 1)))
        status = status_no_memory(context, size);
    while (status == PNB_OK && used < size) {
        ssize_t count = read(file, *out_text + used, size - used);
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0)
            status = status_fail(context, PNB_ERROR_FILE, path, "%s", strerror(errno));
        if (count <= 0)
            break;
        used += (size_t)count;
    }
    close(file);
    if (status != PNB_OK) {
        memory_free(context, *out_text);
        *out_text = NULL;
    }
    *out_length = used;
    return status;
}

static pnb_status load_scene_file(pnb_context *context, const char *path, pnb_scene **out_scene)
{
    char *text, *folder = NULL;
    size_t length;
    pnb_status status = read_file(context, path, &text, &length);
    if (status != PNB_OK)
        return status;
    const char *slash = strrchr(path, '/');
    if (slash && !(folder = memory_strdup(context, path)))
        status = status_no_memory(context, strlen(path));
    if (folder)
        folder[slash == path ? 1 : slash - path] = 0;
    struct scene_file_source source = {.file = path, .folder = folder};
    if (status == PNB_OK)
        status = scene_file_parse(context, text, length, &source, out_scene);
    memory_free(context, folder);
    memory_free(context, text);
    return status;
}

/* The base name without its ending: dir/cow.json gives cow. */
static pnb_status name_after_path(pnb_scene *scene, const char *path)
{
    char name[256];
    const char *slash = strrchr(path, '/');
    snprintf(name, sizeof(name), "%s", slash ? slash + 1 : path);
    char *dot = strrchr(name, '.');
    if (dot && dot != name)
        *dot = 0;
    return scene_set_name(scene, name);
}

pnb_status pnb_scene_load(pnb_context *context, const char *path, pnb_scene **out_scene)
{
    *out_scene = NULL;
    if (!path)
        return status_missing(context, "path");
    if (strncmp(path, "builtin:", 8) == 0)
        return scene_builtin(context, path + 8, out_scene);
    size_t length = strlen(path);
    if (length == 0)
        return status_fail(context, PNB_ERROR_FILE, "scene", "an empty file name");
    bool json = length > 5 && strcasecmp(path + length - 5, ".json") == 0;
    pnb_status status =
        json ? load_scene_file(context, path, out_scene) : scene_import(context, path, out_scene);
    if (status == PNB_OK)
        status = name_after_path(*out_scene, path);
    if (status != PNB_OK) {
        pnb_scene_destroy(*out_scene);
        *out_scene = NULL;
    }
    return status;
}
