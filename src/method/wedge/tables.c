/* method/wedge/tables.c: the wedges' tables on the device.
 *
 *   items (world, 5 texels each)  ->  items in light space (4 texels)  ->  boxes of groups of 32
 *   tiles -> box of their receivers; coarse tiles: boxes of those
 *   coarse tiles: mask of parts, mask of groups, number of groups before each word of it, list of
 *   groups;  tiles: a mask of 32 items for each place of the list
 *
 * Everything long is folded into rows of 1,024 texels (FOLD in common.glsl). Memory: 144 bytes an
 * item; lists take coarse tiles x groups words, masks tiles x places of a list: coarse tiles grow
 * until the lists fit into LIST_BYTES, and places that find no room in MASK_BYTES have no mask
 * (all their items are tried), so both are bounded whatever the scene.
 */
#include "method/wedge/tables.h"

#include <string.h>

#define FOLD       1024
#define LIST_BYTES ((size_t)16 << 20)
#define MASK_BYTES ((size_t)24 << 20)
#define TILE       8
/* Pixels of pictures with tiles of half the size: theirs see more of the scene each. */
#define SMALL_PICTURE ((size_t)200000)
#define COARSE        4

static pnb_status make_texture(struct wedge_room *room, enum gl_format format, int width,
                               int height, const void *texels, struct gl_texture **texture)
{
    gl_texture_destroy(*texture);
    *texture = NULL;
    struct gl_texture_desc desc = {
        .format = format, .width = width, .height = height, .texels = texels};
    int most = gl_device_get_info(room->device)->max_texture_size;
    if (width > most || height > most)
        return status_fail(room->parts->context, PNB_ERROR_UNSUPPORTED, "wedge",
                           "more triangles than the device's textures hold");
    return gl_texture_create(room->device, &desc, texture);
}

static pnb_status make_table(struct wedge_room *room, enum gl_format format, int width, int height,
                             int count, struct wedge_table *table)
{
    pnb_status status = PNB_OK;
    struct gl_target_desc desc = {0};
    gl_target_destroy(table->target);
    table->target = NULL;
    table->count = count;
    for (int i = 0; i < count && status == PNB_OK; i++) {
        status = make_texture(room, format, width, height, NULL, &table->textures[i]);
        desc.colors[i].texture = table->textures[i];
    }
    return status == PNB_OK ? gl_target_create(room->device, &desc, &table->target) : status;
}

static int fold_rows(size_t count)
{
    size_t rows = (count + FOLD - 1) / FOLD;
    return rows < 1 ? 1 : rows > INT32_MAX ? INT32_MAX : (int)rows;
}

/* Items, texel by texel into their five tables. */
static pnb_status upload_items(struct wedge_room *room)
{
    const struct wedge_parts *parts = room->parts;
    size_t count = parts->group_count * WEDGE_GROUP;
    int rows = fold_rows(count);
    float *texels = memory_calloc(parts->context, (size_t)rows * FOLD, 4 * sizeof(float));
    if (!texels)
        return status_no_memory(parts->context, (size_t)rows * FOLD * 16);
    pnb_status status = PNB_OK;
    for (size_t k = 0; k < 5 && status == PNB_OK; k++) {
        for (size_t i = 0; i < count; i++)
            memcpy(texels + 4 * i, (const char *)&parts->items[i] + 16 * k, 16);
        status = make_texture(room, GL_FORMAT_RGBA32F, FOLD, rows, texels, &room->in[k]);
    }
    memory_free(parts->context, texels);
    return status == PNB_OK ? make_table(room, GL_FORMAT_RGBA32F, FOLD, rows, 4, &room->items)
                            : status;
}

static pnb_status upload_groups(struct wedge_room *room)
{
    const struct wedge_parts *parts = room->parts;
    int rows = fold_rows(parts->group_count);
    struct wedge_group *texels =
        memory_calloc(parts->context, (size_t)rows * FOLD, sizeof(*texels));
    if (!texels)
        return status_no_memory(parts->context, (size_t)rows * FOLD * sizeof(*texels));
    if (parts->group_count > 0)
        memcpy(texels, parts->groups, parts->group_count * sizeof(*texels));
    pnb_status status =
        make_texture(room, GL_FORMAT_RGBA32UI, FOLD, rows, texels, &room->group_info);
    memory_free(parts->context, texels);
    return status == PNB_OK ? make_table(room, GL_FORMAT_RGBA32F, FOLD, rows, 4, &room->group_box)
                            : status;
}

