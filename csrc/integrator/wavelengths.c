/* Builds p_cam and the product tables of a scene.
   Any density with the right support is unbiased, so the tables ignore textured concentrations. */
#include "integrator/wavelengths.h"

#include <stdlib.h>

#include "base/error.h"
#include "integrator/integrator.h"

/* Narrow enough for dyes (some 20 nm wide), and a line of 1 nm loses a factor of 2 at most. */
static const float product_bin_nm = 2;
/* Above this many pairs of different things the product is replaced by the sink alone, shared by all sources. */
static const size_t product_pairs_max = 1u << 16;

/* x̄+ȳ+z̄ over Λ: knots at every nm. */
static struct spectrum *luminosity(struct range range)
{
    enum { KNOTS = (int)(CMF_MAX_NM - CMF_MIN_NM) + 1 };
    float lambda[KNOTS], value[KNOTS];
    for (int i = 0; i < KNOTS; i++) {
        float xyz[3];
        lambda[i] = CMF_MIN_NM + (float)i;
        cmf_eval(lambda[i], xyz);
        value[i] = xyz[0] + xyz[1] + xyz[2];
    }
    return spectrum_table(range, lambda, value, KNOTS, BEYOND_ZERO, "camera", NULL);
}

/* (x̄+ȳ+z̄)(0.4 + 0.6 E/Ē), E the lamps' spectrum and Ē its CMF-weighted mean (algorithm.md §1). */
static struct spectrum *visible_importance(struct range range, const struct spectrum *lamps)
{
    struct spectrum *cmf = luminosity(range), *weighted = NULL, *flat = NULL, *sum = NULL, *scaled = NULL;
    if (!cmf || !lamps)
        return cmf;
    weighted = spectrum_product(cmf, lamps);
    double mean = weighted ? spectrum_integral(weighted) / spectrum_integral(cmf) : 0;
    if (mean > 0) {
        flat = spectrum_scaled(cmf, 0.4f);
        scaled = spectrum_scaled(weighted, (float)(0.6 / mean));
        sum = flat && scaled ? spectrum_sum(flat, scaled) : NULL;
    }
    spectrum_destroy(weighted);
    spectrum_destroy(flat);
    spectrum_destroy(scaled);
    if (!sum)
        return cmf;
    spectrum_destroy(cmf);
    return sum;
}

/* Uniform over the bins, plus as much again over the visible where the bins do not cover it. */
static struct spectrum *binned_importance(struct range range, float min, float max, struct spectrum *visible)
{
    float width = max - min, lambda[2] = {min, max}, value[2] = {1 / width, 1 / width};
    struct spectrum *uniform = spectrum_table(range, lambda, value, 2, BEYOND_ZERO, "spectral bins", NULL),
                    *sum = NULL;
    if (uniform && (min > CMF_MIN_NM || max < CMF_MAX_NM)) {
        struct spectrum *share = spectrum_scaled(visible, (float)(1 / spectrum_integral(visible)));
        sum = share ? spectrum_sum(uniform, share) : NULL;
        spectrum_destroy(share);
        spectrum_destroy(uniform);
        uniform = sum;
    }
    spectrum_destroy(visible);
    return uniform;
}

static const struct spectrum *source_spectrum(const struct wavelengths *w, const struct scene *scene,
                                              int source)
{
    if (source >= w->shapes)
        return scene_fluorophore_emission(scene, source - w->shapes);
    int light = 0;
    while (scene_light_shape(scene, light) != source)
        light++;
    return scene_light_spectrum(scene, light);
}

/* ∫ e ã = e ã/P at any one wavelength; at the product's median, which both have. */
static void measure_product(struct wavelengths *w, size_t at, const struct spectrum *source,
                            const struct spectrum *sink)
{
    float pdf;
    if (!w->product[at])
        return;
    w->middle[at] = spectral_histogram_sample(w->product[at], 0.5f, &pdf);
    if (pdf > 0)
        w->overlap[at] = spectrum_pdf(source, w->middle[at]) * spectrum_pdf(sink, w->middle[at]) / pdf;
}

static void fill_products(struct wavelengths *w, const struct scene *scene)
{
    int sinks = w->fluorophores + 1, sources = w->shapes ? w->shapes + w->fluorophores : 0;
    bool pairs = (size_t)sinks * (size_t)sources <= product_pairs_max;
    for (int sink = 0; sink < sinks; sink++) {
        const struct spectrum *taken =
            sink < w->fluorophores ? scene_fluorophore_absorption(scene, sink) : w->camera;
        struct spectral_histogram *shared =
            pairs ? NULL : spectral_histogram_create(taken, NULL, NULL, product_bin_nm);
        for (int source = 0; source < sources; source++) {
            const struct spectrum *given = source_spectrum(w, scene, source);
            size_t at = (size_t)(source * sinks + sink);
            w->product[at] = pairs ? spectral_histogram_create(given, taken, NULL, product_bin_nm) : shared;
            measure_product(w, at, given, taken);
        }
    }
}

bool wavelengths_create(struct wavelengths *w, const struct integrator_settings *settings,
                        const struct scene *scene, stokes_error *err)
{
    struct range range = {settings->lambda_min, settings->lambda_max};
    *w = (struct wavelengths){.shapes = scene_light_shape_count(scene),
                              .fluorophores = scene_fluorophore_count(scene)};
    w->camera = visible_importance(range, scene_lamp_spectrum(scene));
    if (w->camera && settings->spectral_bins > 0)
        w->camera = binned_importance(range, settings->bins_min, settings->bins_max, w->camera);
    size_t pairs = (size_t)(w->shapes + w->fluorophores + 1) * (size_t)(w->fluorophores + 1);
    w->product = calloc(pairs, sizeof *w->product);
    w->overlap = calloc(pairs, sizeof *w->overlap);
    w->middle = calloc(pairs, sizeof *w->middle);
    if (!w->camera || !w->product || !w->overlap || !w->middle || !(spectrum_integral(w->camera) > 0)) {
        wavelengths_destroy(w);
        return fail(err, "settings", "lambda_min, lambda_max",
                    "the camera sees no wavelength between %g and %g nm", settings->lambda_min,
                    settings->lambda_max);
    }
    fill_products(w, scene);
    return true;
}

void wavelengths_destroy(struct wavelengths *w)
{
    size_t sinks = (size_t)w->fluorophores + 1,
           sources = w->shapes ? (size_t)(w->shapes + w->fluorophores) : 0;
    bool pairs = sinks * sources <= product_pairs_max;
    if (w->product)
        for (size_t i = 0; i < (pairs ? sinks * sources : sources ? sinks : 0); i++)
            spectral_histogram_destroy(w->product[i]);
    free(w->product);
    free(w->overlap);
    free(w->middle);
    spectrum_destroy(w->camera);
    *w = (struct wavelengths){0};
}
