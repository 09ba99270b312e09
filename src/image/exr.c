/* image/exr.c: OpenEXR through its C core, from and to memory.
 *
 * Written: one part of scanlines, 32-bit float channels of any names, ZIP. The format wants the
 * channels sorted by name; so they are here. Read: the first part, scanlines or tiles, any of the
 * lossless and lossy compressions, half, float and integer channels. Which channels: "visibility";
 * else R, G, B; else those of the one layer that has "LAYER.R", "LAYER.G", "LAYER.B" (of several:
 * the first whose name ends in "Combined", as Blender calls its picture, else the first); else a
 * single channel. The image is the data window. NaN survives both ways.
 *
 * A broken file may put the decoder into any state that its error codes describe: every call is
 * checked, no chunk is reconstructed by guessing, and each chunk's place is checked here before
 * the decoder is handed a pointer into our pixels. */
#include "image/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <OpenEXR/openexr.h>

/* What the stream callbacks see. */
struct exr_memory {
    pnb_context *context;
    uint8_t *bytes;
    size_t size, capacity;
    bool no_memory;
    char text[200]; /* the last complaint of the library */
};

static struct exr_memory *memory_of(exr_const_context_t exr)
{
    void *user = NULL;
    return exr_get_user_data(exr, &user) == EXR_ERR_SUCCESS ? user : NULL;
}

static void note_error(exr_const_context_t exr, exr_result_t code, const char *text)
{
    struct exr_memory *memory = exr ? memory_of(exr) : NULL;
    if (memory && text && !memory->text[0]) {
        /* Its texts may begin with the file's name in quotes; ours has it already. */
        const char *at = strstr(text, "': ");
        snprintf(memory->text, sizeof(memory->text), "%s", at ? at + 3 : text);
    }
}

static int64_t write_bytes(exr_const_context_t exr, void *user, const void *buffer, uint64_t size,
                           uint64_t offset, exr_stream_error_func_ptr_t error)
{
    struct exr_memory *memory = user;
    uint64_t end = offset + size;
    if (end > memory->size) {
        if (!memory_reserve(memory->context, (void **)&memory->bytes, &memory->capacity,
                            memory->size, (size_t)end - memory->size, 1)) {
            memory->no_memory = true;
            return -1;
        }
        memset(memory->bytes + memory->size, 0, (size_t)end - memory->size);
        memory->size = (size_t)end;
    }
    memcpy(memory->bytes + offset, buffer, (size_t)size);
    return (int64_t)size;
}

static int64_t read_bytes(exr_const_context_t exr, void *user, void *buffer, uint64_t size,
                          uint64_t offset, exr_stream_error_func_ptr_t error)
{
    struct exr_memory *memory = user;
    if (offset >= memory->size)
        return 0;
    if (size > memory->size - offset)
        size = memory->size - offset;
    memcpy(buffer, memory->bytes + offset, (size_t)size);
    return (int64_t)size;
}

static int64_t byte_count(exr_const_context_t exr, void *user)
{
    struct exr_memory *memory = user;
    return (int64_t)memory->size;
}

static pnb_status exr_fail(pnb_context *context, const char *path, const char *did,
                           const struct exr_memory *memory, exr_result_t result)
{
    if (memory->no_memory || result == EXR_ERR_OUT_OF_MEMORY)
        return status_fail(context, PNB_ERROR_MEMORY, path, "no memory left");
    return status_fail(context, PNB_ERROR_FORMAT, path, "%s: %s", did,
                       memory->text[0] ? memory->text : exr_get_default_error_message(result));
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const pnb_channel *)a)->name, ((const pnb_channel *)b)->name);
}

