/* Fits a curve of three coefficients to a colour: Levenberg's damping of Gauss-Newton steps in CIELAB under the working
   space's white, with a ridge where a colour is out of reach. */
#include <math.h>
#include <string.h>

#include "spectrum/rgb_fit.h"

#define MIDDLE_NM 595.0
#define HALF_NM 235.0
#define START_STEEPNESS 150.0 /* of a search that begins at an optimal colour */
#define BAND_NODES 8

/* Where the search stands: residual and Jacobian of L*a*b* by the coefficients. */
struct linearized {
    double residual[3], jacobian[3][3];
    double error, cost; /* ΔE*ab; its square with the ridge's penalty */
};

void fitter_set(struct fitter *f, enum rgb_method method, const struct working_space *space, int step_nm)
{
    f->method = method;
    observer_set(&f->observer, space, step_nm);
    memcpy(f->rgb_to_xyz, space->rgb_to_xyz, sizeof f->rgb_to_xyz);
}

/* CIE 15:2018, eqs. 8.6 to 8.11: the cube root with its linear foot, and its derivative. */
static double lab_root(double q, double *slope)
{
    const double foot = 216.0 / 24389;
    if (q > foot) {
        double root = cbrt(q);
        *slope = root / (3 * q);
        return root;
    }
    *slope = 841.0 / 108;
    return *slope * q + 4.0 / 29;
}

/* L*a*b* of XYZ and, if asked, the derivatives by X, Y and Z of the roots it is made of. */
static void lab_of(const struct fitter *f, const double xyz[3], double lab[3], double slope[3])
{
    double root[3];
    for (int c = 0; c < 3; c++) {
        root[c] = lab_root(xyz[c] / f->observer.white[c], &slope[c]);
        slope[c] /= f->observer.white[c];
    }
    lab[0] = 116 * root[1] - 16;
    lab[1] = 500 * (root[0] - root[1]);
    lab[2] = 200 * (root[1] - root[2]);
}

/* The variable of the quadratic at t in −1 … 1 over the observer's range. */
static double variable(enum rgb_method method, double t)
{
    return method == RGB_MOMENTS ? sin(M_PI / 2 * t) : t;
}

/* The sigmoid and its derivative. */
static double sigmoid(enum rgb_method method, double x, double *slope)
{
    double s = 1 / sqrt(1 + x * x);
    if (method == RGB_MOMENTS) {
        *slope = s * s / M_PI;
        return 0.5 + atan(x) / M_PI;
    }
    *slope = 0.5 * s * s * s;
    return 0.5 + 0.5 * x * s;
}

/* XYZ of the curve and its derivatives by the coefficients. */
static void curve_xyz(const struct fitter *f, const double p[3], double xyz[3], double by[3][3])
{
    const struct observer *o = &f->observer;
    memset(xyz, 0, 3 * sizeof *xyz);
    memset(by, 0, 9 * sizeof **by);
    for (int i = 0; i < o->count; i++) {
        double t = variable(f->method, 2.0 * i / (o->count - 1) - 1), x = (p[0] * t + p[1]) * t + p[2];
        double slope, value = sigmoid(f->method, x, &slope);
        for (int c = 0; c < 3; c++) {
            double w = o->weight[i][c], d = w * slope;
            xyz[c] += w * value;
            by[c][2] += d;
            by[c][1] += d * t;
            by[c][0] += d * t * t;
        }
    }
}

static struct linearized linearize(const struct fitter *f, const double p[3], const double target[3],
                                   double ridge)
{
    struct linearized at;
    double xyz[3], by[3][3], lab[3], slope[3];
    curve_xyz(f, p, xyz, by);
    lab_of(f, xyz, lab, slope);
    at.cost = 0;
    for (int i = 0; i < 3; i++) {
        at.residual[i] = lab[i] - target[i];
        at.cost += at.residual[i] * at.residual[i];
        double dx = slope[0] * by[0][i], dy = slope[1] * by[1][i], dz = slope[2] * by[2][i];
        at.jacobian[0][i] = 116 * dy;
        at.jacobian[1][i] = 500 * (dx - dy);
        at.jacobian[2][i] = 200 * (dy - dz);
    }
    at.error = sqrt(at.cost);
    at.cost += ridge * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    return at;
}

