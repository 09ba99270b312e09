/* scene/import_stream.c: decodes the importer's answer. The importer may have gone wrong in any
 * way, so every count is held against the bytes that are there before it is used: no allocation is
 * larger than a small multiple of the answer. O(size) without touching the arrays' content. */
#include "scene/import_stream.h"

#include <string.h>

#include "scene/import.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "the importer's answer is little-endian and used where it lies"
#endif

struct reader {
    pnb_context *context;
    const unsigned char *at;
    size_t left;
    bool broken;
};

/* The next size bytes, or NULL. */
static const unsigned char *take(struct reader *reader, size_t size)
{
    if (size > reader->left) {
        reader->broken = true;
        return NULL;
    }
    const unsigned char *p = reader->at;
    reader->at += size;
    reader->left -= size;
    return p;
}

static const void *take_array(struct reader *reader, size_t count, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes)) {
        reader->broken = true;
        return NULL;
    }
    return take(reader, bytes);
}

static uint32_t take_u32(struct reader *reader)
{
    uint32_t value = 0;
    const unsigned char *p = take(reader, sizeof(value));
    if (p)
        memcpy(&value, p, sizeof(value));
    return value;
}

static void take_numbers(struct reader *reader, double *values, size_t count)
{
    const unsigned char *p = take(reader, count * sizeof(*values));
    if (p)
        memcpy(values, p, count * sizeof(*values));
    else
        memset(values, 0, count * sizeof(*values));
}

/* Length of the UTF-8 character at p of at most left bytes; 0: none begins here. */
static size_t utf8_length(const unsigned char *p, size_t left)
{
    size_t length = p[0] < 0x80 ? 1 : (p[0] & 0xe0) == 0xc0 ? 2 : (p[0] & 0xf0) == 0xe0 ? 3 : 4;
    static const uint32_t least[5] = {0, 0, 0x80, 0x800, 0x10000};
    if (p[0] < 0x20 || p[0] == 0x7f || (p[0] >= 0x80 && p[0] < 0xc2) || p[0] > 0xf4 ||
        length > left)
        return 0;
    uint32_t code = length == 1 ? p[0] : p[0] & (0x7fu >> length);
    for (size_t i = 1; i < length; i++) {
        if ((p[i] & 0xc0) != 0x80)
            return 0;
        code = code << 6 | (p[i] & 0x3f);
    }
    if (length > 1 &&
        (code < least[length] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)))
        return 0;
    return length;
}

/* Valid UTF-8 without control characters, whatever came; the caller's memory. NULL: broken, or no
 * memory (then the error is set). */
static char *take_text(struct reader *reader)
{
    size_t length = take_u32(reader);
    if (length > IMPORT_TEXT_MAX) {
        reader->broken = true;
        return NULL;
    }
    const unsigned char *p = take(reader, (length + 3) / 4 * 4);
    if (!p)
        return NULL;
    char *text = memory_calloc(reader->context, length + 1, 1);
    if (!text) {
        status_no_memory(reader->context, length + 1);
        return NULL;
    }
    for (size_t i = 0; i < length;) {
        size_t n = utf8_length(p + i, length - i);
        if (n == 0)
            text[i++] = '?';
        for (; n > 0; n--, i++)
            text[i] = (char)p[i];
    }
    return text;
}

/* Room for one more; false: no memory. */
static bool grow(struct reader *reader, void **array, size_t *capacity, size_t count, size_t size)
{
    if (memory_reserve(reader->context, array, capacity, count, 1, size))
        return true;
    status_no_memory(reader->context, size * (count + 1));
    return false;
}

/* Each of these appends what one record says; false: broken, or no memory. */
static bool read_mesh(struct reader *reader, struct scene_import_data *data)
{
    struct scene_import_mesh mesh = {.name = take_text(reader)};
    mesh.vertex_count = take_u32(reader);
    mesh.triangle_count = take_u32(reader);
    uint32_t flags = take_u32(reader);
    mesh.positions = take_array(reader, mesh.vertex_count, 3 * sizeof(float));
    if (flags & IMPORT_HAS_NORMALS)
        mesh.normals = take_array(reader, mesh.vertex_count, 3 * sizeof(float));
    mesh.indices = take_array(reader, mesh.triangle_count, 3 * sizeof(uint32_t));
    if (!mesh.name || reader->broken ||
        !grow(reader, (void **)&data->meshes, &data->mesh_capacity, data->mesh_count,
              sizeof(mesh))) {
        memory_free(reader->context, mesh.name);
        return false;
    }
    data->meshes[data->mesh_count++] = mesh;
    return true;
}

static bool read_object(struct reader *reader, struct scene_import_data *data)
{
    struct scene_import_object object = {.name = take_text(reader)};
    object.mesh = take_u32(reader);
    uint32_t flags = take_u32(reader);
    object.double_sided = flags & IMPORT_DOUBLE_SIDED;
    object.casts = !(flags & IMPORT_CASTS_NOT);
    object.receives = !(flags & IMPORT_RECEIVES_NOT);
    object.plane = flags & IMPORT_PLANE;
    take_numbers(reader, object.world_from_mesh, 12);
    take_numbers(reader, object.color, 3);
    take_numbers(reader, object.emission, 3);
    if (object.mesh >= data->mesh_count)
        reader->broken = true;
    if (!object.name || reader->broken ||
        !grow(reader, (void **)&data->objects, &data->object_capacity, data->object_count,
              sizeof(object))) {
        memory_free(reader->context, object.name);
        return false;
    }
    data->objects[data->object_count++] = object;
    return true;
}

