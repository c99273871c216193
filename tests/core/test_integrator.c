/* Integrators: the weights are a partition of unity, and every technique delivers what its density claims (algorithm.md §8). */
#include "boxes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "integrator/mis.h"
#include "statistics.h"

#include <cmocka.h>

static const struct range range = {300, 830};

/* --- Densities -------------------------------------------------------------------------------------------- */

enum { EDGES = 5, CUTS = EDGES + 1, CLASSES = 3, CELLS = (EDGES + 1) * CUTS * CLASSES, BATCHES = 32 };

/* What technique (path length, cut) gave itself, and what its density claims of everybody's samples. */
struct ledger {
    const struct integrator *it;
    double delivered[CELLS], claimed[CELLS];
    double worst_weight; /* distance from the plain products */
    int complaints;
};

static int cell(const struct full_path *path, int cut)
{
    int dyes = 0;
    for (int i = 1; i < path->edges; i++)
        dyes += path->step[i].label == LABEL_FLUORESCENT;
    return (path->edges * CUTS + cut) * CLASSES + (dyes < CLASSES ? dyes : CLASSES - 1);
}

static void enter(void *observer, const struct full_path *path, double value)
{
    struct ledger *ledger = observer;
    double densities = 0, density[CUTS];
    float cmf[3];
    cmf_eval(path->step[path->edges].lambda, cmf); /* what the film makes of it */
    value *= (double)cmf[0] + (double)cmf[1] + (double)cmf[2];
    for (int cut = 0; cut <= path->edges; cut++)
        densities += density[cut] = mis_cut_density(ledger->it, path, cut);
    ledger->delivered[cell(path, path->cut)] += value;
    double error = fabs(path->weight - density[path->cut] / densities);
    if (path->weight > 0)
        ledger->worst_weight = fmax(ledger->worst_weight, error);
    if (getenv("STOKES_TEST_VERBOSE") && error > 1e-4 && ledger->complaints++ < 5) {
        print_message("weight %g, plainly %g: cut %d of %d\n", path->weight, density[path->cut] / densities,
                      path->cut, path->edges);
        for (int i = 0; i <= path->edges; i++)
            print_message("  %d: label %d dye %d disperses %d fwd %g rev %g G %g lambda %g link %g\n", i,
                          path->step[i].label, path->step[i].dye, path->step[i].disperses, path->step[i].fwd,
                          path->step[i].rev, path->step[i].geometry, (double)path->step[i].lambda, density[i]);
    }
    for (int cut = 0; cut <= path->edges; cut++)
        ledger->claimed[cell(path, cut)] += value * density[cut] / densities;
}

/* Rare cells hold a few large contributions, and no mean of them is near normal. */
static const double rare_share = 1e-3;

/* All cells of one path length. `sees_error` is a share of what all paths of that length bring. */
static bool cells_agree(int edges, const struct batches delivered[CELLS], const struct batches claimed[CELLS],
                        const struct batches surplus[CELLS], double sees_error)
{
    double total = 0;
    bool fine = true;
    int first = edges * CUTS * CLASSES, last = first + CUTS * CLASSES;
    for (int i = first; i < last; i++)
        total += delivered[i].mean;
    for (int i = first; i < last; i++) {
        if (claimed[i].mean <= rare_share * total)
            continue;
        struct finding found =
            batches_against(&surplus[i], 0, (struct power){.sees_error = sees_error, .scale = total}, CELLS);
        if (getenv("STOKES_TEST_VERBOSE") || !found.agrees || !found.powerful)
            print_message(
                "edges %d, cut %d, dyes %d: delivers %.5g, claims %.5g of %.5g (z %.2f, sees %.2g)\n", edges,
                i / CLASSES % CUTS, i % CLASSES, delivered[i].mean, claimed[i].mean, total, found.z,
                found.sees);
        fine &= found.agrees && found.powerful;
    }
    return fine;
}

/* Runs BATCHES independent batches and asserts that each cell's surplus has expectation zero. */
static void assert_techniques_deliver(const char *name, int lanes, bool lenses, int samples, double sees_error)
{
    enum { PIXELS = 16 };
    struct scene *scene = box_scene(range, lenses, PIXELS);
    int border[4] = {0, 0, PIXELS, PIXELS};
    struct film *film = film_create(PIXELS, PIXELS, border, 0, range, NULL);
    struct integrator_settings settings = integrator_settings_default();
    settings.name = name;
    settings.lanes = lanes;
    settings.d0_nm = 4;
    settings.shrink = 0;
    settings.max_path = settings.max_camera = settings.max_light = EDGES;
    struct integrator *it = integrator_create(&settings, scene, film, 1, NULL, NULL, NULL);
    assert_non_null(it);
    static struct batches delivered[CELLS], claimed[CELLS], surplus[CELLS];
    memset(surplus, 0, sizeof surplus);
    memset(delivered, 0, sizeof delivered);
    memset(claimed, 0, sizeof claimed);
    it->observe = enter;
    double worst_weight = 0;
    for (int batch = 0; batch < BATCHES; batch++) {
        struct ledger ledger = {.it = it};
        it->observer = &ledger;
        for (int sample = 0; sample < samples; sample++)
            for (int pixel = 0; pixel < PIXELS * PIXELS; pixel++)
                integrator_sample(it, 0, pixel % PIXELS, pixel / PIXELS, batch * samples + sample);
        worst_weight = fmax(worst_weight, ledger.worst_weight);
        for (int i = 0; i < CELLS; i++) {
            batches_add(&surplus[i], (ledger.delivered[i] - ledger.claimed[i]) / samples);
            batches_add(&delivered[i], ledger.delivered[i] / samples);
            batches_add(&claimed[i], ledger.claimed[i] / samples);
        }
    }
    bool fine = true;
    for (int edges = 1; edges <= EDGES; edges++)
        fine &= cells_agree(edges, delivered, claimed, surplus, sees_error);
    integrator_destroy(it);
    film_destroy(film);
    scene_destroy(scene);
    assert_true(fine);
    /* The recursion of the weights is their plain products, and so they sum to 1. */
    assert_true(worst_weight < 1e-4);
}

