/* Linux: time, shared memory, file descriptors and files that appear whole.
   Another system is another file like this one, chosen by the Makefile. */
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/error.h"
#include "base/os.h"
#include "base/thread.h"

double os_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

int thread_processors(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) != 0)
        return 1;
    int count = CPU_COUNT(&set);
    return count > 0 ? count : 1;
}

/* --- Shared memory ----------------------------------------------------------------------------------------- */

/* Without this seal the parent could shrink the memory under a copy, and the copy would end in SIGBUS. */
static bool forbid_shrinking(int fd, stokes_error *err)
{
    int seals = fcntl(fd, F_GET_SEALS);
    if (seals >= 0 && (seals & F_SEAL_SHRINK))
        return true;
    if (fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK) == 0)
        return true;
    return fail(err, "shared memory", "seal",
                "descriptor %d cannot be kept from shrinking (%s); make it by memfd_create "
                "with MFD_ALLOW_SEALING",
                fd, strerror(errno));
}

bool os_memory_map(struct os_memory *memory, int fd, bool writable, stokes_error *err)
{
    struct stat status;
    if (fstat(fd, &status) != 0)
        return fail(err, "shared memory", "descriptor", "%d: %s", fd, strerror(errno));
    bool mapped = memory->data && memory->fd == fd && memory->writable == writable;
    if (mapped && memory->bytes == (size_t)status.st_size)
        return true;
    if (!forbid_shrinking(fd, err))
        return false;
    /* Once more: it may have shrunk before the seal. */
    if (fstat(fd, &status) != 0)
        return fail(err, "shared memory", "descriptor", "%d: %s", fd, strerror(errno));
    size_t bytes = (size_t)status.st_size;
    void *data = NULL;
    if (bytes > 0) {
        data = mmap(NULL, bytes, writable ? PROT_READ | PROT_WRITE : PROT_READ, MAP_SHARED, fd, 0);
        if (data == MAP_FAILED)
            return fail(err, "shared memory", "map", "%zu bytes: %s", bytes, strerror(errno));
    }
    os_memory_unmap(memory);
    *memory = (struct os_memory){.data = data, .bytes = bytes, .fd = fd, .writable = writable};
    return true;
}

void os_memory_unmap(struct os_memory *memory)
{
    if (memory->data)
        munmap(memory->data, memory->bytes);
    *memory = (struct os_memory){.fd = -1};
}

/* --- Descriptors ------------------------------------------------------------------------------------------- */

bool os_readable(int fd, double seconds)
{
    struct pollfd wait = {.fd = fd, .events = POLLIN};
    double end = os_seconds() + seconds;
    for (;;) {
        double left = end - os_seconds();
        int ready = poll(&wait, 1, left > 0 ? (int)(left * 1000 + 0.5) : 0);
        if (ready > 0)
            return true;
        if (ready == 0 || errno != EINTR)
            return ready < 0;
    }
}

/* True if the call is to be made again: a signal came, or the other side has set the descriptor not to block. */
static bool try_again(int fd, short events)
{
    if (errno != EAGAIN)
        return errno == EINTR;
    struct pollfd wait = {.fd = fd, .events = events};
    return poll(&wait, 1, -1) >= 0 || errno == EINTR;
}

size_t os_read_some(int fd, void *data, size_t bytes)
{
    ssize_t got;
    do
        got = read(fd, data, bytes);
    while (got < 0 && try_again(fd, POLLIN));
    return got > 0 ? (size_t)got : 0;
}

bool os_read_all(int fd, void *data, size_t bytes)
{
    unsigned char *at = data;
    while (bytes > 0) {
        size_t got = os_read_some(fd, at, bytes);
        if (got == 0)
            return false;
        at += got;
        bytes -= got;
    }
    return true;
}

bool os_write_all(int fd, const void *data, size_t bytes)
{
    const unsigned char *at = data;
    while (bytes > 0) {
        ssize_t put = write(fd, at, bytes);
        if (put < 0 && try_again(fd, POLLOUT))
            continue;
        if (put <= 0)
            return false;
        at += put;
        bytes -= (size_t)put;
    }
    return true;
}

long os_parent(void)
{
    return (long)getppid();
}

/* --- Files ------------------------------------------------------------------------------------------------- */

bool os_write_file(const char *path, const void *data, size_t bytes, stokes_error *err)
{
    size_t room = strlen(path) + 32;
    char *temporary = malloc(room);
    if (!temporary)
        return fail(err, path, "write", "out of memory");
    snprintf(temporary, room, "%s.part-%ld", path, (long)getpid());
    int fd = open(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    bool good = fd >= 0 && os_write_all(fd, data, bytes);
    int why = errno;
    if (fd >= 0 && close(fd) != 0) {
        good = false;
        why = errno;
    }
    if (!good && fd >= 0)
        unlink(temporary);
    good = good ? os_commit_file(temporary, path, err) : fail(err, path, "write", "%s", strerror(why));
    free(temporary);
    return good;
}

/* The data must be on the disk before the name is: else a power cut leaves the name with nothing behind it. */
static bool flush_file(const char *path)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return false;
    bool good = fsync(fd) == 0 || errno == EINVAL || errno == EROFS;
    return close(fd) == 0 && good;
}

bool os_commit_file(const char *temporary, const char *path, stokes_error *err)
{
    struct stat there;
    if (stat(path, &there) == 0 && !S_ISREG(there.st_mode)) { /* a device or a pipe would be gone */
        unlink(temporary);
        return fail(err, path, "write", "is no file");
    }
    if (flush_file(temporary) && rename(temporary, path) == 0)
        return true;
    int why = errno;
    unlink(temporary);
    return fail(err, path, "write", "%s", strerror(why));
}
