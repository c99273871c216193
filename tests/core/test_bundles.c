/* Bundles of wavelengths (algorithm.md §11): lanes are stratified where a run begins, and who leads is drawn among those that live. Everything is read
   from traced sub-paths, in a box with glass and a dye whose bands are narrower than what its lanes are drawn from. */
#include "boxes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include "statistics.h"

#include <cmocka.h>

enum { PIXELS = 256, BINS = 16 };
static const struct range whole = {300, 830};
/* Of a quantile; the wavelengths and the cdf are floats. */
static const double rounding = 1e-4;

/* What a test sees of each run's start: vertex `at` of a sub-path that goes on. */
typedef void visitor(void *seen, const struct integrator *, enum side, const struct subpath *, int at);

/* One sample each of many pixels: independent sub-paths, which are all that is traced. */
static void visit_runs(int lanes, visitor *visit, void *seen)
{
    struct scene *scene = banded_box_scene(whole, PIXELS);
    int border[4] = {0, 0, PIXELS, PIXELS};
    struct film *film = film_create(PIXELS, PIXELS, border, 0, whole, NULL);
    struct integrator_settings settings = box_settings("bdpt", 4);
    settings.lanes = lanes;
    settings.max_path = 8;
    struct integrator *it = integrator_create(&settings, scene, film, 1, NULL, NULL, NULL);
    assert_non_null(it);
    struct worker *w = &it->worker[0];
    for (int pixel = 0; pixel < PIXELS * PIXELS; pixel++) {
        w->random = random_path(0, (uint32_t)pixel, 0);
        w->light.count = 0;
        path_trace_camera(it, w, (float)(pixel % PIXELS) + 0.5f, (float)(pixel / PIXELS) + 0.5f);
        path_trace_light(it, w);
        for (int side = 0; side < SIDES; side++) {
            const struct subpath *path = side == SIDE_LIGHT ? &w->light : &w->camera;
            for (int i = 0; i + 1 < path->count; i++)
                if (path->vertex[i].label == LABEL_FLUORESCENT)
                    visit(seen, it, side, path, i);
        }
    }
    integrator_destroy(it);
    film_destroy(film);
    scene_destroy(scene);
}

/* --- Stratification --------------------------------------------------------------------------------------------- */

/* What the lanes of a run are drawn from. */
static const struct spectrum *source(const struct integrator *it, enum side side, const struct vertex *v)
{
    if (v->kind == VERTEX_CAMERA)
        return it->wavelengths.camera;
    if (v->kind == VERTEX_LIGHT)
        return scene_light_spectrum(it->scene, v->light.light);
    int dye = surface_fluorophore(&v->surface, v->lobe);
    return side == SIDE_CAMERA ? scene_fluorophore_absorption(it->scene, dye)
                               : scene_fluorophore_emission(it->scene, dye);
}

struct strata {
    int lanes, wrong_count;
    double
        worst; /* distance of a lane's quantile from its place behind the first lane's, around the unit interval */
    double first[SIDES][2][BINS], runs[SIDES][2]; /* quantiles of the first lane, at starts and behind dyes */
};

static void look_at_lanes(void *seen, const struct integrator *it, enum side side, const struct subpath *path,
                          int at)
{
    struct strata *strata = seen;
    const struct vertex *v = &path->vertex[at];
    const struct spectrum *drawn_from = source(it, side, v);
    double all = spectrum_integral(drawn_from), first = 0;
    strata->wrong_count += v->lanes_out != strata->lanes || v[1].arrival.lanes != strata->lanes;
    for (int i = 0; i < v->lanes_out; i++) {
        double quantile = spectrum_integral_to(drawn_from, v->lambda_out[i]) / all;
        first = i == 0 ? quantile : first;
        double off = quantile - first - (double)i / strata->lanes;
        strata->worst = fmax(strata->worst, fabs(off - round(off)));
    }
    strata->first[side][at > 0][(int)fmin(first * BINS, BINS - 1)]++;
    strata->runs[side][at > 0]++;
}

static void lanes_are_stratified_where_a_run_begins(void **state)
{
    struct strata strata = {.lanes = *(const int *)*state};
    visit_runs(strata.lanes, look_at_lanes, &strata);
    assert_int_equal(strata.wrong_count, 0);
    assert_true(strata.worst < rounding);
    /* So that each is distributed as if it were alone. */
    for (int side = 0; side < SIDES; side++)
        for (int dye = 0; dye < 2; dye++) {
            double expected[BINS];
            for (int i = 0; i < BINS; i++)
                expected[i] = strata.runs[side][dye] / BINS;
            assert_distributed(strata.first[side][dye], expected, BINS, (struct power){.sees_error = 0.1});
        }
}

/* --- Leaders ---------------------------------------------------------------------------------------------------- */

struct leaders {
    int dead_that_lead, wrong_count;
    double led[SIDES][LANES_MAX + 1][LANES_MAX]; /* by how many live, and the leader's place among them */
};

static void look_at_leader(void *seen, const struct integrator *it, enum side side,
                           const struct subpath *path, int at)
{
    struct leaders *leaders = seen;
    (void)it;
    int living = 0, place = 0;
    const struct vertex *next = &path->vertex[at + 1];
    for (int i = 0; i < next->arrival.lanes; i++) {
        bool lives = next->arrival.throughput[i] > 0;
        living += lives;
        place += lives && i < next->leader;
        leaders->wrong_count += (next->lead[i] > 0) != lives;
    }
    leaders->wrong_count += next->leaders != living;
    leaders->dead_that_lead += !(next->arrival.throughput[next->leader] > 0);
    if (at > 0 || side == SIDE_LIGHT) /* the camera's first leader is the first lane */
        leaders->led[side][living][place]++;
}

/* Each number of the living is a table of its own; together they have Σ (living − 1) degrees of freedom. */
static void assert_uniform(const double led[LANES_MAX + 1][LANES_MAX], int lanes)
{
    double observed[LANES_MAX * LANES_MAX], expected[LANES_MAX * LANES_MAX];
    size_t bins = 0, tables = 0;
    for (int living = 2; living <= lanes; living++) {
        double all = lanes_sum(led[living], living);
        if (all < living * CHI2_EXPECTED_MIN)
            continue;
        for (int i = 0; i < living; i++, bins++) {
            observed[bins] = led[living][i];
            expected[bins] = all / living;
        }
        tables++;
    }
    assert_true(tables >= 2);
    struct chi2 found = chi2_test(observed, expected, bins, tables - 1);
    print_message("%zu bins, %g leaders: p = %.2g, sees %.2g\n", bins, found.count, found.p,
                  chi2_sees(&found, C_FALSE_ALARM));
    assert_true(found.p >= C_FALSE_ALARM);
    assert_true(chi2_sees(&found, C_FALSE_ALARM) < 0.1);
}

static void leaders_are_drawn_among_the_living(void **state)
{
    int lanes = *(const int *)*state;
    struct leaders leaders = {0};
    visit_runs(lanes, look_at_leader, &leaders);
    assert_int_equal(leaders.dead_that_lead, 0);
    assert_int_equal(leaders.wrong_count, 0);
    for (int side = 0; side < SIDES; side++)
        assert_uniform(leaders.led[side], lanes);
}

int main(void)
{
    static int four = 4, eight = 8;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(lanes_are_stratified_where_a_run_begins, &four),
        cmocka_unit_test_prestate(lanes_are_stratified_where_a_run_begins, &eight),
        cmocka_unit_test_prestate(leaders_are_drawn_among_the_living, &four),
        cmocka_unit_test_prestate(leaders_are_drawn_among_the_living, &eight),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
