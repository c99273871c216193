/* Mollification kernels (algorithm.md §3; eqs. 1–28): values, densities and draws against brute force, and what they conserve. */
#include "material/mollified.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "material_kit.h"
#include "statistics.h"

#include <cmocka.h>

#define UP vec3(0, 0, 1)
static const struct vec3 slant = {0.48f, 0.36f, 0.8f};

static struct kit_random seeded(uint32_t seed)
{
    return (struct kit_random){random_path(seed, 0, 0), 0};
}

/* Lambertian dyes, plain surfaces, mixtures and matrices, by tables: everything about them is exact. */
static struct material *exact_material(struct kit_random *r, int i)
{
    const struct bsdf_kind *dye = bsdf_kind_find("fluorescent");
    struct closure *plain;
    switch (i % 4) {
    case 0: return kit_compile(kit_random_bsdf(r, dye, 0));
    case 1:
        plain = kit_random_bsdf(r, bsdf_kind_find("diffuse"), 0);
        plain->value[0]->constant = 0;
        return kit_compile(kit_mix(kit_random_bsdf(r, dye, 0), plain, kit_value(0.4f)));
    case 2: return kit_compile(kit_random_bsdf(r, bsdf_kind_find("reradiation_matrix"), 0));
    default:
        return kit_compile(kit_mix(kit_random_bsdf(r, dye, 0), kit_random_bsdf(r, dye, 0), kit_value(0.3f)));
    }
}

/* π f_elastic(λi→λo) of a surface of Lambert's law, kernel included. */
static double elastic(const struct surface *s, enum kernel k, double in, double out, double d)
{
    return PI_F * (double)kernel_density(k, (float)in, (float)out, (float)d) *
           surface_mollified(s, k, UP, UP, (float)in, (float)out, (float)d);
}

static double fluorescent(const struct surface *s, double in, double out)
{
    double sum = 0;
    for (int f = 0; f < s->fluorescent_count; f++)
        sum += PI_F * (double)surface_fluorescent(s, f, UP, UP, (float)in, (float)out);
    return sum;
}

static double of(const struct surface *s, enum kernel k, enum side side, double from, double to, double d)
{
    return side == SIDE_LIGHT ? elastic(s, k, from, to, d) : elastic(s, k, to, from, d);
}

static void kernels_are_unit_areas_where_they_should_be(void **state)
{
    (void)state;
    static const double d = 40, at = 555;
    for (int k = 0; k < KERNEL_COUNT; k++) {
        double area = 0, mean = 0;
        for (int i = 0; i < 40000; i++) {
            double shift = -100 + 200 * (i + 0.5) / 40000;
            double value =
                kernel_density((enum kernel)k, (float)at, (float)(at + shift), (float)d) * 200 / 40000;
            area += value;
            mean += value * shift;
        }
        assert_float_equal(area, 1, 1e-3);
        assert_float_equal(mean, k == KERNEL_ASYMMETRIC ? d : 0, 0.05);
        assert_true(kernel_name((enum kernel)k));
    }
    assert_true(kernel_density(KERNEL_CONSTANT, 500, 540.1f, 40) == 0);
    assert_true(kernel_density(KERNEL_BOX, 500, 540.1f, 40) == 0);
    assert_true(kernel_density(KERNEL_ASYMMETRIC, 500, 499.9f, 40) == 0);
    assert_true(kernel_density(KERNEL_ASYMMETRIC, 500, 579.9f, 40) > 0);
}

/* f_mb by its definition: the diagonal's g averaged over a square of side d about (λi, λo). */
static void the_box_is_a_filter_in_both_wavelengths(void **state)
{
    (void)state;
    struct kit_random r = seeded(61);
    for (int i = 0; i < 40; i++) {
        struct material *m = exact_material(&r, i);
        struct surface s = kit_surface(m, UP, UP);
        double d = kit_between(&r, 5, 80), in = kit_between(&r, 310, 820),
               out = in + kit_between(&r, -1, 1) * d * 0.999;
        double sum = 0, step = 0.01;
        for (double x = in - d / 2 + step / 2; x < in + d / 2; x += step)
            if (fabs(x - out) < d / 2 && x >= 300 && x <= 830)
                sum += PI_F * (double)surface_elastic(&s, UP, UP, (float)x) * step;
        assert_float_equal(elastic(&s, KERNEL_BOX, in, out, d), sum / (d * d),
                           1e-3 * sum / (d * d) + 2e-2 / (d * d));
        material_destroy(m);
    }
}

