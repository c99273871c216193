/* Statistics for tests: distributions by series and continued fractions (Abramowitz & Stegun 1964, §6.5,
   §26.5), batches, families and χ². Written for clarity: tests ask a few hundred times, not a million. */
#include "statistics.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/random.h"

#define DETECTION 0.99 /* chance with which an error is "seen" */
#define TERMS_MAX 100000

double independent(uint64_t seed, uint64_t index)
{
    uint64_t x = random_mix(random_mix(seed + 0x9e3779b97f4a7c15ull) + 0xd1342543de82ef95ull * index);
    return (double)(x >> 11) * 0x1p-53;
}

/* --- Distributions ---------------------------------------------------------------------------------------
 */

double normal_upper_tail(double z)
{
    return erfc(z / sqrt(2)) / 2;
}

/* x in [low, high] with f(x) = target for a falling f: bisection to the last bit. */
static double invert_falling(double (*f)(double x, double parameter), double parameter, double target,
                             double low, double high)
{
    for (int i = 0; i < 200; i++) {
        double middle = (low + high) / 2;
        if (f(middle, parameter) > target)
            low = middle;
        else
            high = middle;
    }
    return (low + high) / 2;
}

static double normal_tail_of(double z, double unused)
{
    (void)unused;
    return normal_upper_tail(z);
}

double normal_quantile(double p)
{
    /* By the smaller tail: 1 − p would round away a p near 0. */
    return p < 0.5 ? -invert_falling(normal_tail_of, 0, p, 0, 40)
                   : invert_falling(normal_tail_of, 0, 1 - p, 0, 40);
}

/* Continued fraction of the incomplete beta function (A&S 26.5.8), by Lentz's method. */
static double beta_fraction(double a, double b, double x)
{
    double c = 1, d = 1 - (a + b) * x / (a + 1), value;
    d = 1 / (fabs(d) < DBL_MIN ? DBL_MIN : d);
    value = d;
    for (int m = 1; m < TERMS_MAX; m++) {
        double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        double change = 1;
        for (int half = 0; half < 2; half++) {
            double term = half ? odd : even;
            d = 1 + term * d;
            c = 1 + term / c;
            d = 1 / (fabs(d) < DBL_MIN ? DBL_MIN : d);
            c = fabs(c) < DBL_MIN ? DBL_MIN : c;
            change = c * d;
            value *= change;
        }
        if (fabs(change - 1) < 1e-15)
            break;
    }
    return value;
}

double beta_lower(double a, double b, double x)
{
    if (x <= 0 || x >= 1)
        return x >= 1;
    double front = exp(lgamma(a + b) - lgamma(a) - lgamma(b) + a * log(x) + b * log1p(-x));
    /* The fraction converges fast below the mean; above it the complement does. */
    return x < (a + 1) / (a + b + 2) ? front * beta_fraction(a, b, x) / a
                                     : 1 - front * beta_fraction(b, a, 1 - x) / b;
}

double student_upper_tail(double t, double freedom)
{
    double tail = beta_lower(freedom / 2, 0.5, freedom / (freedom + t * t)) / 2;
    return t < 0 ? 1 - tail : tail;
}

double student_critical(double p, double freedom)
{
    double high = 1;
    while (student_upper_tail(high, freedom) > p)
        high *= 2;
    return invert_falling(student_upper_tail, freedom, p, 0, high);
}

/* P(a, x) by its series (A&S 6.5.29), for x < a + 1. */
static double gamma_series(double a, double x)
{
    double term = 1 / a, sum = term;
    for (int n = 1; n < TERMS_MAX && term > sum * 1e-17; n++) {
        term *= x / (a + n);
        sum += term;
    }
    return sum * exp(a * log(x) - x - lgamma(a));
}

/* Q(a, x) by its continued fraction (A&S 6.5.31), by Lentz's method, for x > a + 1. */
static double gamma_fraction(double a, double x)
{
    double b = x + 1 - a, c = 1 / DBL_MIN, d = 1 / b, value = d;
    for (int n = 1; n < TERMS_MAX; n++) {
        double term = -n * (n - a);
        b += 2;
        d = term * d + b;
        c = b + term / c;
        d = 1 / (fabs(d) < DBL_MIN ? DBL_MIN : d);
        c = fabs(c) < DBL_MIN ? DBL_MIN : c;
        value *= c * d;
        if (fabs(c * d - 1) < 1e-15)
            break;
    }
    return value * exp(a * log(x) - x - lgamma(a));
}

