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

/* NULL, with the compiler's error. */
struct dielectric *dielectric_create(struct compiler *, struct ior);
void dielectric_destroy(void *);

/* Sets kind and parameters. Colours are the caller's: 0 reflected, 1 transmitted (its root if `halved`: half of the colour for each
   of two crossings), 2 the tint of F0, applied by the share `tinted`. */
void dielectric_shade(struct lobe *, float roughness, enum dielectric_branches, float tinted, bool halved);

#endif
