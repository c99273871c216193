/* The Principled BSDF: inputs by index, and the compilers of its two models. */
#ifndef MATERIAL_PRINCIPLED_H
#define MATERIAL_PRINCIPLED_H

#include "material/lobe.h"

enum { PRINCIPLED_BASE, PRINCIPLED_TINT };
enum { PRINCIPLED_METALLIC, PRINCIPLED_ROUGHNESS, PRINCIPLED_SPECULAR, PRINCIPLED_TRANSMISSION };
enum { PRINCIPLED_MODEL, PRINCIPLED_IOR };
enum { PRINCIPLED_MULTI_SCATTER };

bool principled3_compile(struct compiler *, const struct closure *);
bool principled4_compile(struct compiler *, const struct closure *);

static inline float saturate(float x)
{
    return clampf(x, 0, 1);
}

/* True if the value can be above low and below high (exclusive) somewhere. */
static inline bool principled_can_exceed(const struct closure *c, int value, float bound)
{
    float constant;
    return !closure_value_is_constant(c, value, &constant) || constant > bound;
}
static inline bool principled_can_stay_below(const struct closure *c, int value, float bound)
{
    float constant;
    return !closure_value_is_constant(c, value, &constant) || constant < bound;
}

#endif
