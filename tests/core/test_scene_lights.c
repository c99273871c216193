/* Lights as emitters: every kind's densities integrate to 1 and are those that are drawn from, and powers are
   the ones that physics gives. Measures as in scene.h. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include "lamps.h"
#include "statistics.h"

#include <cmocka.h>

/* Estimators without variance are held against rounding (of sums of DRAWS floats), the others against
   statistics. */
static void assert_estimates(const struct batches *found, const double *exact, size_t count,
                             struct power power)
{
    struct batches noisy[LAMPS];
    double exact_noisy[LAMPS];
    size_t noisy_count = 0;
    for (size_t i = 0; i < count; i++)
        if (batches_error(&found[i]) > 1e-5 * exact[i]) {
            noisy[noisy_count] = found[i];
            exact_noisy[noisy_count++] = exact[i];
        } else {
            assert_float_equal(found[i].mean / exact[i], 1, 1e-5);
        }
    if (noisy_count)
        assert_unbiased(noisy, exact_noisy, noisy_count, power);
}

static void densities_are_those_that_are_drawn_from(void **state)
{
    (void)state;
    for (size_t k = 0; k < LAMPS; k++) {
        struct scene *scene = lamps[k].make();
        assert_int_equal(scene_light_count(scene), 1);
        for (uint64_t i = 0; i < 2000; i++) {
            float u[6], pdf_point, pdf_direction, pdf_lambda;
            struct light_point point;
            struct vec3 origin, direction;
            lamps_draw(k, i, u, 6);
            assert_true(scene_sample_light(scene, u, &point, &pdf_point));
            assert_float_equal(scene_pdf_light(scene, &point) / pdf_point, 1, 1e-5);
            if (lamps[k].area > 0)
                assert_float_equal(pdf_point * lamps[k].area, 1, 1e-4);
            float lambda = scene_sample_light_lambda(scene, &point, u[5], &pdf_lambda);
            assert_float_equal(scene_pdf_light_lambda(scene, &point, lambda) / pdf_lambda, 1, 1e-5);
            if (!scene_sample_light_direction(scene, &point, u + 3, &origin, &direction, &pdf_direction))
                continue;
            assert_float_equal(scene_pdf_light_direction(scene, &point, direction) / pdf_direction, 1, 1e-5);
            assert_float_equal(length(direction), 1, 1e-5);
        }
        scene_destroy(scene);
    }
}

/* E[1/pdf over a set drawn otherwise]: directions uniform on the sphere, so ∫ pdf · cos dω = 4π E[pdf · cos]. */
static void direction_densities_integrate_to_one(void **state)
{
    (void)state;
    struct batches found[LAMPS] = {0};
    double exact[LAMPS];
    size_t count = 0;
    for (size_t k = 0; k < LAMPS; k++) {
        struct scene *scene = lamps[k].make();
        for (uint64_t b = 0; lamps[k].power > 0 && b < BATCHES; b++) {
            double sum = 0;
            for (uint64_t i = 0; i < DRAWS; i++) {
                float u[3], pdf;
                struct light_point point;
                struct vec3 direction = scenes_direction(200 + k, b * DRAWS + i);
                lamps_draw(300 + k, b * DRAWS + i, u, 3);
                scene_sample_light(scene, u, &point, &pdf);
                sum += scene_pdf_light_direction(scene, &point, direction) *
                       (point.has_normal ? fabsf(dot(direction, point.normal)) : 1);
            }
            batches_add(&found[count], 4 * M_PI * sum / DRAWS);
        }
        if (lamps[k].power > 0)
            /* half of the sphere's points cannot face a narrow cone's directions, which then are not drawn */
            exact[count++] = strcmp(lamps[k].name, "spot with a radius") == 0 ? 0.5 : 1;
        scene_destroy(scene);
    }
    assert_estimates(found, exact, count, (struct power){.sees_error = 0.08});
}

/* ∫ of emission, times a function that is not even in any direction, by drawn directions and by uniform ones. */
static void directions_are_drawn_with_their_density(void **state)
{
    (void)state;
    static struct scene *(*const make[])(void) = {lamps_make_rectangle,      lamps_make_spot,
                                                  lamps_make_stretched_spot, lamps_make_point,
                                                  lamps_make_two_sided_mesh, lamps_make_one_sided_mesh};
    enum { KINDS = sizeof make / sizeof *make };
    struct batches drawn[KINDS] = {0}, uniform[KINDS] = {0};
    for (size_t k = 0; k < KINDS; k++) {
        struct scene *scene = make[k]();
        for (uint64_t b = 0; b < BATCHES; b++) {
            double by_density = 0, by_all = 0;
            for (uint64_t i = 0; i < DRAWS; i++) {
                float u[5], pdf;
                struct light_point point;
                struct vec3 origin, d, all = scenes_direction(1000 + k, b * DRAWS + i);
                lamps_draw(1100 + k, b * DRAWS + i, u, 5);
                scene_sample_light(scene, u, &point, &pdf);
                if (scene_sample_light_direction(scene, &point, u + 3, &origin, &d, &pdf)) {
                    float cosine = point.has_normal ? fabsf(dot(d, point.normal)) : 1;
                    by_density += (1 + 0.5f * d.x - 0.3f * d.y + cosine) *
                                  scene_light_emission(scene, &point, d, LAMBDA) / pdf;
                }
                float cosine = point.has_normal ? fabsf(dot(all, point.normal)) : 1;
                by_all += (1 + 0.5f * all.x - 0.3f * all.y + cosine) * 4 * PI_F *
                          (point.has_normal ? cosine : 1) * scene_light_emission(scene, &point, all, LAMBDA);
            }
            batches_add(&drawn[k], by_density / DRAWS);
            batches_add(&uniform[k], by_all / DRAWS);
        }
        scene_destroy(scene);
    }
    assert_same(drawn, uniform, KINDS, (struct power){.sees_error = 0.1});
}

