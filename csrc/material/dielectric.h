/* What Principled's glass shares with the dielectric: its data and how to fill a lobe. */
#ifndef MATERIAL_DIELECTRIC_H
#define MATERIAL_DIELECTRIC_H

#include "material/albedo.h"

enum dielectric_branches { BRANCHES_BOTH, BRANCHES_REFLECT, BRANCHES_REFRACT };

struct dielectric {
    struct ior ior; /* of the inside; outside is 1 */
    bool disperses;
    struct albedo_table *entering, *leaving; /* for energy compensation; NULL: none */
};

/* Compensated for what single scattering loses if `roughness` names that input of the closure; −1: not. NULL, with the compiler's
   error. */
struct dielectric *dielectric_create(struct compiler *, struct ior, const struct closure *, int roughness);
void dielectric_destroy(void *);

/* How a lobe departs from plain Fresnel. */
struct dielectric_look {
    enum dielectric_branches branches;
    float tinted; /* share by which colour 2 tints F0 */
    bool halved;  /* the transmitted colour's root, for each of two crossings */
    bool
        model_3; /* Cycles before 4.0: Fresnel of the camera's direction with the shading normal, separable masking */
};

/* Sets kind and parameters. Colours are the caller's: 0 reflected, 1 transmitted, 2 the tint of F0. */
void dielectric_shade(struct lobe *, float roughness, struct dielectric_look);

#endif