/* Solves the symmetric 3×3 system a·x = b by Cholesky's decomposition. */
static bool solve(double a[3][3], const double b[3], double x[3])
{
    double y[3];
    for (int j = 0; j < 3; j++)
        for (int i = j; i < 3; i++) {
            double sum = a[i][j];
            for (int k = 0; k < j; k++)
                sum -= a[i][k] * a[j][k];
            if (i == j && !(sum > 0))
                return false;
            a[i][j] = i == j ? sqrt(sum) : sum / a[j][j];
        }
    for (int i = 0; i < 3; i++) {
        y[i] = b[i];
        for (int k = 0; k < i; k++)
            y[i] -= a[i][k] * y[k];
        y[i] /= a[i][i];
    }
    for (int i = 2; i >= 0; i--) {
        x[i] = y[i];
        for (int k = i + 1; k < 3; k++)
            x[i] -= a[k][i] * x[k];
        x[i] /= a[i][i];
    }
    return true;
}

/* The coefficients after a step of (JᵀJ + wI + μ diag) δ = -Jᵀr - wp: Marquardt's scaling, and a ridge that keeps the
   curve from growing steeper where that gains less than it costs. */
static bool step(const struct linearized *at, double ridge, double damping, const double p[3], double next[3])
{
    double normal[3][3], gradient[3], delta[3];
    for (int i = 0; i < 3; i++) {
        gradient[i] = -ridge * p[i];
        for (int k = 0; k < 3; k++)
            gradient[i] -= at->jacobian[k][i] * at->residual[k];
        for (int j = 0; j < 3; j++) {
            normal[i][j] = i == j ? ridge : 0;
            for (int k = 0; k < 3; k++)
                normal[i][j] += at->jacobian[k][i] * at->jacobian[k][j];
        }
    }
    for (int i = 0; i < 3; i++)
        normal[i][i] *= 1 + damping;
    if (!solve(normal, gradient, delta))
        return false;
    for (int i = 0; i < 3; i++)
        next[i] = p[i] + delta[i];
    return true;
}

static void target_lab(const struct fitter *f, const double rgb[3], double lab[3])
{
    double xyz[3], slope[3];
    for (int row = 0; row < 3; row++)
        xyz[row] = f->rgb_to_xyz[3 * row] * rgb[0] + f->rgb_to_xyz[3 * row + 1] * rgb[1] +
                   f->rgb_to_xyz[3 * row + 2] * rgb[2];
    lab_of(f, xyz, lab, slope);
}

/* In the measure of FIT_STEEPEST. */
static double steepness(const struct fit *fit)
{
    return fmax(fabs(fit->p[0]), fabs(fit->p[1])) / (fit->method == RGB_MOMENTS ? FIT_ATAN : 1);
}

struct fit fitter_improve(const struct fitter *f, const double rgb[3], struct fit start, double ridge,
                          int iterations)
{
    double target[3], damping = 1e-4;
    target_lab(f, rgb, target);
    struct linearized at = linearize(f, start.p, target, ridge);
    for (int i = 0, slow = 0; i < iterations && slow < 2 && damping < 1e8; i++) {
        if (at.error < FIT_SOLVED || steepness(&start) > 2 * FIT_STEEPEST)
            break;
        double next[3];
        struct linearized there = {.cost = INFINITY};
        if (step(&at, ridge, damping, start.p, next))
            there = linearize(f, next, target, ridge);
        if (there.cost < at.cost) {
            slow = there.cost > 0.9999 * at.cost ? slow + 1 : 0;
            memcpy(start.p, next, sizeof next);
            at = there;
            damping *= 0.1;
        } else {
            damping = 10 * fmax(damping, 1e-8);
        }
    }
    start.error = at.error;
    return start;
}

struct fit fit_grey(enum rgb_method method, double value)
{
    const double least = 1e-12; /* x = ±5e5: in floats exactly 0 and 1 */
    double v = fmin(fmax(value, least), 1 - least), x = 0;
    switch (method) {
    case RGB_SIGMOID: x = (v - 0.5) / sqrt(v * (1 - v)); break;
    case RGB_MOMENTS: x = tan(M_PI * (v - 0.5)); break;
    }
    return (struct fit){.method = method, .p = {0, 0, x}};
}

bool fit_reaches(const struct fit *fit)
{
    return fit->error < FIT_REACHED && steepness(fit) <= FIT_STEEPEST;
}

