/* cli/render.c: 'penumbra render': scene in, picture out.
 *
 *   load -> surface (once) -> per light: visibility -> shade -> files -> JSON
 *
 * Everything that can be wrong with the command line or the output paths is found before the work.
 */
#include "commands.h"
#include "session.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PICTURE_ENDINGS ".png .exr .pfm"

static const char help_text[] =
    "The picture is PNG (8-bit sRGB), EXR or PFM by the file's ending. An EXR holds R, G, B "
    "(linear)\n"
    "and the channels visibility (of light --light-index; with several lights also visibility.0,\n"
    "visibility.1, ...), depth, normal.X/Y/Z and position.X/Y/Z; where nothing is seen they are "
    "NaN.\n"
    "A visibility file has one channel: 1 lit, 0 umbra, NaN where the camera sees no surface.\n\n"
    "--json prints milliseconds: prepare (once per mesh), primary (the visible surface), "
    "visibility\n"
    "(one frame's, all lights; the median of several runs where it is quick), shade.\n\n"
    "examples\n"
    "  penumbra render builtin:spheres-9x9\n"
    "  penumbra render cow.obj -o cow.exr -m reference -n 1024 -s 1600x1200\n"
    "  penumbra render scene.json --visibility v.pfm --visibility v.png --light-index 1 --json\n"
    "  penumbra render cow.obj --light '{\"type\": \"disk\", \"center\": [0, 4, 0],\n"
    "      \"normal\": [0, -1, 0], \"radius\": 0.5}'\n";

static const struct cli_command command = {
    .name = "render",
    .operands = "SCENE",
    .summary = "One picture of a scene: shaded, with shadows",
    .options = CLI_METHOD | CLI_OUTPUT | CLI_SIZE | CLI_LIGHT | CLI_LIGHT_INDEX | CLI_SAMPLES |
               CLI_PARAM | CLI_VISIBILITY | CLI_THREADS | CLI_JSON | CLI_QUIET,
    .least_operands = 1,
    .most_operands = 1,
    .output_help = "the picture (default: the scene's base name with .png, in this folder)",
    .text = help_text,
};

struct light_result {
    float *visibility;
    pnb_solver_report report; /* its warnings are the solver's */
};

struct render {
    struct cli_session session;
    const struct cli_options *options;
    char output[4096];
    pnb_scene *scene;
    pnb_surface *surface;
    pnb_surface_view view;
    pnb_solver *solver;
    struct light_result *lights;
    size_t light_count;
    float *rgb;
    double prepare_ms, visibility_ms, shade_ms;
    char device[256];
};

/* "models/cow.obj" gives "cow.png", "builtin:fence" gives "fence.png". */
static void default_output(const char *scene, char *path, size_t size)
{
    const char *slash = strrchr(scene, '/');
    const char *base = slash ? slash + 1 : scene;
    if (strncmp(base, "builtin:", 8) == 0)
        base += 8;
    const char *dot = strrchr(base, '.');
    int length = dot && dot > base ? (int)(dot - base) : (int)strlen(base);
    snprintf(path, size, "%.*s.png", length, base);
}

static int check_outputs(struct render *render)
{
    const struct cli_options *options = render->options;
    if (options->output && strlen(options->output) >= sizeof(render->output))
        return cli_error(options->output, "the path is too long");
    if (options->output)
        snprintf(render->output, sizeof(render->output), "%s", options->output);
    else
        default_output(options->operands[0], render->output, sizeof(render->output));
    if (!cli_has_ending(render->output, PICTURE_ENDINGS))
        return cli_usage_error("render", "--output", "'%.200s' ends in none of " PICTURE_ENDINGS,
                               render->output);
    int result = cli_check_writable(render->output);
    for (size_t i = 0; i < options->visibility_count && result == CLI_GO_ON; i++) {
        if (strcmp(options->visibilities[i], render->output) == 0)
            return cli_usage_error("render", "--visibility", "is the same file as the picture");
        result = cli_check_writable(options->visibilities[i]);
    }
    return result;
}

/* One light's visibility, with its time and counters. */
static int solve_light(struct render *render, size_t index, const pnb_receivers *receivers)
{
    struct light_result *result = &render->lights[index];
    pnb_light light;
    pnb_scene_light(render->scene, index, &light);
    result->visibility = malloc(receivers->count * sizeof(float));
    if (!result->visibility)
        return cli_error("memory", "none left for %zu pixels", receivers->count);

    if (cli_solve(&render->session, render->solver, &light, receivers, render->options->json,
                  result->visibility, &result->report, NULL) != PNB_OK)
        return cli_session_fail(&render->session);
    render->prepare_ms = result->report.prepare_ms;
    char processor[256];
    snprintf(render->device, sizeof(render->device), "%s",
             cli_device(&result->report, processor, sizeof(processor)));
    render->visibility_ms += result->report.visibility_ms;
    return CLI_GO_ON;
}

