/* method/registry.c: the table of methods. One line each; a method goes by deleting its line and
 * its room. */
#include <stdio.h>
#include <string.h>

#include "method/method.h"

static const struct method *const methods[] = {
    &method_reference,
    &method_exact,
    &method_planar,
    &method_dbuffer,
    &method_wedge,
    &method_wedge_probabilistic,
    &method_wedge_blend,
    &method_line_map,
    &method_sampled_maps,
    &method_hard_map,
    &method_hard_volume,
    &method_pcss,
};

static const char default_method[] = "exact";

size_t pnb_method_count(void)
{
    return sizeof(methods) / sizeof(*methods);
}

const pnb_method_info *pnb_method(size_t index)
{
    return index < pnb_method_count() ? &methods[index]->info : NULL;
}

const struct method *method_find(const char *name)
{
    for (size_t i = 0; i < pnb_method_count(); i++)
        if (strcmp(methods[i]->info.name, name) == 0)
            return methods[i];
    return NULL;
}

const pnb_method_info *pnb_method_find(const char *name)
{
    const struct method *method = name ? method_find(name) : NULL;
    return method ? &method->info : NULL;
}

static void list_if(bool (*can)(const pnb_method_info *info, unsigned bits), unsigned bits,
                    char *text, size_t size)
{
    size_t used = (size_t)snprintf(text, size, "none");
    bool first = true;
    for (size_t i = 0; i < pnb_method_count(); i++) {
        if (!can(pnb_method(i), bits))
            continue;
        used = first ? 0 : used;
        if (used < size)
            used += (size_t)snprintf(text + used, size - used, "%s%s", first ? "" : ", ",
                                     pnb_method(i)->name);
        first = false;
    }
}

static bool can_light(const pnb_method_info *info, unsigned bits)
{
    return (info->lights & bits) != 0;
}

static bool can_any_receiver(const pnb_method_info *info, unsigned bits)
{
    return info->receivers == PNB_RECEIVERS_ANY;
}

void method_list_lights(unsigned bits, char *text, size_t size)
{
    list_if(can_light, bits, text, size);
}

void method_list_any_receivers(char *text, size_t size)
{
    list_if(can_any_receiver, 0, text, size);
}

const char *pnb_default_method(void)
{
    return default_method;
}
