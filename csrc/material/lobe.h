/* The room's inside: kinds of BSDF (what JSON names), kinds of lobe (what a surface is made of), and the compiled material.
   A BSDF compiles into one lobe or more; at a hit each lobe gets its colours, numbers and frame. */
#ifndef MATERIAL_LOBE_H
#define MATERIAL_LOBE_H

#include "material/closure.h"

/* --- Lobes ----------------------------------------------------------------------------------------------- */

enum lobe_nature { LOBE_FINITE, LOBE_FLUORESCENT, LOBE_DELTA };

/* What a δ lobe does with a direction. `probability` is that of the branch taken, given the lobe; by the symmetry of
   Fresnel's formulae it is the same seen from the other side. */
struct delta {
    struct vec3 leaving; /* local */
    float coefficient;   /* T or R, without n² */
    float probability;
    float n_squared; /* (n_c/n_l)²: 1 unless it refracts */
    bool refracts, disperses;
    enum scatter_class depth_class;
};

/* What an elastic lobe's wavelengths are made of: all of it, g = r (1 − c a); what it reflects, r; what its dye leaves to reflect. */
enum part { PART_ALL, PART_REFLECTED, PART_KEPT };

/* A part as a sum of tables, whose integrals take constant time. */
struct part_terms {
    double constant;
    int count;
    struct {
        double factor;
        const struct spectrum *spectrum;
    } term[2];
};

/* Directions are local: z is along the shading normal; z > 0 is the side of ng. A lobe that does not care about sides
   mirrors them. Unused functions are NULL: a δ lobe has `scatter` only, a fluorescent one nothing but `albedo`. */
struct lobe_kind {
    const char *name;
    enum lobe_nature nature;
    enum scatter_class
        reflects_as; /* how Cycles counts its reflection; its transmission is SCATTER_TRANSMISSION */
    bool is_lambert; /* `evaluate` is albedo · |to_light.z|/π on one side, and albedo that of any cosine */

    /* Estimate of the share of power that this lobe scatters of what arrives with cosine z, without the weight. Sets chances; for
       lobes of finite density it is also g of eq. 26. */
    float (*albedo)(const struct lobe *, float z, float lambda);
    /* ∫ albedo dλ from a to b; NULL: quadrature. False: this lobe cannot (a textured colour), use quadrature. */
    bool (*albedo_integral)(const struct lobe *, float z, float a, float b, double *integral);

    /* Parts, for lobes whose dye keeps some from being reflected. NULL: all is reflected. */
    float (*part)(const struct lobe *, enum part, float lambda);
    /* NULL or false: quadrature. */
    bool (*terms)(const struct lobe *, enum part, struct part_terms *);

    /* Of microfacets and mirrors: reflectance at the cosine between a direction and the facet's normal. */
    float (*reflectance)(const struct lobe *, float cosine, float lambda);
    /* f_s·|to_light.z|, sr⁻¹, without the weight. Both directions are off the horizon. */
    float (*evaluate)(const struct lobe *, struct vec3 to_light, struct vec3 to_camera, float lambda);
    /* Density per solid angle of leaving, for a sub-path from `side`. */
    float (*pdf)(const struct lobe *, enum side, struct vec3 arriving, struct vec3 leaving, float lambda);
    bool (*sample)(const struct lobe *, enum side, struct vec3 arriving, float lambda, const float u[3],
                   struct vec3 *leaving);
    bool (*disperses)(const struct lobe *); /* its transmission; NULL: does not refract */

    bool (*scatter)(const struct lobe *, enum side, struct vec3 arriving, float lambda, float u,
                    struct delta *);
};

/* Not `static` where another file makes lobes of the kind, too. */
extern const struct lobe_kind lobe_diffuse, lobe_fluorescent, lobe_dielectric, lobe_smooth_dielectric;

/* Cosine-distributed diffuse reflection on the arriving side, shared by several kinds. */
float diffuse_pdf(const struct lobe *, enum side, struct vec3 arriving, struct vec3 leaving, float lambda);
bool diffuse_sample(const struct lobe *, enum side, struct vec3 arriving, float lambda, const float u[3],
                    struct vec3 *leaving);

