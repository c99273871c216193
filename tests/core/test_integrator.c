/* Integrators as a whole: radiance that is known, and light that nothing sees. Their densities are test_techniques.c's. */
#include "boxes.h"

#include <limits.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "integrator/path.h"
#include "statistics.h"

#include <cmocka.h>

static const struct range range = {300, 830};

/* Mean of Y over the film, against the world's own. (X+Y+Z is what p_cam draws from: it has no variance here.) */
static void the_empty_world_has_its_radiance(void **state)
{
    enum { PIXELS = 16, SAMPLES = 64 };
    static const double radiance = 0.01;
    struct scene *scene = world_scene(range, (float)radiance, PIXELS);
    int border[4] = {0, 0, PIXELS, PIXELS};
    struct film *film = film_create(PIXELS, PIXELS, border, 0, range, NULL);
    struct integrator_settings settings = integrator_settings_default();
    settings.name = *state;
    struct integrator *it = integrator_create(&settings, scene, film, 1, NULL, NULL, NULL);
    struct batches batches = {0};
    double exact = 0;
    assert_non_null(it);
    for (float lambda = CMF_MIN_NM; lambda < CMF_MAX_NM; lambda++) {
        float cmf[3];
        cmf_eval(lambda, cmf);
        exact += it->kappa * radiance * (double)cmf[1];
    }
    for (int pixel = 0; pixel < PIXELS * PIXELS; pixel++) {
        for (int sample = 0; sample < SAMPLES; sample++)
            integrator_sample(it, 0, pixel % PIXELS, pixel / PIXELS, sample);
        batches_add(&batches, (double)film->sum[4 * pixel + 1] / (1 << FILM_FRACTION_BITS) / SAMPLES);
    }
    assert_unbiased(&batches, &exact, 1, (struct power){.sees_error = 0.01});
    integrator_destroy(it);
    film_destroy(film);
    scene_destroy(scene);
}

/* A lamp that diffuse rays do not see lights nothing, whichever end of the path was traced first. */
static void what_only_the_camera_sees_lights_nothing(void **state)
{
    struct scene *scene = hidden_lamp_scene(range, 16);
    struct batches reference = box_mean_below(scene, range, box_settings("pt", 4), 128),
                   other = box_mean_below(scene, range, box_settings(*state, 4), 32);
    /* The second lamp would add about as much as the first. */
    assert_same(&reference, &other, 1, (struct power){.sees_error = 0.15});
    scene_destroy(scene);
}

/* A dye that lets nothing be reflected in a band: what leaves it there is drawn apart from what passes elsewhere, and a run that is evaluated
   again at another wavelength needs both. mbdpt evaluates no run again. What becomes of the others without the clamp of P_F is
   test_unclamped.c's: over paths of up to 6 edges 6 % are missing. */
static void a_dye_that_absorbs_all_brings_runs_evaluated_again_what_it_brings_others(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        int lanes, samples;
    } subject[] = {{"mbdpt", 4, 20}, {"bdpt", 1, 20}, {"bdpt", 4, 12}, {"pt_nee", 1, 46}};
    struct scene *scene = saturated_box_scene(range, 16);
    struct batches mean[4];
    for (int i = 0; i < 4; i++) {
        struct integrator_settings settings = box_settings(subject[i].name, 2);
        settings.lanes = subject[i].lanes;
        settings.max_path = 6;
        mean[i] = box_mean_below(scene, range, settings, subject[i].samples);
        if (i > 0)
            assert_same(&mean[0], &mean[i], 1, (struct power){.sees_error = 0.03});
    }
    scene_destroy(scene);
}

