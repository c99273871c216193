/* Reflectances from trigonometric moments (Peters et al. 2019): bounded, with the moments that were asked for, smooth; and colours as such. */
#include "spectrum/moments.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "delta_e.h"
#include "spectrum/library/library.h"
#include "statistics.h"

#include <cmocka.h>

static const struct range lambda_range = {300, 830};
static const float LOW = 360, HIGH = 830;

/* Moments by brute force: a tenth of a nanometre at a time. */
static void brute_moments(const struct moment_curve *curve, double *moments, int count)
{
    enum { STEPS = 4700 };
    memset(moments, 0, (size_t)count * sizeof *moments);
    for (int i = 0; i < STEPS; i++) {
        double phi = M_PI * (i + 0.5) / STEPS, g = moment_curve_eval(curve, LOW + (HIGH - LOW) * phi / M_PI);
        for (int l = 0; l < count; l++)
            moments[l] += g * cos(l * phi) / STEPS;
    }
}

static struct spectrum *wandering(uint64_t seed, int knots)
{
    float lambda[64], value[64];
    for (int i = 0; i < knots; i++) {
        lambda[i] = LOW + (HIGH - LOW) * (float)i / (float)(knots - 1);
        value[i] = (float)independent(seed, (uint64_t)i);
    }
    return spectrum_table(lambda_range, lambda, value, (size_t)knots, BEYOND_HOLD, "test", NULL);
}

static void moments_of_a_table_are_exact(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed < 20; seed++) {
        struct spectrum *s = wandering(seed, 24);
        double found[12], wanted[12] = {0};
        moments_of_spectrum(s, LOW, HIGH, found, 12);
        for (int i = 0; i < 47000; i++) {
            double phi = M_PI * (i + 0.5) / 47000;
            float g = spectrum_eval(s, (float)(LOW + (HIGH - LOW) * phi / M_PI));
            for (int l = 0; l < 12; l++)
                wanted[l] += g * cos(l * phi) / 47000;
        }
        for (int l = 0; l < 12; l++)
            assert_float_equal(found[l], wanted[l], 2e-6);
        spectrum_destroy(s);
    }
}

static void the_curve_has_the_moments_and_stays_within_bounds(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed < 200; seed++) {
        int count = 1 + (int)(seed % 16);
        struct spectrum *s = wandering(seed, 40);
        double moments[16], found[16];
        struct moment_curve curve;
        stokes_error err;
        moments_of_spectrum(s, LOW, HIGH, moments, count);
        assert_true(moment_curve_make(moments, count, LOW, HIGH, &curve, "test", &err));
        brute_moments(&curve, found, count);
        for (int l = 0; l < count; l++)
            assert_float_equal(found[l], moments[l], 1e-4);
        for (double nm = 250; nm < 900; nm += 0.7) {
            double g = moment_curve_eval(&curve, nm);
            assert_true(g >= 0 && g <= 1);
        }
        spectrum_destroy(s);
    }
}

/* Steps between 0 and 1 are where ordinary truncated series overshoot most. */
static void a_band_is_bounded_and_rings_little(void **state)
{
    (void)state;
    float lambda[4] = {500, 500, 600, 600}, value[4] = {0, 1, 1, 0};
    struct spectrum *s = spectrum_table(lambda_range, lambda, value, 4, BEYOND_ZERO, "test", NULL);
    double moments[12], series_worst = 0, worst = 0;
    struct moment_curve curve;
    stokes_error err;
    moments_of_spectrum(s, LOW, HIGH, moments, 12);
    assert_true(moment_curve_make(moments, 12, LOW, HIGH, &curve, "test", &err));
    for (double nm = LOW; nm < HIGH; nm += 0.5) {
        double phi = M_PI * (nm - LOW) / (HIGH - LOW), series = moments[0];
        for (int l = 1; l < 12; l++)
            series += 2 * moments[l] * cos(l * phi);
        double g = moment_curve_eval(&curve, nm);
        assert_true(g >= 0 && g <= 1);
        if (nm < 470 || nm > 630)
            worst = fmax(worst, g);
        series_worst = fmin(series_worst, series);
    }
    assert_true(series_worst < -0.05); /* what a truncated series does */
    assert_true(worst < 0.02);
    spectrum_destroy(s);
}

static void a_few_moments_keep_a_measured_reflectance(void **state)
{
    (void)state;
    size_t patches = 0;
    double worst[3] = {0}; /* of 4, 8 and 16 moments: root mean square over 400–700 nm */
    const struct library_entry *entry;
    for (size_t i = 0; (entry = library_at(i)); i++) {
        if (strncmp(entry->name, "colorchecker/", 13) != 0)
            continue;
        patches++;
        stokes_error err;
        struct spectrum *s = spectrum_library(lambda_range, entry->name, entry->name, &err);
        double moments[16], previous = INFINITY;
        for (int count = 4; count <= 16; count *= 2) {
            moments_of_spectrum(s, LOW, HIGH, moments, count);
            struct spectrum *small = spectrum_moments(lambda_range, moments, count, LOW, HIGH, "small", &err);
            assert_non_null(small);
            double sum = 0;
            for (float l = 400; l < 700; l += 1)
                sum += pow(spectrum_eval(s, l) - spectrum_eval(small, l), 2) / 300;
            worst[count / 8] = fmax(worst[count / 8], sqrt(sum));
            assert_true(sqrt(sum) < previous * 1.1 + 1e-3);
            previous = sqrt(sum);
            spectrum_destroy(small);
        }
        spectrum_destroy(s);
    }
    assert_int_equal(patches, 24);
    assert_true(worst[0] < 0.09 && worst[1] < 0.045 && worst[2] < 0.008);
}

