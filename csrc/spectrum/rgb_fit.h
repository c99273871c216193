/* Fitting curves of three coefficients to colours: Jakob & Hanika's, and those of three trigonometric moments (moments.h); for the files
   of this room only. */
#ifndef SPECTRUM_RGB_FIT_H
#define SPECTRUM_RGB_FIT_H

#include "spectrum/white.h"

/* A quadratic, highest power first, in t = (λ − 595 nm)/235 nm or, for moments, in −cos φ = sin(π t/2): all coefficients are of like size.
   The curve is its sigmoid: 1/2 + x/(2√(1 + x²)), or for moments 1/2 + atan(x)/π. */
struct fit {
    enum rgb_method method;
    double p[3];
    double error; /* ΔE*ab from what was asked for */
};

struct fitter {
    enum rgb_method method;
    struct observer observer;
    double rgb_to_xyz[9];
};
void fitter_set(struct fitter *, enum rgb_method, const struct working_space *, int step_nm);

#define FIT_SOLVED 1e-4     /* ΔE*ab at which a search ends */
#define FIT_REACHED 0.05    /* ΔE*ab up to which a colour counts as reached */
#define FIT_STEEPEST 1000.0 /* coefficients beyond which a curve is a step narrower than the observer's nodes */
#define FIT_SMOOTH 400.0    /* the same, for the nearest colour of one that is out of reach */
#define FIT_ATAN 50.0       /* how much larger both are for moments: an arc tangent nears 0 and 1 more slowly */

/* Improves `start` towards a colour; `ridge` is the price of large coefficients, 0 for none. */
struct fit fitter_improve(const struct fitter *, const double rgb[3], struct fit start, double ridge, int iterations);
/* From nothing: the colour, or the nearest that a smooth curve makes. */
struct fit fitter_solve(const struct fitter *, const double rgb[3]);
bool fit_reaches(const struct fit *);
/* The curve that is constant. */
struct fit fit_grey(enum rgb_method, double value);
/* Of a Jakob–Hanika fit. */
struct rgb_curve fit_curve(const struct fit *);
/* A constant colour; *outside (may be NULL) as in rgb_curve_fit. */
struct fit fit_color(enum rgb_method, const struct working_space *, const float rgb[3], bool *outside);

#endif
