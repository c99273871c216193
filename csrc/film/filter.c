/* Drawing from the pixel filter: the four-term Blackman–Harris window (Harris 1978, "On the use of windows for
   harmonic analysis"), whose cdf has a closed form; a table and Newton's method invert it. */
#include <math.h>

#include "film/film.h"

#include "film/filter.inc"

static const double cosine[4] = {0.35875, 0.48829, 0.14128, 0.01168};
#define TWO_PI 6.283185307179586
#define STEPS 12

/* The window's length is 1, from −1/2 to 1/2, and its integral 1; c = cos 2πx. */
static double window(double c)
{
    double c2 = 2 * c * c - 1, c3 = 2 * c * c2 - c;
    return 1 + (cosine[1] * c + cosine[2] * c2 + cosine[3] * c3) / cosine[0];
}

static double window_cdf(double x, double c, double s)
{
    double s2 = 2 * s * c, s3 = 2 * c * s2 - s;
    return 0.5 + x + (cosine[1] * s + cosine[2] * s2 / 2 + cosine[3] * s3 / 3) / (TWO_PI * cosine[0]);
}

/* For u in [1/2, 1). One step is enough but for the last quantiles, where the window is next to nothing. */
static double invert_upper_half(double u)
{
    double at = (u - 0.5) * 2 * QUANTILES;
    int i = (int)at;
    double low = quantile[i], high = quantile[i + 1], x = low + (high - low) * (at - i);
    for (int step = 0; step < STEPS; step++) {
        double c = cos(TWO_PI * x), s = sin(TWO_PI * x), error = window_cdf(x, c, s) - u;
        *(error < 0 ? &low : &high) = x;
        double next = x - error / window(c);
        if (next < low || next > high) /* the tail is flat: Newton's step leaves the bracket */
            next = (low + high) / 2;
        double change = fabs(next - x);
        x = next;
        if (change < 1e-4) /* the next one would be of its square */
            break;
    }
    return x;
}

float film_filter_sample(float width, float u)
{
    if (!(u > 0) || !(u < 1))
        return u >= 1 ? width : -width;
    double x = u < 0.5f ? -invert_upper_half(1 - (double)u) : invert_upper_half(u);
    return (float)(2 * x) * width;
}

/* Pixel centres lie at half integers; a camera sample of pixel i looks through i + 1/2 + offset. So what is seen
   through `at` belongs to pixel i with the filter's density at i + 1/2 - at; one of them is drawn, and stands
   for all. */
int film_filter_pixel(float width, float at, float u, float *weight)
{
    int first = (int)ceilf(at - 0.5f - width), last = (int)floorf(at - 0.5f + width);
    double per_pixel = TWO_PI / (2 * (double)width), sum = 0, passed = 0;
    for (int i = first; i <= last; i++)
        sum += window(cos((i + 0.5 - (double)at) * per_pixel));
    *weight = (float)(sum / (2 * (double)width));
    for (int i = first; i < last; i++) {
        passed += window(cos((i + 0.5 - (double)at) * per_pixel));
        if (u * sum < passed)
            return i;
    }
    return last;
}
