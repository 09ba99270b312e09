/* image/image.h: image files inside the library, one function pair per format, and colour. */
#ifndef IMAGE_IMAGE_H
#define IMAGE_IMAGE_H

#include <penumbra/image.h>

#include "base/base.h"

/* No image has more pixels than this, written or read: a broken header cannot ask for the moon. */
#define IMAGE_PIXELS_MAX ((size_t)1 << 28)

/* What a compressed file of so many bytes can hold at most. Deflate shrinks to no less than 1/1032,
 * the other compressions of our formats to more: a header that promises beyond this is broken, and
 * is found out before the memory is taken. */
static inline bool image_fits_file(uint64_t pixel_bytes, size_t file_size)
{
    return pixel_bytes / 2048 <= file_size;
}

/* Like pnb_image_create() without the zeros: readers fill every pixel or fail. name: whose fault a
 * bad size is. */
pnb_status image_alloc(pnb_context *context, const char *name, uint64_t width, uint64_t height,
                       int channels, pnb_image *out_image);

/* A whole file in memory, at most limit bytes; memory_free() it. accept() sees the first bytes (up
 * to 16) and may refuse the rest of the file by returning false; NULL: anything goes. Reads pipes
 * and devices as well as files. */
pnb_status file_read(pnb_context *context, const char *path, size_t limit,
                     bool (*accept)(const uint8_t *first, size_t size), uint8_t **out_bytes,
                     size_t *out_size);

/* From and to bytes in memory; path is for the error's text. Encoders' bytes: memory_free(). */
pnb_status png_encode(pnb_context *context, const pnb_image *image, bool srgb, uint8_t **out_bytes,
                      size_t *out_size);
pnb_status png_decode(pnb_context *context, const char *path, const uint8_t *bytes, size_t size,
                      pnb_image *out_image);
pnb_status exr_encode(pnb_context *context, const char *path, int width, int height,
                      const pnb_channel *channels, size_t channel_count, uint8_t **out_bytes,
                      size_t *out_size);
pnb_status exr_decode(pnb_context *context, const char *path, const uint8_t *bytes, size_t size,
                      pnb_image *out_image);
pnb_status pfm_encode(pnb_context *context, const pnb_image *image, uint8_t **out_bytes,
                      size_t *out_size);
pnb_status pfm_decode(pnb_context *context, const char *path, const uint8_t *bytes, size_t size,
                      pnb_image *out_image);
/* What pnb_image_read() does once the bytes are in memory. */
pnb_status image_decode(pnb_context *context, const char *path, const uint8_t *bytes, size_t size,
                        pnb_image *out_image);

/* IEC 61966-2-1, both ways, exact at both ends and at the knee; any finite value. */
double srgb_from_linear(double linear);
double linear_from_srgb(double encoded);
/* 0..255, rounded to nearest; clipped; NaN gives 0. */
uint8_t srgb8_from_linear(float linear);

/* OKLab (Ottosson 2020): lightness, green-red, blue-yellow, to linear RGB. */
void linear_from_oklab(const double lab[3], double out_rgb[3]);

#endif
