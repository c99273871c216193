/* The closure tree: what the stream's `surface` member says, built by csrc/stream and compiled by material_compile. */
#ifndef MATERIAL_CLOSURE_H
#define MATERIAL_CLOSURE_H

#include "material/material.h"
#include "spectrum/reradiation.h"

/* V of STREAM.md. A node owns its children. */
enum value_kind {
    VALUE_CONSTANT,
    VALUE_TEXTURE,
    VALUE_SCALE_OFFSET,
    VALUE_FRESNEL,
    VALUE_FACING,
    VALUE_BACKFACING,
    VALUE_PRODUCT
};
struct value_node {
    enum value_kind kind;
    float constant, scale, offset; /* constant: also ior of FRESNEL, blend of FACING */
    struct texture *texture;       /* owned */
    struct value_node *child[2];
};

/* S where a BSDF takes it: a spectrum, or scale·texture as an RGB reflectance. Owned. */
struct color_node {
    struct spectrum *spectrum;
    struct texture *texture;
    float scale;
};

/* L of STREAM.md on a surface: spectral radiance = spectrum, or scale·texture as RGB under D65. Owned. */
struct emission_node {
    struct spectrum *spectrum;
    struct texture *texture;
    float scale;
    bool two_sided;
};

enum closure_kind { CLOSURE_BSDF, CLOSURE_EMISSION, CLOSURE_MIX, CLOSURE_ADD, CLOSURE_NULL };

#define CLOSURE_COLORS 4
#define CLOSURE_VALUES 6

/* Index of refraction: term[] by kind. ABBE: n_D, Abbe number. CAUCHY: A, B (µm²), C (µm⁴). SELLMEIER: B1, C1 (µm²), B2, … */
enum ior_kind { IOR_CONSTANT, IOR_ABBE, IOR_CAUCHY, IOR_SELLMEIER };
struct ior {
    enum ior_kind kind;
    double term[6];
};
/* A glass by name ("BK7", …); false if unknown. */
bool ior_library(const char *name, struct ior *);

/* What a BSDF's JSON may hold, so that the stream needs no code of its own per BSDF. NULL ends each list. */
struct bsdf_signature {
    const char *name;
    const char *color_names[CLOSURE_COLORS], *value_names[CLOSURE_VALUES];
    const char *option_names[4],
        *option_choices[4][4]; /* JSON strings (or false/true for choices "false", "true") → 0, 1, … */
    const char *number_names[4];
    double number_defaults[4];
    bool takes_ior,
        takes_metal; /* `ior`; `metal` stands for color "eta" and "k" from the library ("metal/Ag/eta") */
    bool takes_matrix; /* `matrix`, which it must have */
};
const struct bsdf_kind *bsdf_kind_find(const char *name); /* NULL: unknown */
const struct bsdf_signature *bsdf_kind_signature(const struct bsdf_kind *);

struct closure {
    enum closure_kind kind;
    struct closure *child[2];
    struct value_node *factor;                /* MIX */
    struct emission_node *emission;           /* EMISSION */
    const struct bsdf_kind *bsdf;             /* BSDF: by bsdf_kind_find */
    struct color_node *color[CLOSURE_COLORS]; /* in the order of the kind's color_names; NULL: its default */
    struct value_node *value[CLOSURE_VALUES]; /* in the order of the kind's value_names; NULL: its default */
    int option[4];                            /* in the order of the kind's option_names */
    double number[4];                         /* in the order of the kind's number_names */
    struct ior ior;
    stokes_matrix *matrix; /* owned */
    struct texture *normal_map;
    float normal_strength;
};

void closure_destroy(struct closure *);
void value_node_destroy(struct value_node *);
void color_node_destroy(struct color_node *);
void emission_node_destroy(struct emission_node *);

/* What the compiler needs of the scene. Borrowed; must outlive the material. */
struct material_context {
    struct range range;
    enum uv_rule uv_rule;
    struct working_space working_space;
    const struct rgb_table *rgb_table; /* NULL while no texture needs one */
    float luminance[3];
};

/* Takes the closure (destroyed with the material, and on failure). NULL with *err if it has too many lobes, or a spectrum is
   not what its place allows (negative emission, reflectance outside [0,1] …). Warnings go to `warn` (may be NULL). */
struct material *material_compile(const char *name, struct closure *, const struct material_context *,
                                  void (*warn)(void *user, const stokes_error *), void *user,
                                  stokes_error *err);
void material_destroy(struct material *);
const char *material_name(const struct material *);
bool material_needs_rgb_table(const struct closure *);
/* Textures that name UV layers, for the scene to resolve. */
size_t material_texture_count(const struct material *);
struct texture *material_texture(const struct material *, size_t index);

/* Fluorophores (emission, ã) of a material: count, and giving them scene-wide indices starting at `first`. */
int material_fluorophore_count(const struct material *);
void material_set_fluorophores(struct material *, int first);
const struct spectrum *material_fluorophore_emission(const struct material *, int index);
const struct spectrum *material_fluorophore_absorption(const struct material *, int index);
/* As surface_pdf_emitted and surface_pdf_absorbed. */
float material_fluorophore_pdf(const struct material *, int index, enum side, float lambda_in,
                               float lambda_out);

#endif
