/* scene/import_process.c: runs the importer and gathers its answer.
 *
 * The importer is a program of its own in a process group of its own; it gets /dev/null, two pipes
 * and nothing else of ours. Its answer is read as it comes, up to a limit; of its standard error
 * the first line that says something is kept. When the time is over, the answer too long, or the
 * caller cancels, the whole group is killed. Every way out closes the pipes and reaps the process.
 */
#define _GNU_SOURCE
#include "scene/import.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "scene/import_stream.h"

#define IMPORTER_NAME "penumbra-import"

static const char known_endings[] = "glb gltf obj ply stl off dae fbx 3ds x3d blend lwo ac ms3d x";

static bool known_ending(const char *path)
{
    const char *dot = strrchr(path, '.'), *slash = strrchr(path, '/');
    if (!dot || (slash && dot < slash) || !dot[1])
        return false;
    size_t length = strlen(dot + 1);
    for (const char *p = known_endings; *p; p += strcspn(p, " "), p += *p == ' ')
        if (strcspn(p, " ") == length && strncasecmp(p, dot + 1, length) == 0)
            return true;
    return false;
}

/* A regular file of a known kind, with something in it, that we may read. */
static pnb_status check_file(pnb_context *context, const char *path, size_t *out_size)
{
    struct stat info;
    int fd = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0)
        return status_fail(context, PNB_ERROR_FILE, path, "%s", strerror(errno));
    int result = fstat(fd, &info);
    int reason = errno;
    close(fd);
    if (result != 0)
        return status_fail(context, PNB_ERROR_FILE, path, "%s", strerror(reason));
    if (S_ISDIR(info.st_mode))
        return status_fail(context, PNB_ERROR_FILE, path, "is a folder");
    if (!S_ISREG(info.st_mode))
        return status_fail(context, PNB_ERROR_FILE, path, "is not a regular file");
    if (!known_ending(path))
        return status_fail(context, PNB_ERROR_FORMAT, path,
                           "unknown kind of file; the endings read are: json %s", known_endings);
    if (info.st_size == 0)
        return status_fail(context, PNB_ERROR_FORMAT, path, "is empty");
    *out_size = (size_t)info.st_size;
    return PNB_OK;
}

/* Folder of the file, up times ".." further, then rest. */
static bool try_beside(const char *file, const char *rest, char *out)
{
    const char *slash = strrchr(file, '/');
    int length = slash ? (int)(slash - file) : 1;
    if (snprintf(out, PATH_MAX, "%.*s/%s", length, slash ? file : ".", rest) >= PATH_MAX)
        return false;
    return access(out, X_OK) == 0;
}

/* PNB_IMPORTER; beside the library or the program, or up to two folders above them, as in a build
 * folder; where it was to be installed; in libexec relative to the library, when the installation
 * was moved. */
static pnb_status find_importer(pnb_context *context, char *out)
{
    static const char *const built[] = {IMPORTER_NAME, "../" IMPORTER_NAME, "../../" IMPORTER_NAME};
    static const char *const moved[] = {"../libexec/penumbra/" IMPORTER_NAME,
                                        "../../libexec/penumbra/" IMPORTER_NAME};
    const char *given = getenv("PNB_IMPORTER");
    if (given && *given) {
        snprintf(out, PATH_MAX, "%s", given);
        return PNB_OK;
    }
    Dl_info library = {0};
    char program[PATH_MAX];
    ssize_t length = readlink("/proc/self/exe", program, sizeof(program) - 1);
    program[length > 0 ? length : 0] = 0;
    if (!dladdr((void *)known_endings, &library) || !library.dli_fname)
        library.dli_fname = program;
    for (size_t i = 0; i < 3; i++)
        if (try_beside(library.dli_fname, built[i], out) || try_beside(program, built[i], out))
            return PNB_OK;
    snprintf(out, PATH_MAX, "%s/%s", PNB_LIBEXECDIR, IMPORTER_NAME);
    if (access(out, X_OK) == 0)
        return PNB_OK;
    for (size_t i = 0; i < 2; i++)
        if (try_beside(library.dli_fname, moved[i], out) || try_beside(program, moved[i], out))
            return PNB_OK;
    return status_fail(context, PNB_ERROR_FILE, IMPORTER_NAME,
                       "not found in %s nor beside the program (PNB_IMPORTER names another place)",
                       PNB_LIBEXECDIR);
}

struct job {
    pnb_context *context;
    const char *path;
    size_t memory_bytes, answer_limit;
    double seconds;
    pid_t pid; /* 0: none */
    int answer_fd, complaint_fd;
    unsigned char *answer;
    size_t answer_size, answer_capacity;
    char complaint[4096];
    size_t complaint_size;
};

static void close_fd(int *fd)
{
    if (*fd >= 0)
        close(*fd);
    *fd = -1;
}

