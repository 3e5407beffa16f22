/* Whole files in, and files out that are either the old one or the new one. */
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "context.h"

/* strerror is not thread-safe and speaks the locale's language; these few say it plainly. */
static const char *reason(int e)
{
    switch (e) {
    case ENOENT:
        return "there is no such file or folder";
    case EACCES:
    case EPERM:
        return "permission denied";
    case EISDIR:
        return "it is a folder";
    case ENOTDIR:
        return "a part of the path is not a folder";
    case ENAMETOOLONG:
        return "the name is too long";
    case ENOSPC:
    case EDQUOT:
        return "the disk is full";
    case EROFS:
        return "the file system is read-only";
    case EMFILE:
    case ENFILE:
        return "too many files are open";
    case ELOOP:
        return "too many symbolic links";
    case EFBIG:
        return "the file is too large";
    case EPIPE:
        return "nobody reads any more";
    case EIO:
        return "input or output error";
    default:
        return "system error";
    }
}

static rt_status fail_path(rt_context *ctx, const char *doing, const char *path, int e)
{
    char name[512];
    return rti_fail(ctx, RT_ERROR_IO, "%s: cannot %s: %s (errno %d)", rti_quote(name, sizeof name, path, strlen(path)), doing,
                    reason(e), e);
}

enum { WHY_SIZE = 512 };

/* The context's hook, when it has one: a descriptor, -1 with *status set, or RT_OPEN_DEFAULT. */
static int ask_hook(rt_context *ctx, const char *path, rt_open_mode mode, const char *doing, rt_status *status)
{
    char name[512], why[WHY_SIZE] = "";
    int fd;
    if (!ctx->open)
        return RT_OPEN_DEFAULT;
    errno = 0;
    fd = ctx->open(ctx->open_user, path, mode, why, sizeof why);
    if (fd >= 0 || fd == RT_OPEN_DEFAULT)
        return fd;
    why[sizeof why - 1] = 0;
    *status = why[0]
                  ? rti_fail(ctx, RT_ERROR_IO, "%s: cannot %s: %s", rti_quote(name, sizeof name, path, strlen(path)), doing, why)
                  : fail_path(ctx, doing, path, errno);
    return -1;
}

static rt_status read_all(rt_context *ctx, int fd, const char *path, uint64_t limit, size_t guess, void **data, size_t *size)
{
    size_t capacity = guess + 1, used = 0;
    unsigned char *block = rti_alloc(ctx, capacity + 1);
    char name[512];
    if (!block)
        return rti_fail_memory(ctx, rti_quote(name, sizeof name, path, strlen(path)), capacity + 1);
    for (;;) {
        ssize_t n;
        if (used == capacity) { /* grows only when the file does while we read it, or is a pipe */
            size_t grown = capacity * 2;
            void *moved = rti_realloc(ctx, block, capacity + 1, grown + 1);
            if (!moved) {
                rti_free(ctx, block, capacity + 1);
                return rti_fail_memory(ctx, rti_quote(name, sizeof name, path, strlen(path)), grown + 1);
            }
            block = moved;
            capacity = grown;
        }
        n = read(fd, block + used, capacity - used);
        if (n == 0)
            break;
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0) {
            int e = errno;
            rti_free(ctx, block, capacity + 1);
            return fail_path(ctx, "read it", path, e);
        }
        used += (size_t)n;
        if (limit && used > limit) {
            rti_free(ctx, block, capacity + 1);
            return rti_fail(ctx, RT_ERROR_MEMORY_LIMIT, "%s: the file has more than the %llu bytes allowed",
                            rti_quote(name, sizeof name, path, strlen(path)), (unsigned long long)limit);
        }
    }
    if (used != capacity) { /* the caller frees size + 1 bytes */
        void *fitted = rti_shrink(ctx, block, capacity + 1, used + 1);
        if (!fitted)
            fitted = rti_realloc(ctx, block, capacity + 1, used + 1);
        if (!fitted) {
            rti_free(ctx, block, capacity + 1);
            return rti_fail_memory(ctx, rti_quote(name, sizeof name, path, strlen(path)), used + 1);
        }
        block = fitted;
    }
    block[used] = 0;
    *data = block;
    *size = used;
    return RT_OK;
}

