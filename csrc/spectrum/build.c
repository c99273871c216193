/* Spectra from tables and from other spectra. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/error.h"
#include "spectrum/knots.h"

struct spectrum *spectrum_constant(struct range range, float value)
{
    if (!range_check(range, "constant", NULL) || !isfinite(value))
        return NULL;
    struct knots k = {0};
    knots_add(&k, range.min, value);
    knots_add(&k, range.max, value);
    return knots_finish(&k, "constant", NULL);
}

static bool check_table(const float *lambda, const float *value, size_t count, const char *name,
                        stokes_error *err)
{
    if (!count)
        return fail(err, name, "table", "it is empty");
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(lambda[i]) || !isfinite(value[i]))
            return fail(err, name, "table", "entry %zu is not a finite number", i);
        if (i > 0 && lambda[i] < lambda[i - 1])
            return fail(err, name, "table", "wavelengths descend at entry %zu, %g nm", i, lambda[i]);
        if (i > 1 && lambda[i] == lambda[i - 2])
            return fail(err, name, "table", "three entries at %g nm; a step takes two", lambda[i]);
    }
    return true;
}

struct spectrum *spectrum_table(struct range range, const float *lambda, const float *value, size_t count,
                                enum beyond beyond, const char *name, stokes_error *err)
{
    if (!range_check(range, name, err) || !check_table(lambda, value, count, name, err))
        return NULL;
    float first = lambda[0], last = lambda[count - 1];
    float below = beyond == BEYOND_HOLD ? value[0] : 0, above = beyond == BEYOND_HOLD ? value[count - 1] : 0;
    struct knots k = {0};
    knots_add_piece(&k, range, fminf(first, range.min) - 1, below, first, below);
    for (size_t i = 0; i + 1 < count; i++)
        knots_add_piece(&k, range, lambda[i], value[i], lambda[i + 1], value[i + 1]);
    knots_add_piece(&k, range, last, above, fmaxf(last, range.max) + 1, above);
    return knots_finish(&k, name, err);
}

typedef float (*operation)(float, float);

static float add(float a, float b)
{
    return a + b;
}

static float multiply(float a, float b)
{
    return a * b;
}

/* Over one interval in which both are linear: its ends and, where the result is curved, whole nanometres between. */
static void combine_interval(struct knots *k, const struct spectrum *a, uint32_t i, const struct spectrum *b,
                             uint32_t j, float from, float to, operation apply)
{
    bool curved = apply == multiply && a->value[i] != a->value[i + 1] && b->value[j] != b->value[j + 1];
    knots_add(k, from, apply(segment_value(a, i, from), segment_value(b, j, from)));
    if (curved)
        for (float l = floorf(from) + 1; l < to; l += 1)
            knots_add(k, l, apply(segment_value(a, i, l), segment_value(b, j, l)));
    knots_add(k, to, apply(segment_value(a, i, to), segment_value(b, j, to)));
}

static struct spectrum *combine(const struct spectrum *a, const struct spectrum *b, operation apply)
{
    assert(same_range(spectrum_range(a), spectrum_range(b)));
    struct knots k = {0};
    uint32_t i = 0, j = 0;
    float end = a->lambda[a->count - 1];
    for (float from = a->lambda[0]; from < end;) {
        while (i + 2 < a->count && a->lambda[i + 1] <= from)
            i++;
        while (j + 2 < b->count && b->lambda[j + 1] <= from)
            j++;
        float to = fminf(a->lambda[i + 1], b->lambda[j + 1]);
        combine_interval(&k, a, i, b, j, from, to, apply);
        from = to;
    }
    return knots_finish(&k, "", NULL);
}

struct spectrum *spectrum_sum(const struct spectrum *a, const struct spectrum *b)
{
    return combine(a, b, add);
}

struct spectrum *spectrum_product(const struct spectrum *a, const struct spectrum *b)
{
    return combine(a, b, multiply);
}

struct spectrum *spectrum_scaled(const struct spectrum *s, float factor)
{
    struct knots k = {0};
    for (uint32_t i = 0; i < s->count; i++)
        knots_add(&k, s->lambda[i], s->value[i] * factor);
    return knots_finish(&k, "", NULL);
}

/* Where the line from (l0, v0) to (l1, v1) meets a level strictly inside, or l1. */
static float crossing(float l0, float v0, float l1, float v1, float level)
{
    if (!((v0 < level && level < v1) || (v1 < level && level < v0)))
        return l1;
    return (float)(l0 + ((double)level - v0) / ((double)v1 - v0) * ((double)l1 - l0));
}

struct spectrum *spectrum_clamped(const struct spectrum *s, float low, float high)
{
    struct knots k = {0};
    knots_add(&k, s->lambda[0], fminf(fmaxf(s->value[0], low), high));
    for (uint32_t i = 0; i + 1 < s->count; i++) {
        float l0 = s->lambda[i], l1 = s->lambda[i + 1], v0 = s->value[i], v1 = s->value[i + 1];
        float first = v0 < v1 ? low : high, second = v0 < v1 ? high : low;
        float at_first = crossing(l0, v0, l1, v1, first), at_second = crossing(l0, v0, l1, v1, second);
        if (at_first < l1)
            knots_add(&k, at_first, first);
        if (at_second < l1)
            knots_add(&k, at_second, second);
        knots_add(&k, l1, fminf(fmaxf(v1, low), high));
    }
    return knots_finish(&k, "", NULL);
}
