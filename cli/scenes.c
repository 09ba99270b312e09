/* cli/scenes.c: 'penumbra scenes': the built-in scenes, listed or written as files. */
#include "commands.h"
#include "session.h"

#include <stdio.h>
#include <string.h>

static const char help_text[] =
    "--write makes NAME.json (with its meshes as .obj beside it) and NAME.glb of each scene, so\n"
    "that other programs can render the same thing. Area lights stand in the GLB as\n"
    "EXT_lights_area.\n\n"
    "examples\n"
    "  penumbra scenes\n"
    "  penumbra render builtin:fence\n"
    "  penumbra scenes --write scenes          every scene\n"
    "  penumbra scenes knot --write scenes     one of them\n";

static const pnb_builtin_info *find_builtin(const char *name, pnb_builtin_info *info)
{
    if (strncmp(name, "builtin:", 8) == 0)
        name += 8;
    for (size_t i = 0; i < pnb_builtin_count(); i++) {
        pnb_builtin(i, info);
        if (strcmp(info->name, name) == 0)
            return info;
    }
    return NULL;
}

static int list_scenes(bool as_json)
{
    json_t *array = as_json ? json_array() : NULL;
    for (size_t i = 0; i < pnb_builtin_count(); i++) {
        pnb_builtin_info info;
        pnb_builtin(i, &info);
        const char *source = info.source ? info.source : "";
        if (array)
            json_array_append_new(array, json_pack("{s:s, s:s, s:s}", "name", info.name, "title",
                                                   info.title, "source", source));
        else
            printf("%-28s %s%s%s%s\n", info.name, info.title, *source ? " (" : "", source,
                   *source ? ")" : "");
    }
    return array ? cli_json_print(json_pack("{s:o}", "scenes", array)) : cli_flush();
}

/* Adds the paths to written, or prints them where that is NULL. */
static int write_scene(struct cli_session *session, const char *name, const char *folder,
                       json_t *written)
{
    char source[256], path[4400];
    snprintf(source, sizeof(source), "builtin:%s", name);
    pnb_scene *scene = NULL;
    if (pnb_scene_load(session->context, source, &scene) != PNB_OK)
        return cli_session_fail(session);
    int result = CLI_GO_ON;
    for (int glb = 0; glb < 2 && result == CLI_GO_ON; glb++) {
        snprintf(path, sizeof(path), "%s/%s.%s", folder, name, glb ? "glb" : "json");
        pnb_status status =
            glb ? pnb_scene_write_glb(scene, path) : pnb_scene_write_json(scene, path);
        if (status != PNB_OK)
            result = cli_session_fail(session);
        else if (written)
            json_array_append_new(written, cli_json_text(path));
        else if (!session->options->quiet)
            printf("%s\n", path);
    }
    pnb_scene_destroy(scene);
    return result;
}

static int write_scenes(const struct cli_options *options, const char *folder)
{
    pnb_builtin_info info;
    for (size_t i = 0; i < options->operand_count; i++)
        if (!find_builtin(options->operands[i], &info))
            return cli_usage_error("scenes", options->operands[i],
                                   "there is no such scene; 'penumbra scenes' lists them");
    if (strlen(folder) > 4000)
        return cli_error(folder, "the path is too long");
    int result = cli_make_folder(folder);
    if (result != CLI_GO_ON)
        return result;

    struct cli_session session;
    result = cli_session_init(&session, options);
    json_t *written = options->json ? json_array() : NULL;
    size_t count = options->operand_count ? options->operand_count : pnb_builtin_count();
    for (size_t i = 0; i < count && result == CLI_GO_ON; i++) {
        if (options->operand_count)
            find_builtin(options->operands[i], &info);
        else
            pnb_builtin(i, &info);
        result = write_scene(&session, info.name, folder, written);
        if (result == CLI_GO_ON && cli_session_stopped())
            result = cli_error("scenes", "cancelled");
    }
    cli_session_finish(&session);
    if (result == CLI_GO_ON)
        return written ? cli_json_print(json_pack("{s:o}", "written", written)) : cli_flush();
    json_decref(written);
    return result;
}

int command_scenes(int argc, char **argv)
{
    const char *folder = NULL;
    const struct cli_extra extras[] = {
        {"write", "DIR", "write the scenes into a folder as JSON and as GLB", &folder}};
    const struct cli_command command = {
        .name = "scenes",
        .operands = "[NAME]...",
        .summary = "The built-in scenes, each usable as builtin:NAME",
        .options = CLI_JSON | CLI_QUIET,
        .extras = extras,
        .extra_count = 1,
        .most_operands = (size_t)-1,
        .text = help_text,
    };
    struct cli_options options;
    int result = cli_options_init(&command, argc, argv, &options);
    if (result != CLI_GO_ON)
        return result;
    if (folder && !*folder)
        result = cli_usage_error("scenes", "--write", "the path is empty");
    else if (folder)
        result = write_scenes(&options, folder);
    else if (options.operand_count)
        result = cli_usage_error("scenes", "command line", "a NAME needs --write DIR");
    else
        result = list_scenes(options.json);
    cli_options_finish(&options);
    return result;
}
