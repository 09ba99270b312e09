/* unbuilt.c: weak stand-ins for what is not written yet, so that everything links. Goes away. */
#include <penumbra/penumbra.h>

#include "light/light.h"
#include "method/method.h"
#include "scene/scene.h"
#include "trace/trace.h"

#pragma GCC diagnostic ignored "-Wmissing-prototypes"
#define WEAK __attribute__((weak))
#define FAIL(c) return status_fail((c), PNB_ERROR_UNSUPPORTED, __func__, "not built yet")

