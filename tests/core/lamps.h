/* One light of each kind, each in a scene of its own, with what must be true of it; for the tests of
   csrc/scene's lights. */
#ifndef LAMPS_H
#define LAMPS_H

#include "scenes.h"

#define LAMBDA 500.0f
#define PER_NM 0.01f /* spectral density of all of them: radiance, intensity or irradiance */
#define WIDTH 530.0  /* of Λ */
#define BATCHES 32
#define DRAWS 20000 /* in a batch */

struct sample_light {
    const char *name;
    struct scene *(*make)(void);
    double area;  /* ∫ over points of 1, i.e. the reciprocal of a uniform density; 0: not uniform */
    double power; /* per nm, of the light alone; 0: distant */
};

#define LAMPS 13
extern const struct sample_light lamps[LAMPS];

struct scene *lamps_make_rectangle(void);
struct scene *lamps_make_ellipse(void);
struct scene *lamps_make_sphere(void);
struct scene *lamps_make_point(void);
struct scene *lamps_make_spot(void);
struct scene *lamps_make_wide_spot(void);
struct scene *lamps_make_sun(void);
struct scene *lamps_make_sharp_sun(void);
struct scene *lamps_make_one_sided_mesh(void);
struct scene *lamps_make_two_sided_mesh(void);
struct scene *lamps_make_similar_mesh(void);
struct scene *lamps_make_constant_world(void);
struct scene *lamps_make_image_world(void);
struct scene *lamps_make_stretched_spot(void);
/* Where those of lamps stand; their local −Z is lit. */
struct transform lamps_tilted(float size);
void lamps_draw(uint64_t seed, uint64_t i, float *u, uint64_t count); /* independent numbers */

#endif
