/* The film's sums: adding samples and splats from any thread, resolving them to pixels, merging parts.
   The rule for overflow is in film.h. */
#include "film/film.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"

#define UNITS ((double)((int64_t)1 << FILM_FRACTION_BITS))
/* Pixels and samples are addressed by 32 bits each (base/random.h). */
#define PIXELS_MAX 0xffffffffull

static bool check_size(int full_width, int full_height, const int border[4], int bins, struct range bin_range,
                       stokes_error *err)
{
    if (full_width < 1 || full_height < 1 || (uint64_t)full_width * (uint64_t)full_height > PIXELS_MAX)
        return fail(err, "film", "resolution", "%d × %d is not a picture", full_width, full_height);
    if (border[0] < 0 || border[1] < 0 || border[2] > full_width || border[3] > full_height ||
        border[0] >= border[2] || border[1] >= border[3])
        return fail(err, "film", "border", "[%d, %d, %d, %d] is no rectangle inside %d × %d", border[0],
                    border[1], border[2], border[3], full_width, full_height);
    if (bins < 0 || bins > FILM_BINS_MAX)
        return fail(err, "film", "spectral_bins", "%d is outside 0 … %d", bins, FILM_BINS_MAX);
    if (bins && !(isfinite(bin_range.min) && isfinite(bin_range.max) && bin_range.min > 0 &&
                  bin_range.min < bin_range.max))
        return fail(err, "film", "spectral_bins", "[%g, %g] nm is no range", (double)bin_range.min,
                    (double)bin_range.max);
    return true;
}

static size_t sum_count(const struct film *film)
{
    return (size_t)film->width * (size_t)film->height * (size_t)film->channels;
}

struct film *film_create(int full_width, int full_height, const int border[4], int bins,
                         struct range bin_range, stokes_error *err)
{
    if (!check_size(full_width, full_height, border, bins, bin_range, err))
        return NULL;
    struct film *film = calloc(1, sizeof *film);
    if (film) {
        film->width = border[2] - border[0];
        film->height = border[3] - border[1];
        film->x0 = border[0];
        film->y0 = border[1];
        film->full_width = full_width;
        film->full_height = full_height;
        film->bins = bins;
        film->bin_range = bin_range;
        film->channels = 4 + bins;
        film->sum = calloc(sum_count(film), sizeof *film->sum); /* < 2^32 · 2^13: no overflow */
    }
    if (!film || !film->sum) {
        fail(err, "film", "resolution", "no memory for %d × %d pixels with %d spectral bins",
             border[2] - border[0], border[3] - border[1], bins);
        film_destroy(film);
        return NULL;
    }
    return film;
}

void film_destroy(struct film *film)
{
    if (!film)
        return;
    free(film->sum);
    free(film);
}

void film_clear(struct film *film)
{
    memset(film->sum, 0, sum_count(film) * sizeof *film->sum);
    film->saturated = film->rejected = 0;
    film->first_sample = film->end_sample = 0;
    film->part = false;
}

/* --- Adding ---------------------------------------------------------------------------------------- */

/* The bin of a wavelength, or −1. The last bin holds its upper end too. */
static int bin_of(const struct film *film, float lambda_nm)
{
    if (!film->bins || !(lambda_nm >= film->bin_range.min && lambda_nm <= film->bin_range.max))
        return -1;
    double width = (double)film->bin_range.max - film->bin_range.min;
    int bin = (int)(((double)lambda_nm - film->bin_range.min) / width * film->bins);
    return bin < film->bins ? bin : film->bins - 1;
}

void film_sample_clear(const struct film *film, struct film_sample *sample)
{
    memset(sample->xyz, 0, sizeof sample->xyz);
    sample->alpha = 0;
    if (sample->bin)
        memset(sample->bin, 0, (size_t)film->bins * sizeof *sample->bin);
}

