/* Every technique delivers what its density claims, class by class of labelled paths, and its weights are those of the plain products
   (algorithm.md §8). STOKES_TEST_VERBOSE=1 prints every cell. */
#include "boxes.h"
#include "ledger.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include "statistics.h"

#include <cmocka.h>

/* --- Copied wavelengths against a path tracer ------------------------------------------------------------------- */

/* Paths of 7 edges that only a copied wavelength connects have no second technique that finds them often: no ledger says whether they are
   right. A path tracer does. */
static void enter_copied(void *observer, const struct full_path *path, double value)
{
    double *sum = observer;
    bool copied = false;
    float cmf[3];
    for (int cut = 1; cut <= path->edges; cut++)
        copied |=
            ledger_is_elastic(path, cut - 1) && ledger_is_elastic(path, cut) && ledger_is_copied(path, cut);
    cmf_eval(path->step[path->edges].lambda, cmf);
    if (copied)
        *sum += value * ((double)cmf[0] + (double)cmf[1] + (double)cmf[2]);
}

static struct batches copied_paths(const struct scene *scene, const char *name, int samples)
{
    int border[4] = {0, 0, LEDGER_PIXELS, LEDGER_PIXELS};
    struct film *film = film_create(LEDGER_PIXELS, LEDGER_PIXELS, border, 0, ledger_range, NULL);
    struct integrator_settings settings = integrator_settings_default();
    struct batches batches = {0};
    settings.name = name;
    settings.max_path = 7;
    for (settings.seed = 0; settings.seed < 32; settings.seed++) {
        struct integrator *it = integrator_create(&settings, scene, film, 1, NULL, NULL, NULL);
        double sum = 0;
        assert_non_null(it);
        it->observe = enter_copied;
        it->observer = &sum;
        for (int sample = 0; sample < samples; sample++)
            for (int pixel = 0; pixel < LEDGER_PIXELS * LEDGER_PIXELS; pixel++)
                integrator_sample(it, 0, pixel % LEDGER_PIXELS, pixel / LEDGER_PIXELS, sample);
        batches_add(&batches, sum / samples);
        integrator_destroy(it);
    }
    film_destroy(film);
    return batches;
}

static void copied_wavelengths_bring_what_a_path_tracer_finds(void **state)
{
    (void)state;
    struct scene *scene = box_scene(ledger_range, true, LEDGER_PIXELS);
    struct batches reference = copied_paths(scene, "pt", 384), copied = copied_paths(scene, "bdpt", 24);
    assert_same(&reference, &copied, 1, (struct power){.sees_error = 0.16});
    scene_destroy(scene);
}

int main(void)
{
    static struct subject
        mbdpt = {.name = "mbdpt", .lanes = 1, .edges = 5, .samples = 20},
        mbdpt_4 = {.name = "mbdpt", .lanes = 4, .edges = 5, .samples = 16},
        mbdpt_inner = {.name = "mbdpt", .lanes = 8, .inner = true, .edges = 5, .samples = 20},
        mbdpt_shared = {.name = "mbdpt", .lanes = 1, .edges = 5, .samples = 12, .shared = true},
        mbdpt_box =
            {.name = "mbdpt", .lanes = 8, .inner = true, .edges = 5, .samples = 24, .kernel = KERNEL_BOX},
        mbdpt_asymmetric = {.name = "mbdpt",
                            .lanes = 8,
                            .inner = true,
                            .edges = 5,
                            .samples = 24,
                            .kernel = KERNEL_ASYMMETRIC},
        mbdpt_glass = {.name = "mbdpt", .lanes = 4, .lenses = true, .edges = 5, .samples = 72},
        bdpt = {.name = "bdpt", .lanes = 1, .edges = 5, .samples = 16},
        bdpt_4 = {.name = "bdpt", .lanes = 4, .edges = 5, .samples = 20},
        bdpt_8 = {.name = "bdpt", .lanes = 8, .edges = 5, .samples = 12},
        bdpt_glass = {.name = "bdpt", .lanes = 1, .lenses = true, .edges = 7, .samples = 64},
        bdpt_4_glass = {.name = "bdpt", .lanes = 4, .lenses = true, .edges = 7, .samples = 64},
        bdpt_4_few =
            {.name = "bdpt", .lanes = 4, .edges = 5, .samples = 16, .sees_error = 0.05, .light_paths = 0.25},
        bdpt_glass_many = {.name = "bdpt",
                           .lanes = 1,
                           .lenses = true,
                           .edges = 7,
                           .samples = 14,
                           .sees_error = 0.05,
                           .light_paths = 2.5},
        mbdpt_4_few = {
            .name = "mbdpt", .lanes = 4, .edges = 5, .samples = 10, .sees_error = 0.04, .light_paths = 0.5};
    const struct CMUnitTest tests[] = {cmocka_unit_test(copied_wavelengths_bring_what_a_path_tracer_finds),
                                       TEST_OF(mbdpt),
                                       TEST_OF(mbdpt_4),
                                       TEST_OF(mbdpt_inner),
                                       TEST_OF(mbdpt_shared),
                                       TEST_OF(mbdpt_box),
                                       TEST_OF(mbdpt_asymmetric),
                                       TEST_OF(mbdpt_glass),
                                       TEST_OF(bdpt),
                                       TEST_OF(bdpt_4),
                                       TEST_OF(bdpt_8),
                                       TEST_OF(bdpt_glass),
                                       TEST_OF(bdpt_4_glass),
                                       TEST_OF(bdpt_4_few),
                                       TEST_OF(bdpt_glass_many),
                                       TEST_OF(mbdpt_4_few)};
    if (getenv("STOKES_TEST_ONLY"))
        cmocka_set_test_filter(getenv("STOKES_TEST_ONLY"));
    return cmocka_run_group_tests(tests, NULL, NULL);
}
