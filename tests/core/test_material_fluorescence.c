/* Fluorescent surfaces: the labels' chances (algorithm.md §4), yields, and balances that must hold to the last digit. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "material_kit.h"
#include "statistics.h"

#include <cmocka.h>

#define UP vec3(0, 0, 1)

static struct kit_random seeded(uint32_t seed)
{
    return (struct kit_random){random_path(seed, 0, 0), 0};
}

/* Chance of a fluorescent label: its density over the wavelength's and the direction's. */
static double label_chance(const struct surface *s, enum side side, int f, float lambda)
{
    const struct spectrum *drawn =
        side == SIDE_CAMERA ? surface_fluorescent_absorption(s, f) : surface_fluorescent_emission(s, f);
    struct vec3 w = normalize(vec3(0.3f, 0.2f, 0.9f));
    float pdf, at = spectrum_sample(drawn, 0.4f, &pdf);
    return surface_pdf_fluorescent(s, side, f, w, w, lambda, at) * (double)PI_F / pdf;
}

static void chances_are_those_of_the_paper_clamped(void **state)
{
    (void)state;
    struct material *m = kit_compile(kit_dye(0.6f, 0.7f, 420, 520, 0.8, false));
    struct surface s = kit_surface(m, UP, UP);
    const struct fluorophore *dye = m->lobe[0].fluorophore;
    for (float l = 301; l < 830; l += 7) {
        double elastic = 0.6 * (1 - 0.7 * spectrum_eval(dye->absorption, l));
        double camera = 0.7 * spectrum_eval(dye->emission, l) * dye->strength;
        double light = 0.7 * spectrum_eval(dye->reradiation, l);
        double p_camera = fmin(FLUORESCENT_CHANCE_MAX, camera / (camera + elastic));
        double p_light = fmin(FLUORESCENT_CHANCE_MAX, light / (light + elastic));
        assert_float_equal(label_chance(&s, SIDE_CAMERA, 0, l), p_camera, 1e-5);
        assert_float_equal(label_chance(&s, SIDE_LIGHT, 0, l), p_light, 1e-5);
        assert_float_equal(surface_pdf_elastic(&s, SIDE_CAMERA, UP, UP, l) * PI_F, 1 - p_camera, 1e-5);
        assert_float_equal(surface_pdf_elastic(&s, SIDE_LIGHT, UP, UP, l) * PI_F, 1 - p_light, 1e-5);
    }
    material_destroy(m);
}

static void a_total_absorber_is_clamped_if_anything_else_can_happen(void **state)
{
    (void)state;
    /* c·a = 1 in a band: the elastic part is 0 there, and not elsewhere. */
    const float lambda[] = {300, 400, 400, 830}, one_then_none[] = {1, 1, 0, 0};
    struct closure *c = kit_dye(0.5f, 1, 400, 520, 1, false);
    color_node_destroy(c->color[1]);
    c->color[1] = kit_table(lambda, one_then_none, 4);
    struct material *m = kit_compile(c);
    struct surface s = kit_surface(m, UP, UP);
    assert_float_equal(label_chance(&s, SIDE_LIGHT, 0, 350), FLUORESCENT_CHANCE_MAX, 1e-6);
    material_destroy(m);

    /* Without any elastic part it is certain. */
    c = kit_dye(0, 1, 400, 520, 1, false);
    m = kit_compile(c);
    s = kit_surface(m, UP, UP);
    assert_false(s.has_elastic);
    assert_true(s.connects);
    assert_float_equal(label_chance(&s, SIDE_LIGHT, 0, 400), 1, 1e-6);
    assert_float_equal(label_chance(&s, SIDE_CAMERA, 0, 520), 1, 1e-6);
    material_destroy(m);

    /* A specular part counts as elastic. */
    struct closure *glass = kit_bsdf("dielectric");
    glass->ior = (struct ior){IOR_CONSTANT, {1.5}};
    m = kit_compile(kit_mix(kit_dye(0, 1, 400, 520, 1, false), glass, kit_value(0.01f)));
    s = kit_surface(m, UP, UP);
    assert_float_equal(label_chance(&s, SIDE_LIGHT, 0, 400), FLUORESCENT_CHANCE_MAX, 1e-6);
    material_destroy(m);
}

