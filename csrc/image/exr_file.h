/* What reading and writing share of an open OpenEXR file: its stream, what went wrong, and the order of channels. Private to exr_*.c. */
#ifndef IMAGE_EXR_FILE_H
#define IMAGE_EXR_FILE_H

#include <openexr.h>
#include <stdio.h>

#include "image/exr.h"

#define PART 0 /* the one that we write, and read */

struct exr_file {
    exr_context_t context;
    FILE *stream;
    uint64_t bytes; /* of the file, when reading */
    int error;      /* the first errno of the stream */
    char why[256];  /* the library's last message */
    char *path;
};

/* Opens the stream, or sets `error`. NULL without memory; yours: exr_close. */
struct exr_file *exr_file_create(const char *path, const char *mode);
/* Lets the library tell its errors to the file. */
exr_context_initializer_t exr_file_initializer(struct exr_file *);
/* The stream's own error says more than what the library makes of it. */
bool exr_file_fail(struct exr_file *, const char *property, stokes_error *err);

/* The channel of that name; `count` if there is none. The search begins behind the last one found, as both lists tend to have one order. */
size_t exr_channel_index(const struct exr_channel *channels, size_t count, const char *name, size_t *last);

#endif