float spectral_value_eval(const struct spectral_value *, float lambda);
bool spectral_value_integral(const struct spectral_value *, float a, float b, double *integral);
bool spectral_value_terms(const struct spectral_value *, struct part_terms *);
static inline struct spectral_value spectral_flat(float scale)
{
    return (struct spectral_value){.form = SPECTRAL_FLAT, .scale = scale};
}
static inline struct spectral_value spectral_of(const struct spectrum *s)
{
    return (struct spectral_value){.form = SPECTRAL_TABLE, .scale = 1, .spectrum = s};
}

/* Index of refraction at a wavelength, nm. */
float ior_eval(const struct ior *, float lambda_nm);
bool ior_is_constant(const struct ior *);
/* The Cauchy form of an Abbe number. */
struct ior ior_to_cauchy(const struct ior *);
/* False, with *err, if it is not finite and within [0.2, 8] all over the range. */
bool ior_check(const struct ior *, struct range, const char *object, stokes_error *err);

/* --- BSDFs ----------------------------------------------------------------------------------------------- */

/* The inputs of one closure at a hit: textures looked up, defaults in place. */
struct inputs {
    struct spectral_value color[CLOSURE_COLORS];
    float luminance[CLOSURE_COLORS]; /* of the colours, in the working space; for Principled's tints */
    float value[CLOSURE_VALUES];
    struct frame frame;     /* about the closure's own normal */
    struct frame geometric; /* about ng */
};

#define PLAN_FACTORS 8
#define MATERIAL_FACTORS 16
#define MATERIAL_EMISSIONS 8

/* What a closure's place in the tree multiplies it by: a constant, and mix factors that vary. */
struct factors {
    float weight;
    int count;
    struct {
        uint8_t index; /* into material.factor */
        bool inverted; /* 1 − factor */
    } at[PLAN_FACTORS];
};

/* One lobe as compiled. `shade` fills kind, colours, parameters of a lobe whose weight, data and frame are set, and may scale the
   weight; false drops the lobe at this hit. */
struct lobe_plan {
    const struct closure *closure;
    bool (*shade)(const struct lobe_plan *, const struct inputs *, struct lobe *);
    void *data; /* owned */
    void (*free_data)(void *);
    struct factors factors;
    float luminance;                 /* of a constant base colour, where `compile` set it */
    struct fluorophore *fluorophore; /* of fluorescent lobes; inside data */
    bool is_transparent;             /* passes straight: part of material_transmittance */
    bool is_holdout;                 /* part of material_holdout; no lobe of any surface */
};

struct compiler; /* compile.c */

struct bsdf_kind {
    struct bsdf_signature signature;
    float color_defaults[CLOSURE_COLORS], value_defaults[CLOSURE_VALUES];
    bool color_may_exceed_1[CLOSURE_COLORS]; /* not a reflectance */
    /* Adds the closure's lobes by compiler_add. False with the compiler's error. */
    bool (*compile)(struct compiler *, const struct closure *);
};

const struct bsdf_kind *bsdf_kind_at(size_t index); /* NULL past the end */

/* Adds a lobe. Takes data. NULL if there are too many (the error is set, data is freed). */
struct lobe_plan *compiler_add(struct compiler *, const struct closure *,
                               bool (*shade)(const struct lobe_plan *, const struct inputs *, struct lobe *),
                               void *data, void (*free_data)(void *));
