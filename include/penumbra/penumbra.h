/* penumbra.h: the whole public interface. Soft shadows from area lights that can be measured.
 *
 * One header per concept; include this one, or only what is needed:
 *   context.h     errors, log, memory, threads, progress
 *   scene.h       meshes, objects, lights, camera; scene files, imported files, built-in scenes
 *   light.h       the shapes of lights, their samples and their unshadowed irradiance
 *   surface.h     the visible surface of each pixel: the receivers of a frame
 *   method.h      methods (what they can do) and solvers (a method at work on a scene)
 *   shadow.h      shadows on planes as geometry, and its files: OBJ, PLY, GLB, SVG, PDF, GeoJSON
 *   planar.h      the sweep by itself: directed edges to regions by winding number, triangles
 *   image.h       float images, PNG, EXR, PFM, error maps
 *   measure.h     visibility against truth: the error figures
 *
 * Conventions: right-handed, Y up, metres; angles in degrees or radians as the name says. Points
 * and directions are world space unless the name says otherwise. Descriptors work zero-initialised:
 * a zero means "the default". Every function that can fail returns pnb_status, and the context then
 * holds one line of text: pnb_context_error(). create/destroy own memory, and destroy(NULL) is
 * fine. NULL for data that is needed is PNB_ERROR_ARGUMENT; a NULL object (context, scene, solver,
 * ...) that a call is made on, or a NULL result pointer, is not looked for.
 */
#ifndef PENUMBRA_PENUMBRA_H
#define PENUMBRA_PENUMBRA_H

#include <penumbra/context.h>
#include <penumbra/image.h>
#include <penumbra/light.h>
#include <penumbra/measure.h>
#include <penumbra/method.h>
#include <penumbra/planar.h>
#include <penumbra/scene.h>
#include <penumbra/shadow.h>
#include <penumbra/surface.h>

#endif
