/* Materials: a closure tree as the stream sends it, compiled into lobes; at a hit the lobes become a `surface`, which
   evaluates, samples and gives densities in both transport directions, at any wavelength, as often as asked.

   Measures (algorithm.md §7): directions have densities per *projected* solid angle about the geometric normal ng, and values
   carry the shading-normal factor |to_light·ns|/|to_light·ng|, so a path's value is ∏ρ·∏G with geometric cosines and
   both directions of transport agree (Veach 1997, §5.3). `to_light` points toward the light's side of the path, `to_camera`
   toward the camera's, both away from the surface.

   A direction that ng and ns see on different sides has no value; for diffuse lobes that holds for the light's direction
   alone, and the camera's side is that of ng.

   Labels: every vertex of a path is ELASTIC (all lobes of finite density that keep the wavelength, summed),
   FLUORESCENT (one such lobe) or SPECULAR (one δ lobe). Densities include the label's probability. */
#ifndef MATERIAL_MATERIAL_H
#define MATERIAL_MATERIAL_H

#include "base/lanes.h"
#include "base/vec.h"
#include "image/texture.h"
#include "spectrum/spectrum.h"

enum label { LABEL_ELASTIC, LABEL_FLUORESCENT, LABEL_SPECULAR };

/* Which end of the path the sub-path comes from. From the camera, wavelengths are drawn λo → λi. */
enum side { SIDE_LIGHT, SIDE_CAMERA };

#define SURFACE_LOBES 8

/* P_F is at most this wherever there is an elastic part (algorithm.md §4). A run that is evaluated again at another wavelength (§9) owes the ratio of the
   two elastic chances at each vertex: with a chance of 1 − P and reflectance g its second moment grows by g²/(1 − P), which must stay below 1. */
#define FLUORESCENT_CHANCE_MAX 0.5f

/* A colour at a surface: 1, a spectrum, or RGB-upsampled coefficients, times a scale. */
struct spectral_value {
    enum spectral_form { SPECTRAL_FLAT, SPECTRAL_TABLE, SPECTRAL_CURVE } form;
    enum uv_rule uv_rule; /* of the curve */
    float scale;
    struct rgb_curve curve;
    const struct spectrum *spectrum; /* of the table; borrowed */
};

/* Where a ray met a surface, as the scene says it. */
struct hit {
    struct vec3 position;
    struct vec3 ng;      /* unit, by the triangle's winding (not turned toward the ray) */
    struct vec3 ns;      /* unit, interpolated; ng where the face is flat */
    struct vec3 tangent; /* ∂p/∂u of the default UV layer, unit; zero where there is none */
    bool mirrored_uv; /* (ns × tangent)·∂p/∂v < 0: the bitangent of normal maps is −ns × tangent */
    struct vec3 generated, object; /* texture coordinates */
    float error;                   /* a bound of the position's rounding error, metres */
    float uv[2];
    float bary_u, bary_v;
    uint32_t instance, primitive;
    const void *mesh; /* struct hit_mesh (hit_mesh.h), for further UV layers */
    int light;        /* index of the emitter that this surface is, or −1 */
};

struct material; /* compiled; immutable; shared by threads */

/* A mix factor that depends on the angle of view: a + b·φ(angle between the camera's direction and ns). It belongs to the
   direction toward the camera, wherever the path came from, so that all techniques see one and the same surface. */
struct view_factor {
    enum view_function { VIEW_FRESNEL, VIEW_FACING, VIEW_BACKFACING } function;
    float a, b, parameter;
};
#define LOBE_VIEW_FACTORS 2

/* A lobe at a hit: kinds and parameters are the room's own (lobe.h). */
struct lobe {
    const struct lobe_kind *kind;
    float weight; /* product of the mix factors that do not depend on the view */
    uint32_t view_count;
    struct view_factor view[LOBE_VIEW_FACTORS];
    struct spectral_value color[3];
    float parameter[6];
    const void *data;   /* borrowed from the material */
    struct frame frame; /* about the shading normal, turned to the side of ng */
    bool mapped;        /* by a normal map, whose hard edges are softened as Cycles does (surface.c) */
};

