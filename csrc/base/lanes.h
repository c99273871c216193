/* Bundles of wavelengths: arrays of LANES_MAX numbers, of which the first n are in use. Loops over lanes hold no branch, so that compilers
   make vector code of them; n is 1, 4 or 8, chosen when the integrator is made. */
#ifndef BASE_LANES_H
#define BASE_LANES_H

#define LANES_MAX 8

/* The first is given, the others follow in steps of 1/n around the unit interval: each is as uniform as the first. */
static inline void lanes_stratify(float u, int n, float out[LANES_MAX])
{
    float step = 1 / (float)n;
    out[0] = u;
    for (int i = 1; i < n; i++) {
        float v = u + (float)i * step;
        out[i] = v < 1 ? v : v - 1;
    }
}

static inline double lanes_sum(const double x[LANES_MAX], int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += x[i];
    return sum;
}

#endif
