/* Piecewise-linear spectra: values, integrals and drawn wavelengths against a reference that searches the table from
   end to end and sums small steps. */
#include "spectrum/spectrum.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "statistics.h"

#include <cmocka.h>

static const struct range lambda_range = {300, 830};
enum { MAX_KNOTS = 40 };

struct table {
    float lambda[MAX_KNOTS], value[MAX_KNOTS];
    size_t count;
};

/* Irregular spacing from hundredths to tens of nanometres, a step at every fifth knot, zeros in between, ends inside
   and outside Λ. */
static struct table random_table(uint64_t seed)
{
    struct table t = {.count = 3 + (size_t)(independent(seed, 0) * (MAX_KNOTS - 3))};
    double at = 200 + 150 * independent(seed, 1);
    for (size_t i = 0; i < t.count; i++) {
        double gap = pow(10, -2 + 4.2 * independent(seed, 10 + 2 * i));
        at += i % 5 == 4 ? 0 : gap;
        t.lambda[i] = (float)at;
        t.value[i] = i % 7 == 3 ? 0 : (float)(2 * independent(seed, 11 + 2 * i));
    }
    return t;
}

static double reference(const struct table *t, enum beyond beyond, double lambda)
{
    if (lambda < t->lambda[0])
        return beyond == BEYOND_HOLD ? t->value[0] : 0;
    for (size_t i = 0; i + 1 < t->count; i++)
        if (lambda < t->lambda[i + 1])
            return t->value[i] + ((double)t->value[i + 1] - t->value[i]) * (lambda - t->lambda[i]) /
                                     ((double)t->lambda[i + 1] - t->lambda[i]);
    return beyond == BEYOND_HOLD ? t->value[t->count - 1] : 0;
}

static struct spectrum *make(const struct table *t, enum beyond beyond)
{
    stokes_error err;
    struct spectrum *s = spectrum_table(lambda_range, t->lambda, t->value, t->count, beyond, "random", &err);
    assert_non_null(s);
    return s;
}

static void a_table_is_linear_between_its_knots(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 200; seed++) {
        struct table t = random_table(seed);
        enum beyond beyond = seed % 2 ? BEYOND_HOLD : BEYOND_ZERO;
        struct spectrum *s = make(&t, beyond);
        for (uint64_t i = 0; i < 500; i++) {
            float lambda = (float)(300 + 530 * independent(seed + 1000, i));
            double nudge =
                1e-3 * fabs(reference(&t, beyond, lambda + 3e-5) - reference(&t, beyond, lambda - 3e-5));
            if (nudge < 1e-3) /* in a gap of floats' width a linear piece is as good as a step */
                assert_float_equal(spectrum_eval(s, lambda), reference(&t, beyond, lambda),
                                   2e-5 + 2e3 * nudge);
        }
        assert_float_equal(spectrum_range(s).min, 300, 0);
        assert_float_equal(spectrum_range(s).max, 830, 0);
        assert_float_equal(spectrum_eval(s, 299.99f) + spectrum_eval(s, 830.01f) + spectrum_eval(s, NAN), 0,
                           0);
        spectrum_destroy(s);
    }
}

static void at_a_step_the_value_is_that_of_the_right(void **state)
{
    (void)state;
    const float lambda[] = {400, 500, 500, 600}, value[] = {1, 2, 5, 6};
    struct spectrum *s = spectrum_table(lambda_range, lambda, value, 4, BEYOND_ZERO, "step", NULL);
    assert_float_equal(spectrum_eval(s, 500), 5, 0);
    assert_float_equal(spectrum_eval(s, nextafterf(500, 0)), 2, 1e-5);
    assert_float_equal(spectrum_eval(s, 400), 1, 0);
    assert_float_equal(spectrum_eval(s, nextafterf(400, 0)), 0, 0);
    assert_float_equal(spectrum_eval(s, 600), 0, 0);
    assert_float_equal(spectrum_integral(s), 150 + 550, 1e-9);
    spectrum_destroy(s);
}