static void the_levels_are_those_of_the_equations(void **state)
{
    (void)state;
    struct kit_random r = seeded(62);
    for (int i = 0; i < 50; i++) {
        struct material *m = kit_compile(kit_random_bsdf(&r, bsdf_kind_find("fluorescent"), 0));
        struct surface s = kit_surface(m, UP, UP);
        const struct closure *c = m->closure;
        double d = 30, in = kit_between(&r, 340, 790), out = in + kit_between(&r, -29, 29),
               q = c->value[0]->constant;
        double r_in = spectrum_eval(c->color[0]->spectrum, (float)in),
               r_out = spectrum_eval(c->color[0]->spectrum, (float)out);
        double a_in = spectrum_eval(c->color[1]->spectrum, (float)in),
               a_out = spectrum_eval(c->color[1]->spectrum, (float)out);
        assert_float_equal(elastic(&s, KERNEL_CONSTANT, in, out, d), r_in * (1 - q * a_in) / (2 * d), 1e-7);
        assert_float_equal(elastic(&s, KERNEL_INCIDENT, in, out, d), r_out * (1 - q * a_out) / (2 * d), 1e-7);
        assert_float_equal(elastic(&s, KERNEL_INCIDENT_REFLECTANCE, in, out, d),
                           r_out * (1 - q * a_in) / (2 * d), 1e-7);
        assert_float_equal(elastic(&s, KERNEL_ASYMMETRIC, in, out, d),
                           out >= in ? r_in * (1 - q * a_in) / (2 * d) : 0, 1e-7);
        material_destroy(m);
    }
}

/* What becomes of a reflectance by a texture: of Lambert's law, with or without a dye. */
static struct material *texturable_material(struct kit_random *r, int i)
{
    struct closure *c = kit_random_bsdf(r, bsdf_kind_find(i % 2 ? "fluorescent" : "diffuse"), 0);
    kit_set_roughness(c, 0);
    return kit_compile(c);
}

/* Its colours are curves as a texel's are (shade.c), which have no table, so that integrals are by quadrature. Every third colour is as
   saturated, and its curve as steep, as they come. */
static struct surface textured_surface(struct kit_random *r, const struct material *m, int i)
{
    const float low = i % 3 ? 0.05f : 0.005f, high = i % 3 ? 0.95f : 0.98f;
    float rgb[3] = {low, low, low};
    struct surface s = kit_surface(m, UP, UP);
    rgb[i / 3 % 3] = high;
    for (int c = 0; c < 3 && i % 3; c++)
        rgb[c] = kit_between(r, low, high);
    for (int lobe = 0; lobe < s.lobe_count; lobe++)
        if (s.lobe[lobe].kind->nature == LOBE_FINITE)
            s.lobe[lobe].color[0] =
                (struct spectral_value){.form = SPECTRAL_CURVE,
                                        .uv_rule = UV_HOLD,
                                        .scale = 1,
                                        .curve = rgb_curve_fit(&m->context.working_space, rgb, NULL)};
    return s;
}

/* Strengths, cdfs and densities against sums at small steps. `share` of the strength is what quadrature may err by. */
static void check_integrals(const struct surface *s, enum kernel kernel, enum side side, float from, float d,
                            double share)
{
    enum { STEPS = 8000 };
    double all = mollified_strength(s, kernel, side, UP, from, d), sum = 0, outside = 0;
    double low = from - 2 * d - 1, width = (4 * d + 2) / STEPS;
    /* A sum over steps misses at most one at each edge, of a level of at most 1. */
    double tolerance = share * all + 1e-6 + width / d;
    for (int n = 0; n < STEPS; n++) {
        double to = low + (n + 0.5) * width;
        double value = of(s, kernel, side, from, to, d) * width;
        bool inside = to >= 300 && to <= 830;
        sum += inside ? value : 0;
        outside += inside ? 0 : value;
        if (!inside)
            continue;
        float pdf = mollified_pdf(s, kernel, side, UP, from, (float)to, d);
        assert_float_equal(pdf * all * width, value, 1e-4 * value + 1e-9);
        if (n % 800 == 0)
            assert_float_equal(mollified_cdf(s, kernel, side, UP, from, (float)(to + 0.5 * width), d) * all,
                               sum, tolerance);
    }
    /* What lies outside of Λ is not always known: beyond it nothing is reflected. It belongs to the strength, and is lost. */
    assert_float_equal(sum + outside, all, tolerance);
    assert_float_equal(mollified_cdf(s, kernel, side, UP, from, 900, d) * all, sum, tolerance);
}

