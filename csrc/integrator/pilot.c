/* What a render learns by looks at the scene, once it is large enough to pay for them: how many light sub-paths a sample should have, and how bright a pixel
   is (algorithm.md §15). A look has one light sub-path a sample; what others would have of variance and of work is reckoned from it. */
#include "integrator/pilot.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "base/thread.h"

enum { STAGES = 2, LOOKS = 2, PIXELS_MIN = 16, SAMPLES = 8 };
static const int stage_pixels[STAGES] = {128, 1024};
/* Samples that the frame has had for each one of a stage. One of a look is as dear as 1.5 with one light sub-path, and as five with 1/16: so looks cost a
   twentieth. */
static const double samples_before = 100;
static const uint32_t pilot_seed = 0x70696c6f;
/* Of the loss, variance × work, with one light sub-path: less is not worth what a look may have missed. */
static const double worth = 0.85;

/* --- One look -------------------------------------------------------------------------------------------------------- */

/* A look while it lasts: what each pixel saw, to be summed in their order whoever traced them. */
struct looking {
    struct integrator *it;
    bool (*stop)(void *user);
    void *user;
    atomic_bool stopped;
    int pixels;
    struct overview overview;
    bool weighs; /* struct trial's */
    struct look *seen;
};

/* The i-th of some pixels all over the frame: a golden ratio's lattice. */
static void choose_pixel(const struct integrator *it, int i, int pixels, int pixel[2])
{
    const double golden = 0.6180339887498949;
    double turn = golden * i;
    pixel[0] = (int)((turn - floor(turn)) * it->full[0]);
    pixel[1] = (int)((i + 0.5) / pixels * it->full[1]);
}

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
    struct trial trial = {.overview = &l->overview, .weighs = l->weighs};
    double unconnected = w->unconnected;
    choose_pixel(l->it, (int)i, l->pixels, trial.pixel);
    w->trial = &trial;
    memset(w->work, 0, sizeof w->work);
    for (int k = 0; k < SAMPLES; k++) {
        integrator_trace(l->it, w, trial.pixel[0], trial.pixel[1], pilot_seed, k);
        trial_end_sample(&trial);
    }
    w->trial = NULL;
    w->unconnected = unconnected;
    trial_end_pixel(&trial, SAMPLES, l->seen[i].variance);
    memcpy(l->seen[i].work, w->work, sizeof w->work);
}

/* False if it was stopped. */
static bool look_once(struct looking *l)
{
    thread_run(l->it->worker_count, (size_t)l->pixels, look_at, should_stop, l);
    return !should_stop(l);
}

static void sum_up(const struct looking *l, struct look *sum)
{
    double samples = (double)l->pixels * SAMPLES;
    *sum = (struct look){0};
    for (int i = 0; i < l->pixels; i++) {
        for (int kind = 0; kind < TECHNIQUE_KINDS; kind++)
            sum->work[kind] += l->seen[i].work[kind] / samples;
        for (int k = 0; k < NUMBERS; k++)
            sum->variance[k] += l->seen[i].variance[k] / samples;
    }
}

bool pilot_look(struct integrator *it, int pixels, bool weighs, bool (*stop)(void *), void *user,
                struct look *look)
{
    struct looking l = {.it = it, .stop = stop, .user = user, .pixels = pixels};
    /* Of the whole frame, so that a part of it is rendered as the whole is. */
    int border[4], frame[4] = {0, 0, it->full[0], it->full[1]};
    double light_paths = it->light_paths, typical = it->typical;
    l.seen = calloc((size_t)pixels, sizeof *l.seen);
    if (!l.seen)
        return false;
    memcpy(border, it->border, sizeof border);
    memcpy(it->border, frame, sizeof frame);
    overview_begin(&l.overview, it->full);
    it->light_paths = 1;
    it->typical = 0;
    /* The first time tells what is typical, here and there. */
    bool done = look_once(&l);
    if (done)
        typical = it->typical = overview_settle(&l.overview, (double)pixels * SAMPLES);
    l.weighs = weighs;
    if (done && weighs)
        done = look_once(&l);
    sum_up(&l, look);
    memcpy(it->border, border, sizeof border);
    it->light_paths = light_paths;
    it->typical = typical;
    free(l.seen);
    return done;
}

/* --- What follows from it -------------------------------------------------------------------------------------------- */

static double loss(const struct look *look, int k)
{
    double n = trial_number(k),
           work = look->work[BY_CAMERA] + fmin(n, 1) * look->work[BY_CONNECTIONS] + n * look->work[BY_SPLATS];
    return look->variance[k] * work;
}

/* The number of light sub-paths with the least loss, if it is worth it. What has no variance, by its noise, tells nothing. */
static double choose(const struct look *look)
{
    int best = NUMBER_ONE;
    double enough = worth * loss(look, NUMBER_ONE);
    for (int k = 0; k < NUMBERS; k++)
        if (look->variance[k] > 0 && loss(look, k) < fmin(loss(look, best), enough))
            best = k;
    return trial_number(best);
}

/* --- When ------------------------------------------------------------------------------------------------------------ */

static double area(const struct integrator *it)
{
    return (double)it->full[0] * it->full[1];
}

static int count_pixels(const struct integrator *it, int stage)
{
    return (int)fmin(fmax(PIXELS_MIN, area(it) / 4), stage_pixels[stage]);
}

static bool chooses(const struct integrator *it)
{
    return !(it->settings.light_paths > 0);
}

/* The sample before which a stage comes. Never the first, so that there is a picture at once. */
static int stage_begins(const struct integrator *it, int stage)
{
    double samples = (double)LOOKS * SAMPLES * count_pixels(it, stage);
    bool looks = it->exact && it->traces_camera && it->traces_light && it->splats;
    return looks ? (int)fmax(1, ceil(samples_before * samples / area(it))) : INT_MAX;
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
    struct look look;
    int stages = 0;
    while (stages < STAGES && stage_begins(it, stages) <= sample)
        stages++;
    if (it->looked >= stages || !pilot_look(it, count_pixels(it, stages - 1), chooses(it), stop, user, &look))
        return;
    it->looked = stages;
    if (chooses(it))
        it->light_paths = choose(&look);
}

double integrator_light_paths(const struct integrator *it, int *from)
{
    *from = chooses(it) && it->looked > 0 ? stage_begins(it, it->looked - 1) : 0;
    return it->traces_light ? it->light_paths : 0;
}
