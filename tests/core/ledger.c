/* Books of what techniques give and claim: one observer enters each contribution for all cuts of its path. */
#include "ledger.h"

#include "boxes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "integrator/link.h"
#include "statistics.h"

#include <cmocka.h>

const struct range ledger_range = {300, 830};

enum {
    EDGES_MAX = 7,
    CUTS = EDGES_MAX + 1,
    CLASSES = 16,
    CELLS = (EDGES_MAX + 1) * CUTS * CLASSES,
    BATCHES = 32,
    PIXELS = LEDGER_PIXELS
};

/* What technique (path length, cut) gave itself, and what its density claims of everybody's samples. */
struct ledger {
    const struct integrator *it;
    double delivered[CELLS], claimed[CELLS];
    double worst_weight; /* distance from the plain products */
};

static bool is_dye(const struct full_path *path, int i)
{
    return i > 0 && i < path->edges && path->step[i].label == LABEL_FLUORESCENT;
}

bool ledger_is_elastic(const struct full_path *path, int i)
{
    return i > 0 && i < path->edges && path->step[i].label == LABEL_ELASTIC;
}

/* Row 4 of algorithm.md §9: both parts of the run that the cut is in disperse. */
bool ledger_is_copied(const struct full_path *path, int cut)
{
    struct chart chart;
    chart_runs(path, &chart);
    return cut > 0 && chart.from_light[cut - 1].disperses && chart.from_camera[cut].disperses;
}

/* By which of its vertices fluoresce; or by how many do, and whether the cut is of the rarest kind: joined by the kernel, or by a copied
   wavelength. */
static int class_of(const struct integrator *it, const struct full_path *path, int cut)
{
    int mask = 0, count = 0;
    for (int i = 1; i < path->edges; i++) {
        mask |= is_dye(path, i) << (i - 1);
        count += is_dye(path, i);
    }
    if (!it->exact)
        return 2 * count + (cut > 0 && ledger_is_elastic(path, cut - 1) && ledger_is_elastic(path, cut));
    return path->edges <= 5 ? mask : 2 * count + ledger_is_copied(path, cut);
}

/* By how many of its vertices fluoresce, and how many scatter inside of volumes. */
static int class_in_volumes(const struct full_path *path)
{
    int dyes = 0, inside = 0;
    for (int i = 1; i < path->edges; i++) {
        dyes += is_dye(path, i);
        inside += path->step[i].in_volume;
    }
    return 5 * (dyes < 2 ? dyes : 2) + (inside < 4 ? inside : 4);
}

static int cell(const struct ledger *ledger, const struct full_path *path, int cut)
{
    return (path->edges * CUTS + cut) * CLASSES +
           (ledger->it->has_volumes ? class_in_volumes(path) : class_of(ledger->it, path, cut));
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
    ledger->delivered[cell(ledger, path, path->cut)] += value;
    if (path->weight > 0)
        ledger->worst_weight =
            fmax(ledger->worst_weight, fabs(path->weight - density[path->cut] / densities));
    for (int cut = 0; cut <= path->edges; cut++)
        ledger->claimed[cell(ledger, path, cut)] += value * density[cut] / densities;
}

/* Cells with less of their path length hold a few large contributions, and no mean of them is near normal; those of paths that met a lamp
   by themselves most of all. */
static double rare_share(int cut)
{
    return cut == 0 ? 3e-3 : 3e-4;
}

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
        int cut = i / CLASSES % CUTS;
        if (claimed[i].mean <= rare_share(cut) * total)
            continue;
        struct finding found =
            batches_against(&surplus[i], 0, (struct power){.sees_error = sees_error, .scale = total}, CELLS);
        if (getenv("STOKES_TEST_VERBOSE") || !found.agrees || !found.powerful)
            print_message("edges %d, cut %d, class %d: delivers %.5g, claims %.5g of %.5g (z %.2f, sees %.2g "
                          "of all, %.2g of itself)\n",
                          edges, cut, i % CLASSES, delivered[i].mean, claimed[i].mean, total, found.z,
                          found.sees, found.sees * total / claimed[i].mean);
        fine &= found.agrees && found.powerful;
    }
    return fine;
}

static struct integrator_settings settings_of(const struct subject *subject)
{
    struct integrator_settings settings = integrator_settings_default();
    settings.name = subject->name;
    settings.lanes = subject->lanes;
    settings.kernel = subject->kernel;
    settings.shared_wavelength = subject->shared;
    settings.light_paths = subject->light_paths;
    settings.d0_nm = subject->half_width_nm > 0 ? subject->half_width_nm : 4;
    settings.shrink = 0;
    settings.max_path = subject->edges;
    settings.all_techniques = !subject->inner;
    for (int s = 2; s < TECHNIQUES_MAX; s++)
        for (int t = 2; t < TECHNIQUES_MAX; t++)
            settings.technique[s][t] = true;
    return settings;
}

/* Runs BATCHES independent batches and asserts that each cell's surplus has expectation zero. */
void techniques_deliver_what_they_claim(void **state)
{
    const struct subject *subject = *state;
    struct scene *scene = subject->place    ? subject->place(ledger_range, PIXELS)
                          : subject->shared ? grey_box_scene(ledger_range, PIXELS)
                                            : box_scene(ledger_range, subject->lenses, PIXELS);
    int border[4] = {0, 0, PIXELS, PIXELS};
    struct film *film = film_create(PIXELS, PIXELS, border, 0, ledger_range, NULL);
    struct integrator_settings settings = settings_of(subject);
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
        for (int sample = 0; sample < subject->samples; sample++)
            for (int pixel = 0; pixel < PIXELS * PIXELS; pixel++)
                integrator_sample(it, 0, pixel % PIXELS, pixel / PIXELS, batch * subject->samples + sample);
        worst_weight = fmax(worst_weight, ledger.worst_weight);
        for (int i = 0; i < CELLS; i++) {
            batches_add(&surplus[i], (ledger.delivered[i] - ledger.claimed[i]) / subject->samples);
            batches_add(&delivered[i], ledger.delivered[i] / subject->samples);
            batches_add(&claimed[i], ledger.claimed[i] / subject->samples);
        }
    }
    bool fine = true;
    for (int edges = 1; edges <= subject->edges; edges++)
        fine &= cells_agree(edges, delivered, claimed, surplus,
                            subject->sees_error > 0 ? subject->sees_error : 0.025);
    integrator_destroy(it);
    film_destroy(film);
    scene_destroy(scene);
    assert_true(fine);
    /* The recursion of the weights is their plain products, and so they sum to 1. */
    assert_true(worst_weight < 1e-4);
}
