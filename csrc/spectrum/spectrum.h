/* Spectra over the transport range Λ. Every spectrum is compiled to a piecewise-linear table with its cumulative
   integral, so evaluation, integrals and inversion of the cdf are exact and take constant time.
   RGB colours that vary over a surface stay as Jakob–Hanika coefficients (struct rgb_curve). */
#ifndef SPECTRUM_SPECTRUM_H
#define SPECTRUM_SPECTRUM_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "color/color.h"
#include "stokes.h"

/* Λ, nm. */
struct range {
    float min, max;
};

/* What a table says outside its own wavelengths. */
enum beyond { BEYOND_ZERO, BEYOND_HOLD };

struct spectrum {
    uint32_t count;     /* knots */
    float min, max;     /* Λ */
    float *lambda;      /* ascending, first = Λ.min, last = Λ.max; two equal neighbours make a step */
    float *value;       /* at the knots */
    struct spectrum_line {
        float begin, end, value, slope; /* the segment after each knot; the last one goes on for ever */
    } *line;
    double *cumulative; /* ∫ from Λ.min to the knot */
    double *second;     /* ∫ of that integral, from Λ.min to the knot */
    uint32_t *bucket;   /* first candidate segment of each bucket_nm-wide bucket of Λ */
    uint32_t bucket_count;
    float buckets_per_nm;
    uint32_t *guide; /* the same for the cdf, count equal parts of it */
};

/* Constructors: yours (spectrum_destroy). All clip to Λ and return NULL with *err filled on bad input: not ascending,
   not finite. `name` goes into the error. Linearly interpolated knots; `beyond` extends the first and last value or drops to zero.
   A black body is 1 at its maximum inside Λ, daylight and the CIE's illuminants at 560 nm; a line has height 1. */
struct spectrum *spectrum_constant(struct range, float value);
struct spectrum *spectrum_table(struct range, const float *lambda, const float *value, size_t count, enum beyond,
                                const char *name, stokes_error *err);
struct spectrum *spectrum_blackbody(struct range, double kelvin, const char *name, stokes_error *err);
struct spectrum *spectrum_daylight(struct range, double kelvin, const char *name, stokes_error *err);
struct spectrum *spectrum_illuminant(struct range, const char *illuminant, const char *name, stokes_error *err);
/* The illuminants without a table in the library, by the names that they have there ("illuminant/D65"); NULL past the end. */
const char *illuminant_computed_at(size_t index);
bool illuminant_is_computed(const char *name);
struct spectrum *spectrum_gaussian(struct range, double mean, double sigma, double peak, const char *name, stokes_error *err);
struct spectrum *spectrum_line(struct range, double center, double width, const char *name, stokes_error *err);
struct spectrum *spectrum_library(struct range, const char *entry, const char *name, stokes_error *err);
/* NULL without memory or where values leave the range of floats; both operands have the same Λ. The product has the knots
   of both; the product of linear pieces is sampled at 1 nm steps too, so it is within rounding of exact at them. */
struct spectrum *spectrum_sum(const struct spectrum *a, const struct spectrum *b);
struct spectrum *spectrum_product(const struct spectrum *a, const struct spectrum *b);
struct spectrum *spectrum_scaled(const struct spectrum *, float factor);
struct spectrum *spectrum_clamped(const struct spectrum *, float low, float high);
void spectrum_destroy(struct spectrum *);

static inline struct range spectrum_range(const struct spectrum *s)
{
    return (struct range){s->lambda[0], s->lambda[s->count - 1]};
}