/* Wavelengths near the ends of Λ among them. */
static void integrals_in_constant_time_are_those_of_brute_force(void **state)
{
    (void)state;
    struct kit_random r = seeded(63);
    for (int i = 0; i < 30; i++) {
        struct material *m = exact_material(&r, i);
        struct surface s = kit_surface(m, UP, UP);
        float d = kit_between(&r, 3, 90), from = i % 3 ? kit_between(&r, 301, 829) : i % 2 ? 305 : 822;
        for (int k = 0; k < KERNEL_COUNT; k++)
            for (int side = 0; side < 2; side++)
                check_integrals(&s, (enum kernel)k, (enum side)side, from, d, 1e-3);
        material_destroy(m);
    }
}

static void integrals_of_textured_colours_are_nearly_those_of_brute_force(void **state)
{
    (void)state;
    struct kit_random r = seeded(68);
    for (int i = 0; i < 30; i++) {
        struct material *m = texturable_material(&r, i);
        struct surface s = textured_surface(&r, m, i);
        float d = kit_between(&r, 3, 100), from = i % 5 ? kit_between(&r, 380, 780) : i % 2 ? 305 : 822;
        for (int k = 0; k < KERNEL_COUNT; k++)
            for (int side = 0; side < 2; side++)
                check_integrals(&s, (enum kernel)k, (enum side)side, from, d, i % 3 ? 0.01 : 0.02);
        material_destroy(m);
    }
}

static void check_draws(struct kit_random *r, const struct surface *s, enum kernel kernel, enum side side,
                        float from, float d, double false_alarm)
{
    enum { DRAWS = 8000, BINS = 108, STEPS = 50 };
    double observed[BINS] = {0}, expected[BINS] = {0}, total = 0;
    double all = mollified_strength(s, kernel, side, UP, from, d);
    if (!(all > 0))
        return;
    for (int b = 0; b < BINS - 1; b++) {
        for (int n = 0; n < STEPS; n++)
            expected[b] += of(s, kernel, side, from, 300 + 530.0 * (b + (n + 0.5) / STEPS) / (BINS - 1), d);
        expected[b] *= DRAWS / all * 530 / (BINS - 1) / STEPS;
        total += expected[b];
    }
    expected[BINS - 1] = fmax(0, DRAWS - total);
    for (int n = 0; n < DRAWS; n++) {
        float lambda, pdf;
        bool drawn = mollified_sample(s, kernel, side, UP, from, d, kit_uniform(r), &lambda, &pdf);
        observed[drawn ? (int)fminf(BINS - 2, (lambda - 300) / 530 * (BINS - 1)) : BINS - 1]++;
    }
    for (int b = 0; b < BINS; b++)
        expected[b] += 1e-3; /* rounding of the cdfs */
    struct chi2 result = chi2_test(observed, expected, BINS, 0);
    if (result.freedom > 0 && result.p < false_alarm)
        fail_msg("%s, side %d, from %g, d %g: p = %g", kernel_name(kernel), (int)side, (double)from,
                 (double)d, result.p);
}

/* By tables, and in every third case by quadrature. */
static void draws_follow_the_densities_and_the_rest_is_lost(void **state)
{
    (void)state;
    enum { CASES = 12 };
    struct kit_random r = seeded(64);
    for (int i = 0; i < CASES; i++) {
        bool textured = i % 3 == 2;
        struct material *m = textured ? texturable_material(&r, i) : exact_material(&r, i);
        struct surface s = textured ? textured_surface(&r, m, i / 3) : kit_surface(m, UP, UP);
        float d = kit_between(&r, 10, 60), from = i % 3 ? kit_between(&r, 310, 820) : 310;
        for (int k = 0; k < KERNEL_COUNT; k++)
            for (int side = 0; side < 2; side++)
                check_draws(&r, &s, (enum kernel)k, (enum side)side, from, d,
                            sidak(C_FALSE_ALARM, CASES * KERNEL_COUNT * 2));
        material_destroy(m);
    }
}

