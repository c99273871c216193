/* Reradiation matrices as materials: shares, draws and densities in both directions, balances, and what the diagonal holds. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "material_kit.h"
#include "statistics.h"

#include <cmocka.h>

#define UP vec3(0, 0, 1)

static struct kit_random seeded(uint32_t seed)
{
    return (struct kit_random){random_path(seed, 0, 0), 0};
}

static struct closure *closure_of(stokes_matrix *m, bool elastic_diagonal)
{
    struct closure *c = kit_bsdf("reradiation_matrix");
    c->matrix = m;
    c->option[0] = elastic_diagonal;
    return c;
}

static stokes_matrix *bands(double first_in, int in, double first_out, int out, double step)
{
    stokes_error err;
    stokes_matrix *m = reradiation_create(first_in, in, first_out, out, step, "test", &err);
    assert_non_null(m);
    return m;
}

static float *share(stokes_matrix *m, int out, int in)
{
    return &m->share[out * m->count_in + in];
}

/* Twenty bands of 20 nm, 390 to 770; each re-emits a tenth into the next three, and reflects a half. */
static stokes_matrix *staircase(void)
{
    stokes_matrix *m = bands(390, 20, 390, 20, 20);
    for (int in = 0; in < 20; in++) {
        *share(m, in, in) = 0.5f;
        for (int out = in + 1; out < in + 4 && out < 20; out++)
            *share(m, out, in) = 0.1f;
    }
    return m;
}

/* π ∫ f over the outgoing wavelengths of one band. */
static double reradiated(const struct surface *s, float in, double low, double high)
{
    double sum = 0;
    for (int n = 0; n < 100; n++)
        sum += PI_F * surface_fluorescent(s, 0, UP, UP, in, (float)(low + (high - low) * (n + 0.5) / 100));
    return sum * (high - low) / 100;
}

static void each_share_leaves_in_its_band(void **state)
{
    (void)state;
    stokes_matrix *m = staircase(), *kept = reradiation_copy(m);
    struct material *material = kit_compile(closure_of(m, true));
    struct surface s = kit_surface(material, UP, UP);
    for (int in = 0; in < 20; in++)
        for (int n = 0; n < 3; n++) {
            float at = (float)(390 + 20 * in) + (float)(n - 1) * 9.9f;
            assert_float_equal(PI_F * surface_elastic(&s, UP, UP, at), 0.5, 1e-6);
            for (int out = 0; out < 20; out++)
                assert_float_equal(reradiated(&s, at, 380 + 20 * out, 400 + 20 * out),
                                   out == in ? 0 : *share(kept, out, in), 1e-6);
        }
    /* Beyond the measured bands the reflectance is held and nothing is re-emitted. */
    assert_float_equal(PI_F * surface_elastic(&s, UP, UP, 320), 0.5, 1e-6);
    assert_true(surface_fluorescent(&s, 0, UP, UP, 320, 500) == 0);
    assert_true(surface_pdf_emitted(&s, 0, 320, 500) == 0);
    material_destroy(material);
    reradiation_destroy(kept);
}

/* Bands of a separable dye with reflectance 0.4: what is measured of it. */
static stokes_matrix *measured_dye(int count, double step, double *own)
{
    stokes_matrix *m = bands(350, count, 350, count, step);
    for (int in = 0; in < count; in++)
        for (int out = 0; out < count; out++) {
            double a = 350 + in * step, e = 350 + out * step;
            double absorbed = 0.6 * exp(-0.5 * pow((a - 480) / 40, 2));
            double emitted = exp(-0.5 * pow((e - 530) / 30, 2)) / (30 * sqrt(2 * M_PI)) * step;
            *share(m, out, in) = (float)(0.7 * absorbed * emitted);
            if (in == out) {
                own[in] = *share(m, out, in);
                *share(m, out, in) += (float)(0.4 * (1 - absorbed));
            }
        }
    return m;
}

static void the_diagonal_is_told_apart_by_its_neighbours(void **state)
{
    (void)state;
    enum { COUNT = 40 };
    double own[COUNT], most = 0, worst = 0;
    struct material *material = kit_compile(closure_of(measured_dye(COUNT, 10, own), false));
    struct surface s = kit_surface(material, UP, UP);
    for (int in = 0; in < COUNT; in++) {
        float at = (float)(350 + 10 * in);
        double found = reradiated(&s, at, at - 5, at + 5);
        most = fmax(most, own[in]);
        worst = fmax(worst, fabs(found - own[in]));
        /* Neither is lost: together they are what was measured. */
        double absorbed = 0.6 * exp(-0.5 * pow((at - 480) / 40, 2));
        assert_float_equal(found + PI_F * surface_elastic(&s, UP, UP, at), own[in] + 0.4 * (1 - absorbed),
                           1e-5);
    }
    /* Second order: of a Gaussian of 30 nm in bands of 10 nm, (10/30)²/4 of its peak at most. */
    assert_true(worst < most * 0.028);
    assert_true(most > 0.02);
    material_destroy(material);
}