/* A pipe whose ends keep clear of the standard descriptors (the program may have closed those). */
static bool open_pipe(int *out_read, int *out_write)
{
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
        return false;
    for (int i = 0; i < 2; i++)
        if (ends[i] <= STDERR_FILENO) {
            int moved = fcntl(ends[i], F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
            close(ends[i]);
            ends[i] = moved;
        }
    *out_read = ends[0];
    *out_write = ends[1];
    return ends[0] >= 0 && ends[1] >= 0;
}

static int spawn(struct job *job, const char *importer, int answer_end, int complaint_end)
{
    char memory[32], seconds[32], path[PATH_MAX + 2];
    snprintf(memory, sizeof(memory), "%zu", job->memory_bytes);
    snprintf(seconds, sizeof(seconds), "%.0f", ceil(job->seconds));
    /* A name that begins with a dash is a file all the same. */
    snprintf(path, sizeof(path), "%s%s", job->path[0] == '-' ? "./" : "", job->path);
    char *arguments[] = {IMPORTER_NAME, "--memory", memory, "--seconds", seconds, path, NULL};

    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    int error = posix_spawn_file_actions_init(&files);
    if (error)
        return error;
    error = posix_spawnattr_init(&attributes);
    if (error) {
        posix_spawn_file_actions_destroy(&files);
        return error;
    }
    sigset_t none, usual;
    sigemptyset(&none);
    sigfillset(&usual);
    sigdelset(&usual, SIGKILL);
    sigdelset(&usual, SIGSTOP);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &usual);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF |
                                              POSIX_SPAWN_SETPGROUP);
    error = posix_spawn_file_actions_adddup2(&files, answer_end, STDOUT_FILENO);
    if (!error)
        error = posix_spawn_file_actions_adddup2(&files, complaint_end, STDERR_FILENO);
    if (!error)
        error = posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    if (!error)
        error = posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
    if (!error)
        error = posix_spawn(&job->pid, importer, &files, &attributes, arguments, environ);
    if (error)
        job->pid = 0;
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return error;
}

/* One read of what is there. */
static pnb_status read_answer(struct job *job)
{
    if (!memory_reserve(job->context, (void **)&job->answer, &job->answer_capacity,
                        job->answer_size, 1u << 18, 1))
        return status_no_memory(job->context, job->answer_size + (1u << 18));
    ssize_t n = read(job->answer_fd, job->answer + job->answer_size,
                     job->answer_capacity - job->answer_size);
    if (n == 0 || (n < 0 && errno != EINTR && errno != EAGAIN))
        close_fd(&job->answer_fd);
    if (n > 0)
        job->answer_size += (size_t)n;
    if (job->answer_size > job->answer_limit)
        return status_fail(job->context, PNB_ERROR_MEMORY, job->path,
                           "holds more than %zu MiB of scene", job->answer_limit >> 20);
    if (job->answer_size >= 8 && memcmp(job->answer, IMPORT_MAGIC, 8) != 0)
        return status_fail(job->context, PNB_ERROR_FORMAT, job->path,
                           "the importer's answer is none");
    return PNB_OK;
}

static void read_complaint(struct job *job)
{
    char bin[4096];
    size_t room = sizeof(job->complaint) - 1 - job->complaint_size;
    ssize_t n = read(job->complaint_fd, room > 0 ? job->complaint + job->complaint_size : bin,
                     room > 0 ? room : sizeof(bin));
    if (n == 0 || (n < 0 && errno != EINTR && errno != EAGAIN))
        close_fd(&job->complaint_fd);
    if (n > 0 && room > 0)
        job->complaint_size += (size_t)n;
}

/* Until both pipes are at their end. Anything but PNB_OK: the importer is still to be killed. */
static pnb_status gather(struct job *job, double deadline_ms)
{
    pnb_context *context = job->context;
    while (job->answer_fd >= 0 || job->complaint_fd >= 0) {
        double left = deadline_ms - clock_ms();
        if (!(left > 0))
            return status_fail(context, PNB_ERROR_FORMAT, job->path, "took more than %g s to read",
                               job->seconds);
        struct pollfd watched[2] = {{job->answer_fd, POLLIN, 0}, {job->complaint_fd, POLLIN, 0}};
        int ready = poll(watched, 2, left < 50 ? (int)left + 1 : 50);
        if (ready < 0 && errno != EINTR)
            return status_fail(context, PNB_ERROR_DEVICE, job->path, "cannot wait: %s",
                               strerror(errno));
        if (ready <= 0) {
            if (context->desc.progress &&
                !context->desc.progress(context->desc.user, "importing", 0))
                return status_fail(context, PNB_ERROR_CANCELLED, job->path, "cancelled");
            continue;
        }
        if (watched[1].revents)
            read_complaint(job);
        pnb_status status = watched[0].revents ? read_answer(job) : PNB_OK;
        if (status != PNB_OK)
            return status;
    }
    return PNB_OK;
}

/* After the pipes are closed the end is near; a process that goes on all the same is killed. */
static pnb_status wait_for_end(struct job *job, double deadline_ms, int *out_status)
{
    *out_status = 0;
    for (long nap_us = 50;; nap_us = nap_us < 10000 ? nap_us * 2 : nap_us) {
        pid_t done = waitpid(job->pid, out_status, WNOHANG);
        if (done == job->pid || (done < 0 && errno == ECHILD)) {
            job->pid = 0; /* ECHILD: the program ignores SIGCHLD; the answer's end must do */
            return PNB_OK;
        }
        if (clock_ms() > deadline_ms)
            return status_fail(job->context, PNB_ERROR_FORMAT, job->path,
                               "took more than %g s to read", job->seconds);
        nanosleep(&(struct timespec){0, nap_us * 1000}, NULL);
    }
}

