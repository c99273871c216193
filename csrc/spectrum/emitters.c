/* Spectra of light sources, by formula or by the CIE's tables. A black body is 1 at its maximum inside Λ; CIE
   illuminants and daylight are 1 at 560 nm, where their tables say 100. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "spectrum/knots.h"
#include "spectrum/library/library.h"

#define C2_NM_K 1.438777e7 /* second radiation constant, CODATA 2018 */

/* ln of Planck's law but for a constant; stable where the exponential overflows. */
static double log_planck(double lambda_nm, double c2_over_t)
{
    double x = c2_over_t / lambda_nm;
    return -5 * log(lambda_nm) - (x + log1p(-exp(-x)));
}

/* Planck's law every nanometre, 1 where it is `log_unit`. */
static struct spectrum *planck(struct range range, double c2_over_t, double log_unit, const char *name,
                               stokes_error *err)
{
    struct knots k = {0};
    for (float l = range.min; l < range.max; l = fminf(floorf(l) + 1, range.max))
        knots_add(&k, l, (float)exp(log_planck(l, c2_over_t) - log_unit));
    knots_add(&k, range.max, (float)exp(log_planck(range.max, c2_over_t) - log_unit));
    return knots_finish(&k, name, err);
}

struct spectrum *spectrum_blackbody(struct range range, double kelvin, const char *name, stokes_error *err)
{
    if (!range_check(range, name, err))
        return NULL;
    if (!(kelvin >= 1 && kelvin <= 1e6)) {
        fail(err, name, "blackbody", "%g K is not between 1 and 1e6", kelvin);
        return NULL;
    }
    double c2_over_t = C2_NM_K / kelvin, wien_nm = c2_over_t / 4.965114231744276;
    return planck(range, c2_over_t, log_planck(fmin(fmax(wien_nm, range.min), range.max), c2_over_t), name,
                  err);
}

/* CIE 15:2018, eqs. 4.7 to 4.11: chromaticity of a phase of daylight, then the weights of its components. */
static void daylight_weights(double kelvin, double weights[2])
{
    double t = 1000 / kelvin;
    double x = kelvin <= 7000 ? ((-4.6070 * t + 2.9678) * t + 0.09911) * t + 0.244063
                              : ((-2.0064 * t + 1.9018) * t + 0.24748) * t + 0.237040;
    double y = (-3 * x + 2.870) * x - 0.275;
    double m = 0.0241 + 0.2562 * x - 0.7341 * y;
    weights[0] = (-1.3515 - 1.7703 * x + 5.9114 * y) / m;
    weights[1] = (0.0300 - 31.4424 * x + 30.0717 * y) / m;
}

static struct spectrum *daylight(struct range range, const double weights[2], const char *name,
                                 stokes_error *err)
{
    float lambda[DAYLIGHT_COUNT], value[DAYLIGHT_COUNT];
    for (int i = 0; i < DAYLIGHT_COUNT; i++) {
        lambda[i] = DAYLIGHT_MIN_NM + DAYLIGHT_STEP_NM * (float)i;
        const float *component = library_daylight(i);
        value[i] = (float)(component[0] + weights[0] * component[1] + weights[1] * component[2]) / 100;
    }
    return spectrum_table(range, lambda, value, DAYLIGHT_COUNT, BEYOND_ZERO, name, err);
}

struct spectrum *spectrum_daylight(struct range range, double kelvin, const char *name, stokes_error *err)
{
    if (!(kelvin >= 4000 && kelvin <= 25000)) {
        fail(err, name, "daylight", "%g K is not between 4000 and 25000", kelvin);
        return NULL;
    }
    double weights[2];
    daylight_weights(kelvin, weights);
    return daylight(range, weights, name, err);
}

static struct spectrum *d65(struct range range, const char *name, stokes_error *err)
{
    float lambda[DAYLIGHT_COUNT], value[DAYLIGHT_COUNT];
    for (int i = 0; i < DAYLIGHT_COUNT; i++) {
        lambda[i] = DAYLIGHT_MIN_NM + DAYLIGHT_STEP_NM * (float)i;
        value[i] = illuminant_d65(lambda[i]) / 100;
    }
    return spectrum_table(range, lambda, value, DAYLIGHT_COUNT, BEYOND_ZERO, name, err);
}

