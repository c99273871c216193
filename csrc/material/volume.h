/* Homogeneous volumes: what scatters and absorbs, per metre, and with which phase functions (algorithm.md §13). */
#ifndef MATERIAL_VOLUME_H
#define MATERIAL_VOLUME_H

#include "material/material.h"

#define VOLUME_PHASES 4
/* Rates of the density that distances are drawn from: constants of the volume, so that all wavelengths and both sides of a path share it. */
#define VOLUME_RATES 8

struct volume_phase {
    struct spectrum *scattering; /* σs, 1/m */
    float most;                  /* its maximum */
    float g;                     /* mean cosine, Henyey–Greenstein */
};

struct volume {
    int phase_count;
    struct volume_phase phase[VOLUME_PHASES];
    struct spectrum *absorption; /* σa, 1/m; NULL: none */
    /* Of volume_finish: */
    struct spectrum *extinction; /* σt, 1/m; NULL: the volume is empty */
    double rate[VOLUME_RATES];   /* 1/m; all 0 where nothing scatters, since then no distance is drawn */
};

/* Takes the spectra (NULL: 0), also on failure. NULL without memory. */
struct volume *volume_create(struct spectrum *scattering, struct spectrum *absorption, float g);
/* a × the first + b × the second; takes both, also on failure. NULL with *why: no memory, coefficients beyond floats, or too many phase functions. */
struct volume *volume_blend(struct volume *first, double a, struct volume *second, double b,
                            stokes_error *why);
/* Sums up what the coefficients mean; to be called once. False without memory. */
bool volume_finish(struct volume *);
void volume_destroy(struct volume *);

/* True if nothing of the volume is above 0. */
bool volume_is_empty(const struct volume *);
bool volume_scatters(const struct volume *);

/* The surface that a scattering vertex has inside of these volumes, each so many times: one lobe for each phase function, at most
   SURFACE_LOBES. `context` is any material of the scene. */
void volume_shade(const struct volume *const volume[], const int times[], int count,
                  const struct material *context, struct surface *);

/* Henyey and Greenstein's phase function between two directions away from the vertex, per steradian; and a draw from it. */
float phase_value(float g, struct vec3 a, struct vec3 b);
struct vec3 phase_sample(float g, struct vec3 arriving, const float u[2]);

#endif
