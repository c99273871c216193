/* Reflectances from a few trigonometric moments: C. Peters, S. Merzbach, J. Hanika, C. Dachsbacher, "Using Moments to Represent Bounded
   Signals for Spectral Rendering", ACM TOG 38(4), 2019.

   Wavelengths become phases φ = π (λ − min)/(max − min) in 0 … π, the signal is mirrored to −π … 0, and its moments are
   c_l = 1/π ∫₀^π g(φ) cos(lφ) dφ. Of all signals within [0, 1] with these moments the bounded maximum entropy spectral estimate is
   g(φ) = 1/2 + 1/π atan(t_0 + Σ t_l cos(lφ)): smooth, and within [0, 1] whatever the moments.
   Integrals: a spectrum compiled from it is linear between whole nanometres, and its cumulative table is exact for that; values, densities
   and draws come from the same table and agree. The curve's own integral, within 0.02 nm of it for random reflectances (test_moments.c), has
   a closed form, dilogarithms at the roots of a polynomial, at many times the cost. */
#ifndef SPECTRUM_MOMENTS_H
#define SPECTRUM_MOMENTS_H

#include "spectrum/spectrum.h"

#define MOMENTS_MAX 64

struct moment_curve {
    int count; /* of moments */
    float min, max;
    double t[MOMENTS_MAX];
};

/* From moments over [min, max] nm. Those at the edge of what a bounded signal can have (a reflectance of exactly 0 or 1 throughout, or that
   jumps between the two) are drawn inward by as little as works. False with *err if no signal within [0, 1] has them, nearly. */
bool moment_curve_make(const double *moments, int count, float min, float max, struct moment_curve *,
                       const char *name, stokes_error *err);
/* Held beyond min and max, where its slope is 0. */
double moment_curve_eval(const struct moment_curve *, double lambda_nm);

/* The first `count` moments of a spectrum over [min, max], exact for its linear pieces. */
void moments_of_spectrum(const struct spectrum *, float min, float max, double *moments, int count);

/* As spectra, a knot a nanometre. */
struct spectrum *spectrum_moments(struct range, const double *moments, int count, float min, float max,
                                  const char *name, stokes_error *err);
struct spectrum *spectrum_rgb_moments(struct range, const struct working_space *, const float rgb[3],
                                      enum uv_rule, bool *outside);

#endif