static void integrals_equal_sums_of_small_steps(void **state)
{
    (void)state;
    enum { STEPS = 200000 };
    for (uint64_t seed = 0; seed < 20; seed++) {
        struct table t = random_table(seed);
        struct spectrum *s = make(&t, BEYOND_HOLD);
        double sum = 0, width = 530.0 / STEPS;
        for (int i = 0; i < STEPS; i++) {
            if (i % 20000 == 7)
                assert_float_equal(spectrum_integral_to(s, (float)(300 + i * width)), sum, 0.02);
            sum += width * reference(&t, BEYOND_HOLD, 300 + (i + 0.5) * width);
        }
        assert_float_equal(spectrum_integral(s), sum,
                           0.02); /* a step inside a width: 2 · 0.00265, at most 6 of them */
        assert_float_equal(spectrum_integral_to(s, 830), spectrum_integral(s), 0);
        assert_float_equal(spectrum_integral_to(s, 300), 0, 0);
        spectrum_destroy(s);
    }
}

/* Drawn at u, a wavelength has u of the integral below it. In floats a wavelength is known to 3e-5 nm, hence the
   tolerance: that times the density. */
static void a_drawn_wavelength_inverts_the_cdf(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 200; seed++) {
        struct table t = random_table(seed);
        struct spectrum *s = make(&t, seed % 2 ? BEYOND_HOLD : BEYOND_ZERO);
        double total = spectrum_integral(s);
        if (!(total > 0)) {
            spectrum_destroy(s);
            continue;
        }
        for (uint64_t i = 0; i < 500; i++) {
            float pdf, u = i == 0   ? 0
                           : i == 1 ? 1 - 0x1p-24f
                                    : (float)(independent(seed + 2000, i) * (1 - 0x1p-24));
            float lambda = spectrum_sample(s, u, &pdf);
            double most = spectrum_max(s) / total;
            assert_float_equal(spectrum_integral_to(s, lambda) / total, u, 1e-4 * most + 1e-7);
            assert_true(pdf > 0 && lambda >= 300 && lambda <= 830);
            assert_float_equal(pdf, spectrum_pdf(s, lambda), 1e-6 * pdf);
        }
        spectrum_destroy(s);
    }
}

static void drawn_wavelengths_are_distributed_as_the_density(void **state)
{
    (void)state;
    enum { BINS = 106, COUNT = 1 << 20 };
    static double observed[BINS], expected[BINS];
    struct table t = random_table(5);
    struct spectrum *s = make(&t, BEYOND_HOLD);
    memset(observed, 0, sizeof observed);
    for (uint64_t i = 0; i < COUNT; i++) {
        float pdf, lambda = spectrum_sample(s, (float)(independent(9, i) * (1 - 0x1p-24)), &pdf);
        observed[(int)fminf((lambda - 300) / 5, BINS - 1)]++;
    }
    for (int i = 0; i < BINS; i++) {
        float from = 300 + 5 * (float)i;
        double share = spectrum_integral_to(s, from + 5) - spectrum_integral_to(s, from);
        expected[i] = COUNT * share / spectrum_integral(s);
    }
    assert_distributed(observed, expected, BINS, (struct power){.sees_error = 0.02});
    spectrum_destroy(s);
}

