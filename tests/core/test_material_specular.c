/* Mirrors, glass and metal: Fresnel against independent formulae, refraction's n², dispersion, total reflection, adjoints under shading
   normals, and rough surfaces that tend to smooth ones. */
#include <complex.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "material/microfacet.h"
#include "material_kit.h"
#include "statistics.h"

#include <cmocka.h>

#define UP vec3(0, 0, 1)

static struct kit_random seeded(uint32_t seed)
{
    return (struct kit_random){random_path(seed, 0, 0), 0};
}

static struct closure *glass(struct ior ior, float roughness, int lobes)
{
    struct closure *c = kit_bsdf("dielectric");
    c->ior = ior;
    c->value[0] = kit_value(roughness);
    c->option[0] = lobes;
    return c;
}
static struct ior constant(double n)
{
    return (struct ior){IOR_CONSTANT, {n}};
}

/* --- Fresnel ------------------------------------------------------------------------------------------------- */

/* From complex amplitudes, by Snell's law. */
static double amplitudes(double cosine, double complex n)
{
    double complex t = csqrt(1 - (1 - cosine * cosine) / (n * n));
    double complex s = (cosine - n * t) / (cosine + n * t), p = (n * cosine - t) / (n * cosine + t);
    return 0.5 * (creal(s * conj(s)) + creal(p * conj(p)));
}

static void fresnel_is_that_of_complex_amplitudes(void **state)
{
    (void)state;
    struct kit_random r = seeded(31);
    for (int i = 0; i < 10000; i++) {
        float cosine = kit_uniform(&r), n = kit_between(&r, 0.3f, 3), k = kit_between(&r, 0, 6);
        double error = n >= 1 ? 2e-5 : 1e-3; /* near the critical angle the slope is infinite */
        assert_float_equal(fresnel_dielectric(cosine, n), amplitudes(cosine, n), error);
        assert_float_equal(fresnel_conductor(cosine, n, k), amplitudes(cosine, n + I * (double)k), error);
    }
}

/* --- Refraction ------------------------------------------------------------------------------------------------ */

/* Draws the branch that is wanted; false if it has no chance. */
static bool draw(const struct surface *s, enum side side, struct vec3 arriving, float lambda, bool refracts,
                 struct scatter *d)
{
    const float first[4] = {0.5f, 0, 0.5f, 0.5f}, last[4] = {0.5f, 0.99999994f, 0.5f, 0.5f};
    return surface_sample(s, side, arriving, lambda, refracts ? last : first, d) && d->refracts == refracts;
}

static void refraction_obeys_snell_and_scales_radiance_by_n_squared(void **state)
{
    (void)state;
    struct material *m = kit_compile(glass(constant(1.5), 0, 0));
    struct surface s = kit_surface(m, UP, UP);
    struct scatter d;
    for (int inside = 0; inside < 2; inside++)
        for (int side = 0; side < 2; side++) {
            double here = inside ? 1.5 : 1, there = inside ? 1 : 1.5, sine = 0.4;
            struct vec3 arriving = vec3(0.4f, 0, (float)((inside ? -1 : 1) * sqrt(1 - sine * sine)));
            double f = amplitudes(fabsf(arriving.z), there / here),
                   scale = side == SIDE_CAMERA ? here / there : there / here;
            assert_true(draw(&s, (enum side)side, arriving, 500, true, &d));
            assert_float_equal(d.direction.x, -sine * here / there, 1e-6);
            assert_true(d.direction.z * arriving.z < 0);
            assert_float_equal(d.value, (1 - f) * scale * scale, 1e-5);
            /* The camera's density is T; the light's is T (n_c/n_l)² in the measure of the light's direction. */
            assert_float_equal(side == SIDE_CAMERA ? d.pdf : d.pdf_other, 1 - f, 1e-5);
            assert_float_equal(side == SIDE_CAMERA ? d.pdf_other : d.pdf, (1 - f) * scale * scale, 1e-5);
            assert_false(d.disperses);
            assert_true(draw(&s, (enum side)side, arriving, 500, false, &d));
            assert_float_equal(d.value, f, 1e-5);
            assert_float_equal(d.pdf, f, 1e-5);
        }
    material_destroy(m);
}

static void beyond_the_critical_angle_all_is_reflected(void **state)
{
    (void)state;
    for (int lobes = 0; lobes < 3; lobes++) {
        struct material *m = kit_compile(glass(constant(1.5), 0, lobes));
        struct surface s = kit_surface(m, UP, UP);
        struct vec3 arriving = normalize(vec3(0.8f, 0, -0.5f));
        struct scatter d;
        const float u[4] = {0.5f, 0.99f, 0.5f, 0.5f};
        bool drawn = surface_sample(&s, SIDE_LIGHT, arriving, 500, u, &d);
        assert_true(drawn == (lobes != 2)); /* `refract` absorbs what it cannot refract */
        if (drawn) {
            assert_false(d.refracts);
            assert_true(d.value == 1 && d.pdf == 1);
        }
        material_destroy(m);
    }
}

