/* A conductor of complex index η + ik over wavelength, smooth or rough. */
#include "material/microfacet.h"

enum { ETA, K };

static float reflectance(const struct lobe *lobe, float cosine, float lambda)
{
    return fresnel_conductor(cosine, spectral_value_eval(&lobe->color[ETA], lambda),
                             spectral_value_eval(&lobe->color[K], lambda));
}

static const struct lobe_kind lobe_conductor = {
    .name = "conductor",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_GLOSSY,
    .albedo = reflectance_albedo,
    .reflectance = reflectance,
    .evaluate = microfacet_evaluate,
    .pdf = microfacet_pdf,
    .sample = microfacet_sample,
};

static const struct lobe_kind lobe_smooth_conductor = {
    .name = "conductor, smooth",
    .nature = LOBE_DELTA,
    .reflects_as = SCATTER_GLOSSY,
    .albedo = reflectance_albedo,
    .reflectance = reflectance,
    .scatter = mirror_scatter,
};

static bool shade(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    (void)plan;
    lobe->color[ETA] = in->color[ETA];
    lobe->color[K] = in->color[K];
    lobe->parameter[0] = alpha_of_roughness(in->value[0]);
    lobe->parameter[1] = 0;
    lobe->kind = in->value[0] < SMOOTH_ROUGHNESS ? &lobe_smooth_conductor : &lobe_conductor;
    return true;
}

static bool compile(struct compiler *compiler, const struct closure *closure)
{
    static const char *const name[] = {"eta", "k"};
    for (int i = 0; i < 2; i++)
        if (!closure_spectrum(closure, i))
            return compiler_fail(compiler, name[i], "must be a spectrum (or name a metal)");
    if (!(spectrum_min(closure_spectrum(closure, ETA)) > 0))
        return compiler_fail(compiler, name[ETA], "must be above 0");
    return compiler_add(compiler, closure, shade, NULL, NULL);
}

const struct bsdf_kind bsdf_conductor = {
    .signature = {.name = "conductor",
                  .color_names = {"eta", "k"},
                  .value_names = {"roughness"},
                  .takes_metal = true},
    .color_may_exceed_1 = {true, true},
    .compile = compile,
};