/* For a density with a line, a step and a gap: λ·value/pdf averages to ∫ λ·value. */
static void the_density_weighs_what_it_draws(void **state)
{
    (void)state;
    const float lambda[] = {350, 400, 400, 401, 401, 500, 600, 700}, value[] = {0, 1, 90, 90, 2, 0, 0, 3};
    struct spectrum *s = spectrum_table(lambda_range, lambda, value, 8, BEYOND_ZERO, "lines", NULL);
    struct batches found = {0};
    for (uint64_t batch = 0; batch < 64; batch++) {
        double sum = 0;
        for (uint64_t i = 0; i < 4096; i++) {
            float pdf, drawn = spectrum_sample(s, (float)(independent(batch + 50, i) * (1 - 0x1p-24)), &pdf);
            sum += spectrum_eval(s, drawn) * drawn / pdf;
        }
        batches_add(&found, sum / 4096);
    }
    double exact = 0; /* ∫ λ·value of a linear piece: (h/6)(l0 (2 v0 + v1) + l1 (v0 + 2 v1)) */
    for (int i = 0; i < 7; i++)
        exact +=
            (lambda[i + 1] - lambda[i]) / 6.0 *
            (lambda[i] * (2.0 * value[i] + value[i + 1]) + lambda[i + 1] * (value[i] + 2.0 * value[i + 1]));
    assert_true(batches_agree(&found, exact, (struct power){.sees_error = 0.01}, 1));
    spectrum_destroy(s);
}

static void sums_and_products_are_those_of_the_values(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 100; seed++) {
        struct table ta = random_table(seed), tb = random_table(seed + 500);
        struct spectrum *a = make(&ta, BEYOND_HOLD), *b = make(&tb, BEYOND_ZERO);
        struct spectrum *sum = spectrum_sum(a, b), *product = spectrum_product(a, b);
        for (uint64_t i = 0; i < 300; i++) {
            float lambda = (float)(300 + 530 * independent(seed + 3000, i)), whole = floorf(lambda);
            double va = spectrum_eval(a, lambda), vb = spectrum_eval(b, lambda);
            assert_float_equal(spectrum_eval(sum, lambda), va + vb, 1e-5);
            if (whole >= 300)
                assert_float_equal(spectrum_eval(product, whole),
                                   (double)spectrum_eval(a, whole) * spectrum_eval(b, whole), 1e-5);
        }
        assert_float_equal(spectrum_integral(sum), spectrum_integral(a) + spectrum_integral(b), 1e-4);
        spectrum_destroy(a);
        spectrum_destroy(b);
        spectrum_destroy(sum);
        spectrum_destroy(product);
    }
}

static void a_clamped_spectrum_is_clamped_everywhere(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 100; seed++) {
        struct table t = random_table(seed);
        struct spectrum *s = make(&t, BEYOND_HOLD), *clamped = spectrum_clamped(s, 0.5f, 1.2f);
        for (uint64_t i = 0; i < 300; i++) {
            float lambda = (float)(300 + 530 * independent(seed + 4000, i)), value = spectrum_eval(s, lambda);
            double steepness = fabs(spectrum_eval(s, lambda + 1e-4f) - spectrum_eval(s, lambda - 1e-4f));
            if (steepness < 1e-3)
                assert_float_equal(spectrum_eval(clamped, lambda), fminf(fmaxf(value, 0.5f), 1.2f), 1e-3);
        }
        assert_true(spectrum_min(clamped) >= 0.5f && spectrum_max(clamped) <= 1.2f);
        spectrum_destroy(s);
        spectrum_destroy(clamped);
    }
}

/* Chromaticities that the CIE publishes with the tables, in five decimals, those of F in four. */
static void illuminants_have_their_published_chromaticity(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double x, y;
    } published[] = {{"A", 0.44758, 0.40745},   {"C", 0.31006, 0.31616},   {"D50", 0.34567, 0.35851},
                     {"D55", 0.33243, 0.34744}, {"D65", 0.31272, 0.32903}, {"D75", 0.29903, 0.31488},
                     {"E", 0.33331, 0.33329},   {"F1", 0.3131, 0.3371},    {"F2", 0.3721, 0.3751},
                     {"F7", 0.3129, 0.3292},    {"F11", 0.3805, 0.3769},   {"F12", 0.4370, 0.4042}};
    for (size_t i = 0; i < sizeof published / sizeof *published; i++) {
        stokes_error err;
        struct spectrum *s = spectrum_illuminant(lambda_range, published[i].name, "lamp", &err);
        assert_non_null(s);
        bool coarse =
            published[i].name[0] == 'F' || published[i].name[0] == 'C'; /* summed as published, by 5 nm */
        double sum[3] = {0};
        for (int nm = 360; nm <= 830; nm += coarse ? 5 : 1) {
            float cmf[3];
            cmf_eval((float)nm, cmf);
            for (int c = 0; c < 3; c++)
                sum[c] += cmf[c] * spectrum_eval(s, (float)nm);
        }
        double tolerance = published[i].name[0] == 'F' ? 7e-5 : 2e-5;
        assert_float_equal(sum[0] / (sum[0] + sum[1] + sum[2]), published[i].x, tolerance);
        assert_float_equal(sum[1] / (sum[0] + sum[1] + sum[2]), published[i].y, tolerance);
        spectrum_destroy(s);
    }
}

