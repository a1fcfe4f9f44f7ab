/* A layer between a program and the disk, loaded by LD_PRELOAD: it counts what reaches the disk, lets it be full, and cuts the power.
 *
 * It can also stop the program as Ctrl-C does, and lack links as some file systems of networks do.
 *
 * LAYER_STATE names a file with one `struct state`, which all processes share; LAYER_LOG one to which every write ("W device inode") and
 * every call that makes a file or folder safe ("S device inode seconds nanoseconds") is appended; LAYER_ROOT the folder that lies on the disk. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

struct state {
    atomic_long root;    /* process that was started first; 0: none yet */
    atomic_long is_cut;  /* 1: the power is off */
    atomic_long calls;   /* so far */
    atomic_long cut_at;  /* number of the call at which the power is cut; 0: never */
    atomic_long written; /* bytes so far */
    atomic_long space;   /* bytes of the disk */
    atomic_long stop_at; /* number of the call at which the first process gets SIGINT; 0: never */
    atomic_long no_link; /* 1: the file system has no hard links */
};

static struct state *state;
static int events = -1;
static char root[4096];
static ssize_t (*real_write)(int, const void *, size_t);
static ssize_t (*real_writev)(int, const struct iovec *, int);
static int (*real_fsync)(int);
static int (*real_unlink)(const char *);
static int (*real_link)(const char *, const char *);
static int (*real_rename)(const char *, const char *);

__attribute__((constructor)) static void begin(void) {
    real_write = dlsym(RTLD_NEXT, "write");
    real_writev = dlsym(RTLD_NEXT, "writev");
    real_fsync = dlsym(RTLD_NEXT, "fsync");
    real_unlink = dlsym(RTLD_NEXT, "unlink");
    real_link = dlsym(RTLD_NEXT, "link");
    real_rename = dlsym(RTLD_NEXT, "rename");
    const char *at = getenv("LAYER_STATE"), *log = getenv("LAYER_LOG"), *folder = getenv("LAYER_ROOT");
    if (!at || !log || !folder) return;
    int file = open(at, O_RDWR | O_CLOEXEC);
    if (file < 0) return;
    state = mmap(NULL, sizeof *state, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    events = open(log, O_WRONLY | O_APPEND | O_CLOEXEC);
    snprintf(root, sizeof root, "%s/", folder);
    long none = 0;
    atomic_compare_exchange_strong(&state->root, &none, (long)getpid());
}

/* Whether a descriptor is a file or folder on the disk. */
static int is_on_disk(int fd) {
    if (!state) return 0;
    char link[64], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t n = readlink(link, path, sizeof path - 2);
    if (n < 0) return 0;
    path[n] = '/';
    path[n + 1] = 0;
    return strncmp(path, root, strlen(root)) == 0;
}

/* Counts a call; at the one where the power is cut, nothing of this program goes on. */
static void count(void) {
    if (!state) return;
    long number = atomic_fetch_add(&state->calls, 1) + 1;
    if (number == atomic_load(&state->cut_at)) {
        atomic_store(&state->is_cut, 1);
        kill((pid_t)atomic_load(&state->root), SIGKILL);
    }
    if (number == atomic_load(&state->stop_at)) kill((pid_t)atomic_load(&state->root), SIGINT);
    while (atomic_load(&state->is_cut)) {
        /* A thread of the first process ends with it */
        if (getpid() != (pid_t)atomic_load(&state->root)) kill(getpid(), SIGKILL);
        pause();
    }
}

static void tell(int fd, char kind) {
    struct stat s;
    struct timespec now;
    if (fstat(fd, &s) != 0) return;
    clock_gettime(CLOCK_REALTIME, &now);
    char line[160];
    int n = snprintf(line, sizeof line, "%c %lu %lu %ld %ld\n", kind, (unsigned long)s.st_dev, (unsigned long)s.st_ino,
                     (long)now.tv_sec, now.tv_nsec);
    if (real_write(events, line, (size_t)n) < 0) abort();
}

/* Takes room for so many bytes; 0 where there is none. */
static int has_room(size_t n) {
    if (atomic_fetch_add(&state->written, (long)n) + (long)n <= atomic_load(&state->space)) return 1;
    errno = ENOSPC;
    return 0;
}

ssize_t write(int fd, const void *bytes, size_t n) {
    if (is_on_disk(fd)) {
        count();
        if (!has_room(n)) return -1;
        tell(fd, 'W');
    }
    return real_write(fd, bytes, n);
}

ssize_t writev(int fd, const struct iovec *parts, int k) {
    size_t n = 0;
    for (int i = 0; i < k; i++) n += parts[i].iov_len;
    if (is_on_disk(fd)) {
        count();
        if (!has_room(n)) return -1;
        tell(fd, 'W');
    }
    return real_writev(fd, parts, k);
}

int fsync(int fd) {
    int on_disk = is_on_disk(fd);
    if (on_disk) count();
    int answer = real_fsync(fd);
    if (on_disk && answer == 0) tell(fd, 'S');
    return answer;
}

int unlink(const char *path) {
    count();
    return real_unlink(path);
}

int link(const char *from, const char *to) {
    count();
    if (state && atomic_load(&state->no_link)) {
        errno = EPERM;
        return -1;
    }
    return real_link(from, to);
}

int rename(const char *from, const char *to) {
    count();
    return real_rename(from, to);
}
