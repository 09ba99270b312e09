/* scene/write.c: placements as the file formats can say them. */
#include "scene/write.h"

#include <string.h>

bool write_decompose(const double m[12], struct write_placement *out)
{
    vec3 column[3];
    for (int c = 0; c < 3; c++) {
        column[c] = v3(m[c], m[4 + c], m[8 + c]);
        out->scale[c] = v3_length(column[c]);
        out->translate[c] = m[4 * c + 3];
        if (!(out->scale[c] > 0) || !isfinite(out->scale[c]))
            return false;
    }
    if (m34_det(m) < 0)
        out->scale[2] = -out->scale[2];
    for (int c = 0; c < 3; c++) {
        column[c] = v3_scale(column[c], 1 / out->scale[c]);
        for (int row = 0; row < 3; row++)
            out->turn[3 * row + c] = row == 0 ? column[c].x : row == 1 ? column[c].y : column[c].z;
    }
    return fabs(v3_dot(column[0], column[1])) < 1e-6 && fabs(v3_dot(column[1], column[2])) < 1e-6 &&
           fabs(v3_dot(column[2], column[0])) < 1e-6;
}

pnb_status write_bake(pnb_context *context, const struct mesh *mesh, const double m[12],
                      struct mesh *out_mesh)
{
    pnb_mesh_desc desc = {mesh->name,         mesh->positions, mesh->normals,
                          mesh->vertex_count, mesh->indices,   mesh->triangle_count};
    pnb_status status = mesh_init(context, out_mesh, &desc);
    if (status != PNB_OK)
        return status;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        v3_storef(out_mesh->positions + 3 * i, m34_point(m, v3_loadf(mesh->positions + 3 * i)));
        if (mesh->normals)
            v3_storef(out_mesh->normals + 3 * i,
                      v3_normalize(m34_normal(m, v3_loadf(mesh->normals + 3 * i))));
    }
    for (size_t i = 0; i < mesh->triangle_count && m34_det(m) < 0; i++) {
        uint32_t *index = out_mesh->indices + 3 * i, swap = index[1];
        index[1] = index[2];
        index[2] = swap;
    }
    return PNB_OK;
}