pnb_status wedge_tables_upload(struct wedge_room *room)
{
    pnb_context *context = room->parts->context;
    int rows = fold_rows(room->parts->part_count);
    pnb_status status = PNB_OK;
    room->width = 0; /* lists are made anew */
    room->uploaded = false;
    for (int k = 0; k < 2 && status == PNB_OK; k++) {
        memory_free(context, room->box_texels[k]);
        room->box_texels[k] = memory_calloc(context, (size_t)rows * FOLD, 4 * sizeof(float));
        if (!room->box_texels[k])
            return status_no_memory(context, (size_t)rows * FOLD * 16);
        status = make_texture(room, GL_FORMAT_RGBA32F, FOLD, rows, NULL, &room->part_box[k]);
    }
    if (status == PNB_OK)
        status = upload_items(room);
    if (status == PNB_OK)
        status = upload_groups(room);
    room->uploaded = status == PNB_OK;
    return status;
}

/* The box around the eight corners of each part's box. */
void wedge_tables_place(struct wedge_room *room, const struct wedge_light *light)
{
    const struct wedge_parts *parts = room->parts;
    for (size_t i = 0; i < parts->part_count; i++) {
        const struct wedge_part *part = &parts->parts[i];
        vec3 middle = wedge_light_from_world(light, v3_scale(v3_add(part->low, part->high), 0.5));
        vec3 half = v3_scale(v3_sub(part->high, part->low), 0.5);
        const vec3 *axes[3] = {&light->x_axis, &light->y_axis, &light->normal};
        double reach[3];
        for (int k = 0; k < 3; k++)
            reach[k] =
                fabs(axes[k]->x) * half.x + fabs(axes[k]->y) * half.y + fabs(axes[k]->z) * half.z;
        /* Outward by more than floats can be off. */
        vec3 r = v3(reach[0] + 1e-6 * (fabs(middle.x) + reach[0]),
                    reach[1] + 1e-6 * (fabs(middle.y) + reach[1]),
                    reach[2] + 1e-6 * (fabs(middle.z) + reach[2]));
        v3_storef(room->box_texels[0] + 4 * i, v3_sub(middle, r));
        v3_storef(room->box_texels[1] + 4 * i, v3_add(middle, r));
    }
    gl_texture_upload(room->part_box[0], 0, room->box_texels[0]);
    gl_texture_upload(room->part_box[1], 0, room->box_texels[1]);
}

/* Tile sizes, and how lists and masks are laid out. */
static void lay_out(struct wedge_room *room, int width, int height)
{
    size_t most = (size_t)gl_device_get_info(room->device)->max_texture_size;
    size_t groups = room->parts->group_count > 0 ? room->parts->group_count : 1;
    int least = (size_t)width * (size_t)height < SMALL_PICTURE ? TILE / 2 : TILE;
    int size = room->tile_wanted > 0 ? room->tile_wanted : least;
    room->words = (int)((groups + 31) / 32);
    for (;; size *= 2) {
        room->tile_size = size;
        room->tile_columns = (width + size - 1) / size;
        room->tile_rows = (height + size - 1) / size;
        for (room->coarse = COARSE;; room->coarse *= 2) {
            room->coarse_columns = (room->tile_columns + room->coarse - 1) / room->coarse;
            room->coarse_rows = (room->tile_rows + room->coarse - 1) / room->coarse;
            size_t tiles = (size_t)room->coarse_columns * (size_t)room->coarse_rows;
            size_t list_width = groups < most ? groups : most;
            size_t rows = (groups + list_width - 1) / list_width;
            room->list_rows = (int)rows;
            room->list_width = (int)((groups + rows - 1) / rows);
            if ((tiles * groups * sizeof(uint32_t) <= LIST_BYTES && tiles * rows <= most) ||
                tiles == 1)
                break;
        }
        size_t tiles = (size_t)room->tile_columns * (size_t)room->tile_rows;
        size_t places = MASK_BYTES / sizeof(uint32_t) / tiles;
        places = places < groups ? places : groups;
        room->mask_width = (int)(places < most ? places : most);
        if ((tiles <= most && room->mask_width > 0) || tiles == 1)
            break;
    }
}