void film_sample_add(const struct film *film, struct film_sample *sample, double value, float lambda_nm,
                     double kappa)
{
    float cmf[3];
    cmf_eval(lambda_nm, cmf);
    /* A value that is not finite must reach film_add, which rejects the sample, even where every cmf is 0:
       NaN · 0 = NaN. */
    for (int i = 0; i < 3; i++)
        sample->xyz[i] += kappa * value * (double)cmf[i];
    int bin = bin_of(film, lambda_nm);
    if (bin >= 0 && sample->bin)
        sample->bin[bin] += value;
}

/* Not negative once it is rounded: colour-matching functions may undershoot zero in their last bits. */
static bool is_acceptable(double value)
{
    return value > -0.5 / UNITS && value < INFINITY;
}

/* Adds to one sum. A plain atomic addition could leave the range between two threads; a compare-and-swap
   never does. */
static void add_units(struct film *film, int64_t *sum, double value)
{
    double units = value * UNITS;
    int64_t add = units < (double)FILM_SUM_MAX ? llrint(units) : FILM_SUM_MAX;
    if (add <= 0)
        return;
    int64_t old = __atomic_load_n(sum, __ATOMIC_RELAXED), new;
    do {
        if (old == FILM_SUM_MAX)
            return;
        new = old > FILM_SUM_MAX - add ? FILM_SUM_MAX : old + add;
    } while (!__atomic_compare_exchange_n(sum, &old, new, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED));
    if (new == FILM_SUM_MAX) /* once per sum: it never leaves the limit */
        __atomic_fetch_add(&film->saturated, 1, __ATOMIC_RELAXED);
}

static int64_t *sums_at(const struct film *film, int x, int y)
{
    x -= film->x0;
    y -= film->y0;
    if (x < 0 || y < 0 || x >= film->width || y >= film->height)
        return NULL;
    return film->sum + ((size_t)y * (size_t)film->width + (size_t)x) * (size_t)film->channels;
}

static void reject(struct film *film)
{
    __atomic_fetch_add(&film->rejected, 1, __ATOMIC_RELAXED);
}

void film_add(struct film *film, int x, int y, const struct film_sample *sample)
{
    int64_t *sum = sums_at(film, x, y);
    if (!sum)
        return;
    bool good = is_acceptable(sample->alpha);
    for (int i = 0; i < 3; i++)
        good &= is_acceptable(sample->xyz[i]);
    for (int i = 0; i < film->bins && sample->bin; i++)
        good &= is_acceptable(sample->bin[i]);
    if (!good) {
        reject(film);
        return;
    }
    for (int i = 0; i < 3; i++)
        add_units(film, &sum[i], sample->xyz[i]);
    add_units(film, &sum[3], sample->alpha);
    for (int i = 0; i < film->bins && sample->bin; i++)
        add_units(film, &sum[4 + i], sample->bin[i]);
}

void film_splat(struct film *film, int x, int y, double value, float lambda_nm, double kappa)
{
    film = film->splats ? film->splats : film;
    int64_t *sum = sums_at(film, x, y);
    if (!sum)
        return;
    if (!is_acceptable(value) || !is_acceptable(value * kappa)) {
        reject(film);
        return;
    }
    float cmf[3];
    cmf_eval(lambda_nm, cmf);
    for (int i = 0; i < 3; i++)
        add_units(film, &sum[i], kappa * value * (double)cmf[i]);
    int bin = bin_of(film, lambda_nm);
    if (bin >= 0)
        add_units(film, &sum[4 + bin], value);
}

/* --- Reading --------------------------------------------------------------------------------------- */

static double sum_at(const struct film *film, size_t at)
{
    double sum = (double)__atomic_load_n(&film->sum[at], __ATOMIC_RELAXED);
    return film->splats ? sum + (double)__atomic_load_n(&film->splats->sum[at], __ATOMIC_RELAXED) : sum;
}

