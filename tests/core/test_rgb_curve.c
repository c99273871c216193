/* Colours as reflectances: they come back from D65 and the observer as they went in. The way back is computed here
   from the spectra's values at small steps, not by the code that fits. */
#include "spectrum/rgb_fit.h"
#include "spectrum/spectrum.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "delta_e.h"
#include "statistics.h"

#include <cmocka.h>

static const struct range lambda_range = {300, 830};
static const double rec2020[9] = {0.6369580483, 0.1446169036, 0.1688809752, 0.2627002120, 0.6779980715,
                                  0.0593017165, 0.0000000000, 0.0280726930, 1.0609850577};
static const double acescg[9] = {0.6522384, 0.1282386,  0.1699829, 0.2676724, 0.6743395,
                                 0.0579881, -0.0053818, 0.0013691, 1.0930705}; /* adapted to D65 */

/* D65·cmf every half nanometre, for a reflectance of 1 that gives XYZ of D65 with Y = 1. */
enum { STEPS = 940 };
struct observer_table {
    double weight[STEPS + 1][3], white[3];
};

static void set_observer(struct observer_table *o)
{
    memset(o, 0, sizeof *o);
    for (int i = 0; i <= STEPS; i++) {
        float cmf[3], lambda = 360 + 0.5f * (float)i;
        cmf_eval(lambda, cmf);
        for (int c = 0; c < 3; c++)
            o->white[c] += o->weight[i][c] = (double)illuminant_d65(lambda) * cmf[c] * (i % STEPS ? 1 : 0.5);
    }
    double y = o->white[1];
    for (int c = 0; c < 3; c++)
        o->white[c] /= y;
    for (int i = 0; i <= STEPS; i++)
        for (int c = 0; c < 3; c++)
            o->weight[i][c] /= y;
}

static void curve_xyz(const struct observer_table *o, const struct rgb_curve *curve, double xyz[3])
{
    memset(xyz, 0, 3 * sizeof *xyz);
    for (int i = 0; i <= STEPS; i++) {
        double value = rgb_curve_eval(curve, 360 + 0.5f * (float)i, UV_HOLD);
        for (int c = 0; c < 3; c++)
            xyz[c] += o->weight[i][c] * value;
    }
}

static void transform(const double m[9], const double v[3], double out[3])
{
    for (int row = 0; row < 3; row++)
        out[row] = m[3 * row] * v[0] + m[3 * row + 1] * v[1] + m[3 * row + 2] * v[2];
}

/* ΔE2000 between a colour and its curve's look under D65. */
static double round_trip(const struct observer_table *o, const struct working_space *space,
                         const float rgb[3], const struct rgb_curve *curve)
{
    double asked[3], got[3], lab_asked[3], lab_got[3];
    transform(space->rgb_to_xyz, (double[3]){rgb[0], rgb[1], rgb[2]}, asked);
    curve_xyz(o, curve, got);
    lab_of_xyz(asked, o->white, lab_asked);
    lab_of_xyz(got, o->white, lab_got);
    return delta_e_2000(lab_asked, lab_got);
}

/* Pairs from the data that Sharma, Wu and Dalal (2005) published for testing implementations. */
static void the_colour_difference_is_ciede2000(void **state)
{
    (void)state;
    static const double pairs[][7] = {
        {50, 2.6772, -79.7751, 50, 0, -82.7485, 2.0425},
        {50, -1.3802, -84.2814, 50, 0, -82.7485, 1.0000},
        {50, 0, 0, 50, -1, 2, 2.3669},
        {50, 2.49, -0.001, 50, -2.49, 0.0009, 7.1792},
        {50, 2.5, 0, 73, 25, -18, 27.1492},
        {60.2574, -34.0099, 36.2677, 60.4626, -34.1751, 39.4387, 1.2644},
        {2.0776, 0.0795, -1.135, 0.9033, -0.0636, -0.5514, 0.9082},
    };
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++)
        assert_float_equal(delta_e_2000(pairs[i], pairs[i] + 3), pairs[i][6], 1e-4);
}