/* Pictures of few samples do without looks at the scene; each look comes when the frame has had twenty times its samples, with those of the looks before. */
static void looks_cost_a_twentieth_of_the_samples_before(void **state)
{
    (void)state;
    static const int sizes[] = {3, 12, 48, 128, 800};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        int pixels = sizes[i], border[4] = {0, 0, pixels, pixels}, from;
        struct scene *scene = world_scene(range, 0.01f, pixels);
        struct film *film = film_create(pixels, pixels, border, 0, range, NULL);
        struct integrator_settings settings = box_settings("bdpt", 4);
        struct integrator *it = integrator_create(&settings, scene, film, 1, NULL, NULL, NULL);
        assert_non_null(it);
        integrator_look(it, 0, NULL, NULL);
        assert_int_equal(it->worker[0].stamp, 0); /* one for each sample traced */
        int looks = 0, first = integrator_next_look(it, 0);
        for (int at = integrator_next_look(it, 0); at < INT_MAX; at = integrator_next_look(it, at)) {
            uint32_t before = it->worker[0].stamp;
            integrator_look(it, at - 1, NULL, NULL);
            assert_int_equal(it->worker[0].stamp, before);
            integrator_look(it, at, NULL, NULL);
            assert_true(it->worker[0].stamp > before);
            assert_true(20.0 * it->worker[0].stamp <= (double)pixels * pixels * at);
            integrator_light_paths(it, &from);
            assert_int_equal(from, at);
            looks++;
        }
        assert_in_range(looks, 1, 2);
        /* A large picture has one as soon as it has one sample. */
        assert_true(pixels < 800 || first == 1);
        integrator_destroy(it);
        film_destroy(film);
        scene_destroy(scene);
    }
}

/* Every technique respects it, light sub-paths too. */
static void a_holdout_is_black_and_clear_and_the_rest_is_not(void **state)
{
    enum { PIXELS = 16, SAMPLES = 16 };
    struct scene *scene = hole_scene(range, PIXELS);
    int border[4] = {0, 0, PIXELS, PIXELS};
    struct film *film = film_create(PIXELS, PIXELS, border, 0, range, NULL);
    struct integrator_settings settings = box_settings(*state, 4);
    settings.filter_width = 0.1f;
    struct integrator *it = integrator_create(&settings, scene, film, 1, NULL, NULL, NULL);
    assert_non_null(it);
    for (int pixel = 0; pixel < PIXELS * PIXELS; pixel++)
        for (int sample = 0; sample < SAMPLES; sample++)
            integrator_sample(it, 0, pixel % PIXELS, pixel / PIXELS, sample);
    for (int pixel = 0; pixel < PIXELS * PIXELS; pixel++) {
        const int64_t *sum = &film->sum[4 * pixel];
        bool hole = pixel % PIXELS < PIXELS / 2;
        assert_int_equal(sum[3], hole ? 0 : (int64_t)SAMPLES << FILM_FRACTION_BITS);
        assert_true(hole ? sum[1] == 0 : sum[1] > 0);
    }
    integrator_destroy(it);
    film_destroy(film);
    scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(the_empty_world_has_its_radiance, "pt"),
        cmocka_unit_test_prestate(the_empty_world_has_its_radiance, "mbdpt"),
        cmocka_unit_test_prestate(the_empty_world_has_its_radiance, "bdpt"),
        cmocka_unit_test_prestate(what_only_the_camera_sees_lights_nothing, "lt"),
        cmocka_unit_test_prestate(what_only_the_camera_sees_lights_nothing, "pt_nee"),
        cmocka_unit_test_prestate(what_only_the_camera_sees_lights_nothing, "mbdpt"),
        cmocka_unit_test_prestate(what_only_the_camera_sees_lights_nothing, "bdpt"),
        cmocka_unit_test_prestate(a_holdout_is_black_and_clear_and_the_rest_is_not, "pt_nee"),
        cmocka_unit_test_prestate(a_holdout_is_black_and_clear_and_the_rest_is_not, "mbdpt"),
        cmocka_unit_test_prestate(a_holdout_is_black_and_clear_and_the_rest_is_not, "bdpt"),
        cmocka_unit_test(looks_cost_a_twentieth_of_the_samples_before),
        cmocka_unit_test(a_dye_that_absorbs_all_brings_runs_evaluated_again_what_it_brings_others),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