/* The first line with a letter in it. */
static const char *first_complaint(struct job *job)
{
    char *line = job->complaint;
    job->complaint[job->complaint_size] = 0;
    while (*line) {
        size_t length = strcspn(line, "\n");
        char end = line[length];
        line[length] = 0;
        for (const char *c = line; *c; c++)
            if ((*c | 0x20) >= 'a' && (*c | 0x20) <= 'z')
                return line;
        line += length + (end != 0);
    }
    return "";
}

/* What an ended importer's status means. */
static pnb_status judge(struct job *job, int status)
{
    pnb_context *context = job->context;
    int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    job->complaint[job->complaint_size] = 0;
    bool memory = strstr(job->complaint, "bad_alloc") != NULL;
    const char *why = first_complaint(job);
    if (signal == SIGXCPU)
        return status_fail(context, PNB_ERROR_FORMAT, job->path, "took more than %g s to read",
                           job->seconds);
    if ((WIFEXITED(status) && WEXITSTATUS(status) == IMPORT_NO_MEMORY) || (signal && memory))
        return status_fail(context, PNB_ERROR_MEMORY, job->path,
                           "the importer wants more than %zu MiB of memory",
                           job->memory_bytes >> 20);
    if (signal)
        return status_fail(context, PNB_ERROR_FORMAT, job->path,
                           "the importer crashed (signal %d)%s%.300s", signal, *why ? ": " : "",
                           why);
    int exit_status = WEXITSTATUS(status);
    if (exit_status == IMPORT_BAD_FILE && *why)
        return status_fail(context, PNB_ERROR_FORMAT, job->path, "%.300s", why);
    if (exit_status != IMPORT_DONE)
        return status_fail(context, PNB_ERROR_FORMAT, job->path,
                           "the importer failed (exit status %d)%s%.300s", exit_status,
                           *why ? ": " : "", why);
    return PNB_OK;
}

/* Starts the importer with its two pipes. */
static pnb_status start(struct job *job)
{
    char importer[PATH_MAX];
    pnb_status status = find_importer(job->context, importer);
    if (status != PNB_OK)
        return status;
    int answer_end = -1, complaint_end = -1;
    if (!open_pipe(&job->answer_fd, &answer_end) ||
        !open_pipe(&job->complaint_fd, &complaint_end)) {
        status =
            status_fail(job->context, PNB_ERROR_DEVICE, job->path, "no pipe: %s", strerror(errno));
    } else {
        fcntl(job->answer_fd, F_SETPIPE_SZ, 1 << 20); /* fewer turns; fine if refused */
        fcntl(job->answer_fd, F_SETFL, O_NONBLOCK);
        fcntl(job->complaint_fd, F_SETFL, O_NONBLOCK);
        int error = spawn(job, importer, answer_end, complaint_end);
        if (error)
            status = status_fail(job->context, PNB_ERROR_FILE, importer,
                                 "cannot be started to read %s: %s", job->path, strerror(error));
    }
    close_fd(&answer_end);
    close_fd(&complaint_end);
    return status;
}

pnb_status scene_import_run(pnb_context *context, const char *path,
                            const struct scene_import_limits *limits, unsigned char **out_bytes,
                            size_t *out_size)
{
    struct scene_import_limits defaults = {0};
    size_t file_size = 0;
    *out_bytes = NULL;
    *out_size = 0;
    if (!limits)
        limits = &defaults;
    pnb_status status = check_file(context, path, &file_size);
    if (status != PNB_OK)
        return status;
    struct job job = {.context = context, .path = path, .answer_fd = -1, .complaint_fd = -1};
    job.memory_bytes = (size_t)4 << 30;
    if (file_size > job.memory_bytes / 32)
        job.memory_bytes = file_size * 32;
    if (limits->memory_bytes)
        job.memory_bytes = limits->memory_bytes;
    job.answer_limit = limits->answer_bytes ? limits->answer_bytes : (size_t)2 << 30;
    job.seconds = limits->seconds > 0 ? limits->seconds : 120;

    status = start(&job);
    double deadline_ms = clock_ms() + job.seconds * 1e3;
    int end = 0;
    if (status == PNB_OK)
        status = gather(&job, deadline_ms);
    close_fd(&job.answer_fd);
    close_fd(&job.complaint_fd);
    if (status == PNB_OK)
        status = wait_for_end(&job, deadline_ms, &end);
    if (job.pid > 0) {
        kill(-job.pid, SIGKILL);
        kill(job.pid, SIGKILL);
        while (waitpid(job.pid, &end, 0) < 0 && errno == EINTR)
            ;
    } else if (status == PNB_OK) {
        status = judge(&job, end);
    }
    if (status != PNB_OK) {
        memory_free(context, job.answer);
        return status;
    }
    *out_bytes = job.answer;
    *out_size = job.answer_size;
    return PNB_OK;
}