static rt_status check_regular(rt_context *ctx, const char *path, int fd, uint64_t *size)
{
    struct stat st;
    char name[512];
    if (fstat(fd, &st) != 0)
        return fail_path(ctx, "look at it", path, errno);
    if (!S_ISREG(st.st_mode))
        return rti_fail(ctx, RT_ERROR_IO, "%s: %s, not a regular file", rti_quote(name, sizeof name, path, strlen(path)),
                        S_ISDIR(st.st_mode) ? "it is a folder" : "it is a device or a pipe");
    *size = (uint64_t)st.st_size;
    return RT_OK;
}

/* A regular file, open; *size: its bytes now. */
static rt_status open_regular(rt_context *ctx, const char *path, int *fd, uint64_t *size)
{
    rt_status status = RT_OK;
    *fd = ask_hook(ctx, path, RT_OPEN_READ, "open it for reading", &status);
    if (*fd == -1)
        return status;
    if (*fd < 0)
        *fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY); /* a named pipe without a writer does not hang us */
    if (*fd < 0)
        return fail_path(ctx, "open it for reading", path, errno);
    status = check_regular(ctx, path, *fd, size);
    if (status != RT_OK)
        close(*fd);
    return status;
}

rt_status rti_file_read(rt_context *ctx, const char *path, uint64_t limit, void **data, size_t *size)
{
    char name[512];
    uint64_t bytes = 0;
    rt_status status;
    int fd;
    *data = NULL;
    *size = 0;
    status = open_regular(ctx, path, &fd, &bytes);
    if (status != RT_OK)
        return status;
    if ((limit && bytes > limit) || bytes > SIZE_MAX / 4) {
        close(fd);
        return rti_fail(ctx, RT_ERROR_MEMORY_LIMIT, "%s: the file has %llu bytes; %llu are allowed",
                        rti_quote(name, sizeof name, path, strlen(path)), (unsigned long long)bytes,
                        (unsigned long long)(limit ? limit : SIZE_MAX / 4));
    }
    status = read_all(ctx, fd, path, limit, (size_t)bytes, data, size);
    close(fd);
    return status;
}

/* ---- files that may be known already ---- */

#define SETTLES 2000000000LL /* nanoseconds: the coarsest clock of a file system that is still in use ticks every 2 s */

static int64_t nanoseconds(struct timespec t)
{
    return (int64_t)t.tv_sec * 1000000000LL + t.tv_nsec;
}

static bool look(int fd, rti_stamp *stamp)
{
    struct stat st;
    struct timespec now;
    int64_t last;
    clock_gettime(CLOCK_REALTIME, &now); /* before the look: what changes after it is younger */
    if (fstat(fd, &st) != 0)
        return false;
    *stamp = (rti_stamp){.device = (uint64_t)st.st_dev,
                         .inode = (uint64_t)st.st_ino,
                         .size = (uint64_t)st.st_size,
                         .changed = nanoseconds(st.st_ctim),
                         .modified = nanoseconds(st.st_mtim)};
    last = stamp->changed > stamp->modified ? stamp->changed : stamp->modified;
    stamp->settled = last < nanoseconds(now) - SETTLES;
    return true;
}

bool rti_stamp_equal(const rti_stamp *a, const rti_stamp *b)
{
    return a->device == b->device && a->inode == b->inode && a->size == b->size && a->changed == b->changed &&
           a->modified == b->modified;
}

rt_status rti_input_open(rt_context *ctx, const char *path, rti_input *in)
{
    uint64_t size;
    rt_status status = open_regular(ctx, path, &in->fd, &size);
    in->path = path;
    in->stamped = status == RT_OK && look(in->fd, &in->stamp);
    return status;
}

rt_status rti_input_read(rt_context *ctx, rti_input *in, void **data, size_t *size)
{
    char name[512];
    uint64_t bytes = in->stamped ? in->stamp.size : 0;
    rti_stamp after;
    rt_status status;
    *data = NULL;
    *size = 0;
    if (bytes > SIZE_MAX / 4)
        return rti_fail(ctx, RT_ERROR_MEMORY_LIMIT, "%s: the file has %llu bytes; %llu are allowed",
                        rti_quote(name, sizeof name, in->path, strlen(in->path)), (unsigned long long)bytes,
                        (unsigned long long)(SIZE_MAX / 4));
    status = read_all(ctx, in->fd, in->path, 0, (size_t)bytes, data, size);
    /* The stamp is one of these bytes only if it held while they were read. */
    in->stamped = in->stamped && look(in->fd, &after) && rti_stamp_equal(&after, &in->stamp) && *size == in->stamp.size;
    return status;
}

