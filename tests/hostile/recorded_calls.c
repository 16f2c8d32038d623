/* Preloaded into the program: writes every call that changes files or folders to a log, in the order in which they were made, with what was
   written, so that the fate of each can be played through (disk.py).
   CALLS_LOG=path of the log, which grows; CALLS_UNDER=folder whose files count; CALLS_LAST=N ends the process, as a kill does, after record N.
   A record is a line "call number other length length", then the bytes of two texts of these lengths. Numbers are the inode for open and
   mkdir, and the descriptor's inode for write, truncate and fsync. Paths are absolute. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

static int log_file = -1;
static const char* under = NULL;
static long last = 0, records = 0;
static pthread_mutex_t in_order = PTHREAD_MUTEX_INITIALIZER;

__attribute__((constructor)) static void begin(void) {
    int (*real)(const char*, int, ...) = (int (*)(const char*, int, ...))dlsym(RTLD_NEXT, "open");
    const char* path = getenv("CALLS_LOG");
    under = getenv("CALLS_UNDER");
    last = getenv("CALLS_LAST") ? atol(getenv("CALLS_LAST")) : 0;
    if (path && under) log_file = real(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
}

/* A call whose record cannot be written is one that the test would not see. */
static void note(const char* call, unsigned long number, unsigned long other, const void* one, size_t one_size, const void* two,
                 size_t two_size) {
    char head[160];
    const int size = snprintf(head, sizeof head, "%s %lu %lu %zu %zu\n", call, number, other, one_size, two_size);
    const struct iovec parts[3] = {{head, (size_t)size}, {(void*)one, one_size}, {(void*)two, two_size}};
    if (syscall(SYS_writev, log_file, parts, 3) != (long)((size_t)size + one_size + two_size)) abort();
    if (++records == last) _exit(9);
}

static int absolute(int folder, const char* path, char* to) {
    char named[PATH_MAX], place[64];
    if (path[0] != '/' && folder == AT_FDCWD) {
        if (!getcwd(named, sizeof named)) return 0;
    } else if (path[0] != '/') {
        snprintf(place, sizeof place, "/proc/self/fd/%d", folder);
        const ssize_t length = readlink(place, named, sizeof named - 1);
        if (length < 0) return 0;
        named[length] = 0;
    } else {
        named[0] = 0;
    }
    if (snprintf(to, PATH_MAX, "%s%s%s", named, path[0] == '/' ? "" : "/", path) >= PATH_MAX) return 0;
    return log_file >= 0 && strncmp(to, under, strlen(under)) == 0;
}

