/* Statistics for tests: a claim about a random result is tested with a stated false-alarm rate and a stated
   error that it would see, never with a tolerance found by trial.

   The false-alarm budget. The whole suite may cry wolf once in SUITE_FALSE_ALARM⁻¹ choices of seeds. Half of
   that is for the C tests, half for tests/system, and each half is divided equally (Bonferroni) among at most
   C_FAMILIES and SYSTEM_FAMILIES families. A family is one call of an assert_… below (or of its twin in
   tests/system/statistics.py), with however many bins; within it the rate is divided among the bins by Šidák.
   Seeds are fixed: a test that passes keeps passing.

   Power. A comparison "sees" an error if it would raise the alarm with at least 99 % chance. Fewer samples
   than that takes are a failure too: a test that sees nothing proves nothing.

   Include base/error.h (and rooms' headers that do) before cmocka.h: cmocka's macro `fail` hides the
   function. */
#ifndef STATISTICS_H
#define STATISTICS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SUITE_FALSE_ALARM 1e-6
#define C_FAMILIES 250
#define SYSTEM_FAMILIES 250
#define C_FALSE_ALARM                                                                                        \
    (SUITE_FALSE_ALARM / 2 / C_FAMILIES) /* of one family, 2e-9: the default for `false_alarm` */

/* Independent uniform numbers in [0, 1), addressed by seed and index: the tests here assume independent
   samples, and those of base/random.h are stratified on purpose. */
double independent(uint64_t seed, uint64_t index);

/* --- Distributions --------------------------------------------------------------------------------- */

double normal_upper_tail(double z);                       /* P(Z > z) */
double normal_quantile(double p);                         /* z with P(Z ≤ z) = p, 0 < p < 1 */
double student_upper_tail(double t, double freedom);      /* P(T > t) */
double student_critical(double p, double freedom);        /* t with P(T > t) = p, p < 1/2 */
double chi2_upper_tail(double statistic, double freedom); /* P(X > statistic) */
double chi2_critical(double p, double freedom);           /* x with P(X > x) = p */
double gamma_upper(double a, double x);                   /* regularised incomplete gamma Q(a, x) */
double beta_lower(double a, double b, double x);          /* regularised incomplete beta I_x(a, b) */

/* --- Batches ---------------------------------------------------------------------------------------------
 */

/* Results of independent batches of equal size, each the mean of enough samples to be near normal (Welford's
   sums). Start from {0}. */
struct batches {
    uint64_t count;
    double mean, square; /* Σ (value − mean)² */
};
void batches_add(struct batches *, double value);
double batches_variance(const struct batches *); /* of one batch; 0 below two batches */
double batches_error(const struct batches *);    /* standard error of the mean */

/* What a test promises. Errors are relative to the exact value, or to `scale` where that is larger (bins near
 * zero). */
struct power {
    double false_alarm; /* of the whole family; 0: C_FALSE_ALARM */
    double sees_error;  /* this relative error in any one comparison would be seen; 0: no promise */
    double scale;
};

/* The share of a family's false-alarm rate that each of n independent comparisons gets: 1 − (1 − α)^(1/n). */
double sidak(double false_alarm, size_t comparisons);

struct finding {
    double z;      /* standard normal deviate as unlikely as the Student's t that was found */
    double sees;   /* the relative error that this comparison would see */
    bool agrees;   /* no alarm */
    bool powerful; /* sees ≤ sees_error */
};
/* One of `comparisons` in the family: is the batches' expectation `exact`? */
struct finding batches_against(const struct batches *, double exact, struct power, size_t comparisons);
/* Have both the same expectation (Welch's test)? Errors are relative to their mean. */
struct finding batches_versus(const struct batches *, const struct batches *, struct power,
                              size_t comparisons);

/* agrees && powerful */
bool batches_agree(const struct batches *, double exact, struct power, size_t comparisons);

/* --- Families, for cmocka: fail the running test and print each comparison that raised the alarm or saw too
 * little ----- */

void assert_unbiased(const struct batches *bins, const double *exact, size_t count, struct power);
void assert_same(const struct batches *a, const struct batches *b, size_t count, struct power);

/* --- χ² --------------------------------------------------------------------------------------------------
 */

#define CHI2_EXPECTED_MIN 10 /* counts; smaller bins are pooled */

struct chi2 {
    double statistic, p; /* p 0 where something was counted that cannot be */
    size_t freedom;      /* degrees of freedom: pooled bins − 1 − fitted */
    double count;        /* Σ expected */
};
/* Observed against expected counts. Bins that expect less than CHI2_EXPECTED_MIN are pooled with each other.
 */
struct chi2 chi2_test(const double *observed, const double *expected, size_t bins, size_t fitted);
/* The root mean square relative error of the bins' probabilities that such a test sees. */
double chi2_sees(const struct chi2 *, double false_alarm);
void assert_distributed(const double *observed, const double *expected, size_t bins, struct power);

#endif
