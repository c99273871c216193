/* L: emissions. An RGB light is its colour, upsampled, times the white of the working space (architecture.md, "Colour
   and scale"), so that a white diffuser under it looks as it does in Cycles. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/error.h"
#include "stream/expressions.h"

/* Chromaticities nearer than this are the same white: matrices are published with four digits. */
#define WHITE_TOLERANCE 2e-3
#define STEP_NM 1.0f

/* --- The white of the working space ------------------------------------------------------------------------ */

struct white {
    double xyz[3];
    double cct;
    bool is_d65;
};

static struct white white_of(const struct working_space *space)
{
    struct white white;
    const double *m = space->rgb_to_xyz, d65_x = 0.31272, d65_y = 0.32903;
    for (int i = 0; i < 3; i++)
        white.xyz[i] = m[3 * i] + m[3 * i + 1] + m[3 * i + 2];
    double sum = white.xyz[0] + white.xyz[1] + white.xyz[2];
    double x = white.xyz[0] / sum, y = white.xyz[1] / sum;
    white.is_d65 = fabs(x - d65_x) < WHITE_TOLERANCE && fabs(y - d65_y) < WHITE_TOLERANCE;
    double n = (x - 0.3320) / (0.1858 - y); /* McCamy 1992 */
    white.cct = fmin(fmax(((449 * n + 3525) * n + 6823.3) * n + 5520.33, 4000), 25000);
    return white;
}

/* The quadratic over the visible range, held outside of it, whose terms correct a daylight to the exact white. */
static void correction_terms(float lambda_nm, double term[3])
{
    double t = (fmin(fmax(lambda_nm, 400), 700) - 550) / 150;
    term[0] = 1;
    term[1] = t;
    term[2] = t * t;
}

/* Cramer's rule; false if the matrix is singular. */
static bool solve3(const double a[3][3], const double b[3], double x[3])
{
    double minor[3];
    for (int i = 0; i < 3; i++)
        minor[i] = a[1][(i + 1) % 3] * a[2][(i + 2) % 3] - a[1][(i + 2) % 3] * a[2][(i + 1) % 3];
    double det = a[0][0] * minor[0] + a[0][1] * minor[1] + a[0][2] * minor[2];
    if (!(fabs(det) > 1e-12))
        return false;
    for (int column = 0; column < 3; column++) {
        double m[3][3];
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++)
                m[r][c] = c == column ? b[r] : a[r][c];
        x[column] = (m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                     m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])) / det;
    }
    return true;
}

/* Scales the daylight by the quadratic that gives it the XYZ of the white; NULL if that would be negative. */
static struct spectrum *corrected(const struct spectrum *daylight, const struct white *white, struct range range)
{
    double response[3][3] = {{0}}, weight[3];
    double kappa = cmf_normalization(range.min, range.max);
    for (float lambda = CMF_MIN_NM; lambda <= CMF_MAX_NM; lambda += STEP_NM) {
        float xyz[3];
        double term[3];
        cmf_eval(lambda, xyz);
        correction_terms(lambda, term);
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                response[i][j] += kappa * xyz[i] * term[j] * spectrum_eval(daylight, lambda) * STEP_NM;
    }
    if (!solve3(response, white->xyz, weight))
        return NULL;
    size_t count = (size_t)ceilf((range.max - range.min) / STEP_NM) + 1;
    float *lambda = malloc(count * sizeof *lambda), *value = malloc(count * sizeof *value);
    for (size_t i = 0; lambda && value && i < count; i++) {
        double term[3];
        lambda[i] = fminf(range.min + (float)i * STEP_NM, range.max);
        correction_terms(lambda[i], term);
        value[i] = (float)fmax(0, weight[0] * term[0] + weight[1] * term[1] + weight[2] * term[2]);
    }
    struct spectrum *factor = lambda && value ? spectrum_table(range, lambda, value, count, BEYOND_HOLD, "white", NULL) : NULL;
    struct spectrum *white_light = factor ? spectrum_product(daylight, factor) : NULL;
    spectrum_destroy(factor);
    free(lambda);
    free(value);
    return white_light;
}

/* D65/∫D65 over Λ; for another white a daylight of its CCT, made to have its XYZ. */
static struct spectrum *make_white(struct range range, const struct working_space *space, stokes_error *err)
{
    struct white white = white_of(space);
    struct spectrum *daylight = white.is_d65 ? spectrum_illuminant(range, "D65", "white", err)
                                             : spectrum_daylight(range, white.cct, "white", err);
    if (!daylight)
        return NULL;
    double integral = spectrum_integral(daylight);
    struct spectrum *light = NULL;
    if (!(integral > 0))
        fail(err, "white", "emission", "daylight has no power within %g to %g nm", (double)range.min, (double)range.max);
    else
        light = white.is_d65 ? spectrum_scaled(daylight, (float)(1 / integral)) : corrected(daylight, &white, range);
    spectrum_destroy(daylight);
    return light;
}

static const struct spectrum *session_white(const struct place *place)
{
    stokes_session *session = place->message->session;
    stokes_error why = {.text = "the working space's white is no daylight"};
    if (!session->white)
        session->white = make_white(message_range(place->message), &session->color.working_space, &why);
    if (!session->white)
        place_fail(place, "%s", why.text);
    return session->white;
}