static void two_dyes_share_in_proportion(void **state)
{
    (void)state;
    struct material *m = kit_compile(kit_mix(kit_dye(0.5f, 0.4f, 400, 520, 0.9, false),
                                             kit_dye(0.3f, 0.8f, 450, 600, 0.6, true), kit_value(0.3f)));
    struct surface s = kit_surface(m, UP, UP);
    assert_int_equal(s.fluorescent_count, 2);
    assert_int_equal(material_fluorophore_count(m), 2);
    for (float l = 350; l < 700; l += 11) {
        double strength[2], elastic = 0;
        for (int f = 0; f < 2; f++) {
            const struct fluorophore *dye = m->lobe[2 * f].fluorophore;
            double weight = f ? 0.3 : 0.7, c = f ? 0.8 : 0.4, r = f ? 0.3 : 0.5;
            strength[f] = weight * c * spectrum_eval(dye->emission, l) * dye->strength;
            elastic += weight * r * (1 - c * spectrum_eval(dye->absorption, l));
        }
        double total = strength[0] + strength[1], p = fmin(FLUORESCENT_CHANCE_MAX, total / (total + elastic));
        for (int f = 0; f < 2; f++)
            assert_float_equal(label_chance(&s, SIDE_CAMERA, f, l), total > 0 ? p * strength[f] / total : 0,
                               1e-5);
    }
    material_set_fluorophores(m, 5);
    assert_int_equal(surface_fluorophore(&s, 1), 6);
    assert_true(material_fluorophore_emission(m, 1) == surface_fluorescent_emission(&s, 1));
    material_destroy(m);
}

static void labels_are_drawn_with_their_chances(void **state)
{
    (void)state;
    enum { DRAWS = 40000, CASES = 12 };
    struct kit_random r = seeded(21);
    for (int i = 0; i < CASES; i++) {
        struct closure *glass = kit_bsdf("dielectric"),
                       *dye = kit_dye(0.5f, kit_uniform(&r), 420, 520, 1, false);
        glass->ior = (struct ior){IOR_CONSTANT, {1.5}};
        struct material *m = kit_compile(kit_mix(dye, glass, kit_value(kit_between(&r, 0.1f, 0.9f))));
        struct surface s = kit_surface(m, UP, UP);
        enum side side = i & 1 ? SIDE_CAMERA : SIDE_LIGHT;
        float lambda = kit_between(&r, 380, 560);
        double observed[3] = {0}, expected[3];
        expected[LABEL_ELASTIC] = surface_pdf_elastic(&s, side, UP, UP, lambda) * PI_F;
        expected[LABEL_FLUORESCENT] = label_chance(&s, side, 0, lambda);
        expected[LABEL_SPECULAR] = 1 - expected[LABEL_ELASTIC] - expected[LABEL_FLUORESCENT];
        for (int n = 0; n < DRAWS; n++) {
            const float u[4] = {kit_uniform(&r), kit_uniform(&r), kit_uniform(&r), kit_uniform(&r)};
            struct scatter d;
            assert_true(surface_sample(&s, side, UP, lambda, u, &d));
            observed[d.label]++;
        }
        for (int k = 0; k < 3; k++)
            expected[k] *= DRAWS;
        struct chi2 result = chi2_test(observed, expected, 3, 0);
        assert_true(result.p > sidak(C_FALSE_ALARM, CASES));
        material_destroy(m);
    }
}

/* ∫∫ of the whole reradiation from λi, by the public functions, times λo/λi if photons are asked for. Directions are Lambert's. */
static double balance(const struct material *m, float in, bool photons)
{
    struct surface s = kit_surface(m, UP, UP);
    double sum = PI_F * surface_elastic(&s, UP, UP, in);
    for (int f = 0; f < s.fluorescent_count; f++)
        for (int i = 0; i < 1060; i++) {
            float out = 300 + 0.5f * ((float)i + 0.5f);
            sum += 0.5 * PI_F * surface_fluorescent(&s, f, UP, UP, in, out) * (photons ? out / in : 1);
        }
    return sum;
}

static void energy_and_photons_balance_over_random_dyes(void **state)
{
    (void)state;
    struct kit_random r = seeded(22);
    for (int i = 0; i < 1000; i++) {
        /* Yields up to 1.5 and emission below the absorption's wavelength ask for the clamp of §2. */
        struct closure *c = kit_dye(kit_uniform(&r), kit_uniform(&r), kit_between(&r, 320, 700),
                                    kit_between(&r, 360, 760), kit_between(&r, 0, 1.5f), i & 1);
        struct material *m = kit_compile(c);
        for (int n = 0; n < 3; n++) {
            float in = kit_between(&r, 301, 829);
            assert_true(balance(m, in, false) <= 1 + 1e-5);
            assert_true(balance(m, in, true) <= 1 + 1e-4);
        }
        material_destroy(m);
    }
}

