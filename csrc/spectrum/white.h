/* The light that a working space calls white, and the weights by which a reflectance under it becomes XYZ; for the
   files of this room only. */
#ifndef SPECTRUM_WHITE_H
#define SPECTRUM_WHITE_H

#include "spectrum/spectrum.h"

#define OBSERVER_NODES 471 /* every nanometre, or fewer */

/* XYZ of a reflectance that is linear between `count` equally spaced nodes of 360–830 nm, 1 everywhere being white. */
struct observer {
    int count;
    double white[3];
    double weight[OBSERVER_NODES][3];
};
void observer_set(struct observer *, const struct working_space *, int step_nm);

#endif
