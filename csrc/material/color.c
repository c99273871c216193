/* Colours at a surface: values and integrals over wavelength. */
#include "material/lobe.h"

float spectral_value_eval(const struct spectral_value *v, float lambda)
{
    switch (v->form) {
    case SPECTRAL_FLAT: return v->scale;
    case SPECTRAL_TABLE: return v->scale * spectrum_eval(v->spectrum, lambda);
    case SPECTRAL_CURVE: return v->scale * rgb_curve_eval(&v->curve, lambda, v->uv_rule);
    }
    return 0;
}

bool spectral_value_integral(const struct spectral_value *v, float a, float b, double *integral)
{
    switch (v->form) {
    case SPECTRAL_FLAT: *integral = (double)v->scale * (b - a); return true;
    case SPECTRAL_TABLE:
        *integral = v->scale * (spectrum_integral_to(v->spectrum, b) - spectrum_integral_to(v->spectrum, a));
        return true;
    case SPECTRAL_CURVE: return false;
    }
    return false;
}

bool spectral_value_terms(const struct spectral_value *v, struct part_terms *terms)
{
    *terms = (struct part_terms){0};
    if (v->form == SPECTRAL_FLAT)
        terms->constant = v->scale;
    else
        *terms = (struct part_terms){.count = 1, .term = {{v->scale, v->spectrum}}};
    return v->form != SPECTRAL_CURVE;
}
