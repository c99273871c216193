/* Small scenes for the tests of integrators: boxes and spheres of given materials, built through scene/build.h. */
#ifndef BOXES_H
#define BOXES_H

#include "base/error.h"
#include "integrator/path.h"
#include "scene/build.h"
#include "statistics.h"

/* Closures; each call makes a new tree that the scene takes. Spectra are over `range`. */
struct closure *box_diffuse(struct range, float reflectance);
/* A dye that absorbs in the blue and shines in the orange, over a grey. */
struct closure *box_fluorescent(struct range, float concentration, float energy_yield);
struct closure *box_glass(double n_d, double abbe);
struct closure *box_lamp(struct range, float radiance_per_nm);

/* Adds a mesh and one instance of it. */
void box_add_quad(struct scene *, const char *name, const char *material, const float corners[4][3]);
void box_add_sphere(struct scene *, const char *name, const char *material, const float center[3],
                    float radius);

/* A grey floor under two lamps, of which only the camera sees the second; the camera looks at all three. Committed. */
struct scene *hidden_lamp_scene(struct range, int pixels);

/* Nothing but a constant world, of this radiance per nm, and the camera. Committed. */
struct scene *world_scene(struct range, float radiance_per_nm, int pixels);

/* A closed unit box, floor and right wall fluorescent, the rest grey, a square lamp under the ceiling, the camera in the middle of
   the front. With `lenses`, the lamp hangs inside a ball of dispersive glass, and the camera looks through another. Committed. */
struct scene *box_scene(struct range, bool lenses, int pixels);

/* A constant world; the left half of the picture is an object that holds out. Committed. */
struct scene *hole_scene(struct range, int pixels);

/* box_scene without glass, full of a mist that scatters blue light, camera and lamp inside of it; and in it a cloud without a surface that scatters red
   light. Committed. */
struct scene *misty_box_scene(struct range, int pixels);
/* box_scene with lenses, the glass of which scatters and absorbs inside, around the lamp and before the camera. Committed. */
struct scene *bottle_box_scene(struct range, int pixels);

/* box_scene without lenses, its ball of frosted glass: rough enough for runs through it to be evaluated again. Committed. */
struct scene *frosted_box_scene(struct range, int pixels);

/* The same box, all grey and without glass: nothing in it depends on the wavelength. Committed. */
struct scene *grey_box_scene(struct range, int pixels);

/* The same box without glass, with a dye that absorbs all of a band, and so reflects nothing there. Committed. */
struct scene *saturated_box_scene(struct range, int pixels);

/* box_scene without lenses, with a dye that absorbs in one band and emits in another, and nothing outside of these; they overlap. Committed. */
struct scene *banded_box_scene(struct range, int pixels);

/* An integrator with a kernel of constant half-width. */
struct integrator_settings box_settings(const char *name, double d_nm);
/* Mean Y of the lower part of a picture of 16 × 16 pixels, where no lamp is, in 32 batches, one a seed. */
struct batches box_mean_below(const struct scene *, struct range, struct integrator_settings, int samples);

#endif
