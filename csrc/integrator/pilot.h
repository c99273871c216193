/* Looks at the scene (algorithm.md §15); integrator.h says when they come. */
#ifndef INTEGRATOR_PILOT_H
#define INTEGRATOR_PILOT_H

#include "integrator/trial.h"

/* Of a sample. Work in edges traced, by who needs it. */
struct look {
    double variance[NUMBERS], work[TECHNIQUE_KINDS];
};

/* Looks at so many pixels of the whole frame, with one light sub-path a sample, and sets `typical`; a second time if it `weighs`, for the variance. False if
   it was stopped or there is no memory. */
bool pilot_look(struct integrator *, int pixels, bool weighs, bool (*stop)(void *user), void *user,
                struct look *);

#endif
