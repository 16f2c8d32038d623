/* Preloaded into the program: lets the Nth call of a kind fail, and sets a rounding mode before main().
   FAIL_CALL=malloc|pthread_create|open|read|write|rename|fsync, FAIL_AT=N, FAIL_FROM_THEN_ON=1, FAIL_ERRNO=number; ROUNDING=up|down|zero.
   CLOCK=seconds since 1970 that the clock shows, standing still. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <fenv.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);

static const char* failing = NULL;
static long fail_at = 0;
static int from_then_on = 0, number = 0;
static atomic_long calls;

__attribute__((constructor)) static void read_settings(void) {
    const char* rounding = getenv("ROUNDING");
    if (rounding) fesetround(*rounding == 'u' ? FE_UPWARD : *rounding == 'd' ? FE_DOWNWARD : FE_TOWARDZERO);
    fail_at = getenv("FAIL_AT") ? atol(getenv("FAIL_AT")) : 0;
    from_then_on = getenv("FAIL_FROM_THEN_ON") != NULL;
    number = getenv("FAIL_ERRNO") ? atoi(getenv("FAIL_ERRNO")) : ENOMEM;
    failing = getenv("FAIL_CALL");
}

static int fails(const char* name) {
    if (!failing || strcmp(failing, name) != 0) return 0;
    const long call = ++calls;
    if (from_then_on ? call < fail_at : call != fail_at) return 0;
    errno = number;
    return 1;
}

void* malloc(size_t size) { return fails("malloc") ? NULL : __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return fails("malloc") ? NULL : __libc_calloc(count, size); }
void* realloc(void* at, size_t size) { return fails("malloc") ? NULL : __libc_realloc(at, size); }
void* aligned_alloc(size_t alignment, size_t size) {
    return fails("malloc") ? NULL : __libc_memalign(alignment, size);
}
int posix_memalign(void** at, size_t alignment, size_t size) {
    void* memory = fails("malloc") ? NULL : __libc_memalign(alignment, size);
    if (!memory) return ENOMEM;
    *at = memory;
    return 0;
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*), void* argument) {
    static int (*real)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
    if (!real) real = (int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*))dlsym(RTLD_NEXT, "pthread_create");
    return fails("pthread_create") ? number : real(thread, attributes, start, argument);
}

int open(const char* path, int flags, ...) {
    static int (*real)(const char*, int, ...);
    if (!real) real = (int (*)(const char*, int, ...))dlsym(RTLD_NEXT, "open");
    mode_t mode = 0;
    if (flags & (O_CREAT | O_TMPFILE)) {
        va_list more;
        va_start(more, flags);
        mode = va_arg(more, mode_t);
        va_end(more);
    }
    return fails("open") ? -1 : real(path, flags, mode);
}

ssize_t read(int descriptor, void* to, size_t size) {
    static ssize_t (*real)(int, void*, size_t);
    if (!real) real = (ssize_t(*)(int, void*, size_t))dlsym(RTLD_NEXT, "read");
    return fails("read") ? -1 : real(descriptor, to, size);
}

ssize_t write(int descriptor, const void* from, size_t size) {
    static ssize_t (*real)(int, const void*, size_t);
    if (!real) real = (ssize_t(*)(int, const void*, size_t))dlsym(RTLD_NEXT, "write");
    return fails("write") ? -1 : real(descriptor, from, size);
}

int rename(const char* from, const char* to) {
    static int (*real)(const char*, const char*);
    if (!real) real = (int (*)(const char*, const char*))dlsym(RTLD_NEXT, "rename");
    return fails("rename") ? -1 : real(from, to);
}

int fsync(int descriptor) {
    static int (*real)(int);
    if (!real) real = (int (*)(int))dlsym(RTLD_NEXT, "fsync");
    return fails("fsync") ? -1 : real(descriptor);
}

/* The clock of the day; others, which measure how long something takes, go on. */
static int set_clock(long* seconds) {
    const char* clock = getenv("CLOCK");
    if (clock) *seconds = atol(clock);
    return clock != NULL;
}

time_t time(time_t* to) {
    static time_t (*real)(time_t*);
    if (!real) real = (time_t(*)(time_t*))dlsym(RTLD_NEXT, "time");
    long seconds = 0;
    const time_t now = set_clock(&seconds) ? (time_t)seconds : real(NULL);
    if (to) *to = now;
    return now;
}

int clock_gettime(clockid_t which, struct timespec* to) {
    static int (*real)(clockid_t, struct timespec*);
    if (!real) real = (int (*)(clockid_t, struct timespec*))dlsym(RTLD_NEXT, "clock_gettime");
    long seconds = 0;
    if (which != CLOCK_REALTIME || !set_clock(&seconds)) return real(which, to);
    to->tv_sec = seconds;
    to->tv_nsec = 0;
    return 0;
}

int gettimeofday(struct timeval* to, void* zone) {
    struct timespec now;
    (void)zone;
    clock_gettime(CLOCK_REALTIME, &now);
    to->tv_sec = now.tv_sec;
    to->tv_usec = now.tv_nsec / 1000;
    return 0;
}