/* Eqs. 17, 19 and 27 are one: the mollified BBRRDF over its integral. With a matrix it is eq. 28. */
static void all_labels_together_are_the_normalised_bbrrdf(void **state)
{
    (void)state;
    struct kit_random r = seeded(65);
    for (int i = 0; i < 24; i++) {
        struct material *m = exact_material(&r, i);
        struct surface s = kit_surface(m, UP, UP);
        float d = kit_between(&r, 10, 60), from = kit_between(&r, 300 + 2 * d, 830 - 2 * d);
        for (int k = 0; k < KERNEL_COUNT; k++)
            for (int side = 0; side < 2; side++) {
                double sum = 0;
                for (int n = 0; n < 10600; n++) {
                    double to = 300.025 + 0.05 * n;
                    sum +=
                        0.05 * (of(&s, (enum kernel)k, (enum side)side, from, to, d) +
                                (side == SIDE_LIGHT ? fluorescent(&s, from, to) : fluorescent(&s, to, from)));
                }
                for (int n = 0; n < 20; n++) {
                    double to = kit_between(&r, 301, 829);
                    double wanted =
                        (of(&s, (enum kernel)k, (enum side)side, from, to, d) +
                         (side == SIDE_LIGHT ? fluorescent(&s, from, to) : fluorescent(&s, to, from))) /
                        sum;
                    float found =
                        mollified_pdf_of_all(&s, (enum kernel)k, (enum side)side, UP, from, (float)to, d);
                    assert_float_equal(found, wanted, 5e-3 * wanted + 1e-6);
                }
            }
        material_destroy(m);
    }
}

/* Over the kinds of BSDF, tilted light: the density that weights take is the elastic one in the mean, and as d → 0. */
static void densities_for_weights_average_to_the_elastic_one(void **state)
{
    (void)state;
    struct kit_random r = seeded(66);
    for (int kind = 0; bsdf_kind_at((size_t)kind); kind++)
        for (int i = 0; i < 6; i++) {
            struct material *m = kit_compile(kit_random_bsdf(&r, bsdf_kind_at((size_t)kind), 0.3f));
            struct surface s = kit_surface(m, UP, UP);
            float lambda = kit_between(&r, 420, 700), d = kit_between(&r, 5, 50);
            struct vec3 b = normalize(vec3(-0.3f, 0.2f, 0.7f));
            bool exact = true;
            for (int n = 0; n < s.lobe_count; n++)
                exact &= s.lobe[n].kind->nature != LOBE_FINITE || s.lobe[n].kind->terms;
            for (int k = 0; k < KERNEL_COUNT; k++)
                for (int side = 0; side < 2; side++) {
                    float wanted = surface_pdf_elastic(&s, (enum side)side, slant, b, lambda);
                    double mean = 0;
                    for (int n = 0; n < 4000; n++) {
                        float to = lambda - 2 * d + 4 * d * ((float)n + 0.5f) / 4000;
                        float in = side == SIDE_LIGHT ? lambda : to, out = side == SIDE_LIGHT ? to : lambda;
                        mean += surface_pdf_mollified_by(&s, (enum kernel)k, (enum side)side, slant, b,
                                                         lambda, to, d) *
                                kernel_density((enum kernel)k, in, out, d) * 4 * d / 4000;
                    }
                    if (fabs(mean - wanted) > (exact ? 3e-3 : 0.05) * wanted)
                        fail_msg("%s of kind %d, side %d: %g for %g", kernel_name((enum kernel)k), kind, side,
                                 mean, (double)wanted);
                    float near = k == KERNEL_ASYMMETRIC && side == SIDE_CAMERA ? -0.004f : 0.004f;
                    assert_float_equal(surface_pdf_mollified_by(&s, (enum kernel)k, (enum side)side, slant, b,
                                                                lambda, lambda + near, 0.01f),
                                       wanted, 2e-3f * wanted);
                    /* And the value is the elastic one. */
                    assert_float_equal(
                        surface_mollified(&s, (enum kernel)k, slant, b, lambda, lambda + 0.004f, 0.01f),
                        surface_elastic(&s, slant, b, lambda),
                        2e-3f * surface_elastic(&s, slant, b, lambda) + 1e-6);
                }
            material_destroy(m);
        }
}

/* --- What they conserve ---------------------------------------------------------------------------------------- */

/* All that leaves for one unit of energy at λi: energy, or photons per photon (N ∝ E λ). */
static double leaves(const struct surface *s, enum kernel k, double in, double d, bool photons)
{
    double sum = 0;
    for (int n = 0; n < 5300; n++) {
        double out = 300.05 + 0.1 * n;
        sum += 0.1 * (elastic(s, k, in, out, d) + fluorescent(s, in, out)) * (photons ? out / in : 1);
    }
    return sum;
}

