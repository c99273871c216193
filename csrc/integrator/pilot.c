/* What a render learns by looks at the scene, once it is large enough to pay for them: how many light sub-paths a sample should have, and how bright a pixel
   is (algorithm.md §15).

   Each number is tried on the same pixels with the same random numbers, so that what is rare is as rare for all of them, and only what it
   weighs differs. What is compared is the variance of a pixel times the work of a sample. */
#include <limits.h>
#include <stdatomic.h>
#include <string.h>

#include "base/thread.h"
#include "integrator/path.h"
#include "integrator/roulette.h"

enum { STAGES = 2, LOOKS = 8, PIXELS_MIN = 16, PIXELS_MAX = 256, BLOCKS = 2, BLOCK = 4 };
static const int stage_pixels[STAGES] = {64, PIXELS_MAX};
/* Samples that the frame has had for each one of a stage: with the stage before, looks cost a twentieth. */
static const double samples_before = 25;
static const uint32_t pilot_seed = 0x70696c6f;
static const double hopeless = 1.25; /* loss over the least so far, to try still more, which costs more */
static const double fewest = 0.25, most = 16;
/* Loss, of what one light sub-path has: fewer may leave bright spots that are too rare for a look to see, and more make every sample dearer. */
static const double worth_fewer = 0.85, worth_more = 0.7;

struct look {
    double mean, loss; /* of a pixel, X+Y+Z and bins; variance × work of a sample */
};

/* But for lights that the camera sees: they are as noisy whatever is done, and so bright that they would be all that counts. */
static double gathered(const struct integrator *it, const struct worker *w)
{
    const double *xyz = w->gathered.xyz;
    return xyz[0] + xyz[1] + xyz[2] + (it->film->bins ? it->kappa * w->taken : 0) - w->trial.shown;
}

static double area(const struct integrator *it)
{
    return (double)it->full[0] * it->full[1];
}

static int count_pixels(const struct integrator *it, int stage)
{
    return (int)fmin(fmax(PIXELS_MIN, area(it) / 4), stage_pixels[stage]);
}

/* The i-th of some pixels all over the frame: a golden ratio's lattice. */
static void choose_pixel(const struct integrator *it, int i, int pixels, int *x, int *y)
{
    const double golden = 0.6180339887498949;
    double turn = golden * i;
    *x = (int)((turn - floor(turn)) * it->full[0]);
    *y = (int)((i + 0.5) / pixels * it->full[1]);
}

/* Of a sample, from two sums of BLOCK samples. */
static double pixel_variance(const double block[BLOCKS])
{
    double difference = block[0] - block[1];
    return difference * difference / (2 * BLOCK);
}

/* A look while it lasts: what each pixel saw, to be summed in their order whoever traced them. */
struct looking {
    struct integrator *it;
    bool (*stop)(void *user);
    void *user;
    atomic_bool stopped;
    int pixels;
    struct {
        double block[BLOCKS];
        struct trial trial;
    } seen[PIXELS_MAX];
};

static bool should_stop(void *context)
{
    struct looking *l = context;
    if (l->stop && l->stop(l->user))
        atomic_store(&l->stopped, true);
    return atomic_load(&l->stopped);
}

static void look_at(void *context, size_t i, int worker)
{
    struct looking *l = context;
    struct worker *w = &l->it->worker[worker];
    double unconnected = w->unconnected;
    int x, y;
    choose_pixel(l->it, (int)i, l->pixels, &x, &y);
    w->trial = (struct trial){.is_on = true};
    memset(l->seen[i].block, 0, sizeof l->seen[i].block);
    for (int k = 0; k < BLOCKS * BLOCK; k++) {
        w->trial.shown = 0;
        integrator_trace(l->it, w, x, y, pilot_seed, k);
        l->seen[i].block[k / BLOCK] += gathered(l->it, w);
    }
    l->seen[i].trial = w->trial;
    w->trial = (struct trial){0};
    w->unconnected = unconnected;
}

/* False if it was stopped. */
static bool look(struct looking *l, double light_paths, struct look *look)
{
    struct integrator *it = l->it;
    double sum = 0, squares = 0, work = 0, samples = (double)l->pixels * BLOCKS * BLOCK;
    it->light_paths = light_paths;
    thread_run(it->worker_count, (size_t)l->pixels, look_at, should_stop, l);
    if (should_stop(l))
        return false;
    for (int i = 0; i < l->pixels; i++) {
        const double *block = l->seen[i].block;
        sum += block[0] + block[1] + l->seen[i].trial.splats;
        squares += pixel_variance(block) * BLOCKS * BLOCK + l->seen[i].trial.squares;
        work += l->seen[i].trial.work;
    }
    look->mean = sum / samples;
    look->loss = squares / samples * (work / samples);
    return true;
}

/* Goes from one light sub-path by factors as far as that pays; `best` beats `worth` of what one has. */
static bool climb(struct looking *l, double one, double factor, double worth, double *best, double *least)
{
    struct look other;
    for (double light_paths = factor; light_paths >= fewest && light_paths <= most; light_paths *= factor) {
        if (!look(l, light_paths, &other))
            return false;
        if (other.loss < *least && other.loss < worth * one) {
            *least = other.loss;
            *best = light_paths;
        }
        if (factor > 1 && other.loss > hopeless * *least)
            break;
    }
    return true;
}

/* The number of light sub-paths with the least variance × work. With less of it on one side of 1 there is none to be had on the other. */
static double choose(struct looking *l)
{
    struct look one;
    double best = 1, least;
    /* Twice: the first look tells what is typical. */
    if (!look(l, 1, &one))
        return best;
    l->it->typical = one.mean;
    if (!look(l, 1, &one))
        return best;
    least = one.loss;
    if (climb(l, one.loss, 0.5, worth_fewer, &best, &least) && best == 1)
        climb(l, one.loss, 2, worth_more, &best, &least);
    return best;
}

/* --- When ------------------------------------------------------------------------------------------------------------ */

/* The sample before which a stage comes. Never the first, so that there is a picture at once. */
static int stage_begins(const struct integrator *it, int stage)
{
    double samples = (double)LOOKS * BLOCKS * BLOCK * count_pixels(it, stage);
    bool chooses = it->exact && !(it->settings.light_paths > 0) && it->traces_light && it->traces_camera;
    return chooses ? (int)fmax(1, ceil(samples_before * samples / area(it))) : INT_MAX;
}

int integrator_next_look(const struct integrator *it, int sample)
{
    int next = INT_MAX;
    for (int i = STAGES - 1; i >= 0; i--)
        if (stage_begins(it, i) > sample)
            next = stage_begins(it, i);
    return next;
}

void integrator_look(struct integrator *it, int sample, bool (*stop)(void *), void *user)
{
    struct looking l = {.it = it, .stop = stop, .user = user};
    int stages = 0;
    while (stages < STAGES && stage_begins(it, stages) <= sample)
        stages++;
    if (it->looked >= stages)
        return;
    it->looked = stages;
    l.pixels = count_pixels(it, stages - 1);
    /* Of the whole frame, so that a part of it is rendered as the whole is. */
    int border[4], frame[4] = {0, 0, it->full[0], it->full[1]};
    memcpy(border, it->border, sizeof border);
    memcpy(it->border, frame, sizeof frame);
    it->typical = 0;
    it->light_paths = choose(&l);
    memcpy(it->border, border, sizeof border);
}

double integrator_light_paths(const struct integrator *it, int *from)
{
    *from = it->looked > 0 ? stage_begins(it, it->looked - 1) : 0;
    return it->traces_light ? it->light_paths : 0;
}
