/* Fitting Jakob & Hanika's curves; for the files of this room only. */
#ifndef SPECTRUM_RGB_FIT_H
#define SPECTRUM_RGB_FIT_H

#include "spectrum/white.h"

/* A curve in the variable t = (λ - 595 nm)/235 nm, highest power first: all coefficients then are of like size. */
struct fit {
    double p[3];
    double error; /* ΔE*ab from what was asked for */
};

struct fitter {
    struct observer observer;
    double rgb_to_xyz[9];
};
void fitter_set(struct fitter *, const struct working_space *, int step_nm);

#define FIT_SOLVED 1e-4     /* ΔE*ab at which a search ends */
#define FIT_REACHED 0.05    /* ΔE*ab up to which a colour counts as reached */
#define FIT_STEEPEST 1000.0 /* coefficients beyond which a curve is a step narrower than the observer's nodes */
#define FIT_SMOOTH 400.0    /* the same, for the nearest colour of one that is out of reach */

/* Improves `start` towards a colour; `ridge` is the price of large coefficients, 0 for none. */
struct fit fitter_improve(const struct fitter *, const double rgb[3], struct fit start, double ridge, int iterations);
/* From nothing: the colour, or the nearest that a smooth curve makes. */
struct fit fitter_solve(const struct fitter *, const double rgb[3]);
bool fit_reaches(const struct fit *);
/* The curve that is constant. */
struct fit fit_grey(double value);
struct rgb_curve fit_curve(const struct fit *);

#endif
