/* Drawing from the pixel filter: the four-term Blackman–Harris window (Harris 1978, "On the use of windows
   for harmonic analysis"), whose cdf has a closed form; its inverse is found by Newton's method. */
#include <math.h>

#include "film/film.h"

static const double cosine[4] = {0.35875, 0.48829, 0.14128, 0.01168};
#define TWO_PI 6.283185307179586
/* x in units of the whole window's length has nearly this standard deviation; a logistic curve of it is a
   good start. */
#define DEVIATION 0.1342
#define STEPS 12

/* Density and cdf at x in [−1/2, 1/2]; the window's length is 1, its integral cosine[0] before
   normalisation. */
static double window(double x, double *cdf)
{
    double c = cos(TWO_PI * x), s = sin(TWO_PI * x);
    double c2 = 2 * c * c - 1, s2 = 2 * s * c;
    double c3 = c * c2 - s * s2, s3 = s * c2 + c * s2;
    double sines = cosine[1] * s + cosine[2] * s2 / 2 + cosine[3] * s3 / 3;
    *cdf = 0.5 + x + sines / (TWO_PI * cosine[0]);
    return 1 + (cosine[1] * c + cosine[2] * c2 + cosine[3] * c3) / cosine[0];
}

float film_filter_sample(float width, float u)
{
    if (!(u > 0) || !(u < 1))
        return u >= 1 ? width : -width;
    double low = -0.5, high = 0.5;
    double x = fmin(fmax(DEVIATION * 0.5513 * log(u / (1.0 - u)), -0.45), 0.45);
    for (int step = 0; step < STEPS; step++) {
        double cdf, density = window(x, &cdf);
        *(cdf < u ? &low : &high) = x;
        double next = x - (cdf - u) / density;
        if (next < low || next > high) /* the tails are flat: Newton's step leaves the bracket */
            next = (low + high) / 2;
        if (fabs(next - x) < 1e-7) {
            x = next;
            break;
        }
        x = next;
    }
    return (float)(2 * x) * width;
}

/* Pixel centres lie at half integers; a camera sample of pixel i looks through i + 1/2 + offset. So what is
   seen through `at` belongs to pixel i with the filter's density at i + 1/2 - at; one of them is drawn, and
   stands for all. */
int film_filter_pixel(float width, float at, float u, float *weight)
{
    int first = (int)ceilf(at - 0.5f - width), last = (int)floorf(at - 0.5f + width);
    double sum = 0, passed = 0, unused;
    for (int i = first; i <= last; i++)
        sum += window((i + 0.5 - (double)at) / (2 * (double)width), &unused);
    *weight = (float)(sum / (2 * (double)width));
    for (int i = first; i <= last; i++) {
        passed += window((i + 0.5 - (double)at) / (2 * (double)width), &unused);
        if (u * sum < passed)
            return i;
    }
    return last;
}