static void every_rec709_colour_comes_back(void **state)
{
    (void)state;
    enum { SIDE = 17 };
    struct working_space space;
    static struct observer_table o;
    working_space_rec709(&space);
    set_observer(&o);
    double worst = 0;
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        float rgb[3] = {(float)(i % SIDE) / (SIDE - 1), (float)(i / SIDE % SIDE) / (SIDE - 1),
                        (float)(i / SIDE / SIDE) / (SIDE - 1)};
        bool outside = true;
        struct rgb_curve curve = rgb_curve_fit(&space, rgb, &outside);
        assert_false(outside);
        worst = fmax(worst, round_trip(&o, &space, rgb, &curve));
    }
    print_message("worst ΔE2000 %.4f\n", worst);
    assert_true(worst < 0.1);
}

static void dark_and_almost_white_colours_come_back(void **state)
{
    (void)state;
    struct working_space space;
    static struct observer_table o;
    working_space_rec709(&space);
    set_observer(&o);
    for (uint64_t i = 0; i < 2000; i++) {
        double scale = pow(10, -6 * independent(1, i));
        float rgb[3];
        for (int c = 0; c < 3; c++) {
            double u = independent(2 + (uint64_t)c, i);
            rgb[c] = (float)(i % 2 ? scale * u : 1 - scale * u);
        }
        bool outside = true;
        struct rgb_curve curve = rgb_curve_fit(&space, rgb, &outside);
        assert_true(round_trip(&o, &space, rgb, &curve) < 0.1);
        assert_false(outside);
    }
}

static void greys_are_constant(void **state)
{
    (void)state;
    struct working_space space;
    working_space_rec709(&space);
    for (int i = 0; i <= 1000; i++) {
        float grey = (float)i / 1000, rgb[3] = {grey, grey, grey};
        bool outside = true;
        struct spectrum *s = spectrum_rgb(lambda_range, &space, rgb, UV_EXTRAPOLATE, &outside);
        assert_float_equal(spectrum_min(s), grey, 1e-6);
        assert_float_equal(spectrum_max(s), grey, 1e-6);
        assert_false(outside);
        spectrum_destroy(s);
    }
    struct rgb_curve white = rgb_curve_fit(&space, (float[3]){1, 1, 1}, NULL);
    struct rgb_curve black = rgb_curve_fit(&space, (float[3]){0, 0, 0}, NULL);
    assert_float_equal(rgb_curve_eval(&white, 500, UV_HOLD), 1, 0);
    assert_float_equal(rgb_curve_eval(&black, 500, UV_HOLD), 0, 0);
}

/* The look of reflectances that exist: bands with soft edges, so soft that a smooth curve can stand in for them. */
static void what_a_reflectance_reaches_comes_back_in_wide_spaces(void **state)
{
    (void)state;
    static struct observer_table o;
    set_observer(&o);
    for (int which = 0; which < 2; which++) {
        struct working_space space;
        assert_true(working_space_set(&space, which ? acescg : rec2020, NULL));
        for (uint64_t i = 0; i < 400; i++) {
            double from = 350 + 400 * independent(10, i), to = from + 20 + 300 * independent(11, i);
            double soft = 2 + 20 * independent(12, i), low = 0.02 * independent(13, i), xyz[3] = {0}, rgb[3];
            bool dip = independent(14, i) < 0.3;
            for (int k = 0; k <= STEPS; k++) {
                double l = 360 + 0.5 * k, band = 0.5 * (tanh((l - from) / soft) - tanh((l - to) / soft));
                for (int c = 0; c < 3; c++)
                    xyz[c] += o.weight[k][c] * (low + (1 - 2 * low) * (dip ? 1 - band : band));
            }
            transform(space.xyz_to_rgb, xyz, rgb);
            float color[3] = {(float)rgb[0], (float)rgb[1], (float)rgb[2]};
            bool outside = true;
            struct rgb_curve curve = rgb_curve_fit(&space, color, &outside);
            assert_false(outside);
            assert_true(round_trip(&o, &space, color, &curve) < 0.1);
        }
    }
}

static double lab_distance(const struct observer_table *o, const double asked[3],
                           const struct rgb_curve *curve)
{
    double xyz[3], lab[3];
    curve_xyz(o, curve, xyz);
    lab_of_xyz(xyz, o->white, lab);
    return sqrt((lab[0] - asked[0]) * (lab[0] - asked[0]) + (lab[1] - asked[1]) * (lab[1] - asked[1]) +
                (lab[2] - asked[2]) * (lab[2] - asked[2]));
}

