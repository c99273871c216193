/* The bounded maximum entropy spectral estimate (Peters et al. 2019, §4), by way of the exponential moments. */
#include "spectrum/moments.h"

#include <complex.h>
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "spectrum/knots.h"
#include "spectrum/rgb_fit.h"

/* How far moments may be drawn toward those of a constant 1/2: the first step, and the last. */
#define INWARD_FIRST 1e-9
#define INWARD_LAST 1e-3
/* Reflection coefficients nearer to 1 leave no digits. */
#define SINGULAR (1 - 1e-12)

typedef double complex number;

/* With G(z) = c_0 + 2 Σ c_l z^l, analytic in the disc and g = Re G on its edge, H = exp(iπ(G − 1/2)) has a real part of at least 0 there: it
   belongs to a positive measure, whose moments are h_0's real part and h_l/2. H' = 2πi (Σ l c_l z^(l−1)) H gives the h_l. */
static void exponential_moments(const double *c, int count, number *h)
{
    h[0] = cexp(I * M_PI * (c[0] - 0.5));
    for (int l = 1; l < count; l++) {
        h[l] = 0;
        for (int j = 1; j <= l; j++)
            h[l] += j * c[j] * h[l - j];
        h[l] *= 2 * M_PI * I / l;
    }
}

/* Levinson's recursion: Σ_j q_j μ_(k−j) is `left` for k = 0 and 0 for 0 < k < count; q_0 = 1. False where μ belong to no positive density. */
static bool levinson(const number *mu, int count, number *q, double *left)
{
    double error = creal(mu[0]);
    q[0] = 1;
    for (int n = 1; n < count && error > 0; n++) {
        number sum = 0, next[MOMENTS_MAX];
        q[n] = 0;
        for (int j = 0; j < n; j++)
            sum += q[j] * mu[n - j];
        number k = -sum / error;
        if (!(cabs(k) < SINGULAR))
            return false;
        for (int j = 0; j <= n; j++)
            next[j] = q[j] + k * conj(q[n - j]);
        memcpy(q, next, ((size_t)n + 1) * sizeof *q);
        error *= 1 - creal(k * conj(k));
    }
    *left = error;
    return error > 0;
}

/* Σ_k a_(k+l) conj(b_k): the coefficient of z^l of a(z) conj(b(z)) on the unit circle. */
static number correlate(const number *a, const number *b, int count, int l)
{
    number sum = 0;
    for (int k = l < 0 ? -l : 0; k < count && k + l < count; k++)
        sum += a[k + l] * conj(b[k]);
    return sum;
}

/* The estimate of H is i Im h_0 + p/q, p the part of q·(H − i Im h_0) up to degree count − 1. As Re(p conj q) = left on the circle,
   tan π(g − 1/2) = Im H/Re H is the trigonometric polynomial (Im(p conj q) + Im h_0 |q|²)/left, even in φ. */
static bool estimate(const double *c, int count, double *t)
{
    number h[MOMENTS_MAX], mu[MOMENTS_MAX] = {0}, q[MOMENTS_MAX], p[MOMENTS_MAX];
    double left;
    exponential_moments(c, count, h);
    for (int l = 0; l < count; l++)
        mu[l] = l == 0 ? creal(h[0]) : 0.5 * h[l];
    if (!levinson(mu, count, q, &left))
        return false;
    for (int l = 0; l < count; l++) {
        p[l] = q[l] * creal(h[0]);
        for (int j = 0; j < l; j++)
            p[l] += q[j] * h[l - j];
    }
    for (int l = 0; l < count; l++) {
        number odd = (correlate(p, q, count, l) - conj(correlate(p, q, count, -l))) / (2 * I);
        t[l] = (l ? 2 : 1) * creal(odd + cimag(h[0]) * correlate(q, q, count, l)) / left;
        if (!isfinite(t[l]))
            return false;
    }
    return true;
}

bool moment_curve_make(const double *moments, int count, float min, float max, struct moment_curve *curve,
                       const char *name, stokes_error *err)
{
    if (count < 1 || count > MOMENTS_MAX)
        return fail(err, name, "moments", "are %d; 1 to %d are taken", count, MOMENTS_MAX);
    if (!(min > 0 && max - min >= 1 && isfinite(max)))
        return fail(err, name, "moments", "lie over %g to %g nm", (double)min, (double)max);
    for (int l = 0; l < count; l++)
        if (!(fabs(moments[l]) <= 1))
            return fail(err, name, "moments", "number %d is %g; a reflectance has none beyond 1", l,
                        moments[l]);
    *curve = (struct moment_curve){.count = count, .min = min, .max = max};
    if (estimate(moments, count, curve->t))
        return true;
    for (double inward = INWARD_FIRST; inward <= INWARD_LAST; inward *= 10) {
        double c[MOMENTS_MAX];
        for (int l = 0; l < count; l++)
            c[l] = (1 - inward) * moments[l] + (l == 0 ? 0.5 * inward : 0);
        if (estimate(c, count, curve->t))
            return true;
    }
    return fail(err, name, "moments", "belong to no reflectance within 0 and 1");
}

