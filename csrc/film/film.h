/* The film: XYZ, alpha and optional spectral bins per pixel, in 64-bit fixed point, so that sums are the
   same bits whatever the order of threads and merges. One unit is 2^-FILM_FRACTION_BITS.

   The overflow rule: what is added is never negative (a contribution that is negative once rounded, or not
   finite, is rejected and counted), and a sum that would pass FILM_SUM_MAX stays there. min(Σ,
   FILM_SUM_MAX) of non-negative terms does not depend on their order or grouping, so saturation is as
   deterministic as the sums; `saturated` counts the sums that stand at the limit. */
#ifndef FILM_FILM_H
#define FILM_FILM_H

#include <stdint.h>

#include "color/color.h"
#include "image/texture.h"
#include "spectrum/spectrum.h"
#include "stokes.h"

#define FILM_FRACTION_BITS 28
#define FILM_SUM_MAX ((int64_t)1 << 62)
#define FILM_BINS_MAX 4096

struct film {
    int width, height; /* the border's rectangle */
    int x0, y0;        /* its lower left corner in the full frame */
    int full_width, full_height;
    int bins; /* spectral bins, 0: none */
    struct range bin_range;
    int channels;                 /* 4 + bins: X, Y, Z, alpha, bins */
    int64_t *sum;                 /* channels per pixel, first row at the bottom */
    int first_sample, end_sample; /* samples that are in, [first, end) */
    bool part; /* a pass that was broken off: one sample of some pixels, and no range (film_close_part) */
    struct film *splats;          /* borrowed: film_splat adds there instead; NULL: here */
    uint64_t saturated, rejected; /* sums at the limit; samples and splats that were negative or not finite */
};

/* Yours: film_destroy. NULL with *err: too large, or no memory. */
struct film *film_create(int full_width, int full_height, const int border[4], int bins,
                         struct range bin_range, stokes_error *err);
void film_destroy(struct film *);
void film_clear(struct film *);

/* What one camera sample gathers before it is added in one go (rounding once). bins are radiance per bin,
   W·m⁻²·sr⁻¹. */
struct film_sample {
    double xyz[3], alpha;
    double *bin; /* film->bins of them; NULL without */
};
/* Adds spectral energy `value` (∫ over its own pdf already divided) at a wavelength: κ·value·cmf(λ) and the
   bin. */
void film_sample_add(const struct film *, struct film_sample *, double value, float lambda_nm, double kappa);
void film_sample_clear(const struct film *, struct film_sample *);

/* x, y in the full frame; outside the border nothing happens. Both are atomic and commute. */
void film_add(struct film *, int x, int y, const struct film_sample *);
void film_splat(struct film *, int x, int y, double value, float lambda_nm, double kappa);

/* RGBA f32 in the working space, bottom row first, divided by the number of samples; with the sums of `splats`. */
void film_resolve(const struct film *, const struct working_space *, int samples, float *rgba);
/* One row of it, counted from the bottom; `rgba` is the whole picture's. For threads. */
void film_resolve_row(const struct film *, const struct working_space *, int samples, int row, float *rgba);

/* Makes a pass that was broken off a picture of its own: pixels with done[pixel] keep their sample, the others become black
   and transparent; the splats, kept apart until now, are those of a `share` of all light paths, and count for all of them.
   Such a film can be written and not be merged. */
void film_close_part(struct film *, const uint8_t *done, double share);
/* What film_resolve divides by. */
int film_divisor(const struct film *);

/* What the header says of how a film was made. Text pairs, written into the EXR. */
struct film_note {
    const char *key, *value;
};
/* An EXR: R, G, B, A (f32), spectral bins in the layout of Fichet et al. 2021, and the sums themselves, for
   merging. */
bool film_write_exr(const struct film *, const struct working_space *, const struct film_note *, size_t notes,
                    const char *path, stokes_error *err);
/* Reads the sums back. Yours: film_destroy. */
struct film *film_read_exr(const char *path, char *fingerprint, size_t fingerprint_size, stokes_error *err);
/* The header alone: the working space that R, G, B are in, and each note in the order of writing. `space`
   and `note` may be NULL. */
bool film_read_notes(const char *path, struct working_space *space,
                     void (*note)(void *user, const char *key, const char *value), void *user,
                     stokes_error *err);
/* Adds b's sums to a. Ranges must touch without overlapping. Whatever the order of merging, the bits are
   the same. */
bool film_merge(struct film *a, const struct film *b, stokes_error *err);
/* An 8-bit PNG of display-referred pixels in [0,1], RGBA with straight alpha, bottom row first. */
bool film_write_png(int width, int height, const float *rgba, const char *path, stokes_error *err);

/* An offset in pixels drawn from the Blackman–Harris window of Blender's filter width. As in Cycles the
   window spans twice that width: offsets lie in [-width, width]. */
float film_filter_sample(float width, float u);

/* The other way round, for one axis of a splat: the pixel that a point at `at` (in pixels) is counted in,
   drawn so that it reaches each pixel as often as that pixel's camera samples reach it; *weight (near 1)
   multiplies the value. The pixel may lie outside the film, and *weight is 0 where a narrow filter leaves a
   gap. */
int film_filter_pixel(float width, float at, float u, float *weight);

#endif
