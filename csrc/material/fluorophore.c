/* What is re-emitted at which wavelength, for a separable dye and for a matrix alike; the lobe that carries it is diffuse. */
#include <stdlib.h>

#include "material/bands.h"

void fluorophore_destroy(void *data)
{
    struct fluorophore *f = data;
    if (!f)
        return;
    spectrum_destroy(f->absorption);
    spectrum_destroy(f->reradiation);
    spectrum_destroy(f->emission);
    spectrum_destroy(f->reflected);
    band_table_destroy(f->bands);
    free(f);
}

/* surface.c knows its wavelengths; its directions are cosine-distributed. */
const struct lobe_kind lobe_fluorescent = {
    .name = "fluorescent",
    .nature = LOBE_FLUORESCENT,
    .reflects_as = SCATTER_DIFFUSE,
    .pdf = diffuse_pdf,
    .sample = diffuse_sample,
};

float fluorophore_value(const struct fluorophore *f, float lambda_in, float lambda_out)
{
    return f->bands ? band_table_value(f->bands, lambda_in, lambda_out)
                    : spectrum_eval(f->reradiation, lambda_in) * spectrum_eval(f->emission, lambda_out);
}

float fluorophore_strength(const struct fluorophore *f, enum side side, float lambda)
{
    if (f->bands)
        return band_table_strength(f->bands, side, lambda);
    return side == SIDE_CAMERA ? spectrum_eval(f->emission, lambda) * (float)f->strength
                               : spectrum_eval(f->reradiation, lambda);
}

float fluorophore_sample(const struct fluorophore *f, enum side side, float lambda_arriving, float u,
                         float *pdf)
{
    return f->bands ? band_table_sample(f->bands, side, lambda_arriving, u, pdf)
                    : spectrum_sample(side == SIDE_CAMERA ? f->reradiation : f->emission, u, pdf);
}

float fluorophore_pdf(const struct fluorophore *f, enum side side, float lambda_arriving,
                      float lambda_leaving)
{
    return f->bands ? band_table_pdf(f->bands, side, lambda_arriving, lambda_leaving)
                    : spectrum_pdf(side == SIDE_CAMERA ? f->reradiation : f->emission, lambda_leaving);
}