pnb_status wedge_tables_resize(struct wedge_room *room, int width, int height)
{
    if (room->width == width && room->height == height)
        return PNB_OK;
    room->width = room->height = 0;
    lay_out(room, width, height);
    int part_words = (int)((room->parts->part_count + 31) / 32);
    int tiles = room->tile_columns * room->tile_rows;
    int coarse = room->coarse_columns * room->coarse_rows;
    const struct {
        struct wedge_table *table;
        enum gl_format format;
        int width, height, count;
    } tables[] = {
        {&room->tile_box, GL_FORMAT_RGBA32F, room->tile_columns, room->tile_rows, 2},
        {&room->coarse_box, GL_FORMAT_RGBA32F, room->coarse_columns, room->coarse_rows, 2},
        {&room->part_mask, GL_FORMAT_R32UI, part_words < 1 ? 1 : part_words, coarse, 1},
        {&room->hits, GL_FORMAT_R32UI, room->words, coarse, 1},
        {&room->prefix, GL_FORMAT_R32UI, room->words + 1, coarse, 1},
        {&room->list, GL_FORMAT_R32UI, room->list_width, room->list_rows * coarse, 1},
        {&room->mask, GL_FORMAT_R32UI, room->mask_width, tiles, 1},
    };
    pnb_status status = PNB_OK;
    for (size_t i = 0; i < sizeof(tables) / sizeof(*tables) && status == PNB_OK; i++)
        status = make_table(room, tables[i].format, tables[i].width, tables[i].height,
                            tables[i].count, tables[i].table);
    if (status != PNB_OK)
        return status;
    room->width = width;
    room->height = height;
    return PNB_OK;
}

static size_t texture_bytes(const struct gl_texture *texture)
{
    return texture ? gl_texture_bytes(texture) : 0;
}

static size_t table_bytes(const struct wedge_table *table)
{
    size_t bytes = 0;
    for (int k = 0; k < table->count; k++)
        bytes += texture_bytes(table->textures[k]);
    return bytes;
}

void wedge_tables_bytes(const struct wedge_room *room, size_t *out_lists, size_t *out_items)
{
    *out_lists = table_bytes(&room->tile_box) + table_bytes(&room->coarse_box) +
                 table_bytes(&room->part_mask) + table_bytes(&room->hits) +
                 table_bytes(&room->prefix) + table_bytes(&room->list) + table_bytes(&room->mask);
    *out_items = table_bytes(&room->items) + table_bytes(&room->group_box) +
                 texture_bytes(room->group_info) + texture_bytes(room->part_box[0]) +
                 texture_bytes(room->part_box[1]);
    for (int k = 0; k < 5; k++)
        *out_items += texture_bytes(room->in[k]);
}

void wedge_tables_finish(struct wedge_room *room)
{
    struct wedge_table *tables[] = {&room->items,      &room->group_box, &room->tile_box,
                                    &room->coarse_box, &room->part_mask, &room->hits,
                                    &room->prefix,     &room->list,      &room->mask};
    for (size_t i = 0; i < sizeof(tables) / sizeof(*tables); i++) {
        gl_target_destroy(tables[i]->target);
        for (int k = 0; k < 4; k++)
            gl_texture_destroy(tables[i]->textures[k]);
    }
    for (int k = 0; k < 5; k++)
        gl_texture_destroy(room->in[k]);
    gl_texture_destroy(room->group_info);
    for (int k = 0; k < 2; k++) {
        gl_texture_destroy(room->part_box[k]);
        if (room->parts)
            memory_free(room->parts->context, room->box_texels[k]);
    }
}
