/* image/error_map.c: a signed error as a picture. Blue: too dark, light grey: right, red: too
 * light, dark grey: no figure there. Errors beyond the scale take the colours of its ends.
 *
 * The scale bar under the picture shows the map's colours with -scale, 0 and +scale in a built-in
 * font of 5x7 dots. Narrow pictures get as many of the numbers as fit without touching. */
#include "image/image.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { GLYPH_WIDTH = 5, GLYPH_HEIGHT = 7, BAR_GAP = 4, BAR_HEIGHT = 8, BAR_ROWS = 26 };

static const double NO_FIGURE = 0.06; /* linear grey */
static const double PAPER = 1, INK = 0.03;

struct glyph {
    char code;
    uint8_t rows[GLYPH_HEIGHT]; /* five bits, the highest is the leftmost dot */
};

static const struct glyph GLYPHS[] = {
    {'0', {0x0e, 0x11, 0x13, 0x15, 0x19, 0x11, 0x0e}},
    {'1', {0x04, 0x0c, 0x04, 0x04, 0x04, 0x04, 0x0e}},
    {'2', {0x0e, 0x11, 0x01, 0x02, 0x04, 0x08, 0x1f}},
    {'3', {0x1f, 0x02, 0x04, 0x02, 0x01, 0x11, 0x0e}},
    {'4', {0x02, 0x06, 0x0a, 0x12, 0x1f, 0x02, 0x02}},
    {'5', {0x1f, 0x10, 0x1e, 0x01, 0x01, 0x11, 0x0e}},
    {'6', {0x06, 0x08, 0x10, 0x1e, 0x11, 0x11, 0x0e}},
    {'7', {0x1f, 0x01, 0x02, 0x04, 0x08, 0x08, 0x08}},
    {'8', {0x0e, 0x11, 0x11, 0x0e, 0x11, 0x11, 0x0e}},
    {'9', {0x0e, 0x11, 0x11, 0x0f, 0x01, 0x02, 0x0c}},
    {'.', {0x00, 0x00, 0x00, 0x00, 0x00, 0x0c, 0x0c}},
    {'-', {0x00, 0x00, 0x00, 0x1f, 0x00, 0x00, 0x00}},
    {'+', {0x00, 0x04, 0x04, 0x1f, 0x04, 0x04, 0x00}},
    {'e', {0x00, 0x00, 0x0e, 0x11, 0x1f, 0x10, 0x0e}},
};

static void put_grey(pnb_image *image, int x, int y, double grey)
{
    if (x < 0 || y < 0 || x >= image->width || y >= image->height)
        return;
    float *to = image->data + 3 * ((size_t)y * (size_t)image->width + (size_t)x);
    to[0] = to[1] = to[2] = (float)grey;
}

static int text_width(const char *text)
{
    return (int)strlen(text) * (GLYPH_WIDTH + 1) - 1;
}

static void put_text(pnb_image *image, int x, int y, const char *text)
{
    for (; *text; text++, x += GLYPH_WIDTH + 1)
        for (size_t g = 0; g < sizeof(GLYPHS) / sizeof(GLYPHS[0]); g++) {
            if (GLYPHS[g].code != (*text == ',' ? '.' : *text)) /* the locale may write a comma */
                continue;
            for (int row = 0; row < GLYPH_HEIGHT; row++)
                for (int column = 0; column < GLYPH_WIDTH; column++)
                    if (GLYPHS[g].rows[row] >> (GLYPH_WIDTH - 1 - column) & 1)
                        put_grey(image, x + column, y + row, INK);
        }
}

static void put_color(float *to, double t)
{
    double rgb[3];
    pnb_colormap_diverging(t, rgb);
    for (int k = 0; k < 3; k++)
        to[k] = (float)rgb[k];
}

static void put_bar(pnb_image *image, int top, double scale)
{
    int width = image->width;
    for (int y = top; y < image->height; y++)
        for (int x = 0; x < width; x++)
            put_grey(image, x, y, PAPER);
    int left = width >= 64 ? 8 : 0, right = width - left;
    for (int y = top + BAR_GAP; y < top + BAR_GAP + BAR_HEIGHT; y++)
        for (int x = left; x < right; x++)
            put_color(image->data + 3 * ((size_t)y * (size_t)width + (size_t)x),
                      (x - left + 0.5) / (right - left));
    char low[24], high[24];
    snprintf(low, sizeof(low), "%+.3g", -scale);
    snprintf(high, sizeof(high), "%+.3g", scale);
    int y = top + BAR_GAP + BAR_HEIGHT + 4;
    int ends = text_width(low) + text_width(high);
    if (ends + 6 > right - left)
        return;
    put_text(image, left, y, low);
    put_text(image, right - text_width(high), y, high);
    if (ends + text_width("0") + 24 <= right - left)
        put_text(image, (width - GLYPH_WIDTH) / 2, y, "0");
    for (int k = 0; k < 3; k++) { /* ticks */
        int x = k == 0 ? left : k == 1 ? width / 2 : right - 1;
        put_grey(image, x, y - 3, INK);
        put_grey(image, x, y - 4, INK);
    }
}

pnb_status pnb_image_error_map(pnb_context *context, const float *error, int width, int height,
                               double scale, bool bar, pnb_image *out_image)
{
    memset(out_image, 0, sizeof(*out_image));
    if (!error)
        return status_missing(context, "error");
    if (!(scale > 0) || !isfinite(scale))
        return status_fail(context, PNB_ERROR_ARGUMENT, "error map", "scale %g is none", scale);
    pnb_status status =
        pnb_image_create(context, width, bar ? height + BAR_ROWS : height, 3, out_image);
    if (status != PNB_OK)
        return status;
    size_t count = (size_t)width * (size_t)height;
    for (size_t i = 0; i < count; i++) {
        float *to = out_image->data + 3 * i;
        if (isnan(error[i]))
            to[0] = to[1] = to[2] = (float)NO_FIGURE;
        else
            put_color(to, 0.5 + 0.5 * error[i] / scale);
    }
    if (bar)
        put_bar(out_image, height, scale);
    return PNB_OK;
}