/* Out of reach: it says so, and no reflectance of one band or one gap is nearer by more than what softness costs. */
static void what_no_reflectance_reaches_gets_the_nearest(void **state)
{
    (void)state;
    static const float colors[][3] = {{0, 0, 1},       {0, 1, 0},      {1, 0, 0},    {1, 1, 0},
                                      {0, 1, 1},       {1, 0, 1},      {0, 0.4f, 0}, {-0.1f, 0.3f, 0.2f},
                                      {1.2f, 1.1f, 1}, {0, 0.7f, 0.9f}};
    static struct observer_table o;
    struct working_space space;
    set_observer(&o);
    assert_true(working_space_set(&space, rec2020, NULL));
    for (size_t n = 0; n < sizeof colors / sizeof *colors; n++) {
        bool outside = false;
        double asked[3], xyz[3], best = 1e9;
        struct rgb_curve curve = rgb_curve_fit(&space, colors[n], &outside);
        assert_true(outside);
        transform(space.rgb_to_xyz, (double[3]){colors[n][0], colors[n][1], colors[n][2]}, xyz);
        lab_of_xyz(xyz, o.white, asked);
        for (int from = 0; from <= STEPS; from += 4) { /* optimal colours (Schrödinger 1920), every 2 nm */
            double band[3] = {0}, lab[3];
            for (int to = from; to <= STEPS; to++) {
                for (int c = 0; c < 3; c++)
                    band[c] += o.weight[to][c];
                for (int gap = 0; gap < 2 && to % 4 == 3; gap++) {
                    double look[3];
                    for (int c = 0; c < 3; c++)
                        look[c] = gap ? o.white[c] - band[c] : band[c];
                    lab_of_xyz(look, o.white, lab);
                    best = fmin(best, hypot(hypot(lab[0] - asked[0], lab[1] - asked[1]), lab[2] - asked[2]));
                }
            }
        }
        double found = lab_distance(&o, asked, &curve);
        print_message("%g %g %g: ΔE*ab %.2f, nearest optimal colour %.2f\n", colors[n][0], colors[n][1],
                      colors[n][2], found, best);
        assert_true(found < best * 1.15 + 1.5);
    }
}

static void strange_numbers_make_a_reflectance_too(void **state)
{
    (void)state;
    static const float colors[][3] = {
        {NAN, 0.5f, 0.5f},  {INFINITY, 0, 0},      {-INFINITY, 1, 1}, {1e30f, 1e30f, 1e30f},
        {-5, -5, -5},       {1e-30f, 0, 1e-38f},   {50, 0, 0},        {1.00001f, 1, 1},
        {1, 1, 0.9999999f}, {1.0001f, 1, 0.9999f}, {-50, 60, -50}};
    struct working_space space;
    working_space_rec709(&space);
    for (size_t n = 0; n < sizeof colors / sizeof *colors; n++) {
        struct rgb_curve curve = rgb_curve_fit(&space, colors[n], NULL);
        for (float l = 300; l <= 830; l += 7) {
            float value = rgb_curve_eval(&curve, l, UV_HOLD);
            assert_true(value >= 0 && value <= 1);
        }
    }
}

static void coefficients_beyond_floats_saturate(void **state)
{
    (void)state;
    struct rgb_curve white = fit_curve(&(struct fit){.p = {0, 0, 1e24}});
    struct rgb_curve black = fit_curve(&(struct fit){.p = {1, 2, -1e24}});
    assert_float_equal(rgb_curve_eval(&white, 500, UV_HOLD), 1, 0);
    assert_float_equal(rgb_curve_eval(&black, 500, UV_HOLD), 0, 0);
}