/* D50, D55 and D75 were made before c2 was revised, with weights rounded to three decimals (CIE 15:2018, note 5). */
static struct spectrum *daylight_illuminant(struct range range, double kelvin, const char *name,
                                            stokes_error *err)
{
    double weights[2];
    daylight_weights(kelvin * 1.4388 / 1.4380, weights);
    for (int i = 0; i < 2; i++)
        weights[i] = round(1000 * weights[i]) / 1000;
    return daylight(range, weights, name, err);
}

struct spectrum *spectrum_illuminant(struct range range, const char *illuminant, const char *name,
                                     stokes_error *err)
{
    static const double illuminant_a = 1.435e7 / 2848; /* c2/T by which the CIE defines A */
    if (!range_check(range, name, err))
        return NULL;
    if (strcmp(illuminant, "A") == 0)
        return planck(range, illuminant_a, log_planck(560, illuminant_a), name, err);
    if (strcmp(illuminant, "E") == 0)
        return spectrum_constant(range, 1);
    if (strcmp(illuminant, "D65") == 0)
        return d65(range, name, err);
    if (strcmp(illuminant, "D50") == 0 || strcmp(illuminant, "D55") == 0 || strcmp(illuminant, "D75") == 0)
        return daylight_illuminant(range, 1000 * (illuminant[1] - '0') + 100 * (illuminant[2] - '0'), name,
                                   err);
    char entry[32] = "illuminant/";
    if (strlen(illuminant) < 8 && library_find(strcat(entry, illuminant)))
        return spectrum_library(range, entry, name, err);
    fail(err, name, "illuminant", "%.32s is not one of A, C, D50, D55, D65, D75, E, F1 to F12", illuminant);
    return NULL;
}

const char *illuminant_computed_at(size_t index)
{
    static const char *const names[] = {"illuminant/A",   "illuminant/D50", "illuminant/D55",
                                        "illuminant/D65", "illuminant/D75", "illuminant/E"};
    return index < sizeof names / sizeof *names ? names[index] : NULL;
}

bool illuminant_is_computed(const char *name)
{
    const char *computed;
    for (size_t i = 0; (computed = illuminant_computed_at(i)); i++)
        if (strcmp(computed, name) == 0)
            return true;
    return false;
}

struct spectrum *spectrum_gaussian(struct range range, double mean, double sigma, double peak,
                                   const char *name, stokes_error *err)
{
    enum { PER_SIGMA = 32, SIGMAS = 7, COUNT = 2 * SIGMAS * PER_SIGMA + 1 };
    if (!(sigma >= 0.01 && sigma <= 1e5) || !isfinite(mean) || !isfinite(peak)) {
        fail(err, name, "gaussian", "mean %g, sigma %g, peak %g: sigma must be 0.01 to 1e5 nm, all finite",
             mean, sigma, peak);
        return NULL;
    }
    float lambda[COUNT], value[COUNT];
    for (int i = 0; i < COUNT; i++) {
        double z = (double)i / PER_SIGMA - SIGMAS;
        lambda[i] = (float)(mean + z * sigma);
        value[i] = (float)(peak * exp(-0.5 * z * z));
    }
    return spectrum_table(range, lambda, value, COUNT, BEYOND_ZERO, name, err);
}

struct spectrum *spectrum_line(struct range range, double center, double width, const char *name,
                               stokes_error *err)
{
    if (!(width >= 1 && width <= 1e5) || !isfinite(center)) {
        fail(err, name, "line", "center %g, width %g: the width must be 1 to 1e5 nm", center, width);
        return NULL;
    }
    float lambda[2] = {(float)(center - width / 2), (float)(center + width / 2)};
    return spectrum_table(range, lambda, (float[2]){1, 1}, 2, BEYOND_ZERO, name, err);
}
