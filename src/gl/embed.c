/* gl/embed.c: a build tool. embed ROOT OUTPUT FILE... writes a C file with the text of every FILE
 * under its path relative to ROOT, so that shaders stay files that tools can read. */
#define _XOPEN_SOURCE 700
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int argc, char **argv)
{
    if (argc < 3) {
        fprintf(stderr, "usage: embed ROOT OUTPUT FILE...\n");
        return 2;
    }
    char *root_path = realpath(argv[1], NULL);
    if (!root_path) {
        perror(argv[1]);
        return 1;
    }
    size_t root = strlen(root_path);
    FILE *out = fopen(argv[2], "wb");
    if (!out) {
        perror(argv[2]);
        return 1;
    }
    fprintf(out, "#include <stddef.h>\n\n#include \"gl/shaders.h\"\n");
    for (int i = 3; i < argc; i++) {
        FILE *in = fopen(argv[i], "rb");
        if (!in) {
            perror(argv[i]);
            fclose(out);
            remove(argv[2]);
            return 1;
        }
        fprintf(out, "\nstatic const char text_%d[] = {", i - 3);
        unsigned long count = 0;
        for (int c; (c = getc(in)) != EOF; count++)
            fprintf(out, "%s%d,", count % 24 ? " " : "\n    ", c > 127 ? c - 256 : c);
        fprintf(out, "\n    0};\n");
        fclose(in);
    }
    fprintf(out, "\nconst struct gl_shader_file gl_shader_files[] = {\n");
    for (int i = 3; i < argc; i++) {
        char *path = realpath(argv[i], NULL);
        bool inside = path && strncmp(path, root_path, root) == 0 && path[root] == '/';
        if (inside)
            fprintf(out, "    {\"%s\", text_%d},\n", path + root + 1, i - 3);
        else
            fprintf(stderr, "%s: not below %s\n", argv[i], root_path);
        free(path);
        if (!inside)
            return 1;
    }
    free(root_path);
    fprintf(out, "    {NULL, NULL},\n};\nconst size_t gl_shader_file_count = %d;\n", argc - 3);
    return fclose(out) != 0;
}
