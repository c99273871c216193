/* Knots become a spectrum: its cumulative integral, and the indices that make look-ups take constant time. */
#include <math.h>
#include <stdlib.h>

#include "base/error.h"
#include "spectrum/knots.h"

#define MAX_BUCKETS 65536

static bool grow(struct knots *k)
{
    size_t room = k->room ? 2 * k->room : 64;
    float *lambda = realloc(k->lambda, room * sizeof *lambda);
    if (lambda)
        k->lambda = lambda;
    float *value = lambda ? realloc(k->value, room * sizeof *value) : NULL;
    if (value)
        k->value = value;
    k->failed = !value;
    k->room = value ? room : k->room;
    return value;
}

void knots_add(struct knots *k, float lambda_nm, float value)
{
    if (k->failed || (k->count && k->lambda[k->count - 1] == lambda_nm && k->value[k->count - 1] == value))
        return;
    if (k->count == k->room && !grow(k))
        return;
    k->lambda[k->count] = lambda_nm;
    k->value[k->count++] = value;
}

void knots_add_piece(struct knots *k, struct range range, float l0, float v0, float l1, float v1)
{
    float low = fmaxf(l0, range.min), high = fminf(l1, range.max);
    if (!(low < high))
        return;
    double slope = ((double)v1 - v0) / ((double)l1 - l0);
    knots_add(k, low, low == l0 ? v0 : (float)(v0 + slope * ((double)low - l0)));
    knots_add(k, high, high == l1 ? v1 : (float)(v0 + slope * ((double)high - l0)));
}

void knots_free(struct knots *k)
{
    free(k->lambda);
    free(k->value);
    *k = (struct knots){0};
}

bool range_check(struct range range, const char *name, stokes_error *err)
{
    if (!isfinite(range.min) || !isfinite(range.max) ||
        !(range.min > 0 && range.min < range.max && range.max < 1e6f))
        return fail(err, name, "range", "%g to %g nm is no range of wavelengths", range.min, range.max);
    return true;
}

/* Per bucket the segment where a search for any of its wavelengths may start. The 1 % before its edge is for rounding. */
static void index_buckets(struct spectrum *s)
{
    double width = ((double)s->lambda[s->count - 1] - s->lambda[0]) / s->bucket_count;
    uint32_t i = 0;
    for (uint32_t b = 0; b < s->bucket_count; b++) {
        double edge = s->lambda[0] + (b - 0.01) * width;
        while (i + 2 < s->count && s->lambda[i + 1] <= edge)
            i++;
        s->bucket[b] = i;
    }
    s->buckets_per_nm = (float)(1 / width);
}

/* The same for the cdf: entry j is where a search for u in [j, j + 1)/entries starts. */
static void index_cdf(struct spectrum *s)
{
    double total = s->cumulative[s->count - 1];
    uint32_t i = 0;
    for (uint32_t j = 0; j < s->count; j++) {
        while (i + 2 < s->count && s->cumulative[i + 1] <= (j - 0.01) / s->count * total)
            i++;
        s->guide[j] = i;
    }
}

static void set_lines(struct spectrum *s)
{
    uint32_t last = s->count - 1;
    for (uint32_t i = 0; i < last; i++) {
        float begin = s->lambda[i], end = s->lambda[i + 1], value = s->value[i];
        s->line[i] =
            (struct spectrum_line){begin, end, value, end > begin ? (s->value[i + 1] - value) / (end - begin) : 0};
    }
    s->line[last] = (struct spectrum_line){s->lambda[last], INFINITY, s->value[last], 0};
    s->min = s->lambda[0];
    s->max = s->lambda[last];
}

static void accumulate(struct spectrum *s)
{
    s->cumulative[0] = s->second[0] = 0;
    for (uint32_t i = 1; i < s->count; i++) {
        double h = (double)s->lambda[i] - s->lambda[i - 1], v0 = s->value[i - 1], v1 = s->value[i];
        s->cumulative[i] = s->cumulative[i - 1] + 0.5 * (v1 + v0) * h;
        s->second[i] = s->second[i - 1] + h * (s->cumulative[i - 1] + h / 6 * (2 * v0 + v1));
    }
}

struct spectrum *knots_finish(struct knots *k, const char *name, stokes_error *err)
{
    struct spectrum *s = k->failed || k->count < 2 || k->count > UINT32_MAX / 2 ? NULL : calloc(1, sizeof *s);
    if (s) {
        uint32_t buckets =
            k->count == 2 ? 1 : (uint32_t)(2 * k->count < MAX_BUCKETS ? 2 * k->count : MAX_BUCKETS);
        *s = (struct spectrum){
            .count = (uint32_t)k->count, .lambda = k->lambda, .value = k->value, .bucket_count = buckets};
        *k = (struct knots){0};
        s->cumulative = malloc(s->count * sizeof *s->cumulative);
        s->second = malloc(s->count * sizeof *s->second);
        s->line = malloc(s->count * sizeof *s->line);
        s->guide = malloc(s->count * sizeof *s->guide);
        s->bucket = malloc(s->bucket_count * sizeof *s->bucket);
    }
    knots_free(k);
    if (!s || !s->cumulative || !s->second || !s->line || !s->guide || !s->bucket) {
        spectrum_destroy(s);
        fail(err, name, "spectrum", "out of memory");
        return NULL;
    }
    set_lines(s);
    accumulate(s);
    if (!isfinite(s->cumulative[s->count - 1])) {
        spectrum_destroy(s);
        fail(err, name, "spectrum", "its values leave the range of floats");
        return NULL;
    }
    index_buckets(s);
    index_cdf(s);
    return s;
}

void spectrum_destroy(struct spectrum *s)
{
    if (!s)
        return;
    free(s->lambda);
    free(s->value);
    free(s->cumulative);
    free(s->second);
    free(s->line);
    free(s->guide);
    free(s->bucket);
    free(s);
}
