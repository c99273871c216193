/* One run of a sub-path as exact.c connects it (algorithm.md §9): the ends that share it, the bundle of wavelengths of the connecting run, and
   a single connection. */
#ifndef INTEGRATOR_RUNS_H
#define INTEGRATOR_RUNS_H

#include "integrator/joint.h"
#include "integrator/relight.h"

/* Ends that share a run: either one vertex as an F end (its run begins there, with nothing in between), or the E ends of a run in the order
   in which they were traced, from `first` on; those from `dispersive` on lie behind a dispersive refraction. */
struct group {
    int start;
    int first, dispersive, end; /* vertices [first, dispersive) and [dispersive, end) */
    struct choice as;
};
enum { GROUPS_MAX = PATH_VERTICES * CHOICES_MAX };

/* The E ends of the run that begins at a vertex. */
struct group runs_elastic(const struct subpath *, int start);
/* All groups of a sub-path; returns how many. */
int runs_list(const struct subpath *, struct group out[GROUPS_MAX]);
/* The source or sink of wavelengths.h that a group's run begins at. */
int runs_origin(const struct integrator *, enum side, const struct subpath *, const struct group *);

/* The bundle of wavelengths of a connecting run. */
struct bundle {
    int lanes;
    float lambda[LANES_MAX];
    double drawn[LANES_MAX];
    const double *density; /* drawn, or NULL for what a sub-path's own steps have paid already */
    double owed;           /* 1/(chance that roulette left the run) */
};

/* Draws it from what the source emits and the sink takes. False if they share nothing. */
bool runs_draw(const struct integrator *, const struct worker *, int source, int sink, uint32_t dimension,
               struct bundle *);
/* The one wavelength that is left behind a group's dispersive refraction. */
void runs_as_traced(const struct integrator *, const struct subpath *, const struct group *, struct bundle *);

/* Part of a group with what it needs to connect. */
struct taps {
    const struct subpath *path;
    const struct group *group;
    int first, end;
    const struct strand *strand; /* NULL: as traced */
};

/* The non-dispersive part of a group at these wavelengths. False if there is none, or nothing of them arrives. */
bool runs_plain(const struct integrator *, struct worker *, enum side, const struct subpath *,
                const struct group *, const struct bundle *, struct taps *);
/* The rest of it, as traced. */
struct taps runs_dispersive(const struct subpath *, const struct group *);

/* Whether a vertex can be the end of a connection with this label. */
bool runs_can_end(const struct vertex *, struct choice as);
/* Vertex y of the light's taps and x of the camera's joined at the bundle's wavelengths. Both may have been looked at before: then `sight` knows. `joint`
   is room for it, and of a lens point holds the direction's density; `splat` is the pixel, or NULL for the camera's own. */
void runs_join(const struct integrator *, struct worker *, struct joint *, const struct taps *light, int y,
               const struct taps *camera, int x, const struct bundle *, struct sight *, const int *splat);

#endif
