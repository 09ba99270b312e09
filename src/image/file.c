/* image/file.c: whole files in and out.
 *
 * Writing: the bytes go to a fresh file beside the wanted one, which then takes its name: whoever
 * looks at the name sees the old file or the whole new one. Every short write and the error of
 * close() count (a full disk may report only there); on failure the temporary file goes away.
 * An existing file keeps its permissions, a symbolic link stays a link. What is not a plain file
 * (a pipe, /dev/stdout) is written in place, since there is nothing to rename over.
 *
 * The signals that a full quota (SIGXFSZ) or a closed pipe (SIGPIPE) would kill the process with
 * are held back meanwhile, so that both become an error like any other. */
#define _GNU_SOURCE
#include "image/image.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

struct quiet_signals {
    sigset_t blocked, before, pending;
};

static void signals_hold(struct quiet_signals *q)
{
    sigemptyset(&q->blocked);
    sigaddset(&q->blocked, SIGXFSZ);
    sigaddset(&q->blocked, SIGPIPE);
    sigpending(&q->pending);
    pthread_sigmask(SIG_BLOCK, &q->blocked, &q->before);
}

static void signals_release(struct quiet_signals *q)
{
    /* Take back what our own writes raised, and only that. */
    const int ours[] = {SIGXFSZ, SIGPIPE};
    for (int i = 0; i < 2; i++) {
        sigset_t one;
        sigemptyset(&one);
        sigaddset(&one, ours[i]);
        if (!sigismember(&q->pending, ours[i]))
            while (sigtimedwait(&one, NULL, &(struct timespec){0, 0}) == -1 && errno == EINTR)
                ;
    }
    pthread_sigmask(SIG_SETMASK, &q->before, NULL);
}

/* 0 or an errno. */
static int write_all(int file, const uint8_t *bytes, size_t size)
{
    while (size > 0) {
        ssize_t n = write(file, bytes, size < (1u << 30) ? size : (1u << 30));
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return errno;
        if (n == 0)
            return ENOSPC;
        bytes += n;
        size -= (size_t)n;
    }
    return 0;
}

static int close_checked(int file)
{
    /* After EINTR the descriptor is gone on Linux all the same. */
    return close(file) != 0 && errno != EINTR ? errno : 0;
}

static int write_in_place(const char *path, const uint8_t *bytes, size_t size)
{
    int file = open(path, O_WRONLY | O_CLOEXEC | O_NOCTTY);
    if (file < 0)
        return errno;
    int error = write_all(file, bytes, size);
    int late = close_checked(file);
    return error ? error : late;
}

/* A file that did not exist before: .NAME.PID-N.tmp beside target. name has room for PATH_MAX. */
static int open_fresh(const char *target, char *name, int *out_file)
{
    const char *slash = strrchr(target, '/');
    int folder = slash ? (int)(slash - target) + 1 : 0;
    const char *base = target + folder;
    for (unsigned n = 0; n < 1000; n++) {
        /* The name may be as long as the file system allows: shorten it to leave room for ours. */
        int length = snprintf(name, PATH_MAX, "%.*s.%.200s.%ld-%u.tmp", folder, target, base,
                              (long)getpid(), n);
        if (length < 0 || length >= PATH_MAX)
            return ENAMETOOLONG;
        *out_file = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (*out_file >= 0)
            return 0;
        if (errno != EEXIST)
            return errno;
    }
    return EEXIST;
}

static int write_and_rename(const char *target, const struct stat *old, const uint8_t *bytes,
                            size_t size)
{
    char name[PATH_MAX];
    int file = -1;
    int error = open_fresh(target, name, &file);
    if (error)
        return error;
    error = write_all(file, bytes, size);
    if (!error && old && fchmod(file, old->st_mode & 07777) != 0)
        error = errno;
    int late = close_checked(file);
    if (!error)
        error = late;
    if (!error && rename(name, target) != 0)
        error = errno;
    if (error)
        unlink(name);
    return error;
}

static int write_file(const char *path, const uint8_t *bytes, size_t size)
{
    struct stat old;
    if (stat(path, &old) != 0) {
        /* Nothing there, or a link that leads nowhere: the file takes the name. */
        return errno == ENOENT ? write_and_rename(path, NULL, bytes, size) : errno;
    }
    if (S_ISDIR(old.st_mode))
        return EISDIR;
    if (!S_ISREG(old.st_mode))
        return write_in_place(path, bytes, size);
    if (access(path, W_OK) != 0)
        return errno;
    char *target = realpath(path, NULL); /* through links */
    if (!target)
        return errno;
    int error = write_and_rename(target, &old, bytes, size);
    free(target);
    return error;
}

pnb_status pnb_file_write(pnb_context *context, const char *path, const void *bytes, size_t size)
{
    if (!path || !*path)
        return status_fail(context, PNB_ERROR_ARGUMENT, "file", "the name is empty");
    struct quiet_signals quiet;
    signals_hold(&quiet);
    int error = write_file(path, bytes, size);
    signals_release(&quiet);
    if (error)
        return status_fail(context, PNB_ERROR_FILE, path, "cannot write: %s", strerror(error));
    return PNB_OK;
}

pnb_status file_read(pnb_context *context, const char *path, size_t limit,
                     bool (*accept)(const uint8_t *first, size_t size), uint8_t **out_bytes,
                     size_t *out_size)
{
    *out_bytes = NULL;
    *out_size = 0;
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY);
    if (file < 0)
        return status_fail(context, PNB_ERROR_FILE, path, "cannot open: %s", strerror(errno));

    uint8_t *bytes = NULL;
    size_t size = 0, capacity = 0;
    bool accepted = accept == NULL;
    pnb_status status = PNB_OK;
    struct stat info;
    /* A plain file's size is known: one allocation, a byte over so that the end shows. */
    size_t expected = 4096;
    if (fstat(file, &info) == 0 && S_ISREG(info.st_mode) && info.st_size > 0)
        expected = (size_t)info.st_size + 1;
    for (;;) {
        if (size == capacity) {
            size_t extra = accepted ? (expected > size ? expected - size : 1) : 4096;
            if (!memory_reserve(context, (void **)&bytes, &capacity, size, extra, 1)) {
                status = status_no_memory(context, size + extra);
                break;
            }
        }
        ssize_t n = read(file, bytes + size, capacity - size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0) {
            status = status_fail(context, PNB_ERROR_FILE, path, "cannot read: %s", strerror(errno));
            break;
        }
        if (n == 0)
            break;
        size += (size_t)n;
        if (!accepted && size >= 16) {
            accepted = true;
            if (!accept(bytes, 16))
                break; /* the caller sees the first bytes and says what it makes of them */
        }
        if (size > limit) {
            status = status_fail(context, PNB_ERROR_FILE, path, "larger than %zu bytes", limit);
            break;
        }
    }
    close(file);
    if (status != PNB_OK) {
        memory_free(context, bytes);
        return status;
    }
    *out_bytes = bytes;
    *out_size = size;
    return PNB_OK;
}
