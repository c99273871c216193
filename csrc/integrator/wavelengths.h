/* The wavelength densities of a scene: p_cam, and tables of products e·ã over pairs of what emits into a run (lights,
   fluorophores) and what takes from it (fluorophores, the camera) — O of algorithm.md §5. */
#ifndef INTEGRATOR_WAVELENGTHS_H
#define INTEGRATOR_WAVELENGTHS_H

#include "scene/scene.h"

struct integrator_settings;

struct wavelengths {
    struct spectrum *camera;             /* p_cam, not normalised */
    int shapes, fluorophores;            /* spectral shapes of lights; many lights share one */
    struct spectral_histogram **product; /* (shapes + fluorophores) × (fluorophores + 1) */
    float *overlap;                      /* the same of ∫ e ã, both normalised, nm⁻¹; about */
    float *middle;                       /* median of the product, nm */
};

bool wavelengths_create(struct wavelengths *, const struct integrator_settings *, const struct scene *,
                        stokes_error *err);
void wavelengths_destroy(struct wavelengths *);

/* Emitters into a run and takers from it, by index into the table: lights are sources, and dyes are sinks, by their own index. */
static inline int wavelengths_source_dye(const struct wavelengths *w, int dye)
{
    return w->shapes + dye;
}
static inline int wavelengths_sink_camera(const struct wavelengths *w)
{
    return w->fluorophores;
}

/* The same for either: what a sub-path of `side` leaves behind at a dye, or would come to from the other. */
static inline int wavelengths_dye(const struct wavelengths *w, enum side side, int dye)
{
    return side == SIDE_LIGHT ? wavelengths_source_dye(w, dye) : dye;
}

/* 0 where source and sink have no wavelength in common. */
static inline float wavelengths_overlap(const struct wavelengths *w, int source, int sink)
{
    return w->overlap[source * (w->fluorophores + 1) + sink];
}

/* A wavelength that both have. */
static inline float wavelengths_middle(const struct wavelengths *w, int source, int sink)
{
    return w->middle[source * (w->fluorophores + 1) + sink];
}

/* NULL where source and sink have no wavelength in common. */
static inline const struct spectral_histogram *wavelengths_product(const struct wavelengths *w, int source,
                                                                   int sink)
{
    return w->product[source * (w->fluorophores + 1) + sink];
}

#endif
