/* Second moments under other counts of techniques (algorithm.md §15). With densities p_j and counts n_j, a contribution is c = f/Σ n_j p_j; with counts n'_j it
   is c' = f/Σ n'_j p_j, and Σ_j n'_j ∫ p_j c'² = Σ_j n_j ∫ p_j c c'. So what camera sub-paths alone hardly ever find counts as often as light
   sub-paths find it. */
#include "integrator/trial.h"

#include <math.h>

#include "integrator/joint.h"
#include "integrator/roulette.h"

/* --- The overview -------------------------------------------------------------------------------------------- */

/* Light counts in steps of 6e-8, and one contribution for 6e4 at most. */
static const double unit = 1 << 24, most = 1e12;

void overview_begin(struct overview *o, const int full[2])
{
    for (int i = 0; i < CELLS * CELLS; i++) {
        atomic_init(&o->light[i], 0);
        o->scale[i] = 1;
    }
    for (int i = 0; i < 2; i++)
        o->full[i] = full[i];
}

static int cell_of(const struct overview *o, int x, int y)
{
    return (int)((int64_t)y * CELLS / o->full[1] * CELLS + (int64_t)x * CELLS / o->full[0]);
}

/* Pixels of [0, full) in a row of cells' i-th. */
static double width_of(int full, int i)
{
    int64_t first = ((int64_t)i * full + CELLS - 1) / CELLS,
            end = ((int64_t)(i + 1) * full + CELLS - 1) / CELLS;
    return (double)(end - first);
}

double overview_settle(struct overview *o, double samples)
{
    double per_pixel = samples / ((double)o->full[0] * o->full[1]), all = 0;
    for (int i = 0; i < CELLS * CELLS; i++)
        all += (double)atomic_load(&o->light[i]) / unit;
    double mean = all / samples;
    for (int i = 0; i < CELLS * CELLS; i++) {
        double pixels = width_of(o->full[0], i % CELLS) * width_of(o->full[1], i / CELLS);
        double here = pixels > 0 ? (double)atomic_load(&o->light[i]) / unit / (pixels * per_pixel) : 0;
        o->scale[i] = mean > 0 ? 1 / (mean + here) : 1;
        atomic_store(&o->light[i], 0);
    }
    return mean;
}

/* --- Contributions ------------------------------------------------------------------------------------------- */

int trial_brightest(const struct integrator *it, int lanes, const double value[], const float lambda_film[],
                    double *light)
{
    int brightest = -1;
    double most = 0;
    *light = 0;
    for (int i = 0; i < lanes; i++) {
        double here = value[i] * roulette_color(it, lambda_film[i]);
        if (!(here > 0) || !isfinite(here))
            continue;
        if (here > most) {
            most = here;
            brightest = i;
        }
        *light += here;
    }
    return brightest;
}

static void sums_add(struct pixel_sums *sums, int k, double value)
{
    sums->sum[k] += value;
    sums->squares[k] += value * value;
}

/* Of all pairs of different ones. */
static double products(const struct pixel_sums *sums, int k)
{
    return sums->sum[k] * sums->sum[k] - sums->squares[k];
}

double trial_see(struct trial *trial, double light, const int splat[2])
{
    const int *pixel = splat ? splat : trial->pixel;
    struct overview *o = trial->overview;
    int cell = cell_of(o, pixel[0], pixel[1]);
    atomic_fetch_add_explicit(&o->light[cell], llrint(fmin(light * unit, most)), memory_order_relaxed);
    return trial->weighs ? light * o->scale[cell] : 0;
}

void trial_add(struct trial *trial, const struct integrator *it, const struct full_path *brightest,
               double now)
{
    enum technique_kind kind = technique_kind(brightest->cut, brightest->edges + 1 - brightest->cut);
    double share[TECHNIQUE_KINDS];
    if (!mis_shares(it, brightest, share))
        return;
    for (int k = 0; k < NUMBERS; k++) {
        double n = trial_number(k);
        double then = now / (share[BY_CAMERA] + fmin(n, 1) * share[BY_CONNECTIONS] + n * share[BY_SPLATS]);
        trial->moment[k] += now * then;
        if (kind != BY_SPLATS)
            sums_add(kind == BY_CAMERA ? &trial->camera : &trial->connected, k, then);
    }
}

void trial_add_joint(const struct integrator *it, const struct worker *w, const struct joint *joint,
                     const double value[], const float lambda_film[], const int splat[2])
{
    double light;
    int brightest = trial_brightest(it, joint->lanes, value, lambda_film, &light);
    if (brightest < 0 || joint->s + joint->t == 2)
        return;
    double now = trial_see(w->trial, light, splat);
    if (now > 0) {
        struct full_path path;
        full_path_of_joint(it, w, joint, brightest, &path);
        trial_add(w->trial, it, &path, now);
    }
}

void trial_count(struct worker *w, const struct joint *joint)
{
    /* In edges traced: its ends, its shadow ray and its weight; where sub-paths meet, their runs evaluated again, too. */
    static const double work[TECHNIQUE_KINDS] = {
        [BY_CAMERA] = 0.7, [BY_CONNECTIONS] = 1.3, [BY_SPLATS] = 0.7};
    enum technique_kind kind = technique_kind(joint->s, joint->t);
    w->work[kind] += work[kind] / joint->owed;
}

/* Contributions by s ≥ 2 come all at once, in so many of the samples. */
void trial_end_sample(struct trial *trial)
{
    for (int k = 0; k < NUMBERS; k++) {
        double joined = fmin(trial_number(k), 1), a = trial->camera.sum[k], b = trial->connected.sum[k];
        trial->moment[k] +=
            products(&trial->camera, k) + joined * (2 * a * b + products(&trial->connected, k));
        sums_add(&trial->plain, k, a);
        sums_add(&trial->joined, k, a + b);
    }
    trial->camera = trial->connected = (struct pixel_sums){0};
}

/* Less the squared means, of samples with a light sub-path and of samples without: how many are which is not left to chance. */
void trial_end_pixel(const struct trial *trial, int samples, double variance[NUMBERS])
{
    for (int k = 0; k < NUMBERS; k++) {
        double joined = fmin(trial_number(k), 1);
        double squares = joined * products(&trial->joined, k) + (1 - joined) * products(&trial->plain, k);
        variance[k] = trial->moment[k] - squares / (samples - 1);
    }
}
