/* What samples with one light sub-path say of other numbers of them (algorithm.md §15), against samples with those numbers. */
#include "boxes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include "integrator/roulette.h"
#include "integrator/trial.h"
#include "statistics.h"

#include <cmocka.h>

enum { PIXELS = 16 };
static const struct range range = {300, 830};
static const int full[2] = {PIXELS, PIXELS}, border[4] = {0, 0, PIXELS, PIXELS};

struct stage {
    struct scene *scene;
    struct film *film;
    struct integrator *it;
};

static struct stage set_up(struct scene *scene)
{
    struct stage stage = {scene, film_create(PIXELS, PIXELS, border, 0, range, NULL), NULL};
    struct integrator_settings settings = box_settings("bdpt", 4);
    settings.max_path = 6;
    stage.it = integrator_create(&settings, scene, stage.film, 1, NULL, NULL, NULL);
    assert_non_null(stage.it);
    return stage;
}

static void put_away(struct stage *stage)
{
    integrator_destroy(stage->it);
    film_destroy(stage->film);
    scene_destroy(stage->scene);
}

/* One sample of each pixel. */
static void trace_frame(struct stage *stage, struct trial *trial, uint32_t seed)
{
    struct worker *w = &stage->it->worker[0];
    w->trial = trial;
    for (int i = 0; i < PIXELS * PIXELS; i++)
        integrator_trace(stage->it, w, i % PIXELS, i / PIXELS, seed, 0);
    w->trial = NULL;
}

/* What an observer is told, of paths that a look learns from. Each contribution is one lane. */
struct told {
    const struct integrator *it;
    double own;             /* to the sample's pixel, since it was set to 0 */
    double squares, splats; /* of all contributions, and of those to other pixels */
};

static void listen(void *observer, const struct full_path *path, double value)
{
    struct told *told = observer;
    double light = value * roulette_color(told->it, path->step[path->edges].lambda);
    if (path->edges == 1)
        return;
    told->squares += light * light;
    if (path->cut == path->edges)
        told->splats += light * light;
    else
        told->own += light;
}

/* --- Contributions one by one --------------------------------------------------------------------------------------- */

static void second_moments_are_those_of_samples_with_so_many_light_paths(void **state)
{
    (void)state;
    enum { BATCHES = 32, FRAMES = 8, NUMBERS_TRIED = 3 };
    static const int number[NUMBERS_TRIED] = {NUMBER_ONE - 2, NUMBER_ONE, NUMBER_ONE + 2};
    struct stage stage = set_up(saturated_box_scene(range, PIXELS));
    struct overview overview;
    struct batches reckoned[NUMBERS_TRIED] = {{0}}, found[NUMBERS_TRIED] = {{0}};
    overview_begin(&overview, full);
    for (uint32_t batch = 0; batch < BATCHES; batch++) {
        struct trial all = {.overview = &overview, .weighs = true};
        stage.it->light_paths = 1;
        for (uint32_t k = 0; k < FRAMES; k++)
            trace_frame(&stage, &all, batch * FRAMES + k);
        for (int i = 0; i < NUMBERS_TRIED; i++) {
            struct trial none = {.overview = &overview};
            struct told told = {.it = stage.it};
            batches_add(&reckoned[i], all.moment[number[i]]);
            stage.it->light_paths = trial_number(number[i]);
            stage.it->observe = listen;
            stage.it->observer = &told;
            for (uint32_t k = 0; k < FRAMES; k++)
                trace_frame(&stage, &none, 1000000 * (uint32_t)(i + 1) + batch * FRAMES + k);
            stage.it->observe = NULL;
            batches_add(&found[i], told.squares);
        }
    }
    assert_same(reckoned, found, NUMBERS_TRIED, (struct power){.sees_error = 0.1});
    put_away(&stage);
}

/* --- Pixels ---------------------------------------------------------------------------------------------------------- */

enum { SEEDS = 16 };