void rti_input_close(rti_input *in)
{
    close(in->fd);
    in->fd = -1;
}

/* ---- reader ---- */

struct rti_reader {
    rt_context *ctx;
    char *path;
    size_t path_size;
    uint64_t size;
    int fd;
};

/* Takes the descriptor over, or closes it. */
static rt_status make_reader(rt_context *ctx, const char *path, int fd, rti_reader **reader)
{
    rti_reader *r = rti_alloc_zero(ctx, sizeof *r);
    uint64_t size = 0;
    rt_status status = check_regular(ctx, path, fd, &size);
    if (status == RT_OK && r) {
        r->path_size = strlen(path) + 1;
        r->path = rti_alloc(ctx, r->path_size);
    }
    if (status == RT_OK && (!r || !r->path))
        status = rti_fail_memory(ctx, "reading a file", strlen(path) + sizeof *r);
    if (status != RT_OK) {
        close(fd);
        if (r)
            rti_free(ctx, r->path, r->path_size);
        rti_free(ctx, r, sizeof *r);
        return status;
    }
    memcpy(r->path, path, r->path_size);
    r->ctx = ctx;
    r->fd = fd;
    r->size = size;
    *reader = r;
    return RT_OK;
}

rt_status rti_reader_open(rt_context *ctx, const char *path, rti_reader **reader)
{
    uint64_t size;
    int fd;
    rt_status status = open_regular(ctx, path, &fd, &size);
    *reader = NULL;
    return status == RT_OK ? make_reader(ctx, path, fd, reader) : status;
}

uint64_t rti_reader_size(const rti_reader *reader)
{
    return reader->size;
}

rt_status rti_reader_read(rti_reader *r, uint64_t offset, void *to, size_t size)
{
    unsigned char *p = to;
    char name[512];
    if (offset > r->size || size > r->size - offset)
        return rti_fail(r->ctx, RT_ERROR_IO, "%s: %zu bytes were wanted from byte %llu; the file has %llu",
                        rti_quote(name, sizeof name, r->path, strlen(r->path)), size, (unsigned long long)offset,
                        (unsigned long long)r->size);
    while (size > 0) {
        ssize_t n = pread(r->fd, p, size, (off_t)offset);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return n < 0 ? fail_path(r->ctx, "read it", r->path, errno)
                         : rti_fail(r->ctx, RT_ERROR_IO, "%s: the file became shorter while it was read",
                                    rti_quote(name, sizeof name, r->path, strlen(r->path)));
        p += n;
        size -= (size_t)n;
        offset += (uint64_t)n;
    }
    return RT_OK;
}

void rti_reader_close(rti_reader *r)
{
    if (!r)
        return;
    close(r->fd);
    rti_free(r->ctx, r->path, r->path_size);
    rti_free(r->ctx, r, sizeof *r);
}

/* ---- files that the library makes and goes on with ---- */

rt_status rti_place_open(rt_context *ctx, const char *path, rti_place *place)
{
    rt_status status = RT_OK;
    const char *slash = strrchr(path, '/');
    memset(place, 0, sizeof *place);
    place->ctx = ctx;
    place->folder = AT_FDCWD;
    place->size = strlen(path) + 1;
    place->path = rti_alloc(ctx, place->size);
    if (!place->path)
        return rti_fail_memory(ctx, "the name of a file", place->size);
    memcpy(place->path, path, place->size);
    place->target = place->path;
    int folder = ask_hook(ctx, path, RT_OPEN_FOLDER, "write it", &status);
    if (folder == -1) {
        rti_place_close(place);
        return status;
    }
    if (folder >= 0) {
        place->folder = folder;
        place->given = true;
        place->target = slash ? place->path + (slash - path) + 1 : place->path;
    }
    return RT_OK;
}

