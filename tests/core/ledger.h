/* Held against each other: what each technique delivers, class by class of labelled paths, and what its density claims of everybody's samples; and the
   weights against plain products (algorithm.md §8). STOKES_TEST_VERBOSE=1 prints every cell. */
#ifndef LEDGER_H
#define LEDGER_H

#include "integrator/mis.h"

extern const struct range ledger_range;
enum { LEDGER_PIXELS = 16 };

/* What is put to the test. `inner`: only connections of two traced sub-paths, chosen by hand. */
struct subject {
    const char *name;
    int lanes;
    bool lenses, inner;
    int edges, samples;
    enum kernel kernel;
    bool shared;                                      /* in a grey box, one wavelength for both sub-paths */
    struct scene *(*place)(struct range, int pixels); /* NULL: a box of boxes.h */
    double sees_error;                                /* of a path length's whole light; 0: 0.025 */
    double light_paths;                               /* of a sample; 0: 1 */
    double half_width_nm;                             /* of the kernel; 0: 4 */
};

/* An inner vertex that keeps the wavelength and is no δ. */
bool ledger_is_elastic(const struct full_path *, int vertex);
/* Row 4 of algorithm.md §9: both parts of the run that the cut is in disperse. */
bool ledger_is_copied(const struct full_path *, int cut);

/* Runs independent batches and asserts that each cell's surplus has expectation zero; *state is the subject. */
void techniques_deliver_what_they_claim(void **state);

#define TEST_OF(subject)                                                                                     \
    {                                                                                                        \
#subject, techniques_deliver_what_they_claim, NULL, NULL, &subject                                   \
    }

#endif