/* One sample each of all seeds for each pixel. */
static void trace_pixels(struct stage *stage, double light_paths, bool weighs, uint32_t first_seed,
                         void (*each)(struct trial *, void *), void (*end)(const struct trial *, void *),
                         void *user)
{
    struct overview overview;
    struct worker *w = &stage->it->worker[0];
    overview_begin(&overview, full);
    stage->it->light_paths = light_paths;
    for (int i = 0; i < PIXELS * PIXELS; i++) {
        struct trial trial = {.overview = &overview, .weighs = weighs, .pixel = {i % PIXELS, i / PIXELS}};
        w->trial = &trial;
        for (uint32_t seed = 0; seed < SEEDS; seed++) {
            integrator_trace(stage->it, w, trial.pixel[0], trial.pixel[1], first_seed + seed, 0);
            each(&trial, user);
        }
        w->trial = NULL;
        end(&trial, user);
    }
}

static void end_sample(struct trial *trial, void *user)
{
    (void)user;
    trial_end_sample(trial);
}

static void add_pixel(const struct trial *trial, void *user)
{
    double *sum = user, variance[NUMBERS];
    trial_end_pixel(trial, SEEDS, variance);
    for (int k = 0; k < NUMBERS; k++)
        sum[k] += variance[k] / SEEDS;
}

/* Of samples with so many light sub-paths, as they are: those with one at least, and those without. */
struct measured {
    struct told told;
    const struct worker *worker;
    double light_paths, variance;
    int pixels, count[2];
    double sum[2], squares[2];
};

static void measure_sample(struct trial *trial, void *user)
{
    struct measured *m = user;
    bool has = m->worker->light_paths > 0;
    (void)trial;
    m->count[has]++;
    m->sum[has] += m->told.own;
    m->squares[has] += m->told.own * m->told.own;
    m->told.own = 0;
}

/* A picture has as many of either kind as the number says, so the variance between the two does not count. Pixels that have no two of a kind by chance are left
   out. */
static void measure_pixel(const struct trial *trial, void *user)
{
    struct measured *m = user;
    double variance = m->told.splats / SEEDS;
    bool enough = true;
    (void)trial;
    for (int has = 0; has < 2; has++) {
        double share = has ? fmin(m->light_paths, 1) : fmax(1 - m->light_paths, 0);
        int count = m->count[has];
        enough = enough && (count > 1 || !(share > 0));
        if (count > 1)
            variance += share * (m->squares[has] - m->sum[has] * m->sum[has] / count) / (count - 1);
        m->sum[has] = m->squares[has] = m->count[has] = 0;
    }
    m->told.splats = 0;
    if (enough) {
        m->variance += variance;
        m->pixels++;
    }
}

static void variances_are_those_of_samples_with_so_many_light_paths(void **state)
{
    (void)state;
    enum { BATCHES = 32, NUMBERS_TRIED = 3 };
    static const int number[NUMBERS_TRIED] = {NUMBER_ONE - 2, NUMBER_ONE, NUMBER_ONE + 2};
    struct stage stage = set_up(saturated_box_scene(range, PIXELS));
    struct batches reckoned[NUMBERS_TRIED] = {{0}}, found[NUMBERS_TRIED] = {{0}};
    for (uint32_t batch = 0; batch < BATCHES; batch++) {
        double variance[NUMBERS] = {0};
        trace_pixels(&stage, 1, true, batch * SEEDS, end_sample, add_pixel, variance);
        for (int i = 0; i < NUMBERS_TRIED; i++) {
            struct measured measured = {
                .told.it = stage.it, .worker = &stage.it->worker[0], .light_paths = trial_number(number[i])};
            batches_add(&reckoned[i], variance[number[i]]);
            stage.it->observe = listen;
            stage.it->observer = &measured.told;
            trace_pixels(&stage, trial_number(number[i]), false, 1000000 * (uint32_t)(i + 1) + batch * SEEDS,
                         measure_sample, measure_pixel, &measured);
            stage.it->observe = NULL;
            batches_add(&found[i], measured.variance * PIXELS * PIXELS / measured.pixels);
        }
    }
    assert_same(reckoned, found, NUMBERS_TRIED, (struct power){.sees_error = 0.2});
    put_away(&stage);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(second_moments_are_those_of_samples_with_so_many_light_paths),
        cmocka_unit_test(variances_are_those_of_samples_with_so_many_light_paths),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
