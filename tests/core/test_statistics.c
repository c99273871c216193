/* The statistical kit against published values and against itself: it must stay quiet on the truth, fire on
   an error of the size that it promises to see, and refuse to judge from too few samples. */
#include "statistics.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

#define ASSERT_NEAR(value, wanted, relative) assert_true(fabs((value) / (wanted)-1) < (relative))

static void normal_distribution_has_its_published_values(void **state)
{
    (void)state;
    ASSERT_NEAR(normal_upper_tail(1.959963984540054), 0.025, 1e-12);
    ASSERT_NEAR(normal_quantile(0.975), 1.959963984540054, 1e-12);
    ASSERT_NEAR(normal_quantile(1e-9), -5.997807015007687, 1e-12);
    ASSERT_NEAR(normal_upper_tail(6), 9.865876450376946e-10, 1e-12);
}

static void student_distribution_has_its_published_values(void **state)
{
    (void)state;
    /* One degree of freedom is Cauchy's distribution, two have a closed form. */
    ASSERT_NEAR(student_upper_tail(3, 1), 0.5 - atan(3) / acos(-1), 1e-12);
    ASSERT_NEAR(student_upper_tail(1.5, 2), 0.5 - 1.5 / (2 * sqrt(2 + 1.5 * 1.5)), 1e-12);
    ASSERT_NEAR(student_critical(0.025, 10), 2.228138851964939, 1e-10);
    ASSERT_NEAR(student_critical(0.0005, 31), 3.633456, 1e-6);
    ASSERT_NEAR(student_upper_tail(-2, 7) + student_upper_tail(2, 7), 1, 1e-12);
}

static void chi2_distribution_has_its_published_values(void **state)
{
    (void)state;
    ASSERT_NEAR(chi2_upper_tail(7, 2), exp(-3.5), 1e-12); /* closed form */
    ASSERT_NEAR(chi2_upper_tail(80, 2), exp(-40), 1e-11);
    ASSERT_NEAR(chi2_critical(0.05, 10), 18.307038053275146, 1e-10);
    ASSERT_NEAR(chi2_critical(0.95, 10), 3.940299136119060, 1e-10);
    ASSERT_NEAR(chi2_upper_tail(3, 1), 2 * normal_upper_tail(sqrt(3)), 1e-12);
    ASSERT_NEAR(gamma_upper(0.5, 30), erfc(sqrt(30)), 1e-11);
}

static void sidak_shares_make_up_the_family(void **state)
{
    (void)state;
    ASSERT_NEAR(1 - pow(1 - sidak(0.01, 50), 50), 0.01, 1e-12);
    assert_true(sidak(1e-9, 100) >= 1e-11);
}

/* A batch: the mean of `samples` exponential variates of mean 1, whose relative error is 1/√samples. */
static double exponential_batch(uint32_t seed, uint32_t batch, uint32_t samples)
{
    double sum = 0;
    for (uint32_t i = 0; i < samples; i++)
        sum -= log1p(-independent((uint64_t)seed << 32 | batch, i));
    return sum / samples;
}

static struct batches exponential_batches(uint32_t seed, uint32_t count, uint32_t samples)
{
    struct batches batches = {0};
    for (uint32_t i = 0; i < count; i++)
        batches_add(&batches, exponential_batch(seed, i, samples));
    return batches;
}

#define FAMILIES_TRIED 20
#define BATCHES 64
#define SAMPLES 24576
#define BINS 10
static const struct power percent = {.false_alarm = 1e-4, .sees_error = 0.01};

static void means_agree_with_the_truth_and_not_with_one_percent_more(void **state)
{
    (void)state;
    int quiet = 0, fired = 0;
    for (uint32_t family = 0; family < FAMILIES_TRIED; family++) {
        struct batches batches = exponential_batches(family, BATCHES, SAMPLES);
        quiet += batches_agree(&batches, 1, percent, BINS);
        fired += !batches_against(&batches, 1.01, percent, BINS).agrees;
        fired += !batches_against(&batches, 0.99, percent, BINS).agrees;
    }
    /* Chance of one false alarm here: 20 × 1e-4 / 10 = 0.02 %. Errors are missed in at most 1 % of the cases.
     */
    assert_int_equal(quiet, FAMILIES_TRIED);
    assert_true(fired > 35);
}

static void two_means_agree_unless_they_differ_by_what_is_promised(void **state)
{
    (void)state;
    int quiet = 0, fired = 0;
    for (uint32_t family = 0; family < FAMILIES_TRIED; family++) {
        struct batches a = exponential_batches(1000 + family, BATCHES, SAMPLES);
        struct batches b = exponential_batches(2000 + family, BATCHES, SAMPLES), shifted = b;
        shifted.mean *= 1.01;
        struct finding same = batches_versus(&a, &b, percent, BINS),
                       other = batches_versus(&a, &shifted, percent, BINS);
        quiet += same.agrees && same.powerful;
        fired += !other.agrees;
    }
    assert_int_equal(quiet, FAMILIES_TRIED);
    assert_true(fired > 16);
}

