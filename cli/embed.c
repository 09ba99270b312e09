/* cli/embed.c: a build tool. embed NAME FILE OUTPUT writes FILE as "static const char NAME[]" with
 * a zero at the end, so that style sheets and scripts stay files that other tools can read. */
#include <stdio.h>

int main(int argc, char **argv)
{
    if (argc != 4) {
        fprintf(stderr, "usage: embed NAME FILE OUTPUT\n");
        return 2;
    }
    FILE *in = fopen(argv[2], "rb"), *out = fopen(argv[3], "wb");
    if (!in || !out) {
        perror(argv[in ? 3 : 2]);
        return 1;
    }
    fprintf(out, "static const char %s[] = {", argv[1]);
    unsigned long count = 0;
    for (int c; (c = getc(in)) != EOF; count++)
        fprintf(out, "%s%d,", count % 24 ? " " : "\n    ", c > 127 ? c - 256 : c);
    fprintf(out, "\n    0};\n");
    int bad = ferror(in) | ferror(out);
    fclose(in);
    return fclose(out) || bad;
}