/* Value at a wavelength; 0 outside Λ. In the innermost loop of every integrator: one bucket, one line of four floats. */
static inline float spectrum_eval(const struct spectrum *s, float lambda_nm)
{
    if (!(lambda_nm >= s->min && lambda_nm <= s->max))
        return 0;
    uint32_t b = (uint32_t)((lambda_nm - s->min) * s->buckets_per_nm);
    const struct spectrum_line *line = &s->line[s->bucket[b < s->bucket_count ? b : s->bucket_count - 1]];
    while (lambda_nm >= line->end)
        line++;
    return line->value + (lambda_nm - line->begin) * line->slope;
}
double spectrum_integral(const struct spectrum *); /* over Λ */
double spectrum_integral_to(const struct spectrum *, float lambda_nm); /* from Λ.min */
double spectrum_second_integral_to(const struct spectrum *, float lambda_nm); /* ∫ spectrum_integral_to, from Λ.min */
float spectrum_max(const struct spectrum *);
float spectrum_min(const struct spectrum *);

/* As a density: value/integral. Sampling inverts the piecewise-quadratic cdf exactly. Needs value ≥ 0 and integral > 0. */
float spectrum_sample(const struct spectrum *, float u, float *pdf);
float spectrum_pdf(const struct spectrum *, float lambda_nm);

/* A density over Λ, piecewise constant on equal bins, for products of spectra: positive wherever the product is, so
   what is drawn from it is unbiased (algorithm.md §9). */
struct spectral_histogram {
    struct range range;
    uint32_t count;
    float *cdf; /* count + 1 entries, 0 … 1 */
};
/* From the product of up to three spectra (NULL ones are left out). NULL if the product is zero everywhere. */
struct spectral_histogram *spectral_histogram_create(const struct spectrum *a, const struct spectrum *b,
                                                     const struct spectrum *c, float bin_nm);
void spectral_histogram_destroy(struct spectral_histogram *);
float spectral_histogram_sample(const struct spectral_histogram *, float u, float *pdf);
float spectral_histogram_pdf(const struct spectral_histogram *, float lambda_nm);

/* Jakob & Hanika 2019: S(λ) = 1/2 + x/(2√(1+x²)), x a quadratic in λ; coefficients for λ in nm, highest power first. */
struct rgb_curve {
    float c[3];
};
/* How a colour becomes a reflectance: by Jakob & Hanika's sigmoid of a quadratic, or as the bounded signal of three trigonometric moments
   (Peters et al. 2019, moments.h). */
enum rgb_method { RGB_SIGMOID, RGB_MOMENTS };
/* What an RGB reflectance does below 360 nm. */
enum uv_rule { UV_HOLD, UV_EXTRAPOLATE, UV_ZERO };

/* Above 830 nm it holds, too. */
static inline float rgb_curve_eval(const struct rgb_curve *curve, float lambda_nm, enum uv_rule uv_rule)
{
    float lowest = uv_rule == UV_EXTRAPOLATE ? 0 : CMF_MIN_NM;
    float l = lambda_nm < lowest ? lowest : lambda_nm > CMF_MAX_NM ? CMF_MAX_NM : lambda_nm;
    float x = (curve->c[0] * l + curve->c[1]) * l + curve->c[2];
    float value = 0.5f + 0.5f * x / sqrtf(1 + x * x);
    return uv_rule == UV_ZERO && lambda_nm < CMF_MIN_NM ? 0 : value;
}

/* Fits a constant colour directly (Gauss–Newton in CIELAB under D65). Colours that no reflectance reaches get the nearest;
   *outside (may be NULL) is then set. */
struct rgb_curve rgb_curve_fit(const struct working_space *, const float rgb[3], bool *outside);
/* The same as a spectrum. */
struct spectrum *spectrum_rgb(struct range, const struct working_space *, const float rgb[3], enum uv_rule, bool *outside);

/* The light that the working space calls white, 1 at 560 nm: D65, or daylight of another white's exact chromaticity. */
struct spectrum *spectrum_white(struct range, const struct working_space *);

/* A table of coefficients over the RGB cube, for textures; built in about a second, by all threads. */
struct rgb_table;
struct rgb_table *rgb_table_create(const struct working_space *, int threads);
void rgb_table_destroy(struct rgb_table *);
struct rgb_curve rgb_table_lookup(const struct rgb_table *, const float rgb[3]);

/* The library (csrc/spectrum/library/): name of an entry, NULL past the end. */
const char *library_name(size_t index);

#endif