static void constant_and_incident_reflectance_make_neither_energy_nor_photons(void **state)
{
    (void)state;
    struct kit_random r = seeded(67);
    for (int i = 0; i < 100; i++) {
        struct material *m = kit_compile(kit_dye(kit_uniform(&r), kit_uniform(&r), kit_between(&r, 320, 700),
                                                 kit_between(&r, 360, 760), kit_between(&r, 0, 1.5f), i & 1));
        struct surface s = kit_surface(m, UP, UP);
        double d = kit_between(&r, 2, 100), in = kit_between(&r, 301, 829);
        for (int k = 0; k < 2; k++) {
            enum kernel kernel = k ? KERNEL_CONSTANT : KERNEL_INCIDENT_REFLECTANCE;
            assert_true(leaves(&s, kernel, in, d, false) < 1 + 2e-3);
            assert_true(leaves(&s, kernel, in, d, true) < 1 + 2e-3);
        }
        material_destroy(m);
    }
}

/* c = Q = 1, a = 1 on [500, 600], r = 1 − a, d = 50, λi = 600. The dye emits at shorter wavelengths, so that photons allow Q = 1. */
static struct material *counterexample(void)
{
    const float lambda[] = {300, 500, 500, 600, 600, 830}, a[] = {0, 0, 1, 1, 0, 0}, r[] = {1, 1, 0, 0, 1, 1};
    struct closure *c = kit_dye(0, 1, 550, 450, 1, true);
    color_node_destroy(c->color[0]);
    color_node_destroy(c->color[1]);
    c->color[0] = kit_table(lambda, r, 6);
    c->color[1] = kit_table(lambda, a, 6);
    return kit_compile(c);
}

static void mollifying_the_whole_diagonal_makes_energy(void **state)
{
    (void)state;
    struct material *m = counterexample();
    struct surface s = kit_surface(m, UP, UP);
    double in = 599.999;
    /* Eq. 6, with its algebra set right: 1/2 + 1. The 2D box does the same, and the other two do not. */
    assert_float_equal(leaves(&s, KERNEL_INCIDENT, in, 50, false), 1.5, 2e-3);
    assert_float_equal(leaves(&s, KERNEL_BOX, in, 50, false), 1.5, 2e-3);
    assert_float_equal(leaves(&s, KERNEL_CONSTANT, in, 50, false), 1, 2e-3);
    assert_float_equal(leaves(&s, KERNEL_INCIDENT_REFLECTANCE, in, 50, false), 1, 2e-3);
    assert_float_equal(mollified_strength(&s, KERNEL_INCIDENT, SIDE_LIGHT, UP, (float)in, 50), 0.5, 1e-3);
    material_destroy(m);
}

/* Eq. 13: a symmetric kernel on a perfect reflector gives as many photons as came; §2.2: an asymmetric one gives more. */
static void only_symmetric_kernels_keep_the_number_of_photons(void **state)
{
    (void)state;
    struct closure *white = kit_bsdf("diffuse");
    white->color[0] = kit_constant(1);
    struct material *m = kit_compile(white);
    struct surface s = kit_surface(m, UP, UP);
    double d = 40, in = 560;
    for (int k = 0; k < KERNEL_COUNT; k++) {
        assert_float_equal(leaves(&s, (enum kernel)k, in, d, false), 1, 2e-3);
        assert_float_equal(leaves(&s, (enum kernel)k, in, d, true), k == KERNEL_ASYMMETRIC ? 1 + d / in : 1,
                           2e-3);
    }
    material_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kernels_are_unit_areas_where_they_should_be),
        cmocka_unit_test(the_box_is_a_filter_in_both_wavelengths),
        cmocka_unit_test(the_levels_are_those_of_the_equations),
        cmocka_unit_test(integrals_in_constant_time_are_those_of_brute_force),
        cmocka_unit_test(integrals_of_textured_colours_are_nearly_those_of_brute_force),
        cmocka_unit_test(draws_follow_the_densities_and_the_rest_is_lost),
        cmocka_unit_test(all_labels_together_are_the_normalised_bbrrdf),
        cmocka_unit_test(densities_for_weights_average_to_the_elastic_one),
        cmocka_unit_test(constant_and_incident_reflectance_make_neither_energy_nor_photons),
        cmocka_unit_test(mollifying_the_whole_diagonal_makes_energy),
        cmocka_unit_test(only_symmetric_kernels_keep_the_number_of_photons),
    };
    return cmocka_run_group_tests_name("material, mollified", tests, NULL, NULL);
}