static void a_black_body_peaks_where_wien_says(void **state)
{
    (void)state;
    for (double kelvin = 3600; kelvin < 9500; kelvin += 250) {
        struct spectrum *s = spectrum_blackbody(lambda_range, kelvin, "body", NULL);
        float peak = 300;
        for (float l = 300; l <= 830; l++)
            if (spectrum_eval(s, l) > spectrum_eval(s, peak))
                peak = l;
        assert_float_equal(peak, 2897771.955 / kelvin, 1);
        assert_float_equal(spectrum_max(s), 1, 1e-5);
        spectrum_destroy(s);
    }
    /* Two values of Planck's law that have a simple ratio: x = c2/(λT) = ln 2 at one, ln 4 at the other. */
    double kelvin = 1.438777e7 / (400 * log(4));
    struct spectrum *s = spectrum_blackbody(lambda_range, kelvin, "body", NULL);
    assert_float_equal(spectrum_eval(s, 400) / spectrum_eval(s, 800), 32.0 * (2 - 1) / (4 - 1), 1e-4);
    spectrum_destroy(s);
}

static void daylight_of_6504_kelvin_is_d65(void **state)
{
    (void)state;
    struct spectrum *day = spectrum_daylight(lambda_range, 6503.6, "day", NULL);
    struct spectrum *d65 = spectrum_illuminant(lambda_range, "D65", "d65", NULL);
    for (float l = 300; l <= 830; l++)
        assert_float_equal(spectrum_eval(day, l), spectrum_eval(d65, l), 3e-4);
    spectrum_destroy(day);
    spectrum_destroy(d65);
}

static void gaussians_and_lines_have_their_areas(void **state)
{
    (void)state;
    struct spectrum *s = spectrum_gaussian(lambda_range, 550, 12, 0.7, "gauss", NULL);
    assert_float_equal(spectrum_integral(s), 0.7 * 12 * sqrt(2 * 3.14159265358979), 1e-3);
    assert_float_equal(spectrum_eval(s, 562), 0.7 * exp(-0.5), 1e-4);
    spectrum_destroy(s);
    s = spectrum_line(lambda_range, 589.3, 2, "line", NULL);
    assert_float_equal(spectrum_integral(s), 2, 1e-4);
    assert_float_equal(spectrum_eval(s, 588.4f), 1, 0);
    assert_float_equal(spectrum_eval(s, 588.2f) + spectrum_eval(s, 590.4f), 0, 0);
    spectrum_destroy(s);
    s = spectrum_line(lambda_range, 300, 10, "cut", NULL); /* half of it lies outside Λ */
    assert_float_equal(spectrum_integral(s), 5, 1e-4);
    spectrum_destroy(s);
}

static void assert_refused(struct spectrum *s, const stokes_error *err, const char *word)
{
    assert_null(s);
    assert_non_null(strstr(err->text, word));
    assert_string_equal(err->object, "lamp");
}

static void what_overflows_is_no_spectrum(void **state)
{
    (void)state;
    struct spectrum *large = spectrum_constant(lambda_range, 1e30f);
    assert_null(spectrum_scaled(large, 1e30f));
    assert_null(spectrum_product(large, large));
    assert_null(spectrum_scaled(large, NAN));
    assert_null(spectrum_constant(lambda_range, INFINITY));
    spectrum_destroy(large);
}

