/* near A.png B.png LIMIT SHARE: whether two pictures agree: of same size, and at most SHARE of
 * their pixels with a channel that differs by more than LIMIT (of 255, in sRGB). Prints what it
 * found. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <penumbra/penumbra.h>

static int encoded(float x)
{
    double e = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
    return (int)lround(255 * e);
}

int main(int argc, char **argv)
{
    pnb_context *context;
    pnb_image images[2];
    if (argc != 5 || pnb_context_create(NULL, &context) != PNB_OK)
        return 2;
    for (int i = 0; i < 2; i++)
        if (pnb_image_read(context, argv[1 + i], &images[i]) != PNB_OK) {
            fprintf(stderr, "%s\n", pnb_context_error(context));
            return 2;
        }
    const pnb_image *a = &images[0], *b = &images[1];
    bool same = a->width == b->width && a->height == b->height && a->channels == b->channels;
    size_t pixels = (size_t)a->width * (size_t)a->height, channels = (size_t)a->channels, off = 0;
    int most = 0;
    for (size_t i = 0; same && i < pixels; i++) {
        int worst = 0;
        for (size_t c = 0; c < channels; c++) {
            int d = abs(encoded(a->data[channels * i + c]) - encoded(b->data[channels * i + c]));
            worst = d > worst ? d : worst;
        }
        off += worst > atoi(argv[3]);
        most = worst > most ? worst : most;
    }
    printf("%s: %zu of %zu pixels differ by more than %s, the most by %d\n", argv[1], off, pixels,
           argv[3], most);
    bool good = same && (double)off <= atof(argv[4]) * (double)pixels;
    for (int i = 0; i < 2; i++)
        pnb_image_finish(context, &images[i]);
    pnb_context_destroy(context);
    return good ? 0 : 1;
}
