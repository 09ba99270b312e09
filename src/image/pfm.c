/* image/pfm.c: portable float maps (Debevec): "Pf" or "PF", width, height, scale, then floats, the
 * bottom row first. The sign of the scale says the byte order (negative: little-endian); its size
 * is a unit that nobody agrees on and is ignored. Written little-endian with scale -1. Bits pass
 * unchanged, NaN included. Bytes after the last row are ignored. */
#include "image/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint32_t load32(const uint8_t *b, bool little)
{
    return little
               ? (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24
               : (uint32_t)b[3] | (uint32_t)b[2] << 8 | (uint32_t)b[1] << 16 | (uint32_t)b[0] << 24;
}

pnb_status pfm_encode(pnb_context *context, const pnb_image *image, uint8_t **out_bytes,
                      size_t *out_size)
{
    char header[64];
    int head = snprintf(header, sizeof(header), "%s\n%d %d\n-1.0\n",
                        image->channels == 3 ? "PF" : "Pf", image->width, image->height);
    size_t row = (size_t)image->width * (size_t)image->channels;
    size_t size = (size_t)head + row * (size_t)image->height * 4;
    uint8_t *bytes = memory_alloc(context, size, 1);
    if (!bytes)
        return status_no_memory(context, size);
    memcpy(bytes, header, (size_t)head);
    uint8_t *to = bytes + head;
    for (int y = image->height - 1; y >= 0; y--) {
        const float *from = image->data + (size_t)y * row;
        for (size_t i = 0; i < row; i++, to += 4) {
            uint32_t bits;
            memcpy(&bits, from + i, 4);
            for (int k = 0; k < 4; k++)
                to[k] = (uint8_t)(bits >> (8 * k));
        }
    }
    *out_bytes = bytes;
    *out_size = size;
    return PNB_OK;
}

/* The next word of the header, at most 31 characters, and the one blank after it; false: none. */
static bool next_word(const uint8_t *bytes, size_t size, size_t *at, char word[32])
{
    size_t i = *at, n = 0;
    while (i < size &&
           (bytes[i] == ' ' || bytes[i] == '\t' || bytes[i] == '\r' || bytes[i] == '\n'))
        i++;
    while (i < size && bytes[i] > ' ' && bytes[i] < 0x7f) {
        if (n == 31)
            return false;
        word[n++] = (char)bytes[i++];
    }
    word[n] = '\0';
    if (n == 0 || i == size)
        return false;
    /* Files written with "\r\n" line ends: the data begins after both. */
    *at = i + 1 + (bytes[i] == '\r' && i + 1 < size && bytes[i + 1] == '\n');
    return true;
}

/* The scale matters by its sign only; strtod() would read it by the program's locale. False: it is
 * no number, or zero. */
static bool scale_sign(const char *word, bool *out_negative)
{
    *out_negative = *word == '-';
    word += *word == '-' || *word == '+';
    size_t digits = strspn(word, "0123456789.");
    bool zero = strspn(word, "0.") == digits;
    const char *rest = word + digits;
    if (*rest == 'e' || *rest == 'E') {
        rest++;
        rest += *rest == '-' || *rest == '+';
        rest += strspn(rest, "0123456789");
    }
    return !zero && *rest == '\0';
}

pnb_status pfm_decode(pnb_context *context, const char *path, const uint8_t *bytes, size_t size,
                      pnb_image *out_image)
{
    char word[4][32];
    size_t at = 0;
    for (int i = 0; i < 4; i++)
        if (!next_word(bytes, size, &at, word[i]))
            return status_fail(context, PNB_ERROR_FORMAT, path, "broken PFM header");
    int channels = strcmp(word[0], "PF") == 0 ? 3 : strcmp(word[0], "Pf") == 0 ? 1 : 0;
    char *end[2];
    long long width = strtoll(word[1], &end[0], 10);
    long long height = strtoll(word[2], &end[1], 10);
    bool little;
    if (channels == 0 || *end[0] || *end[1] || width < 1 || height < 1 ||
        !scale_sign(word[3], &little))
        return status_fail(context, PNB_ERROR_FORMAT, path, "broken PFM header");

    /* The size in the header is believed only as far as the file goes. */
    uint64_t need = 0;
    if (__builtin_mul_overflow((uint64_t)width * 4 * (unsigned)channels, (uint64_t)height, &need) ||
        width > (long long)IMAGE_PIXELS_MAX)
        return status_fail(context, PNB_ERROR_FORMAT, path,
                           "%lld x %lld pixels are more than the limit of %zu", width, height,
                           IMAGE_PIXELS_MAX);
    if (need > size - at)
        return status_fail(context, PNB_ERROR_FORMAT, path,
                           "the file ends early: %llu bytes of pixels expected, %zu found",
                           (unsigned long long)need, size - at);
    pnb_status status =
        image_alloc(context, path, (uint64_t)width, (uint64_t)height, channels, out_image);
    if (status != PNB_OK)
        return status;
    const uint8_t *from = bytes + at;
    size_t row = (size_t)width * (size_t)channels;
    for (long long y = height - 1; y >= 0; y--) {
        float *to = out_image->data + (size_t)y * row;
        for (size_t i = 0; i < row; i++, from += 4) {
            uint32_t bits = load32(from, little);
            memcpy(to + i, &bits, 4);
        }
    }
    return PNB_OK;
}