static void bad_input_is_named(void **state)
{
    (void)state;
    stokes_error e;
    const float down[] = {400, 500, 450}, thrice[] = {400, 400, 400}, nan[] = {400, NAN, 500},
                one[] = {1, 1, 1};
    struct range r = lambda_range, inverted = {500, 400};
    assert_refused(spectrum_table(r, down, one, 3, BEYOND_ZERO, "lamp", &e), &e, "descend at entry 2");
    assert_refused(spectrum_table(r, thrice, one, 3, BEYOND_ZERO, "lamp", &e), &e, "three entries at 400");
    assert_refused(spectrum_table(r, nan, one, 3, BEYOND_ZERO, "lamp", &e), &e, "entry 1 is not");
    assert_refused(spectrum_table(r, one, nan, 3, BEYOND_ZERO, "lamp", &e), &e, "entry 1 is not");
    assert_refused(spectrum_table(r, one, one, 0, BEYOND_ZERO, "lamp", &e), &e, "empty");
    assert_refused(spectrum_table(inverted, one, one, 1, BEYOND_ZERO, "lamp", &e), &e, "500 to 400");
    assert_refused(spectrum_blackbody(r, -3, "lamp", &e), &e, "-3 K");
    assert_refused(spectrum_daylight(r, 3999, "lamp", &e), &e, "3999 K");
    assert_refused(spectrum_illuminant(r, "D66", "lamp", &e), &e, "D66");
    assert_refused(spectrum_gaussian(r, 500, 0, 1, "lamp", &e), &e, "sigma");
    assert_refused(spectrum_line(r, 500, 0.5, "lamp", &e), &e, "width");
    assert_refused(spectrum_library(r, "no/such", "lamp", &e), &e, "no/such");
}

static void a_histogram_draws_as_it_says_and_misses_nothing(void **state)
{
    (void)state;
    enum { COUNT = 1 << 19 };
    static double observed[400], expected[400];
    for (uint64_t seed = 0; seed < 6; seed++) {
        struct table ta = random_table(seed), tb = random_table(seed + 700);
        struct spectrum *a = make(&ta, BEYOND_HOLD), *b = make(&tb, BEYOND_HOLD);
        float bin_nm = seed % 2 ? 5 : 1.7f;
        struct spectral_histogram *h = spectral_histogram_create(a, seed % 3 ? b : NULL, NULL, bin_nm);
        assert_non_null(h);
        memset(observed, 0, sizeof observed);
        double width = 530.0 / h->count, whole = 0;
        for (uint64_t i = 0; i < COUNT; i++) {
            float pdf,
                lambda =
                    spectral_histogram_sample(h, (float)(independent(seed + 60, i) * (1 - 0x1p-24)), &pdf);
            assert_true(pdf > 0 && pdf == spectral_histogram_pdf(h, lambda));
            observed[(int)((lambda - 300) / width)]++;
        }
        for (uint32_t i = 0; i < h->count; i++) {
            float middle = (float)(300 + (i + 0.5) * width);
            expected[i] = COUNT * width * spectral_histogram_pdf(h, middle);
            whole += expected[i];
        }
        assert_float_equal(whole / COUNT, 1, 1e-5);
        assert_distributed(observed, expected, h->count, (struct power){.sees_error = 0.05});
        for (uint64_t i = 0; i < 20000; i++) {
            float lambda = (float)(300 + 530 * independent(seed + 70, i));
            if (spectrum_eval(a, lambda) * (seed % 3 ? spectrum_eval(b, lambda) : 1) > 0)
                assert_true(spectral_histogram_pdf(h, lambda) > 0);
        }
        spectral_histogram_destroy(h);
        spectrum_destroy(a);
        spectrum_destroy(b);
    }
}

