/* scene/write.h: what the writers of scene files and of GLB share. */
#ifndef SCENE_WRITE_H
#define SCENE_WRITE_H

#include "base/buffer.h"
#include "scene/scene.h"

/* world = translate x turn x scale, where the linear part is that (no shear, nothing flattened, to
 * 1e-6 of its size). turn: orthonormal, right-handed, row-major 3x3; a mirror goes into scale[2].
 */
struct write_placement {
    double scale[3], turn[9], translate[3];
};
bool write_decompose(const double world_from_mesh[12], struct write_placement *out);

/* The mesh's arrays moved into world space, for placements that are no such product. A mirror
 * turns the triangles round, so that they keep their front. The caller finishes it. */
pnb_status write_bake(pnb_context *context, const struct mesh *mesh,
                      const double world_from_mesh[12], struct mesh *out_mesh);

#endif
