/* Asking a spectrum: values, integrals, and drawing wavelengths from it as a density. */
#include <assert.h>
#include <math.h>

#include "spectrum/knots.h"

double spectrum_integral(const struct spectrum *s)
{
    return s->cumulative[s->count - 1];
}

double spectrum_integral_to(const struct spectrum *s, float lambda_nm)
{
    if (!(lambda_nm > s->lambda[0]))
        return 0;
    if (lambda_nm >= s->lambda[s->count - 1])
        return spectrum_integral(s);
    uint32_t i = spectrum_segment(s, lambda_nm);
    double length = (double)lambda_nm - s->lambda[i];
    return s->cumulative[i] + 0.5 * length * ((double)s->value[i] + segment_value(s, i, lambda_nm));
}

/* Within a segment the integral is a parabola, and its integral a cubic. Beyond Λ the integral stays what it is. */
double spectrum_second_integral_to(const struct spectrum *s, float lambda_nm)
{
    float last = s->lambda[s->count - 1];
    if (!(lambda_nm > s->lambda[0]))
        return 0;
    if (lambda_nm >= last)
        return s->second[s->count - 1] + spectrum_integral(s) * ((double)lambda_nm - last);
    uint32_t i = spectrum_segment(s, lambda_nm);
    double h = (double)lambda_nm - s->lambda[i];
    return s->second[i] +
           h * (s->cumulative[i] + h / 6 * (2.0 * s->value[i] + segment_value(s, i, lambda_nm)));
}

float spectrum_max(const struct spectrum *s)
{
    float max = s->value[0];
    for (uint32_t i = 1; i < s->count; i++)
        max = fmaxf(max, s->value[i]);
    return max;
}

float spectrum_min(const struct spectrum *s)
{
    float min = s->value[0];
    for (uint32_t i = 1; i < s->count; i++)
        min = fminf(min, s->value[i]);
    return min;
}

/* Within a segment the cdf is v0·h·t + (v1 - v0)·h·t²/2 = rest. Of the two forms of its root this one subtracts
   nothing that is nearly equal, and holds for v1 = v0 too. */
static double invert_segment(double v0, double v1, double length, double rest)
{
    double area = rest / length, root = v0 * v0 + 2 * (v1 - v0) * area;
    double divisor = v0 + sqrt(root > 0 ? root : 0);
    return divisor > 0 ? 2 * area / divisor : 0;
}

float spectrum_sample(const struct spectrum *s, float u, float *pdf)
{
    double total = spectrum_integral(s), target = (u < 1 ? u : 1 - 0x1p-24) * total;
    assert(total > 0);
    uint32_t j = (uint32_t)(u * (float)s->count);
    uint32_t i = s->guide[j < s->count ? j : s->count - 1];
    while (i + 2 < s->count && s->cumulative[i + 1] <= target)
        i++;
    float l0 = s->lambda[i], l1 = s->lambda[i + 1];
    double length = (double)l1 - l0;
    double t = invert_segment(s->value[i], s->value[i + 1], length, target - s->cumulative[i]);
    /* Strictly inside the segment, where the density is positive and which side of a step is meant is certain. */
    float lambda = fminf(fmaxf((float)(l0 + t * length), nextafterf(l0, l1)), nextafterf(l1, l0));
    *pdf = (float)(segment_value(s, i, lambda) / total);
    return lambda;
}

float spectrum_pdf(const struct spectrum *s, float lambda_nm)
{
    double total = spectrum_integral(s);
    return total > 0 ? (float)(spectrum_eval(s, lambda_nm) / total) : 0;
}
