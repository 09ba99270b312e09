/* image.h: float images and their files. Rows run from the top; channels interleaved. */
#ifndef PENUMBRA_IMAGE_H
#define PENUMBRA_IMAGE_H

#include <penumbra/context.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pnb_image {
    int width, height;
    int channels; /* 1 or 3 */
    float *data;  /* height x width x channels; linear light for pictures */
} pnb_image;

/* One named channel of an EXR file. */
typedef struct pnb_channel {
    const char *name; /* "R", "visibility", "normal.X", ... */
    const float *data;
    size_t stride; /* floats from one pixel to the next; 0: 1 */
} pnb_channel;

PNB_API pnb_status pnb_image_create(pnb_context *context, int width, int height, int channels,
                                    pnb_image *out_image);
PNB_API void pnb_image_finish(pnb_context *context, pnb_image *image);

/* All writers write to a temporary name in the same folder and rename: the file is whole or absent.
 */

/* By the file's ending: .png (8-bit sRGB from linear values, clipped to [0,1]), .exr, .pfm. */
PNB_API pnb_status pnb_image_write(pnb_context *context, const char *path, const pnb_image *image);
/* 32-bit float channels, ZIP-compressed. */
PNB_API pnb_status pnb_image_write_exr(pnb_context *context, const char *path, int width,
                                       int height, const pnb_channel *channels,
                                       size_t channel_count);
/* A whole PNG file in memory; srgb: encode linear values, else write them as they are. The bytes
 * are the caller's: pnb_bytes_free(). */
PNB_API pnb_status pnb_image_encode_png(pnb_context *context, const pnb_image *image, bool srgb,
                                        uint8_t **out_bytes, size_t *out_size);
PNB_API void pnb_bytes_free(pnb_context *context, uint8_t *bytes);
PNB_API pnb_status pnb_file_write(pnb_context *context, const char *path, const void *bytes,
                                  size_t size);

/* By content: PNG (sRGB to linear; grey becomes 1 channel), PFM, EXR (channel "visibility" if there
 * is one or else a single channel: 1; R, G, B: 3). */
PNB_API pnb_status pnb_image_read(pnb_context *context, const char *path, pnb_image *out_image);

/* A perceptually uniform colour map: t in [0,1] to linear RGB. Sequential (dark to light) for
 * sizes, diverging (blue - grey - red at 0, 0.5, 1) for signed errors. */
PNB_API void pnb_colormap_sequential(double t, double out_rgb[3]);
PNB_API void pnb_colormap_diverging(double t, double out_rgb[3]);

/* Error map of a signed error (NaN: dark grey), scale: the error at the ends of the map; with a
 * scale bar under the picture if bar is true (the image grows by some rows). */
PNB_API pnb_status pnb_image_error_map(pnb_context *context, const float *error, int width,
                                       int height, double scale, bool bar, pnb_image *out_image);

#ifdef __cplusplus
}
#endif
#endif