static void draws_follow_the_density_that_depends_on_both_wavelengths(void **state)
{
    (void)state;
    enum { CASES = 24, DRAWS = 40000, BINS = 265 };
    struct kit_random r = seeded(31);
    for (int i = 0; i < CASES; i++) {
        struct material *material = kit_compile(closure_of(kit_matrix(&r), i & 2));
        struct surface s = kit_surface(material, UP, UP);
        const struct fluorophore *f = material->lobe[0].fluorophore;
        enum side side = i & 1 ? SIDE_CAMERA : SIDE_LIGHT;
        float unused, given = spectrum_sample(side == SIDE_LIGHT ? f->reradiation : f->emission,
                                              kit_uniform(&r), &unused);
        double observed[BINS] = {0}, expected[BINS] = {0};
        for (int b = 0; b < BINS; b++)
            for (int n = 0; n < 50; n++) {
                float at = 300 + 2 * ((float)b + ((float)n + 0.5f) / 50);
                expected[b] += (side == SIDE_LIGHT ? surface_pdf_emitted(&s, 0, given, at)
                                                   : surface_pdf_absorbed(&s, 0, at, given)) *
                               2 / 50 * DRAWS;
            }
        for (int n = 0; n < DRAWS; n++) {
            float pdf, at = surface_sample_lambda(&s, side, 0, given, kit_uniform(&r), &pdf);
            assert_true(pdf == surface_pdf_lambda(&s, side, 0, given, at));
            assert_true(at >= 300 && at <= 830 && pdf > 0);
            observed[(int)((at - 300) / 2)]++;
        }
        struct chi2 result = chi2_test(observed, expected, BINS, 0);
        assert_true(result.p > sidak(C_FALSE_ALARM, CASES));
        assert_true(result.freedom > 20);
        material_destroy(material);
    }
}

/* What goes from λi to λo is the same whichever side draws it: strength × density is the value, on both. */
static void both_sides_densities_belong_to_one_value(void **state)
{
    (void)state;
    struct kit_random r = seeded(32);
    for (int i = 0; i < 200; i++) {
        struct material *material = kit_compile(i & 1 ? closure_of(kit_matrix(&r), false)
                                                      : kit_dye(0.5f, 0.8f, 420, 520, 0.9, false));
        struct surface s = kit_surface(material, UP, UP);
        const struct fluorophore *f = material->lobe[0].fluorophore;
        for (int n = 0; n < 50; n++) {
            float in = kit_between(&r, 300, 830), out = kit_between(&r, 300, 830);
            double value = fluorophore_value(f, in, out);
            double from_light =
                (double)fluorophore_strength(f, SIDE_LIGHT, in) * surface_pdf_emitted(&s, 0, in, out);
            double from_camera =
                (double)fluorophore_strength(f, SIDE_CAMERA, out) * surface_pdf_absorbed(&s, 0, in, out);
            assert_float_equal(from_light, value, 1e-5 * value + 1e-12);
            assert_float_equal(from_camera, value, 1e-5 * value + 1e-12);
            /* The marginals are positive wherever the value is. */
            if (value > 0) {
                assert_true(spectrum_eval(surface_fluorescent_emission(&s, 0), out) > 0);
                assert_true(spectrum_eval(surface_fluorescent_absorption(&s, 0), in) > 0);
            }
        }
        assert_float_equal(spectrum_integral(f->emission), 1, 1e-4);
        material_destroy(material);
    }
}

static void the_scenes_densities_are_those_of_its_surfaces(void **state)
{
    (void)state;
    struct kit_random r = seeded(33);
    struct material *material = kit_compile(kit_mix(kit_dye(0.5f, 0.8f, 420, 520, 0.9, false),
                                                    closure_of(kit_matrix(&r), false), kit_value(0.5f)));
    struct surface s = kit_surface(material, UP, UP);
    assert_int_equal(material_fluorophore_count(material), 2);
    for (int f = 0; f < 2; f++)
        for (int n = 0; n < 100; n++) {
            float in = kit_between(&r, 300, 830), out = kit_between(&r, 300, 830);
            assert_true(material_fluorophore_pdf(material, f, SIDE_LIGHT, in, out) ==
                        surface_pdf_emitted(&s, f, in, out));
            assert_true(material_fluorophore_pdf(material, f, SIDE_CAMERA, in, out) ==
                        surface_pdf_absorbed(&s, f, in, out));
        }
    material_destroy(material);
}

