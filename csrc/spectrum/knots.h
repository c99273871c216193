/* Building a spectrum knot by knot; for the files of this room only. */
#ifndef SPECTRUM_KNOTS_H
#define SPECTRUM_KNOTS_H

#include "spectrum/spectrum.h"

struct knots {
    float *lambda, *value;
    size_t count, room;
    bool failed; /* out of memory */
};

/* Appends a knot unless it repeats the last one. */
void knots_add(struct knots *, float lambda_nm, float value);
/* Appends the part of a linear piece from (l0, v0) to (l1, v1) that lies in the range. */
void knots_add_piece(struct knots *, struct range, float l0, float v0, float l1, float v1);
/* A spectrum of these knots, which it takes; NULL and *err if there is no memory or a value is not finite. */
struct spectrum *knots_finish(struct knots *, const char *name, stokes_error *err);
void knots_free(struct knots *);

/* True if the range can carry a spectrum. */
bool range_check(struct range, const char *name, stokes_error *err);

static inline bool same_range(struct range a, struct range b)
{
    return a.min == b.min && a.max == b.max;
}

/* The first segment of positive length that holds the wavelength, which lies in Λ. At a step: the one after it. */
static inline uint32_t spectrum_segment(const struct spectrum *s, float lambda_nm)
{
    uint32_t b = (uint32_t)((lambda_nm - s->lambda[0]) * s->buckets_per_nm);
    uint32_t i = s->bucket[b < s->bucket_count ? b : s->bucket_count - 1];
    while (i + 2 < s->count && s->lambda[i + 1] <= lambda_nm)
        i++;
    return i;
}

/* The value of segment i's line at a wavelength of it. */
static inline float segment_value(const struct spectrum *s, uint32_t i, float lambda_nm)
{
    return lambda_nm >= s->lambda[i + 1] ? s->value[i + 1] : s->value[i] + (lambda_nm - s->lambda[i]) * s->line[i].slope;
}

#endif
