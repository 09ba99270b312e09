/* method/planar/write_mesh.c: the shadow for 3-D programs: OBJ, PLY, GLB. World space, metres.
 *
 * In all three the shadow lies `lift` above its plane. GLB: one mesh per receiver plane, named
 * after it, black and unlit (KHR_materials_unlit), COLOR_0 = (0, 0, 0, intensity) with alpha
 * blending: multiplied into what lies below as 1 - intensity = visibility, it darkens by the light
 * that is missing.
 */
#include <stdio.h>
#include <string.h>

#include "method/planar/shadow.h"

/* The plane that a vertex belongs to: vertices of a plane come in one run, like its triangles. */
static size_t first_vertex(const struct pnb_shadow *s, size_t plane)
{
    if (plane == s->view.plane_count)
        return s->view.vertex_count;
    uint32_t t = s->first_triangles[plane];
    return t < s->view.triangle_count ? s->indices[3 * (size_t)t] : s->view.vertex_count;
}

static void lifted(const struct pnb_shadow *s, size_t plane, size_t vertex, double lift, float *out)
{
    v3_storef(out, v3_mad(v3_loadf(s->positions + 3 * vertex), s->sheets[plane].frame.n, lift));
}

/* "shadow-" and the receiver's name, or its number; no control characters. */
static void name_plane(const struct pnb_shadow *s, size_t plane, char *out, size_t size)
{
    const char *name = s->solver->scene->objects[s->planes[plane]].info.name;
    if (name && *name)
        snprintf(out, size, "shadow-%s", name);
    else
        snprintf(out, size, "shadow-%zu", plane);
    for (char *c = out; *c; c++)
        *c = (unsigned char)*c < ' ' ? ' ' : *c;
}

pnb_status shadow_write_obj(const struct pnb_shadow *s, double lift, struct buffer *file)
{
    buffer_print(file, "# soft shadow: vertex colour is 1 - shadow intensity (x y z r g b)\n");
    for (size_t p = 0; p < s->view.plane_count; p++)
        for (size_t i = first_vertex(s, p); i < first_vertex(s, p + 1); i++) {
            float at[3], grey = 1 - s->intensities[i];
            lifted(s, p, i, lift, at);
            buffer_print(file, "v %.9g %.9g %.9g %.6g %.6g %.6g\n", at[0], at[1], at[2], grey, grey,
                         grey);
        }
    for (size_t p = 0; p < s->view.plane_count; p++) {
        char name[256];
        name_plane(s, p, name, sizeof(name));
        buffer_print(file, "o %s\n", name);
        for (size_t t = s->first_triangles[p]; t < s->first_triangles[p + 1]; t++)
            buffer_print(file, "f %u %u %u\n", s->indices[3 * t] + 1, s->indices[3 * t + 1] + 1,
                         s->indices[3 * t + 2] + 1);
    }
    return PNB_OK;
}

pnb_status shadow_write_ply(const struct pnb_shadow *s, double lift, struct buffer *file)
{
    buffer_print(
        file,
        "ply\nformat binary_little_endian 1.0\ncomment soft shadow: intensity 0 lit, 1 umbra\n"
        "element vertex %zu\nproperty float x\nproperty float y\nproperty float z\n"
        "property float intensity\nproperty uchar red\nproperty uchar green\n"
        "property uchar blue\nproperty uchar alpha\n"
        "element face %zu\nproperty list uchar uint vertex_indices\nend_header\n",
        s->view.vertex_count, s->view.triangle_count);
    for (size_t p = 0; p < s->view.plane_count; p++)
        for (size_t i = first_vertex(s, p); i < first_vertex(s, p + 1); i++) {
            struct {
                float at[3], intensity;
                uint8_t color[4];
            } v = {.intensity = s->intensities[i]};
            lifted(s, p, i, lift, v.at);
            v.color[3] = (uint8_t)(255 * fminf(1, fmaxf(0, v.intensity)) + 0.5f);
            buffer_add(file, &v, sizeof(v));
        }
    for (size_t t = 0; t < s->view.triangle_count; t++) {
        uint8_t three = 3;
        buffer_add(file, &three, 1);
        buffer_add(file, s->indices + 3 * t, 3 * sizeof(uint32_t));
    }
    return PNB_OK;
}

static void pad(struct buffer *b, char with)
{
    while (b->size % 4 != 0 && !b->failed)
        buffer_add(b, &with, 1);
}