/* The grey to start from, away from black and white, where nothing changes any more. */
static struct fit start_grey(const struct fitter *f, const double rgb[3])
{
    double y = 0;
    for (int c = 0; c < 3; c++)
        y += f->rgb_to_xyz[3 + c] * rgb[c];
    return fit_grey(f->method, fmin(fmax(y, 1e-3), 0.999));
}

/* Out of reach of smooth curves: a strong ridge first finds the valley, weaker ones follow it towards the optimal
   colours, whose spectra are steps, while the curve is still smooth. */
static struct fit descend(const struct fitter *f, const double rgb[3], struct fit fit, double first_ridge)
{
    struct fit smooth = fit;
    for (double ridge = first_ridge; ridge > 5e-8; ridge *= 0.3) {
        fit = fitter_improve(f, rgb, fit, ridge, 50);
        if (fit_reaches(&fit))
            return fit;
        if (steepness(&fit) >= FIT_SMOOTH && ridge < first_ridge)
            break;
        smooth = fit;
    }
    return smooth;
}

/* A curve that is positive between two nodes, or everywhere else: an optimal colour's band or gap with soft edges. A
   band that reaches the end of the observer's range has no edge there. */
static struct fit soft_band(const struct fitter *f, int from, int to, bool gap)
{
    const struct observer *o = &f->observer;
    double scale = (gap ? -START_STEEPNESS : START_STEEPNESS) * (f->method == RGB_MOMENTS ? FIT_ATAN : 1);
    double t0 = from == 0 ? -3 : variable(f->method, 2.0 * from / (o->count - 1) - 1),
           t1 = to == o->count - 1 ? 3 : variable(f->method, 2.0 * to / (o->count - 1) - 1);
    return (struct fit){.method = f->method, .p = {-scale, scale * (t0 + t1), -scale * t0 * t1}};
}

static double squared_distance(const struct fitter *f, const double xyz[3], const double lab[3])
{
    double there[3], slope[3], sum = 0;
    lab_of(f, xyz, there, slope);
    for (int c = 0; c < 3; c++)
        sum += (there[c] - lab[c]) * (there[c] - lab[c]);
    return sum;
}

/* The nearest of the optimal colours (Schrödinger 1920: reflectances of 0 and 1 with two steps at most), every
   BAND_NODES nodes. */
static struct fit nearest_band(const struct fitter *f, const double rgb[3])
{
    const struct observer *o = &f->observer;
    double target[3], least = INFINITY;
    struct fit best = start_grey(f, rgb);
    target_lab(f, rgb, target);
    for (int from = 0; from < o->count; from += BAND_NODES) {
        double band[3] = {0};
        for (int to = from; to < o->count; to++) {
            for (int c = 0; c < 3; c++)
                band[c] += o->weight[to][c];
            for (int gap = 0; gap < 2 && (to - from) % BAND_NODES == 0; gap++) {
                double left[3] = {o->white[0] - band[0], o->white[1] - band[1], o->white[2] - band[2]};
                double square = squared_distance(f, gap ? left : band, target);
                if (square < least)
                    best = soft_band(f, from, to, gap);
                least = fmin(least, square);
            }
        }
    }
    return best;
}

/* From grey a search may end in the wrong valley; from the nearest optimal colour it starts in the right one. */
static struct fit nearest(const struct fitter *f, const double rgb[3])
{
    struct fit from_grey = descend(f, rgb, start_grey(f, rgb), 1e-2);
    if (fit_reaches(&from_grey))
        return from_grey;
    struct fit from_band = descend(f, rgb, nearest_band(f, rgb), 1e-4);
    return from_band.error < from_grey.error ? from_band : from_grey;
}

struct fit fitter_solve(const struct fitter *f, const double rgb[3])
{
    struct fit fit = fitter_improve(f, rgb, start_grey(f, rgb), 0, 60);
    return fit_reaches(&fit) ? fit : nearest(f, rgb);
}

/* The same curve in λ/nm: t = λ/HALF - MIDDLE/HALF. */
struct rgb_curve fit_curve(const struct fit *fit)
{
    const double m = MIDDLE_NM / HALF_NM;
    double limit = fmin(1, 1e6 / fmax(fabs(fit->p[2]), 1)); /* for floats, whose square must not overflow */
    double a = limit * fit->p[0], b = limit * fit->p[1], c = limit * fit->p[2];
    return (struct rgb_curve){
        {(float)(a / (HALF_NM * HALF_NM)), (float)((b - 2 * a * m) / HALF_NM), (float)((a * m - b) * m + c)}};
}