static void black_white_and_steps_are_drawn_inward_but_little(void **state)
{
    (void)state;
    static const double cases[][4] = {{0, 0, 0, 0}, {1, 0, 0, 0}, {0.5, 0.318309886, 0, -0.106103295}};
    for (size_t i = 0; i < 3; i++) {
        struct moment_curve curve;
        stokes_error err;
        double found[4];
        assert_true(moment_curve_make(cases[i], 4, LOW, HIGH, &curve, "test", &err));
        brute_moments(&curve, found, 4);
        for (int l = 0; l < 4; l++)
            assert_float_equal(found[l], cases[i][l], 1e-3);
    }
}

static void what_no_reflectance_has_is_refused(void **state)
{
    (void)state;
    static const double cases[][3] = {{1.2, 0, 0},   {-0.1, 0, 0},  {0.5, 0.45, 0},
                                      {0.1, 0.2, 0}, {0.5, NAN, 0}, {0.3, 0, 0.5}};
    stokes_error err;
    struct moment_curve curve;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        err = (stokes_error){0};
        assert_false(moment_curve_make(cases[i], 3, LOW, HIGH, &curve, "test", &err));
        assert_string_equal(err.property, "moments");
    }
    assert_false(moment_curve_make(cases[0], 0, LOW, HIGH, &curve, "test", &err));
    assert_false(moment_curve_make(cases[0], MOMENTS_MAX + 1, LOW, HIGH, &curve, "test", &err));
    assert_false(moment_curve_make((double[]){0.5, 0, 0}, 3, 500, 500, &curve, "test", &err));
}

/* Pieces between whole nanometres err by (1 nm)²/12 of the curve's slope (Euler and Maclaurin): by 0.02 nm at a slope of 0.24/nm. The second
   integral, as the slope is 0 at both ends, errs by (1 nm)²/12 of the curve itself: by less than 0.09 nm². */
static void integrals_of_the_compiled_curve_are_the_curves(void **state)
{
    (void)state;
    enum { PER_NM = 16 };
    double worst = 0, worst_second = 0;
    for (uint64_t seed = 1; seed <= 400; seed++) {
        int count = 1 + (int)(seed % 16);
        struct spectrum *s = wandering(seed, 4 + (int)(seed % 37)), *compiled;
        double moments[16], integral = 0, second = 0;
        struct moment_curve curve;
        stokes_error err;
        moments_of_spectrum(s, LOW, HIGH, moments, count);
        assert_true(moment_curve_make(moments, count, LOW, HIGH, &curve, "test", &err));
        compiled = spectrum_moments(lambda_range, moments, count, LOW, HIGH, "test", &err);
        assert_non_null(compiled);
        for (int i = 0; i < (830 - 300) * PER_NM; i++) {
            double value = moment_curve_eval(&curve, 300 + (i + 0.5) / PER_NM) / PER_NM;
            float to = 300 + (float)(i + 1) / PER_NM;
            second += (integral + 0.5 * value) / PER_NM;
            integral += value;
            worst = fmax(worst, fabs(spectrum_integral_to(compiled, to) - integral));
            worst_second = fmax(worst_second, fabs(spectrum_second_integral_to(compiled, to) - second));
        }
        spectrum_destroy(compiled);
        spectrum_destroy(s);
    }
    print_message("integrals err by up to %.5f nm and %.4f nm²\n", worst, worst_second);
    assert_true(worst < 0.02);
    assert_true(worst_second < 0.09);
}

/* --- Colours ------------------------------------------------------------------------------------------------- */

static void spectrum_xyz(const struct spectrum *s, double xyz[3], double white[3])
{
    memset(xyz, 0, 3 * sizeof *xyz);
    memset(white, 0, 3 * sizeof *white);
    for (int i = 0; i <= 940; i++) {
        float cmf[3], lambda = 360 + 0.5f * (float)i;
        cmf_eval(lambda, cmf);
        for (int c = 0; c < 3; c++) {
            double w = (double)illuminant_d65(lambda) * cmf[c];
            white[c] += w;
            xyz[c] += w * (s ? spectrum_eval(s, lambda) : 1);
        }
    }
    for (int c = 0; c < 3; c++)
        xyz[c] /= white[1];
    double y = white[1];
    for (int c = 0; c < 3; c++)
        white[c] /= y;
}

