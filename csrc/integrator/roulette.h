/* Russian roulette on connections: most of them bring next to nothing, and are given up by chance before anything dear is done
   for them. The chance follows estimates; it divides what survives and stays out of the weights (algorithm.md §14). */
#ifndef INTEGRATOR_ROULETTE_H
#define INTEGRATOR_ROULETTE_H

#include "integrator/path.h"

/* For something that would add about `estimate` to the camera's pixel: 1/(chance to go on with it), or 0: given up. */
double roulette(const struct integrator *, struct worker *, double estimate);

/* What counts for that of a radiance of 1 per nm at a wavelength on the film: X+Y+Z, and as much in bins. */
double roulette_color(const struct integrator *, float lambda);
/* Its integral over all wavelengths. */
double roulette_white(const struct integrator *);

/* What the surface at a vertex may send on, sr⁻¹, where it is matte; for others a guess that is rather high. By a dye also
   per nm. */
float roulette_value(const struct vertex *, enum label);

/* Sets worker->power of both sub-paths as they were traced: what arrives at a vertex, on the camera's side times p_cam of the
   wavelength on the film (so that it is a share of what the pixel takes), times what may be sent on. A run that may be evaluated
   again is not taken for dark because its own wavelength was. */
void roulette_weigh(const struct integrator *, struct worker *);

#endif