bool compiler_fail(struct compiler *, const char *property, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void compiler_warn(struct compiler *, const char *property, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
struct range compiler_range(const struct compiler *);
bool compiler_check_ior(struct compiler *, const struct ior *);
bool compiler_check_model(struct compiler *, double model); /* 3: as Cycles before 4.0; 4: since */

/* The constant colour of a closure's input as a spectrum (borrowed), or NULL if it is textured or left out. */
const struct spectrum *closure_spectrum(const struct closure *, int color);
/* True if the colour is left out, textured, or somewhere above 0. */
bool closure_color_is_present(const struct closure *, int color);
/* True if the value is constant; then *value is it (or the default). */
bool closure_value_is_constant(const struct closure *, int value, float *constant);
/* Bounds of a value over everything that the node can say. */
void value_bounds(const struct value_node *, float *low, float *high);

/* Roughness → α. Directions are floats, so slopes below 2·10⁻⁵ are noise; roughness below 10⁻⁴ is a δ lobe. */
#define SMOOTH_ROUGHNESS 1e-4f
#define ALPHA_MIN 2e-5f
static inline float alpha_of_roughness(float roughness)
{
    return clampf(roughness * roughness, ALPHA_MIN, 1);
}

/* --- Fluorophores ---------------------------------------------------------------------------------------- */

/* What is re-emitted: ã(λi) e(λo), or a matrix. Of a matrix `reradiation` and `emission` are the marginals. */
struct fluorophore {
    struct spectrum *absorption;  /* a; NULL of a matrix */
    struct spectrum *reradiation; /* ã = a Q; the share of what arrives that is re-emitted in Λ */
    struct spectrum *emission;    /* ∫e = 1 over Λ */
    struct spectrum *reflected;   /* r a, for ∫ r (1 − c a); NULL if r is textured */
    double strength;              /* A = ∫ã, nm */
    float per_strength, per_emission; /* 1/∫ã, 1/∫e; for separable dyes */
    struct band_table *bands;     /* NULL: separable */
    int index;                    /* among the scene's; −1 before material_set_fluorophores */
};
void fluorophore_destroy(void *);

/* Re-emitted share per nm: ã(λi) e(λo). */
float fluorophore_value(const struct fluorophore *, float lambda_in, float lambda_out);
/* ∫ of the value over the other wavelength: what goes on, of what arrives from `side` with this one. */
float fluorophore_strength(const struct fluorophore *, enum side, float lambda);
/* The new wavelength of a sub-path from `side`, drawn in proportion to the value; *pdf = 0 where there is none. */
float fluorophore_sample(const struct fluorophore *, enum side, float lambda_arriving, float u, float *pdf);
float fluorophore_pdf(const struct fluorophore *, enum side, float lambda_arriving, float lambda_leaving);

/* --- Values ---------------------------------------------------------------------------------------------- */

/* Where textures are looked up. */
struct shading_point {
    const struct hit *hit;
    struct vec3 viewing, ns; /* unit; ns on the side of ng */
    const struct material_context *context;
};
void texture_at(const struct texture *, const struct shading_point *, float rgba[4]);
/* With the view taken from `viewing`. */
float value_eval(const struct value_node *, const struct shading_point *);
/* As a + b·φ(view). False if the node says more than that. Without a view function b = 0. */
bool value_by_view(const struct value_node *, const struct shading_point *, struct view_factor *);
bool value_depends_on_view(const struct value_node *);
/* True if value_by_view can say it. */
bool value_is_affine_in_view(const struct value_node *);
float view_factor_eval(const struct view_factor *, struct vec3 direction, struct vec3 ng, struct vec3 ns);
/* The node's mean over its images, seen head-on. */
float value_mean(const struct value_node *, const float luminance[3]);

/* --- The compiled material -------------------------------------------------------------------------------- */

struct emission_plan {
    const struct emission_node *emission;
    struct factors factors;
};

struct material {
    char name[128];
    struct closure *closure; /* owned; the plans point into it */
    struct material_context context;
    struct lobe_plan lobe[SURFACE_LOBES];
    int lobe_count;
    const struct value_node *factor[MATERIAL_FACTORS]; /* mix factors, each evaluated once a hit */
    int factor_count;
    struct emission_plan emission[MATERIAL_EMISSIONS];
    int emission_count;
    struct spectrum *emission_shape; /* NULL: emits nothing */
    struct spectrum *white;          /* unit integral over Λ; for textured emission */
    struct texture **texture;        /* the array is owned, the textures are the closure's */
    size_t texture_count;
    bool may_be_transparent, is_clear;
    int volume;
};

/* Steps of material_compile: textures into m->texture; emission_shape and white. */
bool material_collect_textures(struct material *, struct compiler *);
bool material_prepare_emission(struct material *, struct compiler *);

/* Mix factors at a hit, each evaluated when first asked for. */
struct factor_values {
    const struct material *material;
    const struct shading_point *point;
    uint32_t known; /* bits */
    struct view_factor value[MATERIAL_FACTORS];
};
/* Their product, seen along a direction. */
float factors_weight(const struct factors *, struct factor_values *, struct vec3 direction);
struct shading_point shading_point_of(const struct material *, const struct hit *, struct vec3 viewing);

#endif
