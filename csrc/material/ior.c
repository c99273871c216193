/* Indices of refraction over wavelength: constant, by Abbe number, Cauchy, Sellmeier; and the library's glasses by name. */
#include <string.h>

#include "base/error.h"
#include "material/lobe.h"
#include "spectrum/library/library.h"

/* Fraunhofer lines, µm: the Abbe number is (n_D − 1)/(n_F − n_C). */
#define LINE_F 0.486134
#define LINE_D 0.589294
#define LINE_C 0.656281

/* n = A + B/λ² through n_D with the Abbe number's n_F − n_C. */
struct ior ior_to_cauchy(const struct ior *abbe)
{
    double n_d = abbe->term[0];
    double b = (n_d - 1) / abbe->term[1] / (1 / (LINE_F * LINE_F) - 1 / (LINE_C * LINE_C));
    return (struct ior){IOR_CAUCHY, {n_d - b / (LINE_D * LINE_D), b}};
}

float ior_eval(const struct ior *ior, float lambda_nm)
{
    struct ior cauchy;
    const double *t = ior->term;
    double l2 = (double)lambda_nm * lambda_nm * 1e-6, n2 = 1;
    switch (ior->kind) {
    case IOR_CONSTANT: return (float)t[0];
    case IOR_ABBE: cauchy = ior_to_cauchy(ior); return ior_eval(&cauchy, lambda_nm);
    case IOR_CAUCHY: return (float)(t[0] + (t[1] + t[2] / l2) / l2);
    case IOR_SELLMEIER:
        for (int i = 0; i < 6; i += 2)
            n2 += t[i] * l2 / (l2 - t[i + 1]);
        return (float)sqrt(n2);
    }
    return 1;
}

bool ior_is_constant(const struct ior *ior)
{
    const double *t = ior->term;
    switch (ior->kind) {
    case IOR_CONSTANT: return true;
    case IOR_ABBE: return t[0] == 1;
    case IOR_CAUCHY: return t[1] == 0 && t[2] == 0;
    case IOR_SELLMEIER: return false;
    }
    return true;
}

bool ior_check(const struct ior *ior, struct range range, const char *object, stokes_error *err)
{
    if (ior->kind == IOR_ABBE && !(ior->term[1] > 0))
        return fail(err, object, "ior", "the Abbe number is %g; it must be above 0", ior->term[1]);
    for (float l = range.min; l <= range.max; l += 1) {
        float n = ior_eval(ior, l);
        if (!(n >= 0.2f && n <= 8))
            return fail(err, object, "ior", "is %g at %g nm; it must be within 0.2 and 8", n, l);
    }
    return true;
}

bool ior_library(const char *name, struct ior *ior)
{
    const struct glass *glass = glass_find(name);
    if (!glass)
        return false;
    ior->kind = IOR_SELLMEIER;
    memcpy(ior->term, glass->term, sizeof ior->term);
    return true;
}