double gamma_upper(double a, double x)
{
    if (x <= 0)
        return 1;
    return x < a + 1 ? 1 - gamma_series(a, x) : gamma_fraction(a, x);
}

double chi2_upper_tail(double statistic, double freedom)
{
    return gamma_upper(freedom / 2, statistic / 2);
}

double chi2_critical(double p, double freedom)
{
    double high = freedom + 1;
    while (chi2_upper_tail(high, freedom) > p)
        high *= 2;
    return invert_falling(chi2_upper_tail, freedom, p, 0, high);
}

/* --- Batches -----------------------------------------------------------------------------------------------
 */

void batches_add(struct batches *batches, double value)
{
    double before = value - batches->mean;
    batches->count++;
    batches->mean += before / (double)batches->count;
    batches->square += before * (value - batches->mean);
}

double batches_variance(const struct batches *batches)
{
    return batches->count < 2 ? 0 : batches->square / (double)(batches->count - 1);
}

double batches_error(const struct batches *batches)
{
    return batches->count ? sqrt(batches_variance(batches) / (double)batches->count) : 0;
}

double sidak(double false_alarm, size_t comparisons)
{
    return -expm1(log1p(-false_alarm) / (double)comparisons);
}

/* The normal deviate as unlikely as t. */
static double normal_equivalent(double t, double freedom)
{
    double tail = student_upper_tail(fabs(t), freedom);
    return copysign(tail > 0 ? -normal_quantile(tail) : 40, t);
}

static struct finding judge(double difference, double error, double freedom, double scale, struct power power,
                            size_t comparisons)
{
    double false_alarm = power.false_alarm > 0 ? power.false_alarm : C_FALSE_ALARM;
    /* A result that is not finite, or that was never repeated, proves nothing. */
    if (freedom < 1 || !isfinite(difference) || !isfinite(error))
        return (struct finding){.z = INFINITY, .sees = INFINITY};
    struct finding finding;
    scale = fmax(fabs(scale), power.scale);
    if (error == 0) { /* all batches equal: right to the last bits, or wrong */
        finding.agrees = fabs(difference) <= 1e-12 * scale;
        finding.z = finding.agrees ? 0 : copysign(INFINITY, difference);
        finding.sees = 0;
    } else {
        double critical = student_critical(sidak(false_alarm, comparisons) / 2, freedom);
        finding.agrees = fabs(difference) <= critical * error;
        finding.z = normal_equivalent(difference / error, freedom);
        finding.sees = (critical + student_critical(1 - DETECTION, freedom)) * error / scale;
    }
    finding.powerful = power.sees_error <= 0 || finding.sees <= power.sees_error;
    return finding;
}

struct finding batches_against(const struct batches *batches, double exact, struct power power,
                               size_t comparisons)
{
    return judge(batches->mean - exact, batches_error(batches), (double)batches->count - 1, exact, power,
                 comparisons);
}

struct finding batches_versus(const struct batches *a, const struct batches *b, struct power power,
                              size_t comparisons)
{
    double va = batches_error(a) * batches_error(a), vb = batches_error(b) * batches_error(b);
    double freedom = (double)(a->count < b->count ? a->count : b->count) - 1;
    if (va + vb > 0 && a->count > 1 && b->count > 1) /* Welch–Satterthwaite */
        freedom =
            (va + vb) * (va + vb) / (va * va / (double)(a->count - 1) + vb * vb / (double)(b->count - 1));
    return judge(a->mean - b->mean, sqrt(va + vb), freedom, (a->mean + b->mean) / 2, power, comparisons);
}

bool batches_agree(const struct batches *batches, double exact, struct power power, size_t comparisons)
{
    struct finding finding = batches_against(batches, exact, power, comparisons);
    return finding.agrees && finding.powerful;
}