/* The inode of a descriptor of a file or folder that counts, 0 of any other. */
static unsigned long counted(int descriptor) {
    char place[64], path[PATH_MAX];
    struct stat state;
    if (log_file < 0 || descriptor == log_file) return 0;
    snprintf(place, sizeof place, "/proc/self/fd/%d", descriptor);
    const ssize_t length = readlink(place, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    if (strncmp(path, under, strlen(under)) != 0 || fstat(descriptor, &state) != 0) return 0;
    return state.st_ino;
}

#define IN_ORDER_BEGIN const int before_ = errno; pthread_mutex_lock(&in_order); errno = before_
#define IN_ORDER_END const int after_ = errno; pthread_mutex_unlock(&in_order); errno = after_

static int opened(int folder, const char* path, int flags, int is_new, int descriptor) {
    char place[PATH_MAX];
    struct stat state;
    if (descriptor < 0 || !absolute(folder, path, place) || fstat(descriptor, &state) != 0) return descriptor;
    if (is_new) note("create", state.st_ino, 0, place, strlen(place), "", 0);
    if (flags & O_TRUNC && S_ISREG(state.st_mode)) note("truncate", state.st_ino, 0, "", 0, "", 0);
    return descriptor;
}

static mode_t mode_of(int flags, va_list more) { return flags & (O_CREAT | O_TMPFILE) ? va_arg(more, mode_t) : 0; }

static int open_and_note(int folder, const char* path, int flags, mode_t mode) {
    IN_ORDER_BEGIN;
    struct stat state;
    const int is_new = flags & O_CREAT && fstatat(folder, path, &state, 0) != 0;
    const int descriptor = opened(folder, path, flags, is_new, (int)syscall(SYS_openat, folder, path, flags, mode));
    IN_ORDER_END;
    return descriptor;
}

int open(const char* path, int flags, ...) {
    va_list more;
    va_start(more, flags);
    const mode_t mode = mode_of(flags, more);
    va_end(more);
    return open_and_note(AT_FDCWD, path, flags, mode);
}
int open64(const char* path, int flags, ...) __attribute__((alias("open")));

int openat(int folder, const char* path, int flags, ...) {
    va_list more;
    va_start(more, flags);
    const mode_t mode = mode_of(flags, more);
    va_end(more);
    return open_and_note(folder, path, flags, mode);
}
int openat64(int folder, const char* path, int flags, ...) __attribute__((alias("openat")));

ssize_t write(int descriptor, const void* from, size_t size) {
    IN_ORDER_BEGIN;
    const unsigned long inode = counted(descriptor);
    const off_t at = inode ? lseek(descriptor, 0, SEEK_CUR) : 0;
    const ssize_t written = syscall(SYS_write, descriptor, from, size);
    if (inode && written > 0) note("write", inode, (unsigned long)at, from, (size_t)written, "", 0);
    IN_ORDER_END;
    return written;
}

/* No output is written by these: the log would have to tell more of them. */
ssize_t writev(int descriptor, const struct iovec* parts, int count) {
    if (counted(descriptor)) abort();
    return syscall(SYS_writev, descriptor, parts, count);
}
ssize_t pwrite(int descriptor, const void* from, size_t size, off_t at) {
    if (counted(descriptor)) abort();
    return syscall(SYS_pwrite64, descriptor, from, size, at);
}
ssize_t pwrite64(int descriptor, const void* from, size_t size, off_t at) __attribute__((alias("pwrite")));

int ftruncate(int descriptor, off_t size) {
    IN_ORDER_BEGIN;
    const int done = (int)syscall(SYS_ftruncate, descriptor, size);
    const unsigned long inode = counted(descriptor);
    if (inode && done == 0) note("truncate", inode, (unsigned long)size, "", 0, "", 0);
    IN_ORDER_END;
    return done;
}
int ftruncate64(int descriptor, off_t size) __attribute__((alias("ftruncate")));

static int sync_and_note(long call, int descriptor) {
    IN_ORDER_BEGIN;
    const int done = (int)syscall(call, descriptor);
    const unsigned long inode = counted(descriptor);
    if (inode && done == 0) note("fsync", inode, 0, "", 0, "", 0);
    IN_ORDER_END;
    return done;
}
int fsync(int descriptor) { return sync_and_note(SYS_fsync, descriptor); }
int fdatasync(int descriptor) { return sync_and_note(SYS_fdatasync, descriptor); }

static int note_names(const char* call, int done, int from_folder, const char* from, int to_folder, const char* to) {
    char one[PATH_MAX], two[PATH_MAX];
    if (done != 0) return done;
    const int first = absolute(from_folder, from, one), second = absolute(to_folder, to, two);
    if (first || second) note(call, 0, 0, one, strlen(one), two, strlen(two));
    return done;
}

int rename(const char* from, const char* to) {
    IN_ORDER_BEGIN;
    const int done = note_names("rename", (int)syscall(SYS_rename, from, to), AT_FDCWD, from, AT_FDCWD, to);
    IN_ORDER_END;
    return done;
}
int link(const char* from, const char* to) {
    IN_ORDER_BEGIN;
    const int done = note_names("link", (int)syscall(SYS_link, from, to), AT_FDCWD, from, AT_FDCWD, to);
    IN_ORDER_END;
    return done;
}
int unlink(const char* path) {
    IN_ORDER_BEGIN;
    const int done = note_names("unlink", (int)syscall(SYS_unlink, path), AT_FDCWD, path, AT_FDCWD, path);
    IN_ORDER_END;
    return done;
}
int rmdir(const char* path) {
    IN_ORDER_BEGIN;
    const int done = note_names("rmdir", (int)syscall(SYS_rmdir, path), AT_FDCWD, path, AT_FDCWD, path);
    IN_ORDER_END;
    return done;
}
int mkdir(const char* path, mode_t mode) {
    IN_ORDER_BEGIN;
    char place[PATH_MAX];
    struct stat state;
    const int done = (int)syscall(SYS_mkdir, path, mode);
    if (done == 0 && absolute(AT_FDCWD, path, place) && stat(path, &state) == 0)
        note("mkdir", state.st_ino, 0, place, strlen(place), "", 0);
    IN_ORDER_END;
    return done;
}

/* The program exchanges names by the number of the call. Others pass. */
long syscall(long number, ...) {
    static long (*real)(long, ...);
    va_list more;
    va_start(more, number);
    long with[6];
    for (int n = 0; n < 6; ++n) with[n] = va_arg(more, long);
    va_end(more);
    if (!real) real = (long (*)(long, ...))dlsym(RTLD_NEXT, "syscall");
    if (number != SYS_renameat2) return real(number, with[0], with[1], with[2], with[3], with[4], with[5]);
    IN_ORDER_BEGIN;
    const long done = real(number, with[0], with[1], with[2], with[3], with[4]);
    note_names(with[4] == 2 ? "exchange" : "rename", (int)done, (int)with[0], (const char*)with[1], (int)with[2], (const char*)with[3]);
    IN_ORDER_END;
    return done;
}
