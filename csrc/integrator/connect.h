/* Connections between sub-paths: next event estimation (s = 1), light tracing (t = 1) and everything between, as rows of
   one table over the labels of the two ends (algorithm.md §5). */
#ifndef INTEGRATOR_CONNECT_H
#define INTEGRATOR_CONNECT_H

#include "integrator/path.h"

/* All connections that worker->light and worker->camera offer; to worker->gathered, or splatted for t = 1. */
void connect_all(const struct integrator *, struct worker *);

/* Of them those of worker->light that the camera sees (t = 1). */
void connect_lenses(const struct integrator *, struct worker *);

#endif