struct surface {
    struct vec3 ng, ns; /* ns: interpolated, without normal maps, on the side of ng */
    struct lobe lobe[SURFACE_LOBES];
    uint8_t lobe_count, fluorescent_count, specular_count;
    bool has_elastic; /* any lobe of finite density that is not fluorescent */
    bool connects;    /* has a lobe of finite density at all */
    bool is_matte;    /* all lobes are (matte.c) */
    bool in_volume;   /* a scattering vertex inside of volumes (volume.h): no normals, all cosines are 1 */
    uint8_t fluorescent[SURFACE_LOBES], specular[SURFACE_LOBES]; /* indices of those lobes */
    const struct material *material;
};

/* Evaluates textures, mix factors and normals. `viewing` points back along the ray that found the hit. */
void material_shade(const struct material *, const struct hit *, struct vec3 viewing, struct surface *);

/* Value ρ of all elastic lobes of finite density, sr⁻¹. */
float surface_elastic(const struct surface *, struct vec3 to_light, struct vec3 to_camera, float lambda);
/* Value of fluorescent lobe f (an index in 0 … fluorescent_count − 1), sr⁻¹ nm⁻¹: c ã(λi) e(λo)/π for JHD18, an entry of the matrix
   over its band's width and π for a reradiation matrix. */
float surface_fluorescent(const struct surface *, int f, struct vec3 to_light, struct vec3 to_camera,
                          float lambda_in, float lambda_out);

/* Density with which a sub-path from `side` that came in from direction `arriving` with wavelength lambda goes on by label
   ELASTIC to `leaving`: label probability × density per projected solid angle. */
float surface_pdf_elastic(const struct surface *, enum side, struct vec3 arriving, struct vec3 leaving,
                          float lambda);
/* The same by fluorescent lobe f, times the density of the new wavelength (nm⁻¹). */
float surface_pdf_fluorescent(const struct surface *, enum side, int f, struct vec3 arriving,
                              struct vec3 leaving, float lambda_arriving, float lambda_leaving);
/* The density of the label ELASTIC for an E–E vertex under the constant kernel, divided by k (algorithm.md §6): from the camera
   (1−P_F(λc))·g(λl)·2d/∫g × the direction's density; tends to surface_pdf_elastic as d → 0. */
float surface_pdf_mollified(const struct surface *, enum side, struct vec3 arriving, struct vec3 leaving,
                            float lambda_arriving, float lambda_leaving, float half_width_nm);

struct scatter {
    enum label label;
    int lobe; /* index f for FLUORESCENT, into specular[] for SPECULAR */
    struct vec3 direction;
    float lambda; /* of the next edge */
    float
        value; /* ρ; for SPECULAR the coefficient T or R, without the δ, with n² where refraction scales radiance */
    float pdf;       /* of this draw: label × wavelength × direction; for SPECULAR without the δ */
    float pdf_other; /* with which the other side's sub-path would have gone the other way */
    bool refracts;   /* passed through the surface with a change of index */
    bool disperses;  /* the direction depends on the wavelength */
    float draw, draw_other; /* FLUORESCENT: what the wavelengths have of the two pdfs */
    int depth_class; /* enum scatter_class: which of Cycles' bounce limits counts it */
};
enum scatter_class {
    SCATTER_DIFFUSE,
    SCATTER_GLOSSY,
    SCATTER_TRANSMISSION,
    SCATTER_TRANSPARENT,
    SCATTER_VOLUME
};

/* Draws label, wavelength and direction from four uniform numbers. False: absorbed, or a wavelength outside Λ. */
bool surface_sample(const struct surface *, enum side, struct vec3 arriving, float lambda, const float u[4],
                    struct scatter *);

/* A step that was drawn before, evaluated at other wavelengths with its geometry kept (algorithm.md §9): the label's value ρ and both
   densities, as in struct scatter. False where a δ lobe cannot make it at this wavelength. Elastic labels read lambda_arriving alone. */
struct surface_step {
    float value, pdf, pdf_other;
};
bool surface_step_again(const struct surface *, enum side, enum label, int lobe, struct vec3 arriving,
                        struct vec3 leaving, float lambda_arriving, float lambda_leaving,
                        struct surface_step *);

