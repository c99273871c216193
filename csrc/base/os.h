/* What depends on the operating system; one implementation file a system (os_linux.c). */
#ifndef BASE_OS_H
#define BASE_OS_H

#include <stdbool.h>
#include <stddef.h>

#include "stokes.h"

/* Seconds from an arbitrary start; never goes back. */
double os_seconds(void);

/* A mapping of shared memory that the parent handed down. */
struct os_memory {
    unsigned char *data;
    size_t bytes;
    int fd;
    bool writable;
};

/* Maps what the memory holds now (again, if it has grown), after forbidding it to shrink. Nothing maps to NULL. */
bool os_memory_map(struct os_memory *, int fd, bool writable, stokes_error *err);
void os_memory_unmap(struct os_memory *);

/* True if `fd` has input (or has ended) within `seconds`. */
bool os_readable(int fd, double seconds);

/* Reads or writes all of it; false at the end of input or on an error. EINTR is retried. */
bool os_read_all(int fd, void *data, size_t bytes);
bool os_write_all(int fd, const void *data, size_t bytes);
/* What has arrived, at most `bytes`, waiting for the first byte; 0 at the end or on an error. */
size_t os_read_some(int fd, void *data, size_t bytes);

/* The process that started this one; another number once that one has died. */
long os_parent(void);

/* Writes `path` whole or not at all: to a temporary name beside it, flushed, then renamed. */
bool os_write_file(const char *path, const void *data, size_t bytes, stokes_error *err);

/* Renames a finished temporary file over `path`; removes it on failure. */
bool os_commit_file(const char *temporary, const char *path, stokes_error *err);

#endif
