/* Diffuse fluorescence (JHD18; algorithm.md §2): f = 1/π [δ(λi − λo) (1 − c a(λi)) r(λi) + c ã(λi) e(λo)], ã = a·Q.
   It compiles into two lobes: what keeps its wavelength, and what is absorbed and re-emitted. */
#include <stdlib.h>

#include "material/lobe.h"

enum { REFLECTANCE, ABSORPTION, EMISSION };
enum { QUANTUM_YIELD, ENERGY_YIELD };
enum { CONCENTRATION };

/* A clamp of Q is worth a warning if it takes away more than this share of what would be re-emitted. */
#define CLAMP_NOTICED 1e-3

/* --- The elastic lobe ------------------------------------------------------------------------------------ */

static float elastic_part(const struct lobe *lobe, enum part part, float lambda)
{
    const struct fluorophore *f = lobe->data;
    float kept = 1, reflected = 1;
    if (part != PART_REFLECTED)
        kept = 1 - lobe->parameter[CONCENTRATION] * spectrum_eval(f->absorption, lambda);
    if (part != PART_KEPT)
        reflected = spectral_value_eval(&lobe->color[0], lambda);
    return reflected * kept;
}

static float elastic_albedo(const struct lobe *lobe, float z, float lambda)
{
    (void)z;
    return elastic_part(lobe, PART_ALL, lambda);
}

/* r − c r a, or r, or 1 − c a. */
static bool elastic_terms(const struct lobe *lobe, enum part part, struct part_terms *terms)
{
    const struct fluorophore *f = lobe->data;
    *terms = (struct part_terms){.constant = 1};
    if (part != PART_KEPT && !spectral_value_terms(&lobe->color[0], terms))
        return false;
    if (part == PART_REFLECTED)
        return true;
    if (part == PART_ALL && !f->reflected)
        return false;
    terms->term[terms->count].factor = -lobe->parameter[CONCENTRATION];
    terms->term[terms->count++].spectrum = part == PART_KEPT ? f->absorption : f->reflected;
    return true;
}

/* ∫ r − c ∫ r a: exact from two cumulative tables, whatever c is at this hit. */
static bool elastic_integral(const struct lobe *lobe, float z, float a, float b, double *integral)
{
    (void)z;
    const struct fluorophore *f = lobe->data;
    if (!f->reflected || !spectral_value_integral(&lobe->color[0], a, b, integral))
        return false;
    double absorbed = spectrum_integral_to(f->reflected, b) - spectrum_integral_to(f->reflected, a);
    *integral -= lobe->parameter[CONCENTRATION] * absorbed;
    return true;
}

static float elastic(const struct lobe *lobe, struct vec3 to_light, struct vec3 to_camera, float lambda)
{
    return to_light.z * to_camera.z > 0 ? elastic_albedo(lobe, 1, lambda) * fabsf(to_light.z) / PI_F : 0;
}

static const struct lobe_kind lobe_elastic = {
    .name = "fluorescent, elastic part",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_DIFFUSE,
    .is_lambert = true,
    .albedo = elastic_albedo,
    .albedo_integral = elastic_integral,
    .part = elastic_part,
    .terms = elastic_terms,
    .evaluate = elastic,
    .pdf = diffuse_pdf,
    .sample = diffuse_sample,
};

static bool shade_elastic(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    (void)plan;
    lobe->color[0] = in->color[REFLECTANCE];
    lobe->parameter[CONCENTRATION] = clampf(in->value[0], 0, 1);
    lobe->kind = &lobe_elastic;
    return true;
}

/* --- The fluorescent lobe -------------------------------------------------------------------------------- */

static bool shade_fluorescent(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    (void)plan;
    lobe->weight *= clampf(in->value[0], 0, 1);
    lobe->kind = &lobe_fluorescent;
    return lobe->weight > 0;
}

/* --- Compiling ------------------------------------------------------------------------------------------- */

/* λ̄_e = ∫ e(λ) λ dλ for ∫e = 1: a linear piece's moment is exact by Simpson's rule. */
static double mean_wavelength(const struct spectrum *e)
{
    double sum = 0;
    for (uint32_t i = 1; i < e->count; i++) {
        double a = e->lambda[i - 1], b = e->lambda[i], middle = 0.5 * (a + b);
        double va = e->value[i - 1], vb = e->value[i];
        sum += (b - a) / 6 * (a * va + 4 * middle * 0.5 * (va + vb) + b * vb);
    }
    return sum;
}

/* min(slope·λ, cap): linear, with one corner. */
static struct spectrum *capped_line(struct range range, double slope, double cap, stokes_error *err)
{
    double corner = cap / slope; /* outside the range, or NaN, where there is none */
    float lambda[3], value[3];
    size_t n = 0;
    lambda[n++] = range.min;
    if (corner > range.min && corner < range.max)
        lambda[n++] = (float)corner;
    lambda[n++] = range.max;
    for (size_t i = 0; i < n; i++)
        value[i] = (float)fmin(slope * lambda[i], cap);
    return spectrum_table(range, lambda, value, n, BEYOND_HOLD, "yield", err);
}

