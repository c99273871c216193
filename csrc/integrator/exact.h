/* Connections without bias: the wavelength of the connecting run is drawn after both sub-paths exist wherever their geometry allows it
   (algorithm.md §9). */
#ifndef INTEGRATOR_EXACT_H
#define INTEGRATOR_EXACT_H

#include "integrator/path.h"

/* All connections that worker->light and worker->camera offer, and where both sides disperse those of a second light sub-path. */
void exact_connect_all(const struct integrator *, struct worker *);

/* Of them those of worker->light that the camera sees (t = 1). */
void exact_see_lights(const struct integrator *, struct worker *);

#endif
