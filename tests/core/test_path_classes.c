/* `bdpt` brings what path tracing brings, class by class of paths (algorithm.md §8): what one class has too much cannot hide in what another lacks.
   STOKES_TEST_VERBOSE=1 prints every class. */
#include "boxes.h"
#include "ledger.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

/* By how many edges paths have, and at how many vertices they fluoresce (2: or more). Paths that only a copied wavelength connects have no
   second technique that finds them often: no ledger says whether they are right, and they are summed once more. */
enum {
    PIXELS = LEDGER_PIXELS,
    EDGES_MAX = 7,
    COUNTS = 3,
    CLASSES = EDGES_MAX * COUNTS,
    COPIED = CLASSES,
    SUMS
};

struct place {
    struct scene *(*scene)(struct range, int pixels);
    const char *reference;
    int edges, paths, samples; /* of the longest paths; of the reference and of `bdpt`, a batch */
    double sees_error, least;  /* of a class, or of what is this share of all but the lamp itself */
    double copied_sees_error;  /* 0: there are none */
};

static bool is_copied(const struct full_path *path)
{
    for (int cut = 1; cut <= path->edges; cut++)
        if (ledger_is_elastic(path, cut - 1) && ledger_is_elastic(path, cut) && ledger_is_copied(path, cut))
            return true;
    return false;
}

static void enter(void *observer, const struct full_path *path, double value)
{
    double *sum = observer;
    int dyes = 0;
    float cmf[3];
    for (int i = 1; i < path->edges; i++)
        dyes += path->step[i].label == LABEL_FLUORESCENT;
    cmf_eval(path->step[path->edges].lambda, cmf);
    value *= (double)cmf[0] + (double)cmf[1] + (double)cmf[2];
    sum[(path->edges - 1) * COUNTS + (dyes < COUNTS ? dyes : COUNTS - 1)] += value;
    if (is_copied(path))
        sum[COPIED] += value;
}

/* In 32 batches, one a seed. */
static void measure(const struct scene *scene, struct integrator_settings settings, int samples,
                    struct batches found[SUMS])
{
    int border[4] = {0, 0, PIXELS, PIXELS};
    struct film *film = film_create(PIXELS, PIXELS, border, 0, ledger_range, NULL);
    for (int batch = 0; batch < 32; batch++, settings.seed++) {
        struct integrator *it = integrator_create(&settings, scene, film, 1, NULL, NULL, NULL);
        double sum[SUMS] = {0};
        assert_non_null(it);
        it->observe = enter;
        it->observer = sum;
        for (int sample = 0; sample < samples; sample++)
            for (int pixel = 0; pixel < PIXELS * PIXELS; pixel++)
                integrator_sample(it, 0, pixel % PIXELS, pixel / PIXELS, sample);
        for (int i = 0; i < SUMS; i++)
            batches_add(&found[i], sum[i] / samples);
        integrator_destroy(it);
    }
    film_destroy(film);
}

/* Classes that bring less than this hold a few large contributions, and no mean of them is near normal. */
static void leave_out_rare(struct batches found[CLASSES], struct batches wanted[CLASSES], double least)
{
    for (int i = 0; i < CLASSES; i++)
        if (found[i].mean + wanted[i].mean < 2 * least)
            found[i].mean = found[i].square = wanted[i].mean = wanted[i].square = 0;
}

static void print(const struct batches *found, const struct batches *wanted, struct power power)
{
    for (int i = 0; i < CLASSES; i++) {
        struct finding finding = batches_versus(&found[i], &wanted[i], power, CLASSES);
        if (found[i].mean > 0)
            print_message("bin %d, %d edges, %d dyes: %.5g, path tracing %.5g (z %.2f, sees %.2g)\n", i,
                          i / COUNTS + 1, i % COUNTS, found[i].mean, wanted[i].mean, finding.z, finding.sees);
    }
}

static void each_class_brings_what_path_tracing_finds(void **state)
{
    const struct place *place = *state;
    struct scene *scene = place->scene(ledger_range, PIXELS);
    struct integrator_settings settings = integrator_settings_default();
    struct batches wanted[SUMS] = {0};
    struct power power = {.sees_error = place->sees_error};
    settings.max_path = place->edges;
    settings.name = place->reference;
    settings.lanes = 1;
    measure(scene, settings, place->paths, wanted);
    for (int i = COUNTS; i < CLASSES; i++)
        power.scale += place->least * wanted[i].mean;
    settings.name = "bdpt";
    for (settings.lanes = 1; settings.lanes <= 4; settings.lanes *= 4) {
        struct batches found[SUMS] = {0};
        settings.seed = 1000; /* other numbers than the reference's */
        measure(scene, settings, place->samples, found);
        leave_out_rare(found, wanted, power.scale / 100);
        if (getenv("STOKES_TEST_VERBOSE"))
            print(found, wanted, power);
        assert_same(found, wanted, CLASSES, power);
        if (place->copied_sees_error > 0)
            assert_same(&found[COPIED], &wanted[COPIED], 1,
                        (struct power){.sees_error = place->copied_sees_error});
    }
    scene_destroy(scene);
}

static struct scene *lenses(struct range range, int pixels)
{
    return box_scene(range, true, pixels);
}

int main(void)
{
    static struct place open = {.scene = saturated_box_scene,
                                .reference = "pt_nee",
                                .edges = 5,
                                .paths = 48,
                                .samples = 16,
                                .sees_error = 0.1,
                                .least = 0.03},
                        glass = {.scene = lenses,
                                 .reference = "pt",
                                 .edges = 7,
                                 .paths = 384,
                                 .samples = 24,
                                 .sees_error = 0.35,
                                 .least = 0.2,
                                 .copied_sees_error = 0.16};
#define PLACE(place)                                                                                         \
    {                                                                                                        \
#place, each_class_brings_what_path_tracing_finds, NULL, NULL, &place                                \
    }
    const struct CMUnitTest tests[] = {PLACE(open), PLACE(glass)};
    if (getenv("STOKES_TEST_ONLY"))
        cmocka_set_test_filter(getenv("STOKES_TEST_ONLY"));
    return cmocka_run_group_tests(tests, NULL, NULL);
}
