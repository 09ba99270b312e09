/* trace/trace.h: primary hits and shadow rays. The only folder that includes Embree. */
#ifndef TRACE_TRACE_H
#define TRACE_TRACE_H

#include "base/base.h"
#include "scene/scene.h"

struct trace;

/* A hierarchy over the scene's objects in world space. casters_only: leave out objects that cast no
 * shadow. Built in parallel by Embree. */
pnb_status trace_create(pnb_scene *scene, bool casters_only, struct trace **out_trace);
void trace_destroy(struct trace *trace);

#endif
