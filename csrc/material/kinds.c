/* The kinds of BSDF. A new one is a file and a line here. */
#include <string.h>

#include "material/lobe.h"

extern const struct bsdf_kind bsdf_diffuse, bsdf_fluorescent, bsdf_reradiation_matrix, bsdf_dielectric,
    bsdf_conductor, bsdf_glossy, bsdf_transparent, bsdf_translucent, bsdf_principled, bsdf_holdout;

static const struct bsdf_kind *const kinds[] = {
    &bsdf_diffuse, &bsdf_fluorescent,  &bsdf_reradiation_matrix, &bsdf_dielectric,  &bsdf_conductor,
    &bsdf_glossy,  &bsdf_transparent, &bsdf_translucent, &bsdf_principled, &bsdf_holdout,
};

const struct bsdf_kind *bsdf_kind_at(size_t index)
{
    return index < sizeof kinds / sizeof *kinds ? kinds[index] : NULL;
}

const struct bsdf_kind *bsdf_kind_find(const char *name)
{
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strcmp(kinds[i]->signature.name, name) == 0)
            return kinds[i];
    return NULL;
}

const struct bsdf_signature *bsdf_kind_signature(const struct bsdf_kind *kind)
{
    return &kind->signature;
}
