/* A flight: one edge of a sub-path on its way, past transparent surfaces and through volumes, to where it next scatters. */
#ifndef INTEGRATOR_FLIGHT_H
#define INTEGRATOR_FLIGHT_H

#include "integrator/path.h"

struct flight {
    struct ray ray;
    uint32_t dimension; /* of the next pass */
    bool passed;        /* a transparent surface that is not clear */
    struct media media; /* that the ray is in, where the scene has volumes */
    int rate;           /* of volume.h, that the distance is drawn with */
    double depth;       /* optical, at which it ends the flight */
};

/* Follows the ray to where it next scatters; every emitter on the way is offered to gather.h (camera side). Returns false when the path ends: it left the
   scene, or met only glass-clear surfaces for too long. */
bool fly(const struct integrator *, struct worker *, enum side, struct flight *, struct vertex *next);

/* A ray leaves vertex v: the media on that side of it. */
struct media flight_media(const struct vertex *v, struct vec3 direction);

/* Densities of an edge's length for a step from `from` (algorithm.md §13), which the other end stops by being in `end`, or a surface (NULL): with which it is really
   drawn, and nominally. `odds` (may be NULL) become those of the other end. */
struct length_density {
    double drawn, nominal;
};
struct length_density flight_density(const struct integrator *, const struct vertex *from,
                                     const struct crossing *, const struct media *end,
                                     float odds[VOLUME_RATES]);
/* The nominal one alone, for a step to `to`. */
double flight_nominal(const struct integrator *, const struct crossing *, const struct vertex *to);

/* What volumes make of the edge to the new vertex `next`, once it has arrived: densities of its length, and what is left of the lanes. False if nothing is. */
bool flight_settle(const struct integrator *, const struct vertex *prev, struct vertex *next);

#endif
