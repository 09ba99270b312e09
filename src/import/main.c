/* import/main.c: penumbra-import [--memory BYTES] [--seconds N] FILE
 *
 * Reads a mesh or scene file and writes the stream of scene/import_stream.h to standard output. Not
 * for people: the library starts it, because the library that reads the files is known to crash on
 * broken ones. It limits itself before it opens the file: address space, processor time, no core
 * file, no writing to files; it ends with the thread that started it. Exit status: enum
 * import_exit.
 */
#define _GNU_SOURCE
#include "import/import.h"

#include <locale.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__)
#define LIMIT_MEMORY false /* the sanitizer's shadow takes terabytes of address space */
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define LIMIT_MEMORY false
#endif
#endif
#ifndef LIMIT_MEMORY
#define LIMIT_MEMORY true
#endif

void import_fail(int exit_status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    fflush(stderr);
    _exit(exit_status);
}

void *import_alloc(size_t count, size_t size)
{
    void *block = calloc(count ? count : 1, size);
    if (!block)
        import_fail(IMPORT_NO_MEMORY, "out of memory");
    return block;
}

void import_free(void *block)
{
    free(block);
}

/* extra: between the limit that sends a signal and the one that kills. */
static void limit(int resource, rlim_t value, rlim_t extra)
{
    struct rlimit limit;
    if (getrlimit(resource, &limit) != 0)
        return;
    if (limit.rlim_max == RLIM_INFINITY || limit.rlim_max > value + extra)
        limit.rlim_max = value + extra;
    limit.rlim_cur = limit.rlim_max < value ? limit.rlim_max : value;
    setrlimit(resource, &limit);
}

static unsigned long long number(const char *text)
{
    char *end;
    unsigned long long value = strtoull(text, &end, 10);
    if (end == text || *end || value == 0)
        import_fail(IMPORT_BAD_CALL, "not a limit: %s", text);
    return value;
}

int main(int argc, char **argv)
{
    unsigned long long memory = 4ull << 30, seconds = 120;
    int argument = 1;
    for (; argument + 1 < argc && strncmp(argv[argument], "--", 2) == 0; argument += 2) {
        if (strcmp(argv[argument], "--memory") == 0)
            memory = number(argv[argument + 1]);
        else if (strcmp(argv[argument], "--seconds") == 0)
            seconds = number(argv[argument + 1]);
        else
            import_fail(IMPORT_BAD_CALL, "unknown option %s", argv[argument]);
    }
    if (argument + 1 != argc)
        import_fail(IMPORT_BAD_CALL, "usage: penumbra-import [--memory BYTES] [--seconds N] FILE");

    prctl(PR_SET_PDEATHSIG, SIGKILL);
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    limit(RLIMIT_CORE, 0, 0);
    limit(RLIMIT_FSIZE, 0, 0);
    limit(RLIMIT_CPU, seconds, 1);
    if (LIMIT_MEMORY)
        limit(RLIMIT_AS, memory, 0);

    /* Numbers in files have points, whatever the user's language. */
    setlocale(LC_ALL, "C");

    /* The stream gets a descriptor of its own: what a reader prints goes to standard error. */
    int fd = dup(STDOUT_FILENO);
    if (fd < 0 || dup2(STDERR_FILENO, STDOUT_FILENO) < 0)
        import_fail(IMPORT_BAD_CALL, "no standard output");

    writer_open(fd);
    convert_file(argv[argument], gltf_read(argv[argument]));
    writer_close();
    _exit(IMPORT_DONE); /* without taking the scene down piece by piece */
}
