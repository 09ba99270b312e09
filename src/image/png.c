/* image/png.c: PNG through libspng.
 *
 * Written: 8 bits, grey or RGB, with an sRGB chunk where the values were encoded. Read: every
 * depth and colour type. Values count as sRGB unless a gAMA chunk (and neither sRGB nor iCCP) says
 * otherwise; alpha is ignored, since what lies behind a picture is unknown. */
#include "image/image.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <spng.h>

static pnb_status png_fail(pnb_context *context, const char *path, int error)
{
    if (error == SPNG_EMEM)
        return status_fail(context, PNB_ERROR_MEMORY, path, "no memory left");
    return status_fail(context, PNB_ERROR_FORMAT, path, "broken PNG: %s", spng_strerror(error));
}

pnb_status png_encode(pnb_context *context, const pnb_image *image, bool srgb, uint8_t **out_bytes,
                      size_t *out_size)
{
    size_t count = (size_t)image->width * (size_t)image->height * (size_t)image->channels;
    uint8_t *pixels = memory_alloc(context, count, 1);
    if (!pixels)
        return status_no_memory(context, count);
    for (size_t i = 0; i < count; i++) {
        float x = image->data[i];
        pixels[i] = srgb       ? srgb8_from_linear(x)
                    : !(x > 0) ? 0
                    : x >= 1   ? 255
                               : (uint8_t)(x * 255 + 0.5f);
    }

    pnb_status status = PNB_OK;
    spng_ctx *png = spng_ctx_new(SPNG_CTX_ENCODER);
    if (!png) {
        memory_free(context, pixels);
        return status_no_memory(context, 0);
    }
    struct spng_ihdr head = {
        .width = (uint32_t)image->width,
        .height = (uint32_t)image->height,
        .bit_depth = 8,
        .color_type = image->channels == 3 ? SPNG_COLOR_TYPE_TRUECOLOR : SPNG_COLOR_TYPE_GRAYSCALE,
    };
    int error = spng_set_option(png, SPNG_ENCODE_TO_BUFFER, 1);
    if (!error)
        error = spng_set_ihdr(png, &head);
    if (!error && srgb)
        error = spng_set_srgb(png, 0);
    if (!error)
        error = spng_encode_image(png, pixels, count, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
    size_t size = 0;
    void *bytes = error ? NULL : spng_get_png_buffer(png, &size, &error);
    if (bytes) {
        /* libspng's block goes back to libspng's allocator: hand out one of ours. */
        *out_bytes = memory_alloc(context, size, 1);
        if (*out_bytes)
            memcpy(*out_bytes, bytes, size);
        else
            status = status_no_memory(context, size);
        *out_size = size;
        free(bytes);
    } else {
        status = status_fail(context, PNB_ERROR_FORMAT, "png", "cannot encode: %s",
                             spng_strerror(error));
    }
    spng_ctx_free(png);
    memory_free(context, pixels);
    return status;
}

/* The value that each code stands for, linear. */
static void decode_table(spng_ctx *png, float *table, size_t count)
{
    double gamma = 0;
    uint8_t intent;
    struct spng_iccp profile;
    bool plain = spng_get_gama(png, &gamma) == 0 && gamma > 0.01 && gamma < 100 &&
                 spng_get_srgb(png, &intent) != 0 && spng_get_iccp(png, &profile) != 0 &&
                 fabs(gamma - 0.45455) > 0.001;
    for (size_t i = 0; i < count; i++) {
        double x = (double)i / (double)(count - 1);
        table[i] = (float)(plain ? pow(x, 1 / gamma) : linear_from_srgb(x));
    }
}

static pnb_status decode_pixels(pnb_context *context, const char *path, spng_ctx *png,
                                const struct spng_ihdr *head, pnb_image *out_image)
{
    bool grey = head->color_type == SPNG_COLOR_TYPE_GRAYSCALE ||
                head->color_type == SPNG_COLOR_TYPE_GRAYSCALE_ALPHA;
    bool wide = head->bit_depth == 16;
    int format = wide ? SPNG_FMT_RGBA16 : SPNG_FMT_RGBA8;
    size_t levels = wide ? 65536 : 256;
    size_t size = 0;
    int error = spng_decoded_image_size(png, format, &size);
    if (error)
        return png_fail(context, path, error);

    pnb_status status = PNB_OK;
    void *pixels = memory_alloc(context, size, 1);
    float *table = memory_alloc(context, levels, sizeof(float));
    if (!pixels || !table) {
        status = status_no_memory(context, size);
        goto done;
    }
    error = spng_decode_image(png, pixels, size, format, 0);
    if (error) {
        status = png_fail(context, path, error);
        goto done;
    }
    decode_table(png, table, levels);
    status = image_alloc(context, path, head->width, head->height, grey ? 1 : 3, out_image);
    if (status != PNB_OK)
        goto done;
    size_t count = (size_t)head->width * head->height;
    int channels = out_image->channels;
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < channels; c++) {
            size_t from = 4 * i + (size_t)c;
            out_image->data[i * (size_t)channels + (size_t)c] =
                table[wide ? ((uint16_t *)pixels)[from] : ((uint8_t *)pixels)[from]];
        }
done:
    memory_free(context, table);
    memory_free(context, pixels);
    return status;
}

pnb_status png_decode(pnb_context *context, const char *path, const uint8_t *bytes, size_t size,
                      pnb_image *out_image)
{
    spng_ctx *png = spng_ctx_new(0);
    if (!png)
        return status_no_memory(context, 0);
    pnb_status status = PNB_OK;
    struct spng_ihdr head;
    int error = spng_set_png_buffer(png, bytes, size);
    /* Colour profiles and texts may not swell beyond reason. */
    if (!error)
        error = spng_set_chunk_limits(png, 64u << 20, 64u << 20);
    if (!error)
        error = spng_get_ihdr(png, &head);
    if (error)
        status = png_fail(context, path, error);
    else if ((uint64_t)head.width * head.height > IMAGE_PIXELS_MAX)
        status = status_fail(context, PNB_ERROR_FORMAT, path,
                             "%u x %u pixels are more than the limit of %zu", head.width,
                             head.height, IMAGE_PIXELS_MAX);
    else if (!image_fits_file((uint64_t)head.width * head.height * head.bit_depth / 8, size))
        status =
            status_fail(context, PNB_ERROR_FORMAT, path, "broken PNG: %u x %u pixels in %zu bytes",
                        head.width, head.height, size);
    else
        status = decode_pixels(context, path, png, &head, out_image);
    spng_ctx_free(png);
    return status;
}