static void false_alarms_come_as_often_as_stated(void **state)
{
    (void)state;
    const struct power loose = {.false_alarm = 0.2};
    int alarms = 0;
    for (uint32_t trial = 0; trial < 4000; trial++) {
        struct batches batches = exponential_batches(10000 + trial, 12, 64);
        alarms += !batches_against(&batches, 1, loose, 1).agrees;
    }
    /* Binomial: 800 ± 25; the skew that batches of 64 keep adds a little. Ten standard errors either way. */
    assert_in_range(alarms, 550, 1050);
}

static void too_few_samples_fail_even_when_they_agree(void **state)
{
    (void)state;
    struct batches batches = exponential_batches(7, 32, 64);
    struct finding finding = batches_against(&batches, 1, percent, BINS);
    assert_true(finding.agrees && !finding.powerful);
    assert_false(batches_agree(&batches, 1, percent, BINS));
    struct batches one = exponential_batches(7, 1, 64), not_finite = batches;
    batches_add(&not_finite, NAN);
    assert_false(batches_agree(&one, one.mean, percent, BINS));
    assert_false(batches_agree(&not_finite, 1, percent, BINS));
}

static void batches_without_variance_must_be_exact(void **state)
{
    (void)state;
    struct batches batches = {0};
    for (int i = 0; i < 4; i++)
        batches_add(&batches, 0.25);
    assert_true(batches_agree(&batches, 0.25, percent, BINS));
    assert_false(batches_agree(&batches, 0.25001, percent, BINS));
}

/* Counts of `n` draws from a density over `bins` whose odd bins are `error` too likely and even ones too
 * rare. */
static void draw_counts(uint32_t seed, uint32_t n, size_t bins, double error, double *observed,
                        double *expected)
{
    for (size_t i = 0; i < bins; i++) {
        observed[i] = 0;
        expected[i] = n / (double)bins;
    }
    for (uint32_t i = 0; i < n; i++) {
        size_t pair = (size_t)(independent(seed, 2 * i) * ((double)bins / 2));
        observed[2 * pair + (independent(seed, 2 * i + 1) < (1 + error) / 2)]++;
    }
}

static void chi2_is_quiet_on_the_truth_and_fires_on_what_it_promises(void **state)
{
    (void)state;
    double observed[40], expected[40];
    int quiet = 0, fired = 0;
    const uint32_t draws = 60000;
    double sees = 0;
    for (uint32_t seed = 0; seed < 50; seed++) {
        draw_counts(seed, draws, 40, 0, observed, expected);
        struct chi2 truth = chi2_test(observed, expected, 40, 0);
        quiet += truth.p > 1e-5;
        sees = chi2_sees(&truth, 1e-5);
        draw_counts(seed + 100, draws, 40, sees, observed, expected);
        fired += chi2_test(observed, expected, 40, 0).p < 1e-5;
    }
    assert_true(sees > 0.03 && sees < 0.05);
    assert_int_equal(quiet, 50);
    assert_true(fired >= 45); /* 99 % each: fewer has a chance of 1e-5 */
}

static void chi2_pools_small_bins_and_refuses_the_impossible(void **state)
{
    (void)state;
    double observed[] = {1000, 1, 0, 2, 1010, 3, 4}, expected[] = {1000, 2, 1, 2, 1000, 3, 3};
    struct chi2 result = chi2_test(observed, expected, 7, 0);
    assert_int_equal(result.freedom, 2);
    ASSERT_NEAR(result.statistic, 0.1 + 1 / 11.0, 1e-12);
    expected[3] = 0;
    assert_true(chi2_test(observed, expected, 7, 0).p == 0);
}

static void families_fail_the_test_that_asks(void **state)
{
    (void)state;
    struct batches bins[2] = {exponential_batches(1, BATCHES, SAMPLES),
                              exponential_batches(2, BATCHES, SAMPLES)};
    const double truth[2] = {1, 1}, wrong[2] = {1, 1.02};
    assert_unbiased(bins, truth, 2, percent);
    assert_same(&bins[0], &bins[1], 1, percent);
    assert_false(batches_agree(&bins[1], wrong[1], percent, 2));
    double observed[40], expected[40];
    draw_counts(3, 60000, 40, 0, observed, expected);
    assert_distributed(observed, expected, 40, (struct power){.sees_error = 0.05});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(normal_distribution_has_its_published_values),
        cmocka_unit_test(student_distribution_has_its_published_values),
        cmocka_unit_test(chi2_distribution_has_its_published_values),
        cmocka_unit_test(sidak_shares_make_up_the_family),
        cmocka_unit_test(means_agree_with_the_truth_and_not_with_one_percent_more),
        cmocka_unit_test(two_means_agree_unless_they_differ_by_what_is_promised),
        cmocka_unit_test(false_alarms_come_as_often_as_stated),
        cmocka_unit_test(too_few_samples_fail_even_when_they_agree),
        cmocka_unit_test(batches_without_variance_must_be_exact),
        cmocka_unit_test(chi2_is_quiet_on_the_truth_and_fires_on_what_it_promises),
        cmocka_unit_test(chi2_pools_small_bins_and_refuses_the_impossible),
        cmocka_unit_test(families_fail_the_test_that_asks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
