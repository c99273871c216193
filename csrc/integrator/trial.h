/* What samples with one light sub-path each say of any other number of them: the variance that a picture would have
   (algorithm.md §15). Light is X+Y+Z and bins; but for lights that the camera sees, directly or by mirrors and clear glass: they are as
   noisy whatever is done, and so bright that they would be all that counts. */
#ifndef INTEGRATOR_TRIAL_H
#define INTEGRATOR_TRIAL_H

#include <stdatomic.h>

#include "integrator/mis.h"

/* The numbers of light sub-paths a sample that are told apart: powers of two. */
enum { NUMBERS = 9, NUMBER_ONE = 4 };
static inline double trial_number(int k)
{
    return ldexp(1, k - NUMBER_ONE);
}

/* How bright the parts of the frame are, and so what a deviation counts for there. */
enum { CELLS = 16 };
struct overview {
    int full[2];
    atomic_llong light[CELLS * CELLS]; /* integers: the same whoever brings it when */
    double scale[CELLS * CELLS];
};
void overview_begin(struct overview *, const int full[2]);
/* From light of so many samples, spread evenly: scales, for light to come. The mean of a pixel. */
double overview_settle(struct overview *, double samples);

/* The samples of one pixel. */
struct trial {
    struct overview *overview;
    int pixel[2];
    bool weighs;            /* else the overview alone is of interest */
    double moment[NUMBERS]; /* of contributions, and of products of those that come to a pixel at once */
    struct pixel_sums {     /* of what comes to the samples' own pixel */
        double sum[NUMBERS], squares[NUMBERS];
    } camera, connected, /* this sample's contributions, by s ≤ 1 and by s ≥ 2 */
        plain, joined;   /* all samples, by s ≤ 1 and in all */
};

/* Of a contribution: its light, and the lane that brings most of it; −1: it is dark. */
int trial_brightest(const struct integrator *, int lanes, const double value[], const float lambda_film[],
                    double *light);

/* A contribution of so much light by all its lanes, into the pixel `splat` if that is not the samples' own: enters the overview. What it counts for, 0
   where the overview alone is of interest. */
double trial_see(struct trial *, double light, const int splat[2]);
/* The rest of it; the brightest lane tells whose it is. */
void trial_add(struct trial *, const struct integrator *, const struct full_path *brightest, double counts);

/* Both, of a connection of worker->trial's samples, from its weighted values; but for the light itself, seen by the camera. */
struct joint;
void trial_add_joint(const struct integrator *, const struct worker *, const struct joint *,
                     const double value[], const float lambda_film[], const int splat[2]);
/* Its work, as much of it as roulette leaves. */
void trial_count(struct worker *, const struct joint *);

/* After each sample. */
void trial_end_sample(struct trial *);
/* Of one sample, times their number; deviations by the overview's scale. */
void trial_end_pixel(const struct trial *, int samples, double variance[NUMBERS]);

#endif