void film_resolve_row(const struct film *film, const struct working_space *space, int samples, int row,
                      float *rgba)
{
    size_t first = (size_t)row * (size_t)film->width, end = first + (size_t)film->width;
    double per_unit = samples > 0 ? 1 / (UNITS * samples) : 0;
    for (size_t p = first; p < end; p++) {
        size_t at = p * (size_t)film->channels;
        double xyz[3];
        for (size_t i = 0; i < 3; i++)
            xyz[i] = sum_at(film, at + i) * per_unit;
        for (int i = 0; i < 3; i++) {
            const double *to = space->xyz_to_rgb + 3 * i;
            rgba[4 * p + (size_t)i] = (float)(to[0] * xyz[0] + to[1] * xyz[1] + to[2] * xyz[2]);
        }
        rgba[4 * p + 3] = (float)(sum_at(film, at + 3) * per_unit);
    }
}

void film_resolve(const struct film *film, const struct working_space *space, int samples, float *rgba)
{
    for (int row = 0; row < film->height; row++)
        film_resolve_row(film, space, samples, row, rgba);
}

int film_divisor(const struct film *film)
{
    return film->part ? 1 : film->end_sample - film->first_sample;
}

void film_close_part(struct film *film, const uint8_t *done, double share)
{
    size_t channels = (size_t)film->channels, count = sum_count(film);
    for (size_t at = 0; at < count; at += channels, done++)
        for (size_t i = at; i < at + channels; i++) {
            double splats = film->splats ? (double)film->splats->sum[i] / share : 0,
                   sum = *done ? (double)film->sum[i] + splats : 0;
            film->sum[i] = sum < (double)FILM_SUM_MAX ? (int64_t)(sum + 0.5) : FILM_SUM_MAX;
        }
    film->splats = NULL;
    film->part = true;
    film->end_sample = film->first_sample;
}

static bool check_merge(const struct film *a, const struct film *b, stokes_error *err)
{
    if (a->full_width != b->full_width || a->full_height != b->full_height)
        return fail(err, "merge", "resolution", "%d × %d and %d × %d differ", a->full_width, a->full_height,
                    b->full_width, b->full_height);
    if (a->x0 != b->x0 || a->y0 != b->y0 || a->width != b->width || a->height != b->height)
        return fail(err, "merge", "border", "the parts cover different rectangles");
    if (a->bins != b->bins ||
        (a->bins && (a->bin_range.min != b->bin_range.min || a->bin_range.max != b->bin_range.max)))
        return fail(err, "merge", "spectral_bins", "the parts have different bins");
    if (a->part || b->part)
        return fail(err, "merge", "samples",
                    "a part of one pass, which was broken off, is no range of samples");
    if (a->first_sample < b->end_sample && b->first_sample < a->end_sample)
        return fail(err, "merge", "samples", "[%d, %d) and [%d, %d) overlap", a->first_sample, a->end_sample,
                    b->first_sample, b->end_sample);
    if (a->end_sample != b->first_sample && b->end_sample != a->first_sample)
        return fail(err, "merge", "samples", "[%d, %d) and [%d, %d) do not touch", a->first_sample,
                    a->end_sample, b->first_sample, b->end_sample);
    return true;
}

bool film_merge(struct film *a, const struct film *b, stokes_error *err)
{
    if (!check_merge(a, b, err))
        return false;
    size_t count = sum_count(a);
    a->saturated = 0;
    for (size_t i = 0; i < count; i++) {
        a->sum[i] = a->sum[i] > FILM_SUM_MAX - b->sum[i] ? FILM_SUM_MAX : a->sum[i] + b->sum[i];
        a->saturated += a->sum[i] == FILM_SUM_MAX;
    }
    a->rejected += b->rejected;
    a->first_sample = a->first_sample < b->first_sample ? a->first_sample : b->first_sample;
    a->end_sample = a->end_sample > b->end_sample ? a->end_sample : b->end_sample;
    return true;
}
