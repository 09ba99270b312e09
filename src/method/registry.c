/* method/registry.c: the table of methods. One line each; a method goes by deleting its line and
 * its room. */
#include <string.h>

#include "method/method.h"

static const struct method *const methods[] = {
    &method_reference,
    &method_exact,
    &method_planar,
};

static const char default_method[] = "reference";

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

const char *pnb_default_method(void)
{
    return default_method;
}
