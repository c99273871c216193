/* A piecewise-constant density that is positive wherever a product of spectra is. */
#include <math.h>
#include <stdlib.h>

#include "spectrum/knots.h"

#define MAX_BINS 4096
#define FLOOR 1e-3 /* of the mean mass: what keeps a faint bin above the resolution of the cdf's floats */

/* The factors, each with the segment that the walk has reached. */
struct factors {
    const struct spectrum *spectrum[3];
    uint32_t segment[3];
    int count;
};

/* The next wavelength after `from`, at most `limit`, where some factor has a knot; sets the segments that hold
   what lies between. */
static float advance(struct factors *f, float from, float limit)
{
    for (int i = 0; i < f->count; i++) {
        const struct spectrum *s = f->spectrum[i];
        while (f->segment[i] + 2 < s->count && s->lambda[f->segment[i] + 1] <= from)
            f->segment[i]++;
        limit = fminf(limit, s->lambda[f->segment[i] + 1]);
    }
    return limit;
}

static double product_at(const struct factors *f, double lambda_nm)
{
    double product = 1;
    for (int i = 0; i < f->count; i++) {
        const struct spectrum *s = f->spectrum[i];
        uint32_t j = f->segment[i];
        double t = (lambda_nm - s->lambda[j]) / ((double)s->lambda[j + 1] - s->lambda[j]);
        product *= s->value[j] + t * ((double)s->value[j + 1] - s->value[j]);
    }
    return fmax(product, 0);
}

/* ∫ product over a bin. Between knots it is a cubic at most, for which Simpson's rule is exact, and its midpoint is
   positive if it is positive anywhere. */
static double bin_mass(struct factors *f, float from, float to)
{
    double mass = 0;
    while (from < to) {
        float next = advance(f, from, to);
        double h = (double)next - from;
        mass += h / 6 * (product_at(f, from) + 4 * product_at(f, from + h / 2) + product_at(f, next));
        from = next;
    }
    return mass;
}

static float bin_edge(const struct spectral_histogram *h, uint32_t i)
{
    float width = (h->range.max - h->range.min) / (float)h->count;
    return i < h->count ? h->range.min + (float)i * width : h->range.max;
}

/* From masses to a cdf. It is a sum of multiples of 2^-24, so that the probability of a bin is what a
   random number of 24 bits gives it. */
static bool normalize(struct spectral_histogram *h, const double *mass)
{
    double total = 0, sum = 0;
    uint32_t positive = 0;
    for (uint32_t i = 0; i < h->count; i++) {
        total += mass[i];
        positive += mass[i] > 0;
    }
    if (!(total > 0) || !isfinite(total))
        return false;
    double least = FLOOR * total / positive, whole = total + least * positive;
    uint32_t last = 0;
    for (uint32_t i = 0; i < h->count; i++) {
        sum += mass[i] > 0 ? mass[i] + least : 0;
        last = mass[i] > 0 ? i : last;
        h->cdf[i + 1] = (float)(round(sum / whole * 0x1p24) * 0x1p-24);
    }
    for (uint32_t i = last + 1; i <= h->count; i++)
        h->cdf[i] = 1;
    return true;
}

static struct spectral_histogram *allocate(struct range range, float bin_nm)
{
    double bins = ceil(((double)range.max - range.min) / (bin_nm > 0.01f ? bin_nm : 0.01f) - 1e-3);
    struct spectral_histogram *h = calloc(1, sizeof *h);
    if (h) {
        h->range = range;
        h->count = bins < 1 ? 1 : bins > MAX_BINS ? MAX_BINS : (uint32_t)bins;
        h->cdf = calloc(h->count + 1, sizeof *h->cdf);
    }
    if (h && h->cdf)
        return h;
    spectral_histogram_destroy(h);
    return NULL;
}

struct spectral_histogram *spectral_histogram_create(const struct spectrum *a, const struct spectrum *b,
                                                     const struct spectrum *c, float bin_nm)
{
    const struct spectrum *given[3] = {a, b, c};
    struct factors f = {0};
    for (int i = 0; i < 3; i++)
        if (given[i])
            f.spectrum[f.count++] = given[i];
    if (!f.count)
        return NULL;
    struct spectral_histogram *h = allocate(spectrum_range(f.spectrum[0]), bin_nm);
    double *mass = h ? malloc(h->count * sizeof *mass) : NULL;
    for (uint32_t i = 0; mass && i < h->count; i++)
        mass[i] = bin_mass(&f, bin_edge(h, i), bin_edge(h, i + 1));
    bool made = mass && normalize(h, mass);
    free(mass);
    if (made)
        return h;
    spectral_histogram_destroy(h);
    return NULL;
}

void spectral_histogram_destroy(struct spectral_histogram *h)
{
    if (!h)
        return;
    free(h->cdf);
    free(h);
}

static float bin_density(const struct spectral_histogram *h, uint32_t i)
{
    return (h->cdf[i + 1] - h->cdf[i]) * (float)h->count / (h->range.max - h->range.min);
}

/* The bin that holds a wavelength of the range. The division may round across an edge; the edges decide. */
static uint32_t bin_of(const struct spectral_histogram *h, float lambda_nm)
{
    float at = (lambda_nm - h->range.min) / (h->range.max - h->range.min) * (float)h->count;
    uint32_t i = at < (float)h->count ? (uint32_t)at : h->count - 1;
    if (lambda_nm < bin_edge(h, i) && i > 0)
        return i - 1;
    return i + 1 < h->count && lambda_nm >= bin_edge(h, i + 1) ? i + 1 : i;
}

float spectral_histogram_sample(const struct spectral_histogram *h, float u, float *pdf)
{
    uint32_t low = 0, high = h->count; /* cdf[low] <= u < cdf[high] */
    u = fminf(u, 1 - 0x1p-24f);
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (h->cdf[middle] <= u)
            low = middle;
        else
            high = middle;
    }
    float from = bin_edge(h, low), to = bin_edge(h, low + 1);
    float lambda = from + (u - h->cdf[low]) / (h->cdf[low + 1] - h->cdf[low]) * (to - from);
    *pdf = bin_density(h, low);
    return fmaxf(from, fminf(lambda, nextafterf(to, from)));
}

float spectral_histogram_pdf(const struct spectral_histogram *h, float lambda_nm)
{
    if (!(lambda_nm >= h->range.min && lambda_nm <= h->range.max))
        return 0;
    return bin_density(h, bin_of(h, lambda_nm));
}