static void an_unclamped_yield_would_make_photons(void **state)
{
    (void)state;
    /* Energy yield 1 from 400 to 520 nm is 1.3 photons for one: the bound must have cut it, and said so. */
    int warnings = 0;
    struct material *m = kit_try_compile(kit_dye(0, 1, 400, 520, 1, true), &warnings, NULL);
    double cut = m->lobe[0].fluorophore->strength / spectrum_integral(m->lobe[0].fluorophore->absorption);
    assert_int_equal(warnings, 1);
    assert_true(cut < 0.8 && cut > 0.7);
    assert_true(balance(m, 400, true) > 0.9);
    material_destroy(m);
}

static void a_quantum_yield_is_a_share_of_photons(void **state)
{
    (void)state;
    int warnings = 0;
    struct material *m = kit_try_compile(kit_dye(0, 1, 420, 560, 0.5, false), &warnings, NULL);
    double absorbed = spectrum_eval(m->lobe[0].fluorophore->absorption, 430);
    assert_int_equal(warnings, 0);
    assert_float_equal(balance(m, 430, true) / absorbed, 0.5, 1e-3);
    material_destroy(m);

    m = kit_compile(kit_dye(0, 1, 420, 560, 0.5, true));
    absorbed = spectrum_eval(m->lobe[0].fluorophore->absorption, 430);
    assert_float_equal(balance(m, 430, false) / absorbed, 0.5, 1e-3);
    material_destroy(m);
}

static void emission_is_normalised_whatever_its_peak(void **state)
{
    (void)state;
    struct closure *c = kit_dye(0.5f, 1, 420, 560, 1, false);
    color_node_destroy(c->color[2]);
    c->color[2] = kit_gaussian(560, 25, 37);
    struct material *m = kit_compile(c);
    assert_float_equal(spectrum_integral(m->lobe[0].fluorophore->emission), 1, 1e-5);
    material_destroy(m);
}

/* The back of a sheet fluoresces as its front does, and nothing passes through. */
static void both_faces_reflect_and_nothing_passes(void **state)
{
    (void)state;
    struct material *m = kit_compile(kit_dye(0.5f, 0.5f, 420, 560, 1, false));
    struct surface s = kit_surface(m, UP, UP);
    struct vec3 down = vec3(0, 0, -1);
    assert_true(surface_fluorescent(&s, 0, down, down, 420, 560) ==
                surface_fluorescent(&s, 0, UP, UP, 420, 560));
    assert_true(surface_elastic(&s, down, down, 420) == surface_elastic(&s, UP, UP, 420));
    assert_true(surface_fluorescent(&s, 0, down, UP, 420, 560) == 0);
    assert_true(surface_elastic(&s, down, UP, 420) == 0);
    assert_true(surface_pdf_fluorescent(&s, SIDE_LIGHT, 0, down, UP, 420, 560) == 0);
    material_destroy(m);
}

static void values_carry_the_shading_normals_factor(void **state)
{
    (void)state;
    struct material *m = kit_compile(kit_dye(0.5f, 0.5f, 420, 560, 1, false));
    struct vec3 ns = normalize(vec3(0.3f, 0.1f, 0.9f)), light = normalize(vec3(-0.4f, 0.2f, 0.6f));
    struct surface s = kit_surface(m, UP, ns);
    const struct fluorophore *dye = m->lobe[0].fluorophore;
    double expected = 0.5 / PI_F * spectrum_eval(dye->reradiation, 430) * spectrum_eval(dye->emission, 570);
    assert_float_equal(
        surface_fluorescent(&s, 0, light, UP, 430, 570) / (expected * dot(light, ns) / light.z), 1, 1e-5);
    assert_float_equal(surface_fluorescent(&s, 0, UP, light, 430, 570) / (expected * ns.z), 1, 1e-5);
    material_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chances_are_those_of_the_paper_clamped),
        cmocka_unit_test(a_total_absorber_is_clamped_if_anything_else_can_happen),
        cmocka_unit_test(two_dyes_share_in_proportion),
        cmocka_unit_test(labels_are_drawn_with_their_chances),
        cmocka_unit_test(energy_and_photons_balance_over_random_dyes),
        cmocka_unit_test(an_unclamped_yield_would_make_photons),
        cmocka_unit_test(a_quantum_yield_is_a_share_of_photons),
        cmocka_unit_test(emission_is_normalised_whatever_its_peak),
        cmocka_unit_test(both_faces_reflect_and_nothing_passes),
        cmocka_unit_test(values_carry_the_shading_normals_factor),
    };
    return cmocka_run_group_tests_name("material, fluorescence", tests, NULL, NULL);
}