/* The same for a bundle of wavelengths; 0 where a δ lobe cannot make the step. */
struct surface_steps {
    float value[LANES_MAX], pdf[LANES_MAX], pdf_other[LANES_MAX];
    float draw[LANES_MAX], draw_other[LANES_MAX]; /* of FLUORESCENT: what the wavelengths have of the two pdfs */
};
/* What a matte surface (matte.c) says of a bundle whatever the directions, kept for the next time that it is asked for the same one; lanes = 0:
   nothing yet. A caller that asks a surface often has two: of the bundle that arrives, and of others. */
struct surface_memo {
    int lanes;
    float lambda[LANES_MAX], elastic[LANES_MAX], dyes[2][LANES_MAX]; /* chance of dyes, by side */
};
enum memo_use { MEMO_ARRIVING, MEMO_OTHERS, MEMOS };
void surface_steps(const struct surface *, enum side, enum label, int lobe, struct vec3 arriving,
                   struct vec3 leaving, int lanes, const float lambda_arriving[],
                   const float lambda_leaving[], struct surface_memo memo[MEMOS], struct surface_steps *);

/* The wavelength that a sub-path of `side` draws at fluorescent lobe f, from a uniform number; and its density. At a wavelength that a
   matrix does not re-emit (nothing of it goes on) *pdf is 0. */
float surface_sample_lambda(const struct surface *, enum side, int f, float lambda_arriving, float u,
                            float *pdf);
float surface_pdf_lambda(const struct surface *, enum side, int f, float lambda_arriving,
                         float lambda_leaving);

/* Properties of an elastic passage from one direction to another, the same for both sides of transport: whether the lobe's directions depend
   on the wavelength, and which of Cycles' bounce limits counts it. */
bool surface_elastic_disperses(const struct surface *, struct vec3 a, struct vec3 b);
enum scatter_class surface_elastic_class(const struct surface *, struct vec3 a, struct vec3 b);

/* surface_pdf_lambda by the ends of the path: the density of λo when a light sub-path draws it at lobe f, given λi, and that of λi when a
   camera sub-path draws it, given λo. Of a separable lobe they are its shapes; of a matrix they depend on both, and are 0 where nothing is re-emitted. */
float surface_pdf_emitted(const struct surface *, int f, float lambda_in, float lambda_out);
float surface_pdf_absorbed(const struct surface *, int f, float lambda_in, float lambda_out);

/* The emission and absorption shapes of fluorescent lobe f, for tables over pairs (algorithm.md §9); borrowed. A matrix's marginals: they
   are positive wherever it is, but are not what it draws from. */
const struct spectrum *surface_fluorescent_emission(const struct surface *, int f);
const struct spectrum *surface_fluorescent_absorption(const struct surface *, int f); /* ã, without c */
/* Index of lobe f's (emission, ã) pair among all of the scene's, given by material_set_fluorophores; −1 before. */
int surface_fluorophore(const struct surface *, int f);

/* `transparent` lobes are never part of a surface (material_shade leaves them out, and rescales nothing): path code and shadow rays
   pass by this transmittance at a wavelength, the summed weight × colour of those lobes, clamped to [0,1]; 0 for materials without. */
float material_transmittance(const struct material *, const struct hit *, struct vec3 viewing, float lambda);
bool material_may_be_transparent(const struct material *);
/* True if it is nothing but a boundary that light of every wavelength passes. */
bool material_is_clear(const struct material *);
/* Index among the scene's volumes of what lies behind the surface, given by material_set_volume; −1: nothing. */
int material_volume(const struct material *);
void material_set_volume(struct material *, int volume);

/* How much of the surface is a hole in the picture (`holdout`), in [0,1]: what alpha loses where a camera ray that only transparent
   surfaces have touched ends here. Such lobes scatter nothing. */
float material_holdout(const struct material *, const struct hit *, struct vec3 viewing);

/* Emitted spectral radiance into the hemisphere of `out` (zero on the back of one-sided emission). */
float material_emission(const struct material *, const struct hit *, struct vec3 out, float lambda);
bool material_emits(const struct material *);
/* For choosing lights and wavelengths: the untextured mean spectrum of the emission (radiance per nm), or NULL. Borrowed. */
const struct spectrum *material_emission_shape(const struct material *);
bool material_emits_on_both_sides(const struct material *);

#endif
