/* What a render learns before it begins: how many light sub-paths a sample should have, and how bright a pixel is (algorithm.md §15).

   Each number is tried on the same pixels with the same random numbers, so that what is rare is as rare for all of them, and only what it
   weighs differs. What is compared is the variance of a pixel times the work of a sample. */
#include <string.h>

#include "integrator/path.h"
#include "integrator/roulette.h"

enum { PIXELS_MIN = 16, PIXELS_MAX = 256, BLOCKS = 2, BLOCK = 4 };
static const uint32_t pilot_seed = 0x70696c6f;
static const double hopeless = 1.25; /* loss, to go further the same way */
/* More light sub-paths make every sample dearer, and what is too rare for a few samples to see gains nothing by them. */
static const double worth_more = 0.7;

struct look {
    double mean, loss; /* of a pixel, X+Y+Z and bins; variance × work of a sample */
};

static double gathered(const struct integrator *it, const struct worker *w)
{
    const double *xyz = w->gathered.xyz;
    return xyz[0] + xyz[1] + xyz[2] + (it->film->bins ? it->kappa * w->taken : 0);
}

/* The i-th of some pixels all over the frame: a golden ratio's lattice. */
static void choose_pixel(const struct integrator *it, int i, int pixels, int *x, int *y)
{
    const double golden = 0.6180339887498949;
    double turn = golden * i;
    *x = (int)((turn - floor(turn)) * it->full[0]);
    *y = (int)((i + 0.5) / pixels * it->full[1]);
}

/* Of a sample, from two sums of BLOCK samples. A pixel that shows a lamp is as noisy whatever is done, and so bright that it would be all that
   counts: what both blocks agree to be far above the average counts for the average. */
static double pixel_variance(const double block[BLOCKS], double typical)
{
    double difference = block[0] - block[1];
    double sure = fmin(block[0], block[1]) / BLOCK, scale = typical > 0 ? fmax(1, sure / typical) : 1;
    return difference * difference / (2 * BLOCK * scale * scale);
}

/* False if it was stopped. */
static bool look(struct integrator *it, double light_paths, bool (*stop)(void *), void *user,
                 struct look *look)
{
    double area = (double)it->full[0] * it->full[1];
    int pixels = (int)fmin(fmax(PIXELS_MIN, area / 4), PIXELS_MAX);
    int samples = pixels * BLOCKS * BLOCK;
    struct worker *w = &it->worker[0];
    double sum = 0, squares = 0;
    it->light_paths = light_paths;
    w->trial = (struct trial){.is_on = true};
    for (int i = 0; i < pixels; i++) {
        double block[BLOCKS] = {0};
        int x, y;
        choose_pixel(it, i, pixels, &x, &y);
        for (int k = 0; k < BLOCKS * BLOCK; k++) {
            integrator_trace(it, w, x, y, pilot_seed, k);
            block[k / BLOCK] += gathered(it, w);
        }
        sum += block[0] + block[1];
        squares += pixel_variance(block, it->typical) * BLOCKS * BLOCK;
        if (stop && stop(user))
            return false;
    }
    look->mean = (sum + w->trial.splats) / samples;
    look->loss = (squares + w->trial.squares) / samples * (w->trial.work / samples);
    return true;
}

void integrator_prepare(struct integrator *it, bool (*stop)(void *), void *user)
{
    static const struct {
        double light_paths, loss; /* the latter to be beaten, of what one has */
        bool goes_on;
    } ways[] = {{0.5, 1, false}, {0.25, 1, true}, {2, worth_more, false}, {4, worth_more, true}};
    struct worker *w = &it->worker[0];
    struct look one, other = {0, 0};
    double best = 1;
    if (!it->exact || it->settings.light_paths > 0 || !it->traces_light || !it->traces_camera)
        return;
    /* Of the whole frame, so that a part of it is rendered as the whole is. */
    int border[4], frame[4] = {0, 0, it->full[0], it->full[1]};
    memcpy(border, it->border, sizeof border);
    memcpy(it->border, frame, sizeof frame);
    /* Twice: the first look tells what is typical. */
    if (look(it, 1, stop, user, &one)) {
        it->typical = one.mean;
        double least = look(it, 1, stop, user, &one) ? one.loss : 0;
        for (size_t i = 0; least > 0 && i < sizeof ways / sizeof *ways; i++) {
            if (ways[i].goes_on && other.loss > hopeless * one.loss)
                continue;
            if (!look(it, ways[i].light_paths, stop, user, &other))
                break;
            if (other.loss < least && other.loss < ways[i].loss * one.loss) {
                least = other.loss;
                best = ways[i].light_paths;
            }
        }
    }
    memcpy(it->border, border, sizeof border);
    it->light_paths = best;
    w->trial = (struct trial){0};
    w->all = w->unconnected = 0;
}

double integrator_light_paths(const struct integrator *it)
{
    return it->traces_light ? it->light_paths : 0;
}