/* Masses are those of (λ - 300)², each raised by a thousandth of their mean; the cdf is rounded to 2^-24. */
static void a_histogram_follows_the_product(void **state)
{
    (void)state;
    enum { BINS = 10 };
    const float ends[] = {300, 830}, rise[] = {0, 530};
    struct spectrum *s = spectrum_table(lambda_range, ends, rise, 2, BEYOND_HOLD, "rise", NULL);
    struct spectral_histogram *h = spectral_histogram_create(s, s, NULL, 53);
    assert_int_equal(h->count, BINS);
    for (int i = 0; i < BINS; i++) {
        double share = (pow(i + 1, 3) - pow(i, 3)) / pow(BINS, 3);
        double floored = (share + 1e-3 / BINS) / (1 + 1e-3);
        assert_float_equal(53 * spectral_histogram_pdf(h, 326.5f + 53 * (float)i), floored, 3 * 0x1p-24);
    }
    spectral_histogram_destroy(h);
    spectrum_destroy(s);
}

static void nothing_is_drawn_from_nothing_and_needles_are_found(void **state)
{
    (void)state;
    struct spectrum *line = spectrum_line(lambda_range, 400, 1, "a", NULL);
    struct spectrum *other = spectrum_line(lambda_range, 500, 1, "b", NULL);
    struct spectrum *both = spectrum_sum(line, other);
    assert_null(spectral_histogram_create(line, other, NULL, 5));
    struct spectral_histogram *h = spectral_histogram_create(line, both, both, 5);
    float pdf, drawn = spectral_histogram_sample(h, 0.7f, &pdf);
    assert_true(drawn >= 395 && drawn <= 405);
    spectral_histogram_destroy(h);
    h = spectral_histogram_create(both, NULL, NULL, 5);
    for (uint32_t i = 0; i <= h->count;
         i++) { /* exactly at a bin's edge it is the bin after it that has mass */
        drawn = spectral_histogram_sample(h, h->cdf[i], &pdf);
        assert_true(pdf > 0 && pdf == spectral_histogram_pdf(h, drawn));
    }
    spectral_histogram_destroy(h);
    spectrum_destroy(line);
    spectrum_destroy(other);
    spectrum_destroy(both);
}

/* Out to seven standard deviations a Gaussian is positive, though by 1e-11 of its peak: far below a float's share. */
static void a_histogram_reaches_faint_tails(void **state)
{
    (void)state;
    struct spectrum *s = spectrum_gaussian(lambda_range, 550, 30, 1, "tails", NULL);
    struct spectral_histogram *h = spectral_histogram_create(s, NULL, NULL, 5);
    for (float l = 345; l < 756; l += 5)
        assert_true(spectral_histogram_pdf(h, l) > 0);
    assert_float_equal(spectral_histogram_pdf(h, 310), 0, 0);
    spectral_histogram_destroy(h);
    spectrum_destroy(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_table_is_linear_between_its_knots),
        cmocka_unit_test(at_a_step_the_value_is_that_of_the_right),
        cmocka_unit_test(integrals_equal_sums_of_small_steps),
        cmocka_unit_test(a_drawn_wavelength_inverts_the_cdf),
        cmocka_unit_test(drawn_wavelengths_are_distributed_as_the_density),
        cmocka_unit_test(the_density_weighs_what_it_draws),
        cmocka_unit_test(sums_and_products_are_those_of_the_values),
        cmocka_unit_test(a_clamped_spectrum_is_clamped_everywhere),
        cmocka_unit_test(illuminants_have_their_published_chromaticity),
        cmocka_unit_test(a_black_body_peaks_where_wien_says),
        cmocka_unit_test(daylight_of_6504_kelvin_is_d65),
        cmocka_unit_test(gaussians_and_lines_have_their_areas),
        cmocka_unit_test(what_overflows_is_no_spectrum),
        cmocka_unit_test(bad_input_is_named),
        cmocka_unit_test(a_histogram_draws_as_it_says_and_misses_nothing),
        cmocka_unit_test(a_histogram_follows_the_product),
        cmocka_unit_test(nothing_is_drawn_from_nothing_and_needles_are_found),
        cmocka_unit_test(a_histogram_reaches_faint_tails),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