/* A light that the method cannot do is found before the first one's work. */
static int check_lights(struct render *render, const pnb_method_info *method)
{
    for (size_t i = 0; i < render->light_count; i++) {
        pnb_light light;
        pnb_scene_light(render->scene, i, &light);
        if (!(method->lights & PNB_LIGHT_BIT(light.type)) &&
            pnb_solver_visibility(render->solver, &light, &(pnb_receivers){0}, NULL) != PNB_OK)
            return cli_session_fail(&render->session);
    }
    return CLI_GO_ON;
}

static int solve(struct render *render)
{
    const struct cli_options *options = render->options;
    pnb_context *context = render->session.context;
    if (pnb_surface_create(context, render->scene, NULL, options->width, options->height,
                           &render->surface) != PNB_OK)
        return cli_session_fail(&render->session);
    pnb_surface_get(render->surface, &render->view);

    const pnb_method_info *method =
        pnb_method_find(options->method ? options->method : pnb_default_method());
    if (options->samples && !method->samples)
        cli_session_warn(&render->session, "--samples: this method does not sample the light");

    pnb_solver_desc desc = {.method = options->method,
                            .samples = options->samples,
                            .params = options->params,
                            .param_count = options->param_count};
    if (pnb_solver_create(context, render->scene, &desc, &render->solver) != PNB_OK)
        return cli_session_fail(&render->session);

    pnb_receivers receivers;
    pnb_surface_receivers(render->surface, &receivers);
    render->light_count = pnb_scene_light_count(render->scene);
    render->lights = calloc(render->light_count + 1, sizeof(*render->lights));
    if (!render->lights)
        return cli_error("memory", "none left");
    int result = check_lights(render, method);
    for (size_t i = 0; i < render->light_count && result == CLI_GO_ON; i++)
        result = solve_light(render, i, &receivers);
    return result;
}

static int shade(struct render *render)
{
    size_t pixels = (size_t)render->options->width * (size_t)render->options->height;
    const float **visibility = calloc(render->light_count + 1, sizeof(*visibility));
    render->rgb = malloc(pixels * 3 * sizeof(float));
    if (!visibility || !render->rgb) {
        free(visibility);
        return cli_error("memory", "none left for %zu pixels", pixels);
    }
    for (size_t i = 0; i < render->light_count; i++)
        visibility[i] = render->lights[i].visibility;
    double begin = cli_clock_ms();
    pnb_status status = pnb_surface_shade(render->surface, visibility, render->rgb);
    render->shade_ms = cli_clock_ms() - begin;
    free(visibility);
    return status == PNB_OK ? CLI_GO_ON : cli_session_fail(&render->session);
}

static int write_exr(struct render *render)
{
    const pnb_surface_view *view = &render->view;
    const struct light_result *lights = render->lights;
    size_t most = 11 + render->light_count, count = 0;
    pnb_channel *channels = calloc(most, sizeof(*channels));
    char(*names)[32] = calloc(render->light_count + 1, sizeof(*names));
    int result;
    if (channels && names) {
        channels[count++] = (pnb_channel){"R", render->rgb, 3};
        channels[count++] = (pnb_channel){"G", render->rgb + 1, 3};
        channels[count++] = (pnb_channel){"B", render->rgb + 2, 3};
        channels[count++] = (pnb_channel){"depth", view->depth, 1};
        channels[count++] = (pnb_channel){"normal.X", view->normals, 3};
        channels[count++] = (pnb_channel){"normal.Y", view->normals + 1, 3};
        channels[count++] = (pnb_channel){"normal.Z", view->normals + 2, 3};
        channels[count++] = (pnb_channel){"position.X", view->positions, 3};
        channels[count++] = (pnb_channel){"position.Y", view->positions + 1, 3};
        channels[count++] = (pnb_channel){"position.Z", view->positions + 2, 3};
        if (render->light_count)
            channels[count++] =
                (pnb_channel){"visibility", lights[render->options->light_index].visibility, 1};
        for (size_t i = 0; render->light_count > 1 && i < render->light_count; i++) {
            snprintf(names[i], sizeof(names[i]), "visibility.%zu", i);
            channels[count++] = (pnb_channel){names[i], lights[i].visibility, 1};
        }
        result = pnb_image_write_exr(render->session.context, render->output, view->width,
                                     view->height, channels, count) == PNB_OK
                     ? CLI_GO_ON
                     : cli_session_fail(&render->session);
    } else {
        result = cli_error("memory", "none left");
    }
    free(channels);
    free(names);
    return result;
}

