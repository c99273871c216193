/* Evaluating the last run of a sub-path again at another wavelength (algorithm.md §9): the geometry and the labels are kept, and the densities
   with which they were really drawn; values and nominal densities are those of the new wavelength. */
#ifndef INTEGRATOR_RELIGHT_H
#define INTEGRATOR_RELIGHT_H

#include "integrator/mis.h"

/* One run, from the vertex where it starts (an F vertex, the light, the camera) to a later one. */
struct relit {
    int start, end;
    float lambda;
    double throughput
        [PATH_VERTICES]; /* on arrival at vertices start + 1 … end, without any density of this run's wavelength */
    float own[PATH_VERTICES]; /* nominal densities of the steps through vertices start … end − 1 */
    float other[PATH_VERTICES];
};

/* Vertex where the run starts that arrives at vertex `at`. */
int run_start(const struct subpath *, int at);

/* False if nothing of this wavelength arrives at `end`. */
bool relight(const struct integrator *, enum side, const struct subpath *, int start, int end, float lambda,
             struct relit *);

/* Overwrites in a full path that full_path_copy has made what the run says of steps through vertices before `upto`. */
void relit_put(const struct relit *, enum side, int upto, struct full_path *);

/* Transmittance of the edge between two neighbouring vertices at one wavelength over that at another: what a ray that passed transparent
   surfaces by chance owes the new one. */
double edge_transmittance_ratio(const struct integrator *, const struct vertex *from, const struct vec3 *to,
                                struct vec3 direction, float lambda, float lambda_drawn);

#endif
