/* A constant RGB reflectance as a curve and as a spectrum. */
#include <math.h>

#include "spectrum/knots.h"
#include "spectrum/rgb_fit.h"

static bool is_grey(const double rgb[3])
{
    return fmax(fmax(rgb[0], rgb[1]), rgb[2]) - fmin(fmin(rgb[0], rgb[1]), rgb[2]) < 1e-7;
}

struct fit fit_color(enum rgb_method method, const struct working_space *space, const float rgb[3],
                     bool *outside)
{
    double color[3];
    for (int c = 0; c < 3; c++)
        color[c] = isfinite(rgb[c]) ? fmin(fmax(rgb[c], -100), 100) : 0;
    struct fit fit = fit_grey(method, color[1]);
    bool reached = color[1] >= 0 && color[1] <= 1;
    if (!is_grey(color)) {
        struct fitter fitter;
        fitter_set(&fitter, method, space, 1);
        fit = fitter_solve(&fitter, color);
        reached = fit_reaches(&fit);
    }
    if (outside)
        *outside = !reached;
    return fit;
}

struct rgb_curve rgb_curve_fit(const struct working_space *space, const float rgb[3], bool *outside)
{
    struct fit fit = fit_color(RGB_SIGMOID, space, rgb, outside);
    return fit_curve(&fit);
}

struct spectrum *spectrum_rgb(struct range range, const struct working_space *space, const float rgb[3],
                              enum uv_rule uv_rule, bool *outside)
{
    if (!range_check(range, "rgb", NULL))
        return NULL;
    struct rgb_curve curve = rgb_curve_fit(space, rgb, outside);
    if (curve.c[0] == 0 && curve.c[1] == 0 && uv_rule != UV_ZERO)
        return spectrum_constant(range, rgb_curve_eval(&curve, CMF_MIN_NM, uv_rule));
    struct knots k = {0};
    /* Every nanometre where the curve bends, its ends alone where it holds. */
    float low = uv_rule == UV_EXTRAPOLATE ? range.min : fmaxf(range.min, CMF_MIN_NM);
    float high = fminf(range.max, CMF_MAX_NM);
    knots_add(&k, range.min, rgb_curve_eval(&curve, range.min, uv_rule));
    if (uv_rule == UV_ZERO && range.min < CMF_MIN_NM)
        knots_add(&k, fminf(CMF_MIN_NM, range.max), 0);
    for (float l = low; l < high; l = floorf(l) + 1)
        knots_add(&k, l, rgb_curve_eval(&curve, l, uv_rule));
    if (low < high)
        knots_add(&k, high, rgb_curve_eval(&curve, high, uv_rule));
    knots_add(&k, range.max, rgb_curve_eval(&curve, range.max, uv_rule));
    return knots_finish(&k, "rgb", NULL);
}