/* Cycles' smoothstep between the cone's rim and the cosine that `blend` says, for a cone of half-angle 0.6
   and blend 0.3. */
static void spots_fall_off_between_rim_and_blend(void **state)
{
    (void)state;
    struct scene *scene = lamps_make_spot();
    struct transform t = lamps_tilted(1);
    float u[3] = {0}, pdf;
    struct light_point point;
    assert_true(scene_sample_light(scene, u, &point, &pdf));
    static const struct {
        double part, value; /* of the way from the rim to the axis, in cosine */
    } steps[] = {{-0.01, 0},  {0.003, 0.0003 - 2e-6}, {0.075, 0.15625},
                 {0.15, 0.5}, {0.225, 0.84375},       {0.31, 1},
                 {0.99, 1}};
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        double z = cos(0.6) + steps[i].part * (1 - cos(0.6)), r = sqrt(1 - z * z);
        for (float phi = 0; phi < 6; phi += 1) {
            struct vec3 local = vec3((float)r * cosf(phi), (float)r * sinf(phi), (float)-z);
            assert_float_equal(scene_light_emission(scene, &point, transform_vector(&t, local), LAMBDA) /
                                   PER_NM,
                               steps[i].value, 2e-5);
        }
    }
    scene_destroy(scene);
}

/* Beside a lamp of known power, a light is chosen by its own; a distant light's falls on the cross-section of
   the scene. */
static void lights_are_chosen_by_the_power_that_physics_gives(void **state)
{
    (void)state;
    for (size_t k = 0; k < LAMPS; k++) {
        if (lamps[k].area == 0)
            continue;
        struct scene *scene = lamps[k].make();
        struct vec3 center;
        float radius;
        scenes_light(scene, (struct light_input){.name = "~",
                                                 .shape = LIGHT_POINT,
                                                 .transform = scenes_identity,
                                                 .emission = scenes_emission(PER_NM)});
        scenes_commit(scene);
        scene_bounds(scene, &center, &radius);
        double section = M_PI * radius * radius,
               of_world = lamps[k].make == lamps_make_constant_world ? 4 * M_PI : 1;
        double power = lamps[k].power > 0 ? lamps[k].power : section * of_world;
        for (uint64_t i = 0; i < 200; i++) {
            float u[3], pdf;
            struct light_point point;
            lamps_draw(150, i, u, 3);
            assert_true(scene_sample_light(scene, u, &point, &pdf));
            bool other = strcmp(scene_light_name(scene, point.light), "~") == 0;
            double chance = (other ? 4 * M_PI : power) / (power + 4 * M_PI);
            assert_float_equal(pdf * (other ? 1 : lamps[k].area) / chance, 1, 1e-4);
        }
        scene_destroy(scene);
    }
}

/* Light that leaves: the mean of L cos / pdf over points and directions is the power that physics gives. */
static void emitted_power_is_what_physics_says(void **state)
{
    (void)state;
    struct batches found[LAMPS] = {0};
    double exact[LAMPS];
    size_t count = 0;
    for (size_t k = 0; k < LAMPS; k++) {
        struct scene *scene = lamps[k].make();
        for (uint64_t b = 0; lamps[k].power > 0 && b < BATCHES; b++) {
            double sum = 0;
            for (uint64_t i = 0; i < DRAWS; i++) {
                float u[5], pdf_point, pdf_direction;
                struct light_point point;
                struct vec3 origin, direction;
                lamps_draw(400 + k, b * DRAWS + i, u, 5);
                if (scene_sample_light(scene, u, &point, &pdf_point) &&
                    scene_sample_light_direction(scene, &point, u + 3, &origin, &direction, &pdf_direction))
                    sum += scene_light_emission(scene, &point, direction, LAMBDA) /
                           ((double)pdf_point * pdf_direction);
            }
            batches_add(&found[count], sum / DRAWS);
        }
        if (lamps[k].power > 0)
            exact[count++] = PER_NM * lamps[k].power;
        scene_destroy(scene);
    }
    assert_estimates(found, exact, count, (struct power){.sees_error = 0.03});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(densities_are_those_that_are_drawn_from),
        cmocka_unit_test(direction_densities_integrate_to_one),
        cmocka_unit_test(lights_are_chosen_by_the_power_that_physics_gives),
        cmocka_unit_test(directions_are_drawn_with_their_density),
        cmocka_unit_test(spots_fall_off_between_rim_and_blend),
        cmocka_unit_test(emitted_power_is_what_physics_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
