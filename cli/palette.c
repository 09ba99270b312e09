/* cli/palette.c: a grey PNG becomes one with colours from a table, by its head alone: the colour
 * type changes and a palette is put in; the compressed pixels stay as they are. So an error map is
 * one small image that a page can show at once, and recolour by writing another palette into it.
 */
#include "compare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIGNATURE = 8, HEAD = SIGNATURE + 4 + 4 + 13 + 4, PALETTE = 4 + 4 + 3 * 256 + 4 };

static uint32_t crc(const uint8_t *bytes, size_t size)
{
    uint32_t value = 0xffffffffu;
    for (size_t i = 0; i < size; i++) {
        value ^= bytes[i];
        for (int k = 0; k < 8; k++)
            value = value >> 1 ^ (value & 1 ? 0xedb88320u : 0);
    }
    return ~value;
}

static void put_big(uint8_t *at, uint32_t value)
{
    for (int k = 0; k < 4; k++)
        at[k] = (uint8_t)(value >> (24 - 8 * k));
}

bool compare_png_palette(const uint8_t *grey, size_t size, const uint8_t (*colors)[3],
                         struct compare_png *out)
{
    /* 8 bits of grey, not interlaced: what the library writes of one channel. */
    if (size < HEAD || memcmp(grey + SIGNATURE + 4, "IHDR", 4) != 0 || grey[24] != 8 ||
        grey[25] != 0 || grey[28] != 0)
        return false;
    uint8_t *bytes = malloc(size + PALETTE);
    if (!bytes)
        return false;
    memcpy(bytes, grey, HEAD);
    bytes[25] = 3;
    put_big(bytes + HEAD - 4, crc(bytes + SIGNATURE + 4, 4 + 13));
    uint8_t *chunk = bytes + HEAD;
    put_big(chunk, 3 * 256);
    memcpy(chunk + 4, "PLTE", 4);
    memcpy(chunk + 8, colors, 3 * 256);
    put_big(chunk + 8 + 3 * 256, crc(chunk + 4, 4 + 3 * 256));
    memcpy(bytes + HEAD + PALETTE, grey + HEAD, size - HEAD);
    *out = (struct compare_png){bytes, size + PALETTE};
    return true;
}

/* Code 0 is what is not compared; else 128 + 127 sign(e) sqrt(|e|). */
void compare_error_colors(double scale, uint8_t (*colors)[3])
{
    for (int code = 0; code < 256; code++) {
        double size = (code - 128) / 127.0, rgb[3];
        pnb_colormap_diverging(fmin(fmax(0.5 + 0.5 * copysign(size * size, size) / scale, 0), 1),
                               rgb);
        for (int k = 0; k < 3; k++)
            colors[code][k] = code ? (uint8_t)(compare_srgb(rgb[k]) * 255 + 0.5) : 68;
    }
}

double compare_srgb(double linear)
{
    double x = fmin(fmax(linear, 0), 1);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}
