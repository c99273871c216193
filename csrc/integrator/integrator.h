/* The integrators: one family over the same path code (path.h, connect.h, mis.h), chosen by name (kinds.c). */
#ifndef INTEGRATOR_INTEGRATOR_H
#define INTEGRATOR_INTEGRATOR_H

#include "film/film.h"
#include "material/mollified.h"
#include "scene/scene.h"

/* Paths have at most this many edges. */
#define PATH_EDGES_MAX 32
#define TECHNIQUES_MAX (PATH_EDGES_MAX + 2)
#define LIGHT_PATHS_MAX 64

/* Unit and range beside each; defaults in integrator_settings_default, and in STREAM.md. */
struct integrator_settings {
    const char *name;
    uint32_t seed;
    int lanes;            /* wavelengths in a bundle: 1, 4 or 8 */
    double d0_nm, shrink; /* d_n = d0 n^(−shrink) */
    enum kernel kernel;
    enum side mollify_side;
    double light_paths; /* light sub-paths of a sample, on average; 0: as many as pay (bdpt), 1 (others) */
    int max_path, max_camera, max_light; /* edges */
    int max_diffuse, max_glossy, max_transmission, max_volume, max_transparent;
    int roulette_start;
    float lambda_min, lambda_max;
    float filter_width; /* pixels */
    bool film_transparent;
    /* Study: both sub-paths at one wavelength instead of a kernel, in scenes without fluorescence: the method that the published one is compared
       with. */
    bool shared_wavelength;
    bool connectable_only;                          /* leave out paths that no connection can make */
    bool all_techniques;                            /* else only those with technique[s][t] */
    bool technique[TECHNIQUES_MAX][TECHNIQUES_MAX]; /* [s][t]: light and camera vertices */
    int spectral_bins;
    float bins_min, bins_max;
};
struct integrator_settings integrator_settings_default(void);

struct integrator; /* what is precomputed for one scene: wavelength densities, product tables */

/* Borrowed: scene, film; both must outlive it. NULL with *err: unknown name. Names through `warn` the lights that it cannot see. */
struct integrator *integrator_create(const struct integrator_settings *, const struct scene *, struct film *,
                                     int threads, void (*warn)(void *user, const stokes_error *), void *user,
                                     stokes_error *err);
void integrator_destroy(struct integrator *);
const char *integrator_name_at(size_t index); /* NULL past the end */

/* Decides what the settings leave open for samples from this one on, up to the next look, by tracing some samples of its own with all workers: at most a
   twentieth of what the frame has by then, if it began at sample 0. Ends early once `stop` (may be NULL; any thread asks) says so. What it decides depends on
   scene, settings but the seed and the border, and the number of the sample. */
void integrator_look(struct integrator *, int sample, bool (*stop)(void *user), void *user);
/* The first sample after this one for which it may decide otherwise; INT_MAX: none. */
int integrator_next_look(const struct integrator *, int sample);

/* Light sub-paths of a sample, on average, since sample *from; 0 if it has none. */
double integrator_light_paths(const struct integrator *, int *from);

/* Traces global sample `sample` (from 0; n = sample + 1) of pixel (x, y) of the full frame and adds it to the film. A pixel outside
   the border traces only what may splat into it. Thread-safe for different workers. */
void integrator_sample(struct integrator *, int worker, int x, int y, int sample);

/* Share of the light (X+Y+Z) so far that came over paths which no connection can make: two neighbours that are not specular, they lack. */
double integrator_unconnected_share(const struct integrator *);

/* False if pixels outside the border can contribute nothing. */
bool integrator_splats(const struct integrator *);

#endif