void rti_place_close(rti_place *place)
{
    if (!place->path)
        return;
    if (place->given)
        close(place->folder);
    rti_free(place->ctx, place->path, place->size);
    memset(place, 0, sizeof *place);
}

bool rti_place_there(const rti_place *place)
{
    struct stat st;
    return fstatat(place->folder, place->target, &st, place->given ? AT_SYMLINK_NOFOLLOW : 0) == 0 ||
           (errno != ENOENT && errno != ENOTDIR);
}

void rti_place_remove(const rti_place *place)
{
    unlinkat(place->folder, place->target, 0);
}

rt_status rti_place_read(const rti_place *place, rti_reader **reader)
{
    *reader = NULL;
    int fd = openat(place->folder, place->target, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY | (place->given ? O_NOFOLLOW : 0));
    if (fd < 0)
        return fail_path(place->ctx, "open it for reading", place->path, errno);
    return make_reader(place->ctx, place->path, fd, reader);
}

rt_status rti_place_append(const rti_place *place, uint64_t offset, const void *data, size_t size)
{
    const unsigned char *p = data;
    int e = 0, fd = openat(place->folder, place->target,
                           O_WRONLY | O_CREAT | O_CLOEXEC | O_NOCTTY | (place->given ? O_NOFOLLOW : 0), 0666);
    if (fd < 0)
        return fail_path(place->ctx, "open it for writing", place->path, errno);
    if (ftruncate(fd, (off_t)offset) != 0)
        e = errno;
    while (size > 0 && !e) {
        ssize_t n = pwrite(fd, p, size, (off_t)offset);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0) {
            e = n < 0 ? errno : EIO;
            break;
        }
        p += n;
        size -= (size_t)n;
        offset += (uint64_t)n;
    }
    if (!e && fsync(fd) != 0 && errno != EINVAL && errno != ENOSYS)
        e = errno;
    if (close(fd) != 0 && !e)
        e = errno;
    return e ? fail_path(place->ctx, "write it", place->path, e) : RT_OK;
}

/* ---- writer ---- */

struct rti_writer {
    rt_context *ctx;
    char *path, *aside; /* aside NULL: written straight (standard output, devices, pipes) */
    size_t path_size, aside_size;
    const char *target; /* path, or its last part in the hook's folder */
    int folder;         /* of the hook; else AT_FDCWD */
    int fd;
    bool own_fd;
    rt_status status;
    size_t used;
    unsigned char buffer[65536];
};

static rt_status flush(rti_writer *w)
{
    size_t at = 0;
    while (w->status == RT_OK && at < w->used) {
        ssize_t n = write(w->fd, w->buffer + at, w->used - at);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            w->status = fail_path(w->ctx, "write it", w->path, errno);
        else
            at += (size_t)n;
    }
    w->used = 0;
    return w->status;
}

static void writer_free(rti_writer *w)
{
    rt_context *ctx = w->ctx;
    if (w->folder >= 0)
        close(w->folder);
    rti_free(ctx, w->path, w->path_size);
    rti_free(ctx, w->aside, w->aside_size);
    rti_free(ctx, w, sizeof *w);
}

/* In a hook's folder what stands there is replaced, whatever it is. */
static bool is_plain_target(const rti_writer *w)
{
    struct stat st;
    return w->folder >= 0 || stat(w->path, &st) != 0 || S_ISREG(st.st_mode);
}

static bool is_folder(const rti_writer *w)
{
    struct stat st;
    int how = w->folder >= 0 ? AT_SYMLINK_NOFOLLOW : 0;
    return fstatat(w->folder, w->target, &st, how) == 0 && S_ISDIR(st.st_mode);
}

/* A name of our own beside the target: ".NAME.PID-N.part" is not longer than the name limit allows for usual names; the counter
 * avoids what is there. */