/* An integrator and its lanes. */
struct subject {
    const char *name;
    int lanes;
};

static void techniques_deliver_what_they_claim_in_the_open(void **state)
{
    const struct subject *subject = *state;
    assert_techniques_deliver(subject->name, subject->lanes, false, 48, 0.02);
}

static void techniques_deliver_what_they_claim_behind_glass(void **state)
{
    const struct subject *subject = *state;
    assert_techniques_deliver(subject->name, subject->lanes, true, 64, 0.02);
}

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

/* Mean Y of the lower part of the picture, where no lamp is, in batches, one a seed. */
static struct batches mean_below(const struct scene *scene, const char *name, int samples)
{
    enum { PIXELS = 16 };
    int border[4] = {0, 0, PIXELS, PIXELS};
    struct film *film = film_create(PIXELS, PIXELS, border, 0, range, NULL);
    struct integrator_settings settings = integrator_settings_default();
    struct batches batches = {0};
    settings.name = name;
    settings.d0_nm = 4;
    settings.shrink = 0;
    for (settings.seed = 0; settings.seed < BATCHES; settings.seed++) {
        struct integrator *it = integrator_create(&settings, scene, film, 1, NULL, NULL, NULL);
        double sum = 0;
        assert_non_null(it);
        film_clear(film);
        for (int sample = 0; sample < samples; sample++)
            for (int pixel = 0; pixel < PIXELS * PIXELS; pixel++)
                integrator_sample(it, 0, pixel % PIXELS, pixel / PIXELS, sample);
        for (int pixel = 0; pixel < PIXELS * PIXELS * 3 / 8; pixel++)
            sum += (double)film->sum[4 * pixel + 1] / (1 << FILM_FRACTION_BITS);
        batches_add(&batches, sum / samples);
        integrator_destroy(it);
    }
    film_destroy(film);
    return batches;
}

/* A lamp that diffuse rays do not see lights nothing, whichever end of the path was traced first. */
static void what_only_the_camera_sees_lights_nothing(void **state)
{
    struct scene *scene = hidden_lamp_scene(range, 16);
    struct batches reference = mean_below(scene, "pt", 128), other = mean_below(scene, *state, 32);
    /* The second lamp would add about as much as the first. */
    assert_same(&reference, &other, 1, (struct power){.sees_error = 0.15});
    scene_destroy(scene);
}

int main(void)
{
    static struct subject subject[] = {{"mbdpt", 1}, {"bdpt", 1}, {"mbdpt", 4}, {"bdpt", 4}};
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(the_empty_world_has_its_radiance, "pt"),
        cmocka_unit_test_prestate(the_empty_world_has_its_radiance, "mbdpt"),
        cmocka_unit_test_prestate(the_empty_world_has_its_radiance, "bdpt"),
        cmocka_unit_test_prestate(what_only_the_camera_sees_lights_nothing, "lt"),
        cmocka_unit_test_prestate(what_only_the_camera_sees_lights_nothing, "pt_nee"),
        cmocka_unit_test_prestate(what_only_the_camera_sees_lights_nothing, "mbdpt"),
        cmocka_unit_test_prestate(what_only_the_camera_sees_lights_nothing, "bdpt"),
        cmocka_unit_test_prestate(techniques_deliver_what_they_claim_in_the_open, &subject[0]),
        cmocka_unit_test_prestate(techniques_deliver_what_they_claim_behind_glass, &subject[0]),
        cmocka_unit_test_prestate(techniques_deliver_what_they_claim_in_the_open, &subject[1]),
        cmocka_unit_test_prestate(techniques_deliver_what_they_claim_behind_glass, &subject[1]),
        cmocka_unit_test_prestate(techniques_deliver_what_they_claim_in_the_open, &subject[2]),
        cmocka_unit_test_prestate(techniques_deliver_what_they_claim_behind_glass, &subject[2]),
        cmocka_unit_test_prestate(techniques_deliver_what_they_claim_in_the_open, &subject[3]),
        cmocka_unit_test_prestate(techniques_deliver_what_they_claim_behind_glass, &subject[3]),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