/* ∫ a·min(slope·λ, cap), and the product itself. NULL when memory runs out. */
static struct spectrum *reradiated(struct compiler *compiler, const struct spectrum *absorption, double slope,
                                   double cap, double *integral)
{
    struct spectrum *yield = capped_line(compiler_range(compiler), slope, cap, NULL);
    struct spectrum *product = yield ? spectrum_product(absorption, yield) : NULL;
    *integral = product ? spectrum_integral(product) : 0;
    spectrum_destroy(yield);
    return product;
}

/* ã = a·Q with Q(λi) ≤ min(1, λi/λ̄_e), so that neither energy nor photons are made (algorithm.md §2). */
static bool make_reradiation(struct compiler *compiler, const struct closure *closure, struct fluorophore *f)
{
    double mean = mean_wavelength(f->emission), yield = closure->number[0], wanted;
    bool quantum = closure->option[0] == QUANTUM_YIELD;
    if (!(yield >= 0 && isfinite(yield)))
        return compiler_fail(compiler, "yield", "is %g; it must not be negative", yield);
    /* Without the bound, a quantum yield is a line in λ, an energy yield a constant. */
    struct spectrum *raw = quantum ? reradiated(compiler, f->absorption, yield / mean, INFINITY, &wanted)
                                   : reradiated(compiler, f->absorption, INFINITY, yield, &wanted);
    spectrum_destroy(raw);
    f->reradiation = quantum ? reradiated(compiler, f->absorption, fmin(yield, 1) / mean, 1, &f->strength)
                             : reradiated(compiler, f->absorption, 1 / mean, fmin(yield, 1), &f->strength);
    if (!raw || !f->reradiation)
        return compiler_fail(compiler, "yield", "out of memory");
    if (f->strength < wanted * (1 - CLAMP_NOTICED))
        compiler_warn(compiler, "yield",
                      "would emit more energy or photons than are absorbed; %.3g %% of the emission is cut",
                      100 * (1 - f->strength / wanted));
    return true;
}

static bool make_spectra(struct compiler *compiler, const struct closure *closure, struct fluorophore *f)
{
    const struct spectrum *absorption = closure_spectrum(closure, ABSORPTION);
    const struct spectrum *emission = closure_spectrum(closure, EMISSION);
    const struct spectrum *reflectance = closure_spectrum(closure, REFLECTANCE);
    if (!absorption)
        return compiler_fail(compiler, "absorption",
                             "must be a spectrum (vary the concentration by a texture)");
    if (!emission)
        return compiler_fail(compiler, "emission",
                             "must be a spectrum (vary the concentration by a texture)");
    double total = spectrum_integral(emission);
    if (!(total > 0))
        return compiler_fail(compiler, "emission", "is zero over the transport range");
    f->absorption = spectrum_scaled(absorption, 1);
    f->emission = spectrum_scaled(emission, (float)(1 / total));
    if (reflectance)
        f->reflected = spectrum_product(reflectance, absorption);
    if (!f->absorption || !f->emission || (reflectance && !f->reflected))
        return compiler_fail(compiler, "absorption", "out of memory");
    f->per_emission = (float)(1 / spectrum_integral(f->emission));
    if (!make_reradiation(compiler, closure, f))
        return false;
    double strength = spectrum_integral(f->reradiation);
    f->per_strength = strength > 0 ? (float)(1 / strength) : 0;
    return true;
}

/* The first of the two lobes owns the fluorophore. */
static bool add_lobes(struct compiler *compiler, const struct closure *closure, struct fluorophore *f)
{
    struct lobe_plan *plan;
    float c;
    bool none = closure_value_is_constant(closure, 0, &c) && c <= 0;
    bool reradiates = f->strength > 0 && !none, reflects = closure_color_is_present(closure, REFLECTANCE);
    if (reradiates) {
        plan = compiler_add(compiler, closure, shade_fluorescent, f, fluorophore_destroy);
        if (!plan)
            return false;
        plan->fluorophore = f;
    }
    if (reflects) {
        plan = compiler_add(compiler, closure, shade_elastic, f, reradiates ? NULL : fluorophore_destroy);
        if (!plan)
            return false;
    }
    if (!reradiates && !reflects)
        fluorophore_destroy(f);
    return true;
}

static bool compile(struct compiler *compiler, const struct closure *closure)
{
    struct fluorophore *f = calloc(1, sizeof *f);
    if (!f)
        return compiler_fail(compiler, "", "out of memory");
    f->index = -1;
    if (!make_spectra(compiler, closure, f)) {
        fluorophore_destroy(f);
        return false;
    }
    return add_lobes(compiler, closure, f);
}

const struct bsdf_kind bsdf_fluorescent = {
    .signature =
        {
            .name = "fluorescent",
            .color_names = {"reflectance", "absorption", "emission"},
            .value_names = {"concentration"},
            .option_names = {"yield_kind"},
            .option_choices = {{"quantum", "energy"}},
            .number_names = {"yield"},
            .number_defaults = {1},
        },
    .color_defaults = {0.8f, 0, 1},
    .value_defaults = {1},
    .color_may_exceed_1 = {false, false, true},
    .compile = compile,
};