static rt_status open_aside(rti_writer *w)
{
    const char *slash = strrchr(w->target, '/');
    size_t folder = slash ? (size_t)(slash - w->target) + 1 : 0;
    w->aside_size = folder + 64;
    w->aside = rti_alloc(w->ctx, w->aside_size);
    if (!w->aside)
        return rti_fail_memory(w->ctx, "writing a file", w->aside_size);
    memcpy(w->aside, w->target, folder);
    for (unsigned n = 0; n < 10000; n++) {
        snprintf(w->aside + folder, 64, ".rtray-%ld-%u.part", (long)getpid(), n);
        w->fd = openat(w->folder, w->aside, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (w->fd >= 0)
            return RT_OK;
        if (errno != EEXIST)
            break;
    }
    return fail_path(w->ctx, "write beside it", w->path, errno);
}

/* Asks the hook for the target's folder, and opens what is written to. */
static rt_status open_target(rti_writer *w, const rti_place *place)
{
    rt_status status = RT_OK;
    if (strcmp(w->path, "-") == 0) {
        w->fd = STDOUT_FILENO;
        w->own_fd = false;
        return RT_OK;
    }
    int folder = !place         ? ask_hook(w->ctx, w->path, RT_OPEN_FOLDER, "write it", &status)
                 : place->given ? fcntl(place->folder, F_DUPFD_CLOEXEC, 0)
                                : RT_OPEN_DEFAULT;
    if (folder == -1)
        return place ? fail_path(w->ctx, "write it", w->path, errno) : status;
    if (folder >= 0) {
        const char *slash = strrchr(w->path, '/');
        w->folder = folder;
        w->target = slash ? slash + 1 : w->path;
    }
    if (is_folder(w))
        return fail_path(w->ctx, "write it", w->path, EISDIR);
    if (is_plain_target(w))
        return open_aside(w);
    w->fd = open(w->path, O_WRONLY | O_CLOEXEC | O_NOCTTY);
    return w->fd < 0 ? fail_path(w->ctx, "open it for writing", w->path, errno) : RT_OK;
}

static rt_status writer_open(rt_context *ctx, const char *path, const rti_place *place, rti_writer **writer)
{
    rti_writer *w;
    rt_status status;
    *writer = NULL;
    if (path[0] == '\0')
        return rti_fail(ctx, RT_ERROR_IO, "the name of the file to write is empty");
    w = rti_alloc_zero(ctx, sizeof *w);
    if (!w)
        return rti_fail_memory(ctx, "writing a file", sizeof *w);
    w->ctx = ctx;
    w->fd = -1;
    w->folder = AT_FDCWD;
    w->own_fd = true;
    w->path_size = strlen(path) + 1;
    w->path = rti_alloc(ctx, w->path_size);
    if (!w->path) {
        status = rti_fail_memory(ctx, "writing a file", w->path_size);
        writer_free(w);
        return status;
    }
    memcpy(w->path, path, w->path_size);
    w->target = w->path;
    status = open_target(w, place);
    if (status != RT_OK) {
        writer_free(w);
        return status;
    }
    *writer = w;
    return RT_OK;
}

rt_status rti_writer_open(rt_context *ctx, const char *path, rti_writer **writer)
{
    return writer_open(ctx, path, NULL, writer);
}

rt_status rti_place_write(const rti_place *place, rti_writer **writer)
{
    return writer_open(place->ctx, place->path, place, writer);
}

rt_status rti_writer_write(rti_writer *w, const void *data, size_t size)
{
    const unsigned char *p = data;
    while (w->status == RT_OK && size > 0) {
        size_t room = sizeof w->buffer - w->used, take = size < room ? size : room;
        memcpy(w->buffer + w->used, p, take);
        w->used += take;
        p += take;
        size -= take;
        if (w->used == sizeof w->buffer)
            flush(w);
    }
    return w->status;
}

rt_status rti_writer_close(rti_writer *w, bool keep)
{
    rt_status status;
    if (!w)
        return RT_OK;
    if (keep)
        flush(w);
    status = w->status;
    if (w->aside && keep && status == RT_OK && fsync(w->fd) != 0 && errno != EINVAL && errno != ENOSYS)
        status = fail_path(w->ctx, "write it", w->path, errno);
    if (w->own_fd && close(w->fd) != 0 && keep && status == RT_OK)
        status = fail_path(w->ctx, "write it", w->path, errno);
    if (w->aside) {
        if (keep && status == RT_OK && renameat(w->folder, w->aside, w->folder, w->target) != 0)
            status = fail_path(w->ctx, "put it in its place", w->path, errno);
        if (!keep || status != RT_OK)
            unlinkat(w->folder, w->aside, 0);
    }
    writer_free(w);
    return status;
}