pnb_status shadow_write_glb(const struct pnb_shadow *s, double lift, struct buffer *file)
{
    struct buffer json, data;
    buffer_init(s->context, &json);
    buffer_init(s->context, &data);
    buffer_print(&json,
                 "{\"asset\":{\"version\":\"2.0\",\"generator\":\"penumbra " PNB_VERSION
                 "\"},\"extensionsUsed\":[\"KHR_materials_unlit\"],\"scene\":0,\"scenes\":[{");
    /* Per plane that has triangles: a node with a mesh of positions, colours, indices. */
    struct buffer numbers, nodes, meshes, views, accessors;
    struct buffer *parts[] = {&numbers, &nodes, &meshes, &views, &accessors};
    for (int i = 0; i < 5; i++)
        buffer_init(s->context, parts[i]);
    int n = 0;
    for (size_t p = 0; p < s->view.plane_count; p++) {
        size_t t0 = s->first_triangles[p], t1 = s->first_triangles[p + 1];
        if (t0 == t1)
            continue;
        size_t v0 = first_vertex(s, p), v1 = v0, vertices;
        for (size_t i = 3 * t0; i < 3 * t1; i++)
            v1 = s->indices[i] + 1 > v1 ? s->indices[i] + 1 : v1;
        vertices = v1 - v0;
        float lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
        size_t at[3];
        at[0] = data.size;
        for (size_t i = v0; i < v1; i++) {
            float x[3];
            lifted(s, p, i, lift, x);
            for (int k = 0; k < 3; k++) {
                lo[k] = fminf(lo[k], x[k]);
                hi[k] = fmaxf(hi[k], x[k]);
            }
            buffer_add(&data, x, sizeof(x));
        }
        at[1] = data.size;
        for (size_t i = v0; i < v1; i++) {
            float color[4] = {0, 0, 0, fminf(1, fmaxf(0, s->intensities[i]))};
            buffer_add(&data, color, sizeof(color));
        }
        at[2] = data.size;
        for (size_t i = 3 * t0; i < 3 * t1; i++) {
            uint32_t index = (uint32_t)(s->indices[i] - v0);
            buffer_add(&data, &index, sizeof(index));
        }
        const char *comma = n ? "," : "";
        char name[256];
        name_plane(s, p, name, sizeof(name));
        buffer_print(&numbers, "%s%d", comma, n / 3);
        buffer_print(&nodes, "%s{\"name\":", comma);
        buffer_json_string(&nodes, name);
        buffer_print(&nodes, ",\"mesh\":%d}", n / 3);
        buffer_print(&meshes, "%s{\"name\":", comma);
        buffer_json_string(&meshes, name);
        buffer_print(&meshes,
                     ",\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"COLOR_0\":%d},"
                     "\"indices\":%d,\"material\":0}]}",
                     n, n + 1, n + 2);
        buffer_print(&views,
                     "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"target\":34962},"
                     "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"target\":34962},"
                     "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"target\":34963}",
                     comma, at[0], 12 * vertices, at[1], 16 * vertices, at[2], 12 * (t1 - t0));
        buffer_print(&accessors, "%s{\"bufferView\":%d,\"componentType\":5126,\"count\":%zu,",
                     comma, n, vertices);
        buffer_print(&accessors,
                     "\"type\":\"VEC3\",\"min\":[%.9g,%.9g,%.9g],\"max\":[%.9g,%.9g,%.9g]},", lo[0],
                     lo[1], lo[2], hi[0], hi[1], hi[2]);
        buffer_print(&accessors,
                     "{\"bufferView\":%d,\"componentType\":5126,\"count\":%zu,\"type\":\"VEC4\"},"
                     "{\"bufferView\":%d,\"componentType\":5125,\"count\":%zu,\"type\":\"SCALAR\"}",
                     n + 1, vertices, n + 2, 3 * (t1 - t0));
        n += 3;
    }
    if (n == 0)
        buffer_print(&json, "\"name\":\"no shadow\"}]");
    if (n > 0) {
        buffer_print(&json, "\"nodes\":[");
        buffer_add(&json, numbers.bytes, numbers.size);
        buffer_print(&json, "]}],\"nodes\":[");
        buffer_add(&json, nodes.bytes, nodes.size);
        buffer_print(&json, "],\"meshes\":[");
        buffer_add(&json, meshes.bytes, meshes.size);
        buffer_print(&json,
                     "],\"materials\":[{\"name\":\"shadow\",\"alphaMode\":\"BLEND\","
                     "\"doubleSided\":true,\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,0,0,1],"
                     "\"metallicFactor\":0,\"roughnessFactor\":1},"
                     "\"extensions\":{\"KHR_materials_unlit\":{}}}],\"bufferViews\":[");
        buffer_add(&json, views.bytes, views.size);
        buffer_print(&json, "],\"accessors\":[");
        buffer_add(&json, accessors.bytes, accessors.size);
        buffer_print(&json, "],\"buffers\":[{\"byteLength\":%zu}]", data.size);
    }
    buffer_print(&json, "}");
    pad(&json, ' ');
    uint32_t head[5] = {0x46546c67u, 2, (uint32_t)(12 + 8 + json.size + (n ? 8 + data.size : 0)),
                        (uint32_t)json.size, 0x4e4f534au};
    buffer_add(file, head, sizeof(head));
    buffer_add(file, json.bytes, json.size);
    if (n > 0) {
        uint32_t chunk[2] = {(uint32_t)data.size, 0x004e4942u};
        buffer_add(file, chunk, sizeof(chunk));
        buffer_add(file, data.bytes, data.size);
    }
    file->failed |= json.failed || data.failed;
    for (int i = 0; i < 5; i++) {
        file->failed |= parts[i]->failed;
        buffer_finish(parts[i]);
    }
    buffer_finish(&json);
    buffer_finish(&data);
    return PNB_OK;
}
