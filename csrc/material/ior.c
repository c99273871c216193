/* Indices of refraction over wavelength: constant, by Abbe number, Cauchy, Sellmeier.
   The glasses' Sellmeier coefficients are facts published in the makers' data sheets. */
#include <string.h>

#include "base/error.h"
#include "material/lobe.h"

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
    case IOR_CONSTANT:
        return (float)t[0];
    case IOR_ABBE:
        cauchy = ior_to_cauchy(ior);
        return ior_eval(&cauchy, lambda_nm);
    case IOR_CAUCHY:
        return (float)(t[0] + (t[1] + t[2] / l2) / l2);
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
    case IOR_CONSTANT:
        return true;
    case IOR_ABBE:
        return t[0] == 1;
    case IOR_CAUCHY:
        return t[1] == 0 && t[2] == 0;
    case IOR_SELLMEIER:
        return false;
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

/* B1, C1 (µm²), B2, C2, B3, C3. */
static const struct {
    const char *name;
    double term[6];
} library[] = {
    /* SCHOTT, optical glass data sheets. */
    {"BK7", {1.03961212, 0.00600069867, 0.231792344, 0.0200179144, 1.01046945, 103.560653}},
    {"F2", {1.34533359, 0.00997743871, 0.209073176, 0.0470450767, 0.937357162, 111.886764}},
    {"SF10", {1.62153902, 0.0122241457, 0.256287842, 0.0595736775, 1.64447552, 147.468793}},
    {"SF11", {1.73759695, 0.013188707, 0.313747346, 0.0623068142, 1.89878101, 155.23629}},
    {"SF5", {1.52481889, 0.011254756, 0.187085527, 0.0588995392, 1.42729015, 129.141675}},
    {"BAF10", {1.5851495, 0.00926681282, 0.143559385, 0.0424489805, 1.08521269, 105.613573}},
    {"BAK4", {1.28834642, 0.00779980626, 0.132817724, 0.0315631177, 0.945395373, 105.965875}},
    {"SK16", {1.34317774, 0.00704687339, 0.241144399, 0.0229005000, 0.994317969, 92.7508526}},
    {"K10", {1.15687082, 0.00809424251, 0.0642625444, 0.0386051284, 0.872376139, 104.747730}},
    {"LASF9", {2.00029547, 0.0121426017, 0.298926886, 0.0538736236, 1.80691843, 156.530829}},
    /* Malitson 1965, fused silica (squares of 0.0684043, 0.1162414, 9.896161 µm). */
    {"silica", {0.6961663, 0.0046791482, 0.4079426, 0.0135120631, 0.8974794, 97.9340025}},
    /* Malitson & Dodge 1972, sapphire, ordinary ray (squares of 0.0726631, 0.1193242, 18.028251 µm). */
    {"sapphire", {1.4313493, 0.0052799261, 0.65054713, 0.0142382647, 5.3414021, 325.017834}},
    /* Daimon & Masumura 2007 have four terms; Peter 1923 for diamond has two (squares of 0.1750, 0.1060 µm). */
    {"diamond", {0.3306, 0.030625, 4.3356, 0.011236, 0, 0}},
};

bool ior_library(const char *name, struct ior *ior)
{
    for (size_t i = 0; i < sizeof library / sizeof *library; i++)
        if (strcmp(library[i].name, name) == 0) {
            ior->kind = IOR_SELLMEIER;
            memcpy(ior->term, library[i].term, sizeof ior->term);
            return true;
        }
    return false;
}
