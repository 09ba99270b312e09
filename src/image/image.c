/* image/image.c: images in memory, and the choice of a file format: by name when writing, by
 * content when reading. */
#include "image/image.h"

#include <string.h>
#include <strings.h>
#include <sys/stat.h>

pnb_status image_alloc(pnb_context *context, const char *name, uint64_t width, uint64_t height,
                       int channels, pnb_image *out_image)
{
    memset(out_image, 0, sizeof(*out_image));
    if (width == 0 || height == 0)
        return status_fail(context, PNB_ERROR_FORMAT, name, "the image has no pixels");
    if (width > IMAGE_PIXELS_MAX || height > IMAGE_PIXELS_MAX / width)
        return status_fail(context, PNB_ERROR_FORMAT, name,
                           "%llu x %llu pixels are more than the limit of %zu",
                           (unsigned long long)width, (unsigned long long)height, IMAGE_PIXELS_MAX);
    size_t count = (size_t)width * (size_t)height * (size_t)channels;
    float *data = memory_alloc(context, count, sizeof(float));
    if (!data)
        return status_no_memory(context, count * sizeof(float));
    *out_image = (pnb_image){(int)width, (int)height, channels, data};
    return PNB_OK;
}

pnb_status pnb_image_create(pnb_context *context, int width, int height, int channels,
                            pnb_image *out_image)
{
    memset(out_image, 0, sizeof(*out_image));
    if (width < 1 || height < 1)
        return status_fail(context, PNB_ERROR_ARGUMENT, "image", "size %d x %d is none", width,
                           height);
    if (channels != 1 && channels != 3)
        return status_fail(context, PNB_ERROR_ARGUMENT, "image", "%d channels; 1 or 3 are possible",
                           channels);
    pnb_status status =
        image_alloc(context, "image", (uint64_t)width, (uint64_t)height, channels, out_image);
    if (status == PNB_OK)
        memset(out_image->data, 0,
               (size_t)width * (size_t)height * (size_t)channels * sizeof(float));
    return status;
}

void pnb_image_finish(pnb_context *context, pnb_image *image)
{
    if (!image)
        return;
    memory_free(context, image->data);
    memset(image, 0, sizeof(*image));
}

static pnb_status image_check(pnb_context *context, const char *path, const pnb_image *image)
{
    if (!image || !image->data || image->width < 1 || image->height < 1)
        return status_fail(context, PNB_ERROR_ARGUMENT, path, "the image is empty");
    if (image->channels != 1 && image->channels != 3)
        return status_fail(context, PNB_ERROR_ARGUMENT, path, "%d channels; 1 or 3 are possible",
                           image->channels);
    return PNB_OK;
}

static bool ends_with(const char *path, const char *ending)
{
    size_t n = strlen(path), k = strlen(ending);
    return n > k && strcasecmp(path + n - k, ending) == 0;
}

/* Something that is there and is no plain file, such as /dev/stdout: its name says no format. */
static bool is_special(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode);
}

pnb_status pnb_image_write(pnb_context *context, const char *path, const pnb_image *image)
{
    if (!path)
        return status_fail(context, PNB_ERROR_ARGUMENT, "image", "no file name");
    pnb_status status = image_check(context, path, image);
    if (status != PNB_OK)
        return status;
    uint8_t *bytes = NULL;
    size_t size = 0;
    if (ends_with(path, ".pfm")) {
        status = pfm_encode(context, image, &bytes, &size);
    } else if (ends_with(path, ".exr")) {
        /* The one-channel images of this library are visibilities. */
        const pnb_channel rgb[3] = {
            {"R", image->data, 3}, {"G", image->data + 1, 3}, {"B", image->data + 2, 3}};
        const pnb_channel one = {"visibility", image->data, 1};
        status =
            exr_encode(context, path, image->width, image->height,
                       image->channels == 3 ? rgb : &one, (size_t)image->channels, &bytes, &size);
    } else if (ends_with(path, ".png") || is_special(path)) {
        status = png_encode(context, image, true, &bytes, &size);
    } else {
        return status_fail(context, PNB_ERROR_ARGUMENT, path,
                           "unknown ending; .png, .exr and .pfm can be written");
    }
    if (status == PNB_OK)
        status = pnb_file_write(context, path, bytes, size);
    memory_free(context, bytes);
    return status;
}

pnb_status pnb_image_write_exr(pnb_context *context, const char *path, int width, int height,
                               const pnb_channel *channels, size_t channel_count)
{
    uint8_t *bytes = NULL;
    size_t size = 0;
    for (size_t i = 0; channels && i < channel_count; i++)
        if (!channels[i].name || !channels[i].data)
            return status_missing(context, channels[i].name ? channels[i].name : "channel name");
    if (channel_count > 0 && !channels)
        return status_missing(context, "channels");
    pnb_status status =
        exr_encode(context, path, width, height, channels, channel_count, &bytes, &size);
    if (status == PNB_OK)
        status = pnb_file_write(context, path, bytes, size);
    memory_free(context, bytes);
    return status;
}

pnb_status pnb_image_encode_png(pnb_context *context, const pnb_image *image, bool srgb,
                                uint8_t **out_bytes, size_t *out_size)
{
    *out_bytes = NULL;
    *out_size = 0;
    pnb_status status = image_check(context, "png", image);
    return status == PNB_OK ? png_encode(context, image, srgb, out_bytes, out_size) : status;
}

void pnb_bytes_free(pnb_context *context, uint8_t *bytes)
{
    memory_free(context, bytes);
}

static const uint8_t PNG_MAGIC[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
static const uint8_t EXR_MAGIC[4] = {0x76, 0x2f, 0x31, 0x01};

static bool is_png(const uint8_t *bytes, size_t size)
{
    return size >= 8 && memcmp(bytes, PNG_MAGIC, 8) == 0;
}

static bool is_exr(const uint8_t *bytes, size_t size)
{
    return size >= 4 && memcmp(bytes, EXR_MAGIC, 4) == 0;
}

static bool is_pfm(const uint8_t *bytes, size_t size)
{
    return size >= 2 && bytes[0] == 'P' && (bytes[1] == 'f' || bytes[1] == 'F');
}

static bool is_known(const uint8_t *bytes, size_t size)
{
    return is_png(bytes, size) || is_exr(bytes, size) || is_pfm(bytes, size);
}

pnb_status image_decode(pnb_context *context, const char *path, const uint8_t *bytes, size_t size,
                        pnb_image *out_image)
{
    memset(out_image, 0, sizeof(*out_image));
    if (is_png(bytes, size))
        return png_decode(context, path, bytes, size, out_image);
    if (is_exr(bytes, size))
        return exr_decode(context, path, bytes, size, out_image);
    if (is_pfm(bytes, size))
        return pfm_decode(context, path, bytes, size, out_image);
    return status_fail(context, PNB_ERROR_FORMAT, path,
                       size == 0 ? "the file is empty" : "neither PNG nor EXR nor PFM");
}

pnb_status pnb_image_read(pnb_context *context, const char *path, pnb_image *out_image)
{
    uint8_t *bytes = NULL;
    size_t size = 0;
    memset(out_image, 0, sizeof(*out_image));
    if (!path)
        return status_fail(context, PNB_ERROR_ARGUMENT, "image", "no file name");
    /* Room for the largest image as three floats a pixel, and its header. */
    pnb_status status =
        file_read(context, path, IMAGE_PIXELS_MAX * 12 + 65536, is_known, &bytes, &size);
    if (status == PNB_OK)
        status = image_decode(context, path, bytes, size, out_image);
    memory_free(context, bytes);
    return status;
}