static pnb_status write_visibility(struct render *render, const char *path)
{
    pnb_context *context = render->session.context;
    pnb_image image = {render->view.width, render->view.height, 1,
                       render->lights[render->options->light_index].visibility};
    pnb_channel channel = {"visibility", image.data, 1};
    if (cli_has_ending(path, ".exr"))
        return pnb_image_write_exr(context, path, image.width, image.height, &channel, 1);
    return pnb_image_write(context, path, &image);
}

static int write_picture(struct render *render)
{
    pnb_image picture = {render->view.width, render->view.height, 3, render->rgb};
    if (cli_has_ending(render->output, ".exr"))
        return write_exr(render);
    return pnb_image_write(render->session.context, render->output, &picture) == PNB_OK
               ? CLI_GO_ON
               : cli_session_fail(&render->session);
}

static int write_files(struct render *render)
{
    const struct cli_options *options = render->options;
    int result = write_picture(render);
    for (size_t i = 0; i < options->visibility_count && result == CLI_GO_ON; i++)
        if (write_visibility(render, options->visibilities[i]) != PNB_OK)
            result = cli_session_fail(&render->session);
    return result;
}

static int print_json(struct render *render)
{
    const struct cli_options *options = render->options;
    const pnb_method_info *method =
        pnb_method_find(options->method ? options->method : pnb_default_method());
    json_t *lights = json_array();
    for (size_t i = 0; i < render->light_count; i++) {
        pnb_light light;
        pnb_scene_light(render->scene, i, &light);
        json_array_append_new(lights,
                              json_pack("{s:i, s:s, s:o, s:o}", "index", (int)i, "type",
                                        pnb_light_type_name(light.type), "milliseconds",
                                        cli_json_number(render->lights[i].report.visibility_ms),
                                        "counters", cli_json_counters(&render->lights[i].report)));
    }
    json_t *value = json_object();
    json_object_set_new(value, "method", cli_json_text(method->name));
    json_object_set_new(value, "scene", cli_json_text(options->operands[0]));
    json_object_set_new(value, "output", cli_json_text(render->output));
    json_object_set_new(value, "width", json_integer(options->width));
    json_object_set_new(value, "height", json_integer(options->height));
    json_object_set_new(value, "light", json_integer((json_int_t)options->light_index));
    if (render->light_count && method->samples)
        json_object_set_new(value, "samples",
                            json_integer(render->lights[options->light_index].report.samples));
    json_object_set_new(value, "milliseconds",
                        json_pack("{s:o, s:o, s:o, s:o}", "prepare",
                                  cli_json_number(render->prepare_ms), "primary",
                                  cli_json_number(render->view.primary_ms), "visibility",
                                  cli_json_number(render->visibility_ms), "shade",
                                  cli_json_number(render->shade_ms)));
    json_object_set_new(value, "parameters",
                        cli_json_parameters(options->params, options->param_count, method));
    if (render->light_count)
        json_object_set_new(value, "counters",
                            cli_json_counters(&render->lights[options->light_index].report));
    json_object_set_new(value, "lights", lights);
    json_object_set_new(value, "device", cli_json_text(render->device));
    json_object_set_new(value, "threads",
                        json_integer(pnb_context_threads(render->session.context)));
    json_object_set_new(value, "warnings", cli_json_warnings(&render->session));
    return cli_json_print(value);
}

static int run(struct render *render)
{
    const struct cli_options *options = render->options;
    int result = check_outputs(render);
    if (result == CLI_GO_ON)
        result = cli_scene_load(&render->session, options->operands[0], &render->scene);
    if (result == CLI_GO_ON && options->visibility_count &&
        pnb_scene_light_count(render->scene) == 0)
        result = cli_error(options->operands[0], "has no light, so there is no visibility");
    if (result == CLI_GO_ON)
        result = solve(render);
    if (result == CLI_GO_ON)
        result = shade(render);
    if (result == CLI_GO_ON && cli_session_stopped())
        result = cli_error("render", "cancelled");
    if (result == CLI_GO_ON)
        result = write_files(render);
    cli_session_clear_bar(&render->session);
    if (result == CLI_GO_ON)
        result = options->json ? print_json(render) : CLI_EXIT_DONE;
    return result;
}

int command_render(int argc, char **argv)
{
    struct cli_options options;
    int result = cli_options_init(&command, argc, argv, &options);
    if (result != CLI_GO_ON)
        return result;
    struct render render = {.options = &options};
    result = cli_session_init(&render.session, &options);
    if (result == CLI_GO_ON)
        result = run(&render);
    for (size_t i = 0; i < render.light_count && render.lights; i++)
        free(render.lights[i].visibility);
    free(render.lights);
    free(render.rgb);
    pnb_solver_destroy(render.solver);
    pnb_surface_destroy(render.surface);
    pnb_scene_destroy(render.scene);
    cli_session_finish(&render.session);
    cli_options_finish(&options);
    return result;
}