/* --- Families
 * ------------------------------------------------------------------------------------------------ */

static bool report(struct finding finding, size_t bin, double found, double error, double wanted,
                   struct power power)
{
    if (!finding.agrees)
        print_error("bin %zu: %.6g ± %.2g is not %.6g (z = %.1f)\n", bin, found, error, wanted, finding.z);
    if (!finding.powerful)
        print_error(
            "bin %zu: %.6g ± %.2g would hide an error of %.3g; the test promises %.3g: more samples\n", bin,
            found, error, finding.sees, power.sees_error);
    return finding.agrees && finding.powerful;
}

void assert_unbiased(const struct batches *bins, const double *exact, size_t count, struct power power)
{
    size_t bad = 0;
    for (size_t i = 0; i < count; i++)
        bad += !report(batches_against(&bins[i], exact[i], power, count), i, bins[i].mean,
                       batches_error(&bins[i]), exact[i], power);
    if (bad)
        fail_msg("%zu of %zu bins", bad, count);
}

void assert_same(const struct batches *a, const struct batches *b, size_t count, struct power power)
{
    size_t bad = 0;
    for (size_t i = 0; i < count; i++)
        bad += !report(batches_versus(&a[i], &b[i], power, count), i, a[i].mean,
                       hypot(batches_error(&a[i]), batches_error(&b[i])), b[i].mean, power);
    if (bad)
        fail_msg("%zu of %zu bins", bad, count);
}

/* --- χ²
 * ----------------------------------------------------------------------------------------------------------
 */

struct chi2 chi2_test(const double *observed, const double *expected, size_t bins, size_t fitted)
{
    struct chi2 result = {0};
    double pooled_observed = 0, pooled_expected = 0;
    size_t used = 0;
    bool impossible = false;
    for (size_t i = 0; i < bins; i++) {
        result.count += expected[i];
        impossible |= !(expected[i] > 0) && observed[i] > 0;
        if (expected[i] < CHI2_EXPECTED_MIN) {
            pooled_observed += observed[i];
            pooled_expected += expected[i];
        } else {
            result.statistic += (observed[i] - expected[i]) * (observed[i] - expected[i]) / expected[i];
            used++;
        }
    }
    if (pooled_expected > 0) {
        double difference = pooled_observed - pooled_expected;
        /* A pool that expects next to nothing would make the statistic anything but χ²: its excess is judged
           as if it expected the minimum, which errs on the quiet side. */
        result.statistic += difference * difference / fmax(pooled_expected, CHI2_EXPECTED_MIN);
        used++;
    }
    result.freedom = used > 1 + fitted ? used - 1 - fitted : 0;
    result.p = impossible       ? 0
               : result.freedom ? chi2_upper_tail(result.statistic, (double)result.freedom)
                                : 1;
    return result;
}

double chi2_sees(const struct chi2 *result, double false_alarm)
{
    if (!result->freedom || !(result->count > 0))
        return INFINITY;
    /* With noncentrality η = N·ε² the statistic is near normal with mean k + η and variance 2(k + 2η). */
    double k = (double)result->freedom, critical = chi2_critical(false_alarm, k), low = 0, high = 1e12;
    double quantile = normal_quantile(DETECTION);
    for (int i = 0; i < 200; i++) {
        double eta = (low + high) / 2;
        if (k + eta - quantile * sqrt(2 * (k + 2 * eta)) < critical)
            low = eta;
        else
            high = eta;
    }
    return sqrt(high / result->count);
}

void assert_distributed(const double *observed, const double *expected, size_t bins, struct power power)
{
    double false_alarm = power.false_alarm > 0 ? power.false_alarm : C_FALSE_ALARM;
    struct chi2 result = chi2_test(observed, expected, bins, 0);
    double sees = chi2_sees(&result, false_alarm);
    if (result.p < false_alarm)
        fail_msg("chi2 = %.1f with %zu degrees of freedom: p = %.2g", result.statistic, result.freedom,
                 result.p);
    if (power.sees_error > 0 && sees > power.sees_error)
        fail_msg("an error of %.3g would be hidden; the test promises %.3g: more samples", sees,
                 power.sees_error);
}