static void below_360_nm_the_rule_decides(void **state)
{
    (void)state;
    struct working_space space;
    const float red[3] = {0.5f, 0.05f, 0.05f};
    working_space_rec709(&space);
    struct rgb_curve curve = rgb_curve_fit(&space, red, NULL);
    struct spectrum *hold = spectrum_rgb(lambda_range, &space, red, UV_HOLD, NULL);
    struct spectrum *zero = spectrum_rgb(lambda_range, &space, red, UV_ZERO, NULL);
    struct spectrum *extrapolate = spectrum_rgb(lambda_range, &space, red, UV_EXTRAPOLATE, NULL);
    assert_float_equal(spectrum_eval(hold, 300), spectrum_eval(hold, 360), 0);
    assert_float_equal(spectrum_eval(zero, 359.9f), 0, 0);
    assert_float_equal(spectrum_eval(zero, 360), spectrum_eval(hold, 360), 1e-6);
    assert_true(spectrum_eval(extrapolate, 300) >
                0.9); /* the reason for the rule (algorithm.md, section 1) */
    for (float l = 300; l <= 830; l += 0.7f) {
        assert_float_equal(spectrum_eval(hold, l), rgb_curve_eval(&curve, l, UV_HOLD), 1e-4);
        assert_float_equal(spectrum_eval(zero, l), rgb_curve_eval(&curve, l, UV_ZERO), 1e-4);
        assert_float_equal(spectrum_eval(extrapolate, l), rgb_curve_eval(&curve, l, UV_EXTRAPOLATE), 1e-4);
    }
    spectrum_destroy(hold);
    spectrum_destroy(zero);
    spectrum_destroy(extrapolate);
}

/* The table against the colours asked for: interpolation adds its share. */
static void the_table_of_curves_keeps_colours(void **state)
{
    (void)state;
    static struct observer_table o;
    struct working_space space;
    set_observer(&o);
    working_space_rec709(&space);
    struct rgb_table *table = rgb_table_create(&space, 2);
    assert_non_null(table);
    double worst = 0, sum = 0;
    enum { COUNT = 20000 };
    for (uint64_t i = 0; i < COUNT; i++) {
        float rgb[3];
        for (int c = 0; c < 3; c++) { /* even in light, in display values, and near the corners of the cube */
            double u = independent(20 + (uint64_t)c, i);
            rgb[c] = (float)(i % 3 == 0   ? u
                             : i % 3 == 1 ? pow(u, 2.2)
                             : u < 0.5    ? u * u * u
                                          : 1 - (1 - u) * (1 - u) * (1 - u));
        }
        struct rgb_curve curve = rgb_table_lookup(table, rgb);
        double difference = round_trip(&o, &space, rgb, &curve);
        sum += difference;
        worst = fmax(worst, difference);
    }
    print_message("ΔE2000 of the table: mean %.4f, worst %.3f\n", sum / COUNT, worst);
    assert_true(sum / COUNT < 0.1 && worst < 1);
    for (int i = 1; i < 8; i++) { /* the cube's corners are nodes */
        float rgb[3] = {(float)(i & 1), (float)(i >> 1 & 1), (float)(i >> 2)};
        struct rgb_curve curve = rgb_table_lookup(table, rgb);
        assert_true(round_trip(&o, &space, rgb, &curve) < 0.1);
    }
    for (int i = 0; i <= 1000; i++) {
        float grey = (float)i / 1000, rgb[3] = {grey, grey, grey};
        struct rgb_curve curve = rgb_table_lookup(table, rgb);
        for (float l = 300; l <= 830; l += 53)
            assert_float_equal(rgb_curve_eval(&curve, l, UV_HOLD), grey, 1e-3);
    }
    rgb_table_destroy(table);
}

/* Part of Rec.2020's cube is out of reach, and cells there lie beside cells of steep curves. */
static void the_table_of_a_wide_space_keeps_what_is_in_reach(void **state)
{
    (void)state;
    static struct observer_table o;
    static struct fitter fitter;
    struct working_space space;
    set_observer(&o);
    assert_true(working_space_set(&space, rec2020, NULL));
    fitter_set(&fitter, RGB_SIGMOID, &space, 5);
    struct rgb_table *table = rgb_table_create(&space, 2);
    double sum = 0;
    int reached = 0, off = 0;
    for (uint64_t i = 0; i < 4000; i++) {
        float rgb[3];
        for (uint64_t c = 0; c < 3; c++)
            rgb[c] = (float)pow(independent(50 + c, i), i % 2 ? 1 : 2.2);
        struct rgb_curve curve = rgb_table_lookup(table, rgb);
        struct fit direct = fitter_solve(&fitter, (double[3]){rgb[0], rgb[1], rgb[2]});
        if (!fit_reaches(&direct))
            continue;
        double difference = round_trip(&o, &space, rgb, &curve);
        sum += difference;
        off += difference > 2;
        reached++;
    }
    print_message("%d of 4000 in reach, mean ΔE2000 %.3f, %d beyond 2\n", reached, sum / reached, off);
    assert_true(reached > 2000 && sum / reached < 0.2 && off < reached / 100);
    rgb_table_destroy(table);
}