/* Of light of one wavelength: what leaves, as energy or as photons. Exact: everything is constant within bands. */
static double balance(const struct surface *s, const struct fluorophore *f, float in, bool photons)
{
    double sum = PI_F * surface_elastic(s, UP, UP, in);
    for (int n = 0; f && n < 5300; n++) {
        float out = 300 + 0.1f * ((float)n + 0.5f);
        sum += 0.1 * fluorophore_value(f, in, out) * (photons ? out / in : 1);
    }
    return sum;
}

static void neither_energy_nor_photons_are_made(void **state)
{
    (void)state;
    struct kit_random r = seeded(34);
    int warned = 0, binding = 0;
    for (int i = 0; i < 100; i++) {
        int warnings = 0;
        struct material *material = kit_try_compile(closure_of(kit_matrix(&r), i & 1), &warnings, NULL);
        struct surface s = kit_surface(material, UP, UP);
        warned += warnings > 0;
        for (int n = 0; n < 10; n++) {
            float in = kit_between(&r, 301, 829);
            double photons = balance(&s, material->lobe[0].fluorophore, in, true);
            assert_true(balance(&s, material->lobe[0].fluorophore, in, false) < 1 + 1e-4);
            assert_true(photons < 1 + 1e-3);
            binding += photons > 0.97;
        }
        material_destroy(material);
    }
    assert_true(warned > 50);
    assert_true(binding > 10);
}

static void what_is_cut_is_said(void **state)
{
    (void)state;
    stokes_matrix *m = staircase();
    int warnings = 0;
    stokes_error err = {0};
    struct material *material = kit_try_compile(closure_of(m, true), &warnings, &err);
    assert_int_equal(warnings, 0);
    material_destroy(material);

    m = staircase();
    *share(m, 5, 5) = 0.95f;
    material = kit_try_compile(closure_of(m, true), &warnings, &err);
    assert_int_equal(warnings, 1);
    struct surface s = kit_surface(material, UP, UP);
    /* 0.05 is left for three tenths of the energy; photons of up to 550 nm for ones of 480 nm leave less. */
    double mean = (510 + 530 + 550) / 3.0;
    assert_float_equal(reradiated(&s, 490, 500, 520) * 3, 0.05 * 480 / mean, 1e-5);
    material_destroy(material);
}

static void a_matrix_is_wanted(void **state)
{
    (void)state;
    stokes_error err = {0};
    assert_null(kit_try_compile(kit_bsdf("reradiation_matrix"), NULL, &err));
    assert_string_equal(err.property, "matrix");
    assert_null(reradiation_create(300, 10, 305, 10, 10, "test", &err)); /* not on one grid */
    assert_null(reradiation_create(300, 0, 300, 10, 10, "test", &err));
    assert_null(reradiation_create(300, 10, 300, 100000, 10, "test", &err));
    assert_null(reradiation_create(300, 10, 300, 10, NAN, "test", &err));
    assert_null(reradiation_create(-INFINITY, 10, 300, 10, 10, "test", &err));
}

/* Odd places in Λ: all of it outside, one band, a band cut by either end. */
static void bands_may_lie_anywhere(void **state)
{
    (void)state;
    static const double first[] = {100, 200, 285, 290, 295.3, 800, 826, 835, 900};
    for (size_t i = 0; i < sizeof first / sizeof *first; i++)
        for (int in = 1; in < 5; in++)
            for (int out = 1; out < 5; out++) {
                stokes_matrix *m = bands(first[i], in, first[i] + 10, out, 10);
                for (int k = 0; k < in * out; k++)
                    m->share[k] = 0.1f;
                struct material *material = kit_compile(closure_of(m, false));
                struct surface s = kit_surface(material, UP, UP);
                for (float l = 300; l <= 830; l += 0.5f)
                    for (int f = 0; f < s.fluorescent_count; f++)
                        for (int side = 0; side < 2; side++) {
                            const struct fluorophore *dye = material->lobe[0].fluorophore;
                            float pdf, at = fluorophore_sample(dye, (enum side)side, l, 0.999999f, &pdf);
                            assert_true(pdf == 0 || (at >= 300 && at <= 830 &&
                                                     pdf == fluorophore_pdf(dye, (enum side)side, l, at)));
                        }
                material_destroy(material);
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_share_leaves_in_its_band),
        cmocka_unit_test(the_diagonal_is_told_apart_by_its_neighbours),
        cmocka_unit_test(draws_follow_the_density_that_depends_on_both_wavelengths),
        cmocka_unit_test(both_sides_densities_belong_to_one_value),
        cmocka_unit_test(the_scenes_densities_are_those_of_its_surfaces),
        cmocka_unit_test(neither_energy_nor_photons_are_made),
        cmocka_unit_test(what_is_cut_is_said),
        cmocka_unit_test(a_matrix_is_wanted),
        cmocka_unit_test(bands_may_lie_anywhere),
    };
    return cmocka_run_group_tests_name("material, matrices", tests, NULL, NULL);
}
