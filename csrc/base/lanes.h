/* Bundles of wavelengths: arrays of LANES_MAX numbers, of which the first n are in use; n is 1, 4 or 8, chosen when the integrator is made. */
#ifndef BASE_LANES_H
#define BASE_LANES_H

#define LANES_MAX 8

/* A function over lanes whose first parameter is their count. LANES_CALL makes of that a constant, for which compilers unroll its loops or,
   where these hold no branch, make vector code of them. Few connections of the mollified table have another count. */
#define LANES_INLINE static inline __attribute__((always_inline))
#define LANES_CALL(function, n, ...)                                                                         \
    ((n) == 1           ? function(1, __VA_ARGS__)                                                           \
     : (n) == 4         ? function(4, __VA_ARGS__)                                                           \
     : (n) == LANES_MAX ? function(LANES_MAX, __VA_ARGS__)                                                   \
                        : function(n, __VA_ARGS__))

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