/* Along a path through the cube, 1/4096 a step, no jump: a texture's gradient stays one. */
static void the_table_is_continuous(void **state)
{
    (void)state;
    struct working_space space;
    working_space_rec709(&space);
    struct rgb_table *table = rgb_table_create(&space, 2);
    for (uint64_t path = 0; path < 200; path++) {
        float before[3] = {0};
        for (int i = 0; i <= 4096; i++) {
            float rgb[3], t = (float)i / 4096;
            for (uint64_t c = 0; c < 3; c++)
                rgb[c] = (float)((1 - t) * independent(30 + c, path) + t * independent(40 + c, path));
            struct rgb_curve curve = rgb_table_lookup(table, rgb);
            for (int k = 0; k < 3; k++) {
                float value = rgb_curve_eval(&curve, 440 + 100 * (float)k, UV_HOLD);
                assert_true(i == 0 || fabsf(value - before[k]) < 5e-3);
                before[k] = value;
            }
        }
    }
    rgb_table_destroy(table);
}

static void a_white_that_is_not_d65_keeps_its_chromaticity(void **state)
{
    (void)state;
    static const double whites[][2] = {
        {0.32168, 0.33767}, {0.34567, 0.3585}, {0.314, 0.351}, {1.0 / 3, 1.0 / 3}};
    for (size_t n = 0; n < sizeof whites / sizeof *whites; n++) {
        double x = whites[n][0], y = whites[n][1], m[9] = {0};
        for (int c = 0; c < 3; c++) { /* three primaries about the white */
            double px = x + 0.2 * cos(2.1 * c), py = y + 0.2 * sin(2.1 * c);
            m[c] = px, m[3 + c] = py, m[6 + c] = 1 - px - py;
        }
        struct working_space space;
        assert_true(working_space_set(&space, m, NULL));
        double rgb[3], scaled[9], xyz[3] = {0};
        transform(space.xyz_to_rgb, (double[3]){x / y, 1, (1 - x - y) / y}, rgb);
        for (int i = 0; i < 9; i++)
            scaled[i] = m[i] * rgb[i % 3];
        assert_true(working_space_set(&space, scaled, NULL));
        struct spectrum *s = spectrum_white(lambda_range, &space);
        for (int nm = 360; nm <= 830; nm++) {
            float cmf[3];
            cmf_eval((float)nm, cmf);
            for (int c = 0; c < 3; c++)
                xyz[c] += cmf[c] * spectrum_eval(s, (float)nm);
        }
        assert_float_equal(xyz[0] / (xyz[0] + xyz[1] + xyz[2]), x, 1e-5);
        assert_float_equal(xyz[1] / (xyz[0] + xyz[1] + xyz[2]), y, 1e-5);
        assert_float_equal(spectrum_eval(s, 560), 1, 1e-6);
        assert_true(spectrum_min(s) >= 0);
        struct rgb_curve curve = rgb_curve_fit(&space, (float[3]){1, 1, 1}, NULL);
        assert_float_equal(rgb_curve_eval(&curve, 500, UV_HOLD), 1, 0);
        spectrum_destroy(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_colour_difference_is_ciede2000),
        cmocka_unit_test(every_rec709_colour_comes_back),
        cmocka_unit_test(dark_and_almost_white_colours_come_back),
        cmocka_unit_test(greys_are_constant),
        cmocka_unit_test(what_a_reflectance_reaches_comes_back_in_wide_spaces),
        cmocka_unit_test(what_no_reflectance_reaches_gets_the_nearest),
        cmocka_unit_test(strange_numbers_make_a_reflectance_too),
        cmocka_unit_test(coefficients_beyond_floats_saturate),
        cmocka_unit_test(below_360_nm_the_rule_decides),
        cmocka_unit_test(the_table_of_curves_keeps_colours),
        cmocka_unit_test(the_table_of_a_wide_space_keeps_what_is_in_reach),
        cmocka_unit_test(the_table_is_continuous),
        cmocka_unit_test(a_white_that_is_not_d65_keeps_its_chromaticity),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