double moment_curve_eval(const struct moment_curve *curve, double lambda_nm)
{
    double at = (lambda_nm - curve->min) / ((double)curve->max - curve->min);
    double cosine = cos(M_PI * fmin(fmax(at, 0), 1)), b1 = 0, b2 = 0;
    for (int l = curve->count - 1; l > 0; l--) { /* Clenshaw's recurrence */
        double b0 = curve->t[l] + 2 * cosine * b1 - b2;
        b2 = b1;
        b1 = b0;
    }
    return 0.5 + atan(curve->t[0] + cosine * b1 - b2) / M_PI;
}

/* ∫ (a + s x) cos(ωx) dx for ω > 0, but for a constant. */
static double wave_part(double a, double s, double omega, double x)
{
    return ((a + s * x) * sin(omega * x) + s * cos(omega * x) / omega) / omega;
}

void moments_of_spectrum(const struct spectrum *spectrum, float min, float max, double *moments, int count)
{
    double length = (double)max - min;
    memset(moments, 0, (size_t)count * sizeof *moments);
    moments[0] = (spectrum_integral_to(spectrum, max) - spectrum_integral_to(spectrum, min)) / length;
    for (uint32_t i = 0; i + 1 < spectrum->count; i++) {
        double from = fmax(spectrum->lambda[i], min), to = fmin(spectrum->lambda[i + 1], max);
        if (!(to > from))
            continue;
        double slope = ((double)spectrum->value[i + 1] - spectrum->value[i]) /
                       ((double)spectrum->lambda[i + 1] - spectrum->lambda[i]);
        double value = spectrum->value[i] + slope * (min - (double)spectrum->lambda[i]);
        for (int l = 1; l < count; l++) {
            double omega = M_PI * l / length;
            moments[l] +=
                (wave_part(value, slope, omega, to - min) - wave_part(value, slope, omega, from - min)) /
                length;
        }
    }
}

/* --- As spectra ---------------------------------------------------------------------------------------------- */

/* Every nanometre inside [min, max], whose ends hold beyond. */
static struct spectrum *compiled(struct range range, const struct moment_curve *curve, bool zero_below,
                                 const char *name, stokes_error *err)
{
    struct knots k = {0};
    float low = fmaxf(range.min, curve->min), high = fminf(range.max, curve->max);
    bool dark = zero_below && range.min < curve->min;
    knots_add(&k, range.min, dark ? 0 : (float)moment_curve_eval(curve, range.min));
    if (dark)
        knots_add(&k, fminf(curve->min, range.max), 0);
    for (float l = low; l < high; l = floorf(l) + 1)
        knots_add(&k, l, (float)moment_curve_eval(curve, l));
    if (low < high)
        knots_add(&k, high, (float)moment_curve_eval(curve, high));
    knots_add(&k, range.max, dark && range.max < curve->min ? 0 : (float)moment_curve_eval(curve, range.max));
    return knots_finish(&k, name, err);
}

struct spectrum *spectrum_moments(struct range range, const double *moments, int count, float min, float max,
                                  const char *name, stokes_error *err)
{
    struct moment_curve curve;
    if (!range_check(range, name, err) || !moment_curve_make(moments, count, min, max, &curve, name, err))
        return NULL;
    return compiled(range, &curve, false, name, err);
}

/* A quadratic in u = −cos φ is t_0 + t_1 cos φ + t_2 cos 2φ: the fit finds the three moments by their curve. */
struct spectrum *spectrum_rgb_moments(struct range range, const struct working_space *space,
                                      const float rgb[3], enum uv_rule uv_rule, bool *outside)
{
    if (!range_check(range, "rgb", NULL))
        return NULL;
    struct fit fit = fit_color(RGB_MOMENTS, space, rgb, outside);
    const struct moment_curve curve = {
        .count = 3,
        .min = CMF_MIN_NM,
        .max = CMF_MAX_NM,
        .t = {fit.p[2] + 0.5 * fit.p[0], -fit.p[1], 0.5 * fit.p[0]},
    };
    return compiled(range, &curve, uv_rule == UV_ZERO, "rgb", NULL);
}
