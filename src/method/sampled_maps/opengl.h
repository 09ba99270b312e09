/* method/sampled_maps/opengl.h: the OpenGL path of sampled-maps and hard-map. */
#ifndef METHOD_SAMPLED_MAPS_OPENGL_H
#define METHOD_SAMPLED_MAPS_OPENGL_H

#include "method/opengl.h"

extern const struct opengl_method sampled_maps_opengl;

#endif