static void a_dispersive_index_bends_blue_more_and_says_so(void **state)
{
    (void)state;
    struct ior flint;
    assert_true(ior_library("SF11", &flint));
    for (int rough = 0; rough < 2; rough++) {
        struct material *m = kit_compile(glass(flint, rough ? 0.2f : 0, 0));
        struct surface s = kit_surface(m, UP, UP);
        struct vec3 arriving = normalize(vec3(0.7f, 0, 0.7f));
        struct scatter blue, red;
        assert_true(draw(&s, SIDE_CAMERA, arriving, 400, true, &blue) &&
                    draw(&s, SIDE_CAMERA, arriving, 700, true, &red));
        assert_true(blue.disperses && red.disperses);
        assert_true(blue.direction.x > red.direction.x + 0.005f);
        struct scatter mirrored;
        assert_true(draw(&s, SIDE_CAMERA, arriving, 400, false, &mirrored));
        assert_false(mirrored.disperses);
        material_destroy(m);
    }
}

static void a_matched_index_lets_light_pass_straight(void **state)
{
    (void)state;
    struct material *m = kit_compile(glass(constant(1), 0.5f, 0));
    struct surface s = kit_surface(m, UP, UP);
    struct vec3 arriving = normalize(vec3(0.7f, 0.2f, 0.4f));
    struct scatter d;
    const float u[4] = {0.5f, 0.5f, 0.5f, 0.5f};
    assert_true(surface_sample(&s, SIDE_CAMERA, arriving, 500, u, &d));
    assert_true(d.label == LABEL_SPECULAR && !d.refracts && d.depth_class == SCATTER_TRANSMISSION);
    assert_float_equal(length(add(d.direction, arriving)), 0, 1e-6);
    assert_float_equal(d.value, 1, 1e-6);
    material_destroy(m);
}

/* --- Shading normals -------------------------------------------------------------------------------------------- */

/* Veach 1997, eq. 5.19: particles take the factor |l·ns||c·ng|/(|l·ng||c·ns|), radiance takes none. */
static void adjoints_differ_by_veachs_factor_under_a_shading_normal(void **state)
{
    (void)state;
    struct kit_random r = seeded(32);
    struct material *m = kit_compile(glass(constant(1.5), 0, 0));
    for (int i = 0; i < 2000; i++) {
        struct vec3 ns = normalize(along(UP, kit_direction(&r), 0.4f)),
                    arriving = kit_direction_about(&r, ns, i & 1);
        struct surface s = kit_surface(m, UP, ns);
        enum side side = i & 2 ? SIDE_CAMERA : SIDE_LIGHT;
        struct scatter d;
        if (!draw(&s, side, arriving, 500, i & 4, &d))
            continue;
        struct vec3 l = side == SIDE_CAMERA ? d.direction : arriving,
                    c = side == SIDE_CAMERA ? arriving : d.direction;
        double nl = dot(l, UP) < 0 ? 1.5 : 1, nc = dot(c, UP) < 0 ? 1.5 : 1;
        double veach = fabs((double)dot(l, ns) * dot(c, UP) / ((double)dot(l, UP) * dot(c, ns)));
        double expected = side == SIDE_CAMERA ? nc * nc / (nl * nl) : veach;
        assert_float_equal(d.value / d.pdf, expected, 2e-4 * expected);
    }
    material_destroy(m);
}

/* --- Rough tends to smooth ---------------------------------------------------------------------------------------- */

/* Mean of value/pdf over the draws that took a branch, and their share. */
static double branch_weight(const struct surface *s, enum side side, struct vec3 arriving, bool refracts,
                            struct kit_random *r, double *share)
{
    double sum = 0;
    int count = 0;
    enum { DRAWS = 40000 };
    for (int n = 0; n < DRAWS; n++) {
        const float u[4] = {kit_uniform(r), kit_uniform(r), kit_uniform(r), kit_uniform(r)};
        struct scatter d;
        if (surface_sample(s, side, arriving, 500, u, &d) && d.refracts == refracts) {
            sum += d.value / d.pdf;
            count++;
        }
    }
    *share = (double)count / DRAWS;
    return sum / count;
}