/* ΔE2000 of a colour's spectrum under D65. */
static double round_trip(const struct working_space *space, const float rgb[3], bool *outside,
                         double *roughness)
{
    struct spectrum *s = spectrum_rgb_moments(lambda_range, space, rgb, UV_HOLD, outside);
    double asked[3], got[3], white[3], lab_asked[3], lab_got[3];
    const double *m = space->rgb_to_xyz;
    assert_non_null(s);
    assert_true(spectrum_min(s) >= 0 && spectrum_max(s) <= 1);
    for (int row = 0; row < 3; row++)
        asked[row] = m[3 * row] * rgb[0] + m[3 * row + 1] * rgb[1] + m[3 * row + 2] * rgb[2];
    spectrum_xyz(s, got, white);
    lab_of_xyz(asked, white, lab_asked);
    lab_of_xyz(got, white, lab_got);
    for (uint32_t i = 1; i < s->count; i++)
        *roughness = fmax(*roughness, fabsf(s->value[i] - s->value[i - 1]));
    spectrum_destroy(s);
    return delta_e_2000(lab_asked, lab_got);
}

static void every_rec709_colour_comes_back_and_is_smooth(void **state)
{
    (void)state;
    enum { SIDE = 9 };
    struct working_space space;
    double worst = 0, worst_step = 0, inner_step = 0;
    int out_of_reach = 0;
    working_space_rec709(&space);
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        float rgb[3] = {(float)(i % SIDE) / (SIDE - 1), (float)(i / SIDE % SIDE) / (SIDE - 1),
                        (float)(i / SIDE / SIDE) / (SIDE - 1)};
        bool outside = true;
        double step = 0, error = round_trip(&space, rgb, &outside, &step);
        out_of_reach += outside;
        worst = fmax(worst, error);
        worst_step = fmax(worst_step, step);
        bool inner =
            fminf(fminf(rgb[0], rgb[1]), rgb[2]) > 0.05f && fmaxf(fmaxf(rgb[0], rgb[1]), rgb[2]) < 0.9f;
        if (inner)
            inner_step = fmax(inner_step, step);
    }
    print_message("worst ΔE2000 %.4f, %d out of reach, steepest %.3f, inside the cube %.3f a nanometre\n",
                  worst, out_of_reach, worst_step, inner_step);
    assert_int_equal(out_of_reach, 0);
    assert_true(worst < 0.1);
    assert_true(inner_step < 0.05);
}

static void a_colours_moments_give_its_spectrum_again(void **state)
{
    (void)state;
    struct working_space space;
    working_space_rec709(&space);
    for (uint64_t i = 0; i < 100; i++) {
        const float rgb[3] = {(float)(0.1 + 0.7 * independent(51, 3 * i)),
                              (float)(0.1 + 0.7 * independent(51, 3 * i + 1)),
                              (float)(0.1 + 0.7 * independent(51, 3 * i + 2))};
        struct spectrum *s = spectrum_rgb_moments(lambda_range, &space, rgb, UV_HOLD, NULL);
        double moments[3];
        stokes_error err;
        moments_of_spectrum(s, LOW, HIGH, moments, 3);
        struct spectrum *again = spectrum_moments(lambda_range, moments, 3, LOW, HIGH, "again", &err);
        assert_non_null(again);
        for (float l = 300; l <= 830; l += 3)
            assert_float_equal(spectrum_eval(s, l), spectrum_eval(again, l), 2e-3);
        spectrum_destroy(s);
        spectrum_destroy(again);
    }
}

static void below_the_visible_it_does_as_the_rule_says(void **state)
{
    (void)state;
    struct working_space space;
    const float rgb[3] = {0.7f, 0.2f, 0.3f};
    working_space_rec709(&space);
    struct spectrum *hold = spectrum_rgb_moments(lambda_range, &space, rgb, UV_HOLD, NULL);
    struct spectrum *zero = spectrum_rgb_moments(lambda_range, &space, rgb, UV_ZERO, NULL);
    assert_true(spectrum_eval(hold, 310) == spectrum_eval(hold, 360));
    assert_true(spectrum_eval(zero, 310) == 0 && spectrum_eval(zero, 361) == spectrum_eval(hold, 361));
    spectrum_destroy(hold);
    spectrum_destroy(zero);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moments_of_a_table_are_exact),
        cmocka_unit_test(the_curve_has_the_moments_and_stays_within_bounds),
        cmocka_unit_test(a_band_is_bounded_and_rings_little),
        cmocka_unit_test(a_few_moments_keep_a_measured_reflectance),
        cmocka_unit_test(black_white_and_steps_are_drawn_inward_but_little),
        cmocka_unit_test(what_no_reflectance_has_is_refused),
        cmocka_unit_test(integrals_of_the_compiled_curve_are_the_curves),
        cmocka_unit_test(every_rec709_colour_comes_back_and_is_smooth),
        cmocka_unit_test(a_colours_moments_give_its_spectrum_again),
        cmocka_unit_test(below_the_visible_it_does_as_the_rule_says),
    };
    return cmocka_run_group_tests_name("moments", tests, NULL, NULL);
}
