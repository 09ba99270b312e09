/* cli/shadow.c: 'penumbra shadow': scene in, the shadow on a plane out, as geometry. */
#include "commands.h"
#include "session.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ENDINGS ".obj .ply .glb .svg .pdf .geojson"

static const char help_text[] =
    "The shadow on a flat receiver as triangles with an intensity per vertex (0 lit, 1 umbra), by "
    "the\n"
    "method planar; see 'penumbra methods planar' for its parameters.\n\n"
    "  .obj      grey vertex colours, 1 - intensity      .svg      a linear gradient per triangle\n"
    "  .ply      a property 'intensity', binary          .pdf      a gradient mesh\n"
    "  .glb      black, alpha = intensity, unlit         .geojson  umbra, outer boundary and "
    "rings\n\n"
    "Files of 3-D programs are in world space, a hair above the plane (--lift METRES); pages and\n"
    "GeoJSON show the plane from the light's side.\n\n"
    "examples\n"
    "  penumbra shadow cow.obj -o cow-shadow.glb\n"
    "  penumbra shadow builtin:knot -o knot.svg -n 32\n"
    "  penumbra shadow scene.json -o floor.pdf -p receiver=floor -p tolerance=0.004\n";

static const char *lift_text;

static const struct cli_extra extras[] = {
    {"lift", "METRES", "how far above the plane (default: a ten-thousandth of its size)",
     &lift_text},
};

static const struct cli_command command = {
    .name = "shadow",
    .operands = "SCENE",
    .summary = "The shadow on a plane as geometry",
    .options = CLI_OUTPUT | CLI_LIGHT | CLI_LIGHT_INDEX | CLI_SAMPLES | CLI_PARAM | CLI_THREADS |
               CLI_JSON | CLI_QUIET | CLI_METHOD,
    .extras = extras,
    .extra_count = sizeof(extras) / sizeof(extras[0]),
    .least_operands = 1,
    .most_operands = 1,
    .output_help = "the file: " ENDINGS,
    .text = help_text,
    .method = "planar",
};

static int print_json(const struct cli_session *session, const pnb_shadow *shadow)
{
    pnb_shadow_view view;
    pnb_solver_report report;
    pnb_shadow_get(shadow, &view);
    pnb_shadow_get_report(shadow, &report);
    json_t *value = json_object();
    json_object_set_new(value, "method", cli_json_text("planar"));
    json_object_set_new(value, "scene", cli_json_text(session->options->operands[0]));
    json_object_set_new(value, "output", cli_json_text(session->options->output));
    json_object_set_new(value, "light", json_integer((json_int_t)session->options->light_index));
    json_object_set_new(value, "vertices", json_integer((json_int_t)view.vertex_count));
    json_object_set_new(value, "triangles", json_integer((json_int_t)view.triangle_count));
    json_object_set_new(value, "planes", json_integer((json_int_t)view.plane_count));
    json_object_set_new(value, "rings", json_integer(view.ring_count));
    json_object_set_new(value, "milliseconds",
                        json_pack("{s:o, s:o}", "prepare", cli_json_number(report.prepare_ms),
                                  "shadow", cli_json_number(report.visibility_ms)));
    json_object_set_new(value, "counters", cli_json_counters(&report));
    json_object_set_new(value, "warnings", cli_json_warnings(session));
    return cli_json_print(value);
}

static int run(struct cli_session *session)
{
    const struct cli_options *options = session->options;
    double lift = -1;
    if (!options->output)
        return cli_usage_error("shadow", "--output", "is needed: a file that ends in " ENDINGS);
    if (!cli_has_ending(options->output, ENDINGS))
        return cli_usage_error("shadow", "--output", "'%.200s' ends in none of " ENDINGS,
                               options->output);
    if (options->method && strcmp(options->method, "planar") != 0)
        return cli_usage_error("shadow", "--method", "shadows as geometry come from planar alone");
    if (lift_text) {
        char *end;
        lift = strtod(lift_text, &end);
        if (end == lift_text || *end || !isfinite(lift) || lift < 0)
            return cli_usage_error("shadow", "--lift", "'%.100s' is no length", lift_text);
    }
    int result = cli_check_writable(options->output);
    pnb_scene *scene = NULL;
    pnb_shadow *shadow = NULL;
    if (result == CLI_GO_ON)
        result = cli_scene_load(session, options->operands[0], &scene);
    if (result == CLI_GO_ON && pnb_scene_light_count(scene) == 0)
        result = cli_error(options->operands[0], "has no light, so there is no shadow");
    if (result == CLI_GO_ON) {
        pnb_light light;
        pnb_scene_light(scene, options->light_index, &light);
        pnb_solver_desc desc = {.samples = options->samples,
                                .params = options->params,
                                .param_count = options->param_count};
        if (pnb_shadow_create(session->context, scene, &light, &desc, &shadow) != PNB_OK)
            result = cli_session_fail(session);
    }
    if (result == CLI_GO_ON && cli_session_stopped())
        result = cli_error("shadow", "cancelled");
    if (result == CLI_GO_ON && pnb_shadow_write(shadow, options->output, lift) != PNB_OK)
        result = cli_session_fail(session);
    cli_session_clear_bar(session);
    if (result == CLI_GO_ON)
        result = options->json ? print_json(session, shadow) : CLI_EXIT_DONE;
    pnb_shadow_destroy(shadow);
    pnb_scene_destroy(scene);
    return result;
}

int command_shadow(int argc, char **argv)
{
    struct cli_options options;
    lift_text = NULL;
    int result = cli_options_init(&command, argc, argv, &options);
    if (result != CLI_GO_ON)
        return result;
    struct cli_session session;
    result = cli_session_init(&session, &options);
    if (result == CLI_GO_ON)
        result = run(&session);
    cli_session_finish(&session);
    cli_options_finish(&options);
    return result;
}