static exr_result_t write_chunks(exr_context_t exr, int width, int height,
                                 const pnb_channel *channels)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t lines = 0;
    exr_result_t result = exr_get_scanlines_per_chunk(exr, 0, &lines);
    for (int y = 0; y < height && result == EXR_ERR_SUCCESS; y += lines) {
        exr_chunk_info_t chunk = {0};
        result = exr_write_scanline_chunk_info(exr, 0, y, &chunk);
        if (result == EXR_ERR_SUCCESS)
            result = y == 0 ? exr_encoding_initialize(exr, 0, &chunk, &pipe)
                            : exr_encoding_update(exr, 0, &chunk, &pipe);
        if (result != EXR_ERR_SUCCESS)
            break;
        /* The library's channels are sorted by name, like ours. */
        for (int c = 0; c < pipe.channel_count; c++) {
            size_t stride = channels[c].stride ? channels[c].stride : 1;
            const float *from = channels[c].data + (size_t)y * (size_t)width * stride;
            pipe.channels[c].user_data_type = EXR_PIXEL_FLOAT;
            pipe.channels[c].user_bytes_per_element = 4;
            pipe.channels[c].user_pixel_stride = (int32_t)(stride * 4);
            pipe.channels[c].user_line_stride = (int32_t)(stride * 4 * (size_t)width);
            pipe.channels[c].encode_from_ptr = (const uint8_t *)from;
        }
        if (y == 0)
            result = exr_encoding_choose_default_routines(exr, 0, &pipe);
        if (result == EXR_ERR_SUCCESS)
            result = exr_encoding_run(exr, 0, &pipe);
    }
    exr_encoding_destroy(exr, &pipe);
    return result;
}

static pnb_status check_channels(pnb_context *context, const char *path, int width, int height,
                                 const pnb_channel *channels, size_t count)
{
    if (width < 1 || height < 1 || (size_t)width > IMAGE_PIXELS_MAX / (size_t)height)
        return status_fail(context, PNB_ERROR_ARGUMENT, path, "size %d x %d cannot be written",
                           width, height);
    if (count < 1 || count > 1024)
        return status_fail(context, PNB_ERROR_ARGUMENT, path,
                           "%zu channels; 1 to 1024 can be written", count);
    for (size_t c = 0; c < count; c++) {
        size_t length = strlen(channels[c].name);
        if (length < 1 || length > 31)
            return status_fail(context, PNB_ERROR_ARGUMENT, path,
                               "channel name \"%s\": 1 to 31 bytes are possible", channels[c].name);
        if (channels[c].stride * 4 * (size_t)width > INT32_MAX)
            return status_fail(context, PNB_ERROR_ARGUMENT, path, "a row is too long");
        if (c > 0 && strcmp(channels[c].name, channels[c - 1].name) == 0)
            return status_fail(context, PNB_ERROR_ARGUMENT, path, "two channels named \"%s\"",
                               channels[c].name);
    }
    return PNB_OK;
}