/* --- Forms ------------------------------------------------------------------------------------------------- */

static bool read_scale(const struct place *emission, double *scale)
{
    struct place place = place_member(emission, "scale");
    *scale = 1;
    if (!place.value)
        return true;
    if (!read_number(&place, -FLT_MAX, FLT_MAX, scale))
        return false;
    return *scale >= 0 || place_fail(&place, "is negative (%g)", *scale);
}

static struct spectrum *read_rgb_emission(const struct place *place, double scale)
{
    struct place rgb_place = place_member(place, "rgb");
    float rgb[3];
    if (!read_floats(&rgb_place, rgb, 3))
        return NULL;
    float most = fmaxf(fmaxf(rgb[0], rgb[1]), rgb[2]), least = fminf(fminf(rgb[0], rgb[1]), rgb[2]);
    if (least < 0) {
        place_fail(&rgb_place, "is negative (%g)", (double)least);
        return NULL;
    }
    if (!(most * scale <= FLT_MAX)) {
        place_fail(place, "is beyond what a float holds");
        return NULL;
    }
    if (most * scale <= 0)
        return spectrum_constant(message_range(place->message), 0);
    for (int i = 0; i < 3; i++)
        rgb[i] /= most;
    const struct spectrum *white = session_white(place);
    struct spectrum *color = white ? rgb_spectrum(place->message, rgb) : NULL;
    struct spectrum *shape = color ? spectrum_product(color, white) : NULL;
    struct spectrum *emission = shape ? spectrum_scaled(shape, (float)(most * scale)) : NULL;
    if (white && !emission)
        place_fail(place, "out of memory");
    spectrum_destroy(color);
    spectrum_destroy(shape);
    return emission;
}

static struct spectrum *read_shape_emission(const struct place *place, double scale)
{
    static const char *const units[] = {"total", "per_nm", NULL};
    struct place shape_place = place_member(place, "shape"), unit_place = place_member(place, "unit");
    int unit = 0;
    if (unit_place.value && !read_choice(&unit_place, units, &unit))
        return NULL;
    struct spectrum *shape = read_spectrum(&shape_place, BEYOND_ZERO, EXPRESSION_DEPTH), *emission = NULL;
    if (!shape)
        return NULL;
    double integral = spectrum_integral(shape), factor = unit == 0 ? scale / integral : scale;
    if (spectrum_min(shape) < 0)
        place_fail(&shape_place, "is negative (%g) somewhere", (double)spectrum_min(shape));
    else if (unit == 0 && !(integral > 0))
        place_fail(&shape_place, "has no power within the transport range");
    else if (!(factor * spectrum_max(shape) <= FLT_MAX && factor <= FLT_MAX))
        place_fail(place, "is beyond what a float holds");
    else if (!(emission = spectrum_scaled(shape, (float)factor)))
        place_fail(place, "out of memory");
    spectrum_destroy(shape);
    return emission;
}

static struct spectrum *read_emission_spectrum(const struct place *place, int depth);

static struct spectrum *read_emission_sum(const struct place *place, int depth)
{
    if (!place_is(place, JSON_ARRAY))
        return NULL;
    size_t count = json_array_size(place->value);
    struct spectrum *all = spectrum_constant(message_range(place->message), 0);
    for (size_t i = 0; all && i < count; i++) {
        struct place element = place_element(place, i);
        struct spectrum *next = read_emission_spectrum(&element, depth - 1);
        struct spectrum *sum = next ? spectrum_sum(all, next) : NULL;
        if (next && !sum)
            place_fail(&element, "out of memory");
        spectrum_destroy(next);
        spectrum_destroy(all);
        all = sum;
    }
    return all;
}

static struct spectrum *read_emission_spectrum(const struct place *place, int depth)
{
    struct place sum = place_member(place, "sum");
    double scale;
    if (!place_is(place, JSON_OBJECT) || !read_scale(place, &scale))
        return NULL;
    if (depth <= 0)
        place_fail(place, "is nested too deeply");
    else if (sum.value)
        return read_emission_sum(&sum, depth);
    else if (place_has(place, "rgb"))
        return read_rgb_emission(place, scale);
    else if (place_has(place, "shape"))
        return read_shape_emission(place, scale);
    else
        place_fail(place, place_has(place, "texture") ? "a texture cannot be summed"
                                                      : "is no emission (rgb, shape, texture or sum)");
    return NULL;
}

struct emission_node *read_emission(const struct place *place)
{
    struct emission_node *emission = calloc(1, sizeof *emission);
    struct place texture = place_member(place, "texture");
    double scale = 1;
    if (!emission) {
        place_fail(place, "out of memory");
        return NULL;
    }
    if (!texture.value)
        emission->spectrum = read_emission_spectrum(place, EXPRESSION_DEPTH);
    else if (read_scale(place, &scale))
        emission->texture = read_texture(&texture);
    emission->scale = (float)scale;
    if (!emission->texture && !emission->spectrum) {
        emission_node_destroy(emission);
        return NULL;
    }
    return emission;
}