static void slightly_rough_glass_weighs_as_smooth_glass(void **state)
{
    (void)state;
    struct kit_random r = seeded(33);
    struct material *smooth = kit_compile(glass(constant(1.5), 0, 0)),
                    *rough = kit_compile(glass(constant(1.5), 0.05f, 0));
    struct vec3 ns = normalize(vec3(0.2f, -0.1f, 1));
    for (int i = 0; i < 8; i++) {
        struct vec3 arriving = normalize(vec3(0.3f, 0.3f, i & 1 ? 0.9f : -0.9f));
        enum side side = i & 2 ? SIDE_CAMERA : SIDE_LIGHT;
        bool refracts = i & 4;
        struct surface a = kit_surface(smooth, UP, ns), b = kit_surface(rough, UP, ns);
        struct scatter d;
        double share;
        assert_true(draw(&a, side, arriving, 500, refracts, &d));
        double weight = branch_weight(&b, side, arriving, refracts, &r, &share);
        /* α = 0.0025: weights and chances move by its square and by slopes of that size. */
        assert_float_equal(weight, d.value / d.pdf, 0.01 * d.value / d.pdf);
        double chance = fresnel_dielectric(fabsf(dot(arriving, ns)), arriving.z > 0 ? 1.5f : 1 / 1.5f);
        assert_float_equal(share, refracts ? 1 - chance : chance, 0.01);
    }
    material_destroy(smooth);
    material_destroy(rough);
}

/* --- Metal ------------------------------------------------------------------------------------------------------ */

static void a_mirror_of_metal_reflects_by_fresnel_at_its_wavelength(void **state)
{
    (void)state;
    struct closure *c = kit_bsdf("conductor");
    const float lambda[] = {300, 830}, eta[] = {0.2f, 1.2f}, k[] = {3, 4};
    c->color[0] = kit_table(lambda, eta, 2);
    c->color[1] = kit_table(lambda, k, 2);
    struct material *m = kit_compile(c);
    struct surface s = kit_surface(m, UP, UP);
    struct vec3 arriving = normalize(vec3(0.6f, 0, 0.5f));
    struct scatter d;
    const float u[4] = {0.5f, 0.5f, 0.5f, 0.5f};
    for (float l = 310; l < 830; l += 100) {
        double t = (l - 300) / 530;
        assert_true(surface_sample(&s, SIDE_CAMERA, arriving, l, u, &d));
        assert_float_equal(d.value, amplitudes(arriving.z, 0.2 + t + I * (3 + t)), 1e-5);
        assert_true(d.pdf == 1 && d.pdf_other == 1);
    }
    material_destroy(m);
}

/* Single-scattering GGX loses energy; a fit-free check of the whole chain: with F = 1 the share that is lost at normal incidence for
   α = 1 is 1 − E, E = ∫ D G₂/(4 cos) from a quadrature that samples nothing. */
static void the_albedo_of_white_microfacets_is_that_of_quadrature(void **state)
{
    (void)state;
    struct kit_random r = seeded(34);
    struct closure *c = kit_bsdf("glossy");
    c->color[0] = kit_constant(1);
    c->value[0] = kit_value(0.7f);
    struct material *m = kit_compile(c);
    struct surface s = kit_surface(m, UP, UP);
    for (int i = 0; i < 4; i++) {
        float z = 0.15f + 0.25f * (float)i;
        struct vec3 w = vec3(sqrtf(1 - z * z), 0, z);
        double sum = 0;
        for (int a = 0; a < 400; a++)
            for (int b = 0; b < 400; b++) {
                double lz = (a + 0.5) / 400, phi = M_PI * (b + 0.5) / 200, q = sqrt(1 - lz * lz);
                struct vec3 l = vec3((float)(q * cos(phi)), (float)(q * sin(phi)), (float)lz);
                sum += surface_elastic(&s, l, w, 500) * lz * 2 * M_PI / 160000;
            }
        struct batches drawn = {0};
        for (int n = 0; n < 40; n++) {
            double share, mean = branch_weight(&s, SIDE_CAMERA, w, false, &r, &share) * share;
            batches_add(&drawn, mean);
        }
        assert_true(batches_agree(&drawn, sum, (struct power){.sees_error = 0.005}, 4));
    }
    material_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fresnel_is_that_of_complex_amplitudes),
        cmocka_unit_test(refraction_obeys_snell_and_scales_radiance_by_n_squared),
        cmocka_unit_test(beyond_the_critical_angle_all_is_reflected),
        cmocka_unit_test(a_dispersive_index_bends_blue_more_and_says_so),
        cmocka_unit_test(a_matched_index_lets_light_pass_straight),
        cmocka_unit_test(adjoints_differ_by_veachs_factor_under_a_shading_normal),
        cmocka_unit_test(slightly_rough_glass_weighs_as_smooth_glass),
        cmocka_unit_test(a_mirror_of_metal_reflects_by_fresnel_at_its_wavelength),
        cmocka_unit_test(the_albedo_of_white_microfacets_is_that_of_quadrature),
    };
    return cmocka_run_group_tests_name("material, specular", tests, NULL, NULL);
}