pnb_status exr_encode(pnb_context *context, const char *path, int width, int height,
                      const pnb_channel *channels, size_t channel_count, uint8_t **out_bytes,
                      size_t *out_size)
{
    *out_bytes = NULL;
    *out_size = 0;
    pnb_channel *sorted = memory_alloc(context, channel_count, sizeof(*sorted));
    if (!sorted)
        return status_no_memory(context, channel_count * sizeof(*sorted));
    memcpy(sorted, channels, channel_count * sizeof(*sorted));
    qsort(sorted, channel_count, sizeof(*sorted), by_name);
    pnb_status status = check_channels(context, path, width, height, sorted, channel_count);
    if (status != PNB_OK) {
        memory_free(context, sorted);
        return status;
    }

    struct exr_memory memory = {.context = context};
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = note_error;
    init.user_data = &memory;
    init.write_fn = write_bytes;
    exr_context_t exr = NULL;
    int part = 0;
    exr_result_t result = exr_start_write(&exr, "exr", EXR_WRITE_FILE_DIRECTLY, &init);
    if (result == EXR_ERR_SUCCESS)
        result = exr_add_part(exr, NULL, EXR_STORAGE_SCANLINE, &part);
    if (result == EXR_ERR_SUCCESS)
        result = exr_initialize_required_attr_simple(exr, part, width, height, EXR_COMPRESSION_ZIP);
    for (size_t c = 0; c < channel_count && result == EXR_ERR_SUCCESS; c++)
        result = exr_add_channel(exr, part, sorted[c].name, EXR_PIXEL_FLOAT,
                                 EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    if (result == EXR_ERR_SUCCESS)
        result = exr_write_header(exr);
    if (result == EXR_ERR_SUCCESS)
        result = write_chunks(exr, width, height, sorted);
    /* The table of chunks is written only now. */
    exr_result_t late = exr ? exr_finish(&exr) : EXR_ERR_SUCCESS;
    if (result == EXR_ERR_SUCCESS)
        result = late;
    memory_free(context, sorted);
    if (result != EXR_ERR_SUCCESS || memory.no_memory) {
        memory_free(context, memory.bytes);
        return exr_fail(context, path, "cannot encode", &memory, result);
    }
    *out_bytes = memory.bytes;
    *out_size = memory.size;
    return PNB_OK;
}

static int find_channel(const exr_attr_chlist_t *list, const char *layer, int layer_length,
                        const char *name)
{
    for (int c = 0; c < list->num_channels; c++) {
        const char *have = list->entries[c].name.str;
        if (have && strncmp(have, layer, (size_t)layer_length) == 0 &&
            strcmp(have + layer_length, name) == 0)
            return c;
    }
    return -1;
}

/* Fills which[] with 1 or 3 indices into the list and returns how many; 0: no rule fits. */
static int choose_channels(const exr_attr_chlist_t *list, int which[3])
{
    static const char *const rgb[3] = {"R", "G", "B"};
    which[0] = find_channel(list, "", 0, "visibility");
    if (which[0] >= 0)
        return 1;
    /* The unnamed layer, then the named ones. */
    for (int pass = 0; pass < 3; pass++) {
        for (int c = 0; c < list->num_channels; c++) {
            const char *name = list->entries[c].name.str;
            size_t length = name ? strlen(name) : 0;
            if (pass > 0 && (length < 3 || strcmp(name + length - 2, ".R") != 0))
                continue;
            if (pass == 1 && (length < 10 || strcmp(name + length - 10, "Combined.R") != 0))
                continue;
            int prefix = pass == 0 ? 0 : (int)length - 1, found = 0;
            for (int k = 0; k < 3; k++) {
                which[k] = find_channel(list, prefix ? name : "", prefix, rgb[k]);
                found += which[k] >= 0;
            }
            if (found == 3)
                return 3;
            if (pass == 0)
                break;
        }
    }
    which[0] = 0;
    return list->num_channels == 1 ? 1 : 0;
}

struct exr_target {
    pnb_image *image;
    int x0, y0; /* the data window's corner */
    const int *which;
};

/* One chunk whose pixels begin at (x, y) of the image. */
static exr_result_t read_chunk(exr_context_t exr, const struct exr_target *target,
                               const exr_chunk_info_t *chunk, long long x, long long y,
                               exr_decode_pipeline_t *pipe, bool first)
{
    const pnb_image *image = target->image;
    if (x < 0 || y < 0 || chunk->width < 1 || chunk->height < 1 ||
        x + chunk->width > image->width || y + chunk->height > image->height)
        return EXR_ERR_BAD_CHUNK_LEADER;
    exr_result_t result = first ? exr_decoding_initialize(exr, 0, chunk, pipe)
                                : exr_decoding_update(exr, 0, chunk, pipe);
    if (result != EXR_ERR_SUCCESS)
        return result;
    int channels = image->channels;
    for (int c = 0; c < pipe->channel_count; c++) {
        pipe->channels[c].decode_to_ptr = NULL;
        for (int k = 0; k < channels; k++) {
            if (target->which[k] != c)
                continue;
            size_t at = ((size_t)y * (size_t)image->width + (size_t)x) * (size_t)channels;
            pipe->channels[c].user_data_type = EXR_PIXEL_FLOAT;
            pipe->channels[c].user_bytes_per_element = 4;
            pipe->channels[c].user_pixel_stride = channels * 4;
            pipe->channels[c].user_line_stride = image->width * channels * 4;
            pipe->channels[c].decode_to_ptr = (uint8_t *)(image->data + at + (size_t)k);
        }
    }
    if (first)
        result = exr_decoding_choose_default_routines(exr, 0, pipe);
    return result == EXR_ERR_SUCCESS ? exr_decoding_run(exr, 0, pipe) : result;
}

static exr_result_t read_scanlines(exr_context_t exr, const struct exr_target *target,
                                   exr_decode_pipeline_t *pipe)
{
    int32_t lines = 0;
    exr_result_t result = exr_get_scanlines_per_chunk(exr, 0, &lines);
    if (result == EXR_ERR_SUCCESS && lines < 1)
        return EXR_ERR_BAD_CHUNK_LEADER;
    for (int y = 0; y < target->image->height && result == EXR_ERR_SUCCESS; y += lines) {
        exr_chunk_info_t chunk = {0};
        result = exr_read_scanline_chunk_info(exr, 0, target->y0 + y, &chunk);
        if (result == EXR_ERR_SUCCESS)
            result = read_chunk(exr, target, &chunk, 0, (long long)chunk.start_y - target->y0, pipe,
                                y == 0);
    }
    return result;
}

static exr_result_t read_tiles(exr_context_t exr, const struct exr_target *target,
                               exr_decode_pipeline_t *pipe)
{
    int32_t width = 0, height = 0;
    exr_result_t result = exr_get_tile_sizes(exr, 0, 0, 0, &width, &height);
    if (result == EXR_ERR_SUCCESS && (width < 1 || height < 1))
        return EXR_ERR_BAD_CHUNK_LEADER;
    bool first = true;
    for (long long y = 0; y < target->image->height && result == EXR_ERR_SUCCESS; y += height)
        for (long long x = 0; x < target->image->width && result == EXR_ERR_SUCCESS; x += width) {
            exr_chunk_info_t chunk = {0};
            result =
                exr_read_tile_chunk_info(exr, 0, (int)(x / width), (int)(y / height), 0, 0, &chunk);
            if (result == EXR_ERR_SUCCESS)
                result = read_chunk(exr, target, &chunk, x, y, pipe, first);
            first = false;
        }
    return result;
}

static pnb_status decode_opened(pnb_context *context, const char *path, exr_context_t exr,
                                const struct exr_memory *memory, pnb_image *out_image)
{
    exr_storage_t storage;
    exr_attr_box2i_t window;
    const exr_attr_chlist_t *list = NULL;
    exr_result_t result = exr_get_storage(exr, 0, &storage);
    if (result == EXR_ERR_SUCCESS)
        result = exr_get_data_window(exr, 0, &window);
    if (result == EXR_ERR_SUCCESS)
        result = exr_get_channels(exr, 0, &list);
    if (result != EXR_ERR_SUCCESS)
        return exr_fail(context, path, "broken EXR", memory, result);
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
        return status_fail(context, PNB_ERROR_FORMAT, path, "deep EXR files cannot be read");

    int which[3] = {0};
    int channels = choose_channels(list, which);
    if (channels == 0)
        return status_fail(context, PNB_ERROR_FORMAT, path,
                           "no channel \"visibility\", no R, G, B and more than one channel");
    for (int k = 0; k < channels; k++)
        if (list->entries[which[k]].x_sampling != 1 || list->entries[which[k]].y_sampling != 1)
            return status_fail(context, PNB_ERROR_FORMAT, path, "channel \"%s\" is subsampled",
                               list->entries[which[k]].name.str);
    long long width = (long long)window.max.x - window.min.x + 1;
    long long height = (long long)window.max.y - window.min.y + 1;
    if (width > 0 && height > 0 && (uint64_t)width <= IMAGE_PIXELS_MAX &&
        (uint64_t)height <= IMAGE_PIXELS_MAX &&
        !image_fits_file((uint64_t)width * (uint64_t)height * (uint64_t)channels * 2, memory->size))
        return status_fail(context, PNB_ERROR_FORMAT, path,
                           "broken EXR: %lld x %lld pixels in %zu bytes", width, height,
                           memory->size);
    pnb_status status = image_alloc(context, path, width < 0 ? 0 : (uint64_t)width,
                                    height < 0 ? 0 : (uint64_t)height, channels, out_image);
    if (status != PNB_OK)
        return status;
    struct exr_target target = {out_image, window.min.x, window.min.y, which};
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    result = storage == EXR_STORAGE_TILED ? read_tiles(exr, &target, &pipe)
                                          : read_scanlines(exr, &target, &pipe);
    exr_decoding_destroy(exr, &pipe);
    if (result == EXR_ERR_SUCCESS)
        return PNB_OK;
    pnb_image_finish(context, out_image);
    return exr_fail(context, path, "broken EXR", memory, result);
}

pnb_status exr_decode(pnb_context *context, const char *path, const uint8_t *bytes, size_t size,
                      pnb_image *out_image)
{
    struct exr_memory memory = {.context = context, .bytes = (uint8_t *)bytes, .size = size};
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = note_error;
    init.user_data = &memory;
    init.read_fn = read_bytes;
    init.size_fn = byte_count;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    exr_context_t exr = NULL;
    exr_result_t result = exr_start_read(&exr, "exr", &init);
    pnb_status status = result == EXR_ERR_SUCCESS
                            ? decode_opened(context, path, exr, &memory, out_image)
                            : exr_fail(context, path, "broken EXR", &memory, result);
    if (exr)
        exr_finish(&exr);
    return status;
}
