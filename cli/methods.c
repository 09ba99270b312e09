/* cli/methods.c: 'penumbra methods': the registry as text or JSON. */
#include "commands.h"
#include "session.h"

#include <stdio.h>
#include <string.h>

static const struct cli_command command = {
    .name = "methods",
    .operands = "[NAME]",
    .summary = "The shadow methods; with NAME, one of them and its parameters",
    .options = CLI_JSON,
    .least_operands = 0,
    .most_operands = 1,
    .text = "examples\n"
            "  penumbra methods\n"
            "  penumbra methods reference\n"
            "  penumbra methods --json\n",
};

static const char *const param_types[] = {"integer", "number", "choice", "text"};

static const char *processor_name(const pnb_method_info *method)
{
    if (method->opengl_path)
        return "CPU, OpenGL";
    return method->processor == PNB_PROCESSOR_OPENGL ? "OpenGL" : "CPU";
}

static const char *receivers_name(const pnb_method_info *method)
{
    return method->receivers == PNB_RECEIVERS_PLANES ? "planes" : "any";
}

static json_t *method_json(const pnb_method_info *method)
{
    json_t *lights = json_array(), *params = json_array();
    for (int type = 0; type < PNB_LIGHT_TYPE_COUNT; type++)
        if (method->lights & PNB_LIGHT_BIT(type))
            json_array_append_new(lights, cli_json_text(pnb_light_type_name(type)));
    for (size_t i = 0; i < method->param_count; i++) {
        const pnb_param_info *info = &method->params[i];
        json_t *param =
            json_pack("{s:s, s:s, s:s, s:s}", "key", info->key, "type", param_types[info->type],
                      "default", info->default_value, "summary", info->summary);
        if (info->type == PNB_PARAM_INTEGER || info->type == PNB_PARAM_NUMBER) {
            json_object_set_new(param, "minimum", cli_json_number(info->minimum));
            json_object_set_new(param, "maximum", cli_json_number(info->maximum));
        }
        if (info->type == PNB_PARAM_CHOICE)
            json_object_set_new(param, "choices", cli_json_text(info->choices));
        json_array_append_new(params, param);
    }
    json_t *value =
        json_pack("{s:s, s:s, s:s, s:s, s:o, s:s, s:s, s:b}", "name", method->name, "title",
                  method->title, "paper", method->paper, "summary", method->summary, "lights",
                  lights, "receivers", receivers_name(method), "processor", processor_name(method),
                  "default", strcmp(method->name, pnb_default_method()) == 0);
    if (method->samples)
        json_object_set_new(value, "samples", json_integer(method->default_samples));
    json_object_set_new(value, "parameters", params);
    return value;
}

static void print_lights(const pnb_method_info *method)
{
    bool first = true;
    for (int type = 0; type < PNB_LIGHT_TYPE_COUNT; type++)
        if (method->lights & PNB_LIGHT_BIT(type)) {
            printf("%s%s", first ? "" : ", ", pnb_light_type_name(type));
            first = false;
        }
}

/* A text broken between words at column 78, each line indented. */
static void print_wrapped(const char *text, int indent)
{
    int column = indent;
    printf("%*s", indent, "");
    while (*text) {
        int length = (int)strcspn(text, " ");
        if (column > indent && column + 1 + length > 78) {
            printf("\n%*s", indent, "");
            column = indent;
        } else if (column > indent) {
            column += printf(" ");
        }
        column += printf("%.*s", length, text);
        text += length;
        text += strspn(text, " ");
    }
    printf("\n");
}

static void print_method(const pnb_method_info *method)
{
    printf("%s: %s\n", method->name, method->title);
    print_wrapped(method->summary, 2);
    if (*method->paper)
        printf("  paper      %s\n", method->paper);
    printf("  lights     ");
    print_lights(method);
    printf("\n  receivers  %s\n  processor  %s\n", receivers_name(method), processor_name(method));
    if (method->samples)
        printf("  samples    %d unless -n says otherwise\n", method->default_samples);
    if (!method->param_count)
        printf("  no parameters\n");
    else
        printf("  parameters (-p KEY=VALUE)\n");
    for (size_t i = 0; i < method->param_count; i++) {
        const pnb_param_info *info = &method->params[i];
        printf("    %s=%s  ", info->key, info->default_value);
        if (info->type == PNB_PARAM_CHOICE)
            printf("(%s)", info->choices);
        else if (info->type == PNB_PARAM_TEXT)
            printf("(text)");
        else
            printf("(%g to %g)", info->minimum, info->maximum);
        printf("\n");
        print_wrapped(info->summary, 8);
    }
}

static void print_list(void)
{
    for (size_t i = 0; i < pnb_method_count(); i++) {
        const pnb_method_info *method = pnb_method(i);
        bool preset = strcmp(method->name, pnb_default_method()) == 0;
        printf("%-20s %s%s\n", method->name, method->title, preset ? " (default)" : "");
        printf("%-20s %s; receivers: %s; lights: ", "", processor_name(method),
               receivers_name(method));
        print_lights(method);
        printf("\n");
        if (*method->paper)
            printf("%-20s %s\n", "", method->paper);
    }
}

int command_methods(int argc, char **argv)
{
    struct cli_options options;
    int result = cli_options_init(&command, argc, argv, &options);
    if (result != CLI_GO_ON)
        return result;

    const pnb_method_info *one = NULL;
    if (options.operand_count) {
        const char *name = options.operands[0];
        one = pnb_method_find(name);
        if (!one) {
            result = cli_usage_error("methods", name,
                                     "there is no such method; 'penumbra methods' lists them");
            cli_options_finish(&options);
            return result;
        }
    }
    if (options.json) {
        json_t *value;
        if (one) {
            value = method_json(one);
        } else {
            json_t *array = json_array();
            for (size_t i = 0; i < pnb_method_count(); i++)
                json_array_append_new(array, method_json(pnb_method(i)));
            value = json_pack("{s:o}", "methods", array);
        }
        result = cli_json_print(value);
    } else {
        if (one)
            print_method(one);
        else
            print_list();
        result = cli_flush();
    }
    cli_options_finish(&options);
    return result;
}
