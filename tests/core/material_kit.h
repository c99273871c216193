/* Building materials for tests: closures by hand, closures at random over the table of kinds, and surfaces of them. */
#ifndef MATERIAL_KIT_H
#define MATERIAL_KIT_H

#include "base/random.h"
#include "material/lobe.h"

#define KIT_RANGE ((struct range){300, 830})

/* Uniform numbers in a row, for building cases. */
struct kit_random {
    struct random_path path;
    uint32_t next;
};
float kit_uniform(struct kit_random *);
float kit_between(struct kit_random *, float low, float high);
struct vec3 kit_direction(struct kit_random *);
/* On the side of n (or of −n), with a cosine of at least 0.05. */
struct vec3 kit_direction_about(struct kit_random *, struct vec3 n, bool other_side);

struct closure *kit_bsdf(const char *name);
struct color_node *kit_constant(float value);
struct color_node *kit_table(const float *lambda, const float *value, size_t count);
struct color_node *kit_gaussian(double mean, double sigma, double peak);
struct value_node *kit_value(float constant);
struct closure *kit_mix(struct closure *a, struct closure *b, struct value_node *factor);
struct closure *kit_add(struct closure *a, struct closure *b);

/* A dye: reflectance r, absorption Gaussian at `absorbs`, emission Gaussian at `emits`. */
struct closure *kit_dye(float reflectance, float concentration, double absorbs, double emits, double yield,
                        bool energy);

/* A matrix at random; some ask for more energy or photons than there are. */
stokes_matrix *kit_matrix(struct kit_random *);

/* A closure of this kind with every input at random, by its signature; roughness is at least `roughness`. */
struct closure *kit_random_bsdf(struct kit_random *, const struct bsdf_kind *, float roughness);
/* Takes its roughness away: a δ lobe where the kind has one. */
void kit_set_roughness(struct closure *, float roughness);
/* Names it, for messages. */
const char *kit_describe(const struct closure *, char text[256]);

/* Must compile. */
struct material *kit_compile(struct closure *);
struct material *kit_try_compile(struct closure *, int *warnings, stokes_error *err);

/* A hit with normals; the surface there. */
struct hit kit_hit(struct vec3 ng, struct vec3 ns);
struct surface kit_surface(const struct material *, struct vec3 ng, struct vec3 ns);

#endif