static bool read_camera(struct reader *reader, struct scene_import_data *data)
{
    struct scene_import_camera camera;
    char *name = take_text(reader);
    take_numbers(reader, camera.eye, 3);
    take_numbers(reader, camera.direction, 3);
    take_numbers(reader, camera.up, 3);
    take_numbers(reader, &camera.vertical_fov_degrees, 1);
    bool fine = name && !reader->broken;
    memory_free(reader->context, name);
    if (!fine || !grow(reader, (void **)&data->cameras, &data->camera_capacity, data->camera_count,
                       sizeof(camera)))
        return false;
    data->cameras[data->camera_count++] = camera;
    return true;
}

static bool read_light(struct reader *reader, struct scene_import_data *data)
{
    char *name = take_text(reader);
    pnb_light light = {.name = name, .type = (pnb_light_type)take_u32(reader)};
    double shape[9];
    take_u32(reader);
    take_numbers(reader, light.color, 3);
    take_numbers(reader, shape, 9);
    switch (light.type) {
    case PNB_LIGHT_RECTANGLE:
        memcpy(light.shape.rectangle.center, shape, 24);
        memcpy(light.shape.rectangle.half_u, shape + 3, 24);
        memcpy(light.shape.rectangle.half_v, shape + 6, 24);
        break;
    case PNB_LIGHT_DISK:
        memcpy(light.shape.disk.center, shape, 24);
        memcpy(light.shape.disk.normal, shape + 3, 24);
        light.shape.disk.radius = shape[6];
        break;
    case PNB_LIGHT_POINT: memcpy(light.shape.point.position, shape, 24); break;
    case PNB_LIGHT_SUN:
        memcpy(light.shape.sun.direction, shape, 24);
        light.shape.sun.angular_diameter_degrees = shape[3];
        break;
    default: reader->broken = true; break;
    }
    if (!name || reader->broken ||
        !grow(reader, (void **)&data->lights, &data->light_capacity, data->light_count,
              sizeof(light))) {
        memory_free(reader->context, name);
        return false;
    }
    data->lights[data->light_count++] = light;
    return true;
}

static bool read_note(struct reader *reader, struct scene_import_data *data)
{
    char *note = take_text(reader);
    if (!note || !grow(reader, (void **)&data->notes, &data->note_capacity, data->note_count,
                       sizeof(note))) {
        memory_free(reader->context, note);
        return false;
    }
    data->notes[data->note_count++] = note;
    return true;
}

static bool read_surroundings(struct reader *reader, struct scene_import_data *data)
{
    take_numbers(reader, data->ambient, 3);
    take_numbers(reader, data->background, 3);
    data->has_surroundings = true;
    return !reader->broken;
}

static bool read_record(struct reader *reader, uint32_t kind, struct scene_import_data *data)
{
    switch (kind) {
    case IMPORT_MESH: return read_mesh(reader, data);
    case IMPORT_OBJECT: return read_object(reader, data);
    case IMPORT_CAMERA: return read_camera(reader, data);
    case IMPORT_LIGHT: return read_light(reader, data);
    case IMPORT_NOTE: return read_note(reader, data);
    case IMPORT_SURROUNDINGS: return read_surroundings(reader, data);
    default: reader->broken = true; return false;
    }
}

pnb_status scene_import_decode(pnb_context *context, const char *file, const unsigned char *bytes,
                               size_t size, struct scene_import_data *out_data)
{
    struct reader reader = {context, bytes, size, false};
    memset(out_data, 0, sizeof(*out_data));
    const unsigned char *magic = take(&reader, 8);
    if (!magic || memcmp(magic, IMPORT_MAGIC, 8) != 0)
        return status_fail(context, PNB_ERROR_FORMAT, file, "the importer's answer is none");
    uint32_t version = take_u32(&reader);
    take_u32(&reader);
    if (version != IMPORT_VERSION)
        return status_fail(context, PNB_ERROR_FORMAT, file,
                           "the importer is of another version (%u, not %u)", version,
                           IMPORT_VERSION);
    for (;;) {
        size_t offset = size - reader.left;
        uint32_t kind = take_u32(&reader);
        uint64_t length = 0;
        take_u32(&reader);
        const unsigned char *p = take(&reader, sizeof(length));
        if (p)
            memcpy(&length, p, sizeof(length));
        if (!reader.broken && kind == IMPORT_END && length == 0 && reader.left == 0)
            return PNB_OK;

        /* A record is read within its own bounds, and must fill them. */
        struct reader record = reader;
        record.left = length;
        if (reader.broken || length > reader.left || length % 4 != 0 ||
            !read_record(&record, kind, out_data) || record.left != 0) {
            bool memory = !reader.broken && !record.broken && length <= reader.left &&
                          length % 4 == 0 && record.left == 0;
            scene_import_data_finish(context, out_data);
            if (memory)
                return PNB_ERROR_MEMORY;
            return status_fail(context, PNB_ERROR_FORMAT, file,
                               "the importer's answer is broken at byte %zu", offset);
        }
        take(&reader, length);
    }
}

void scene_import_data_finish(pnb_context *context, struct scene_import_data *data)
{
    for (size_t i = 0; i < data->mesh_count; i++)
        memory_free(context, data->meshes[i].name);
    for (size_t i = 0; i < data->object_count; i++)
        memory_free(context, data->objects[i].name);
    for (size_t i = 0; i < data->light_count; i++)
        memory_free(context, (char *)data->lights[i].name);
    for (size_t i = 0; i < data->note_count; i++)
        memory_free(context, data->notes[i]);
    memory_free(context, data->meshes);
    memory_free(context, data->objects);
    memory_free(context, data->cameras);
    memory_free(context, data->lights);
    memory_free(context, data->notes);
    memset(data, 0, sizeof(*data));
}
