/* Scanline OpenEXR files of 32-bit channels (ZIP), through OpenEXRCore: named channels in (halves are made
   floats), named channels out, and text attributes. A file appears under its name only when it is whole; what is read is trusted in
   nothing. */
#ifndef IMAGE_EXR_H
#define IMAGE_EXR_H

#include <stdint.h>

#include "stokes.h"

#define EXR_NAME_MAX 31 /* longer names would need a file version that old readers refuse */

struct exr_channel {
    char name[EXR_NAME_MAX + 1];
    bool integer; /* u32, else f32 */
};

struct exr_text {
    const char *name, *text; /* the name at most EXR_NAME_MAX bytes */
};

/* Pixels count from the bottom, as everywhere in Stokes; EXR itself counts from the top. */
struct exr_layout {
    int full_width, full_height; /* display window, from (0, 0) */
    int x0, y0, width, height;   /* data window */
    const struct exr_channel *channels;
    size_t channel_count;
    const struct exr_text *texts;
    size_t text_count;
    const float *chromaticities; /* x, y of red, green, blue, white; or NULL */
};

/* Fills the `width` 32-bit values of row y (0 is the data window's lowest) of a channel. Rows come from top
   to bottom. */
typedef void (*exr_source)(const void *user, size_t channel, int y, void *values);
bool exr_write(const struct exr_layout *, exr_source, const void *user, const char *path, stokes_error *err);

struct exr_file;
struct exr_file *exr_open(const char *path, stokes_error *err); /* yours: exr_close */
void exr_close(struct exr_file *);
/* full_width … height of the layout; the rest is left alone. False, with *err, if the windows make no
   sense. */
bool exr_windows(struct exr_file *, struct exr_layout *, stokes_error *err);
size_t exr_text_count(struct exr_file *);
/* A text attribute by index (NULL where that attribute is no text) and by name (NULL if missing). Borrowed. */
const char *exr_text_at(struct exr_file *, size_t index, const char **name);
const char *exr_text_named(struct exr_file *, const char *name);

size_t exr_channel_count(struct exr_file *);
/* The name of a channel by index, in the file's order, and whether it is made of integers; NULL past the end. Borrowed. */
const char *exr_channel_at(struct exr_file *, size_t index, bool *integer);

/* Hands out the rows of those channels, which must all exist with that type; channels in between are
   skipped. False from the sink stops; it has then filled *err. */
typedef bool (*exr_sink)(void *user, size_t channel, int y, const void *values, stokes_error *err);
bool exr_read(struct exr_file *, const struct exr_channel *channels, size_t count, exr_sink, void *user,
              stokes_error *err);

#endif
