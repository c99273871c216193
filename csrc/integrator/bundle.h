/* Bundles of wavelengths on their way along a sub-path (algorithm.md §11). */
#ifndef INTEGRATOR_BUNDLE_H
#define INTEGRATOR_BUNDLE_H

#include "integrator/path.h"

/* The wavelength of a run that begins: its own with chance q_own, or one of the camera's. Returns the chance of what was chosen. */
double bundle_choose_copy(const struct worker *, struct copying *, uint32_t dimension);

/* Everything that the lanes owe after a step that the leader drew: densities, who might have led, gains. False if nothing lives on. */
bool bundle_follow(const struct integrator *, struct worker *, enum side, const struct subpath *,
                   uint32_t dimension, const struct scatter *, struct vertex *, struct vertex *next,
                   struct surface_steps *, double gain[LANES_MAX]);

/* The next vertex's arrival, but for the edge to it. `at`: the number of v in its sub-path. */
void bundle_depart(const struct integrator *, const struct worker *, enum side, const struct vertex *v,
                   int at, const struct surface_steps *, const double gain[LANES_MAX], struct vertex *next);
/* The same from an end whose lanes are set. */
void bundle_depart_end(const struct integrator *, const struct worker *, enum side, struct vertex *end,
                       const double throughput[LANES_MAX], const float draw[LANES_MAX], int leader,
                       struct vertex *next);

#endif
