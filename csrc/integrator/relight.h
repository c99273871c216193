/* Evaluating the last run of a sub-path again at other wavelengths (algorithm.md §9): the geometry and the labels are kept, and the densities
   with which they were really drawn; values and nominal densities are those of the new wavelengths. */
#ifndef INTEGRATOR_RELIGHT_H
#define INTEGRATOR_RELIGHT_H

#include "integrator/path.h"

/* One run at other wavelengths, from the vertex where it starts to a later one. */
struct strand {
    int start;
    struct arrival at[PATH_VERTICES]; /* start + 1 … ; without any density of this run's wavelength */
    float own[PATH_VERTICES][LANES_MAX], other[PATH_VERTICES][LANES_MAX]; /* of steps through start … */
};

/* Returns the last vertex up to `end` at which something of these wavelengths arrives, or `start`. `path` has `end` + 1 vertices, or `end` if
   the last is still to come: then what arrives there lacks the last edge's seam and passage. */
int relight(const struct integrator *, const struct worker *, enum side, const struct subpath *, int start,
            int end, int lanes, const float lambda[LANES_MAX], struct strand *);

/* Transmittance of the edge between two neighbouring vertices at a wavelength, for rays that passed transparent surfaces by chance. */
double edge_transmittance(const struct integrator *, enum side, const struct vertex *from, const struct vec3 *to,
                          struct vec3 direction, float lambda);

#endif
