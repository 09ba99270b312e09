/* Any bytes as an image file: PNG, EXR or PFM by their content. */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "image/image.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pnb_context *context;
    pnb_image image;
    if (pnb_context_create(NULL, &context) != PNB_OK)
        return 0;
    if (image_decode(context, "fuzz.image", data, size, &image) == PNB_OK) {
        /* What was accepted is a whole image: every pixel can be read, and it can be written. */
        size_t count = (size_t)image.width * (size_t)image.height * (size_t)image.channels;
        if (image.width < 1 || image.height < 1 || (image.channels != 1 && image.channels != 3))
            abort();
        volatile float sum = 0;
        for (size_t i = 0; i < count; i++)
            sum += image.data[i];
        uint8_t *bytes;
        if (count < 1 << 20 && pfm_encode(context, &image, &bytes, &size) == PNB_OK)
            memory_free(context, bytes);
        pnb_image_finish(context, &image);
    } else {
        /* An error is one line that names the file. */
        const char *error = pnb_context_error(context);
        if (image.data || strncmp(error, "fuzz.image: ", 12) != 0 || strchr(error, '\n'))
            if (strncmp(error, "memory: ", 8) != 0)
                abort();
    }
    pnb_context_destroy(context);
    return 0;
}
