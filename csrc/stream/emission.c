/* L: emissions. An RGB light is its colour, upsampled, times the white of the working space (algorithm.md §10), so
   that a white diffuser under it looks as it does in Cycles. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/error.h"
#include "stream/expressions.h"

/* --- The white of the working space ------------------------------------------------------------------------ */

/* Luminance of a spectrum, as the film has it. */
static double luminance(const struct spectrum *spectrum, struct range range)
{
    double sum = 0;
    for (float lambda = CMF_MIN_NM; lambda <= CMF_MAX_NM; lambda += 1) {
        float xyz[3];
        cmf_eval(lambda, xyz);
        sum += (double)xyz[1] * spectrum_eval(spectrum, lambda);
    }
    return cmf_normalization(range.min, range.max) * sum;
}

/* Scaled to Y = 1: for D65 that is D65/∫D65 over Λ, by the film's own scale. */
static struct spectrum *make_white(struct range range, const struct working_space *space)
{
    struct spectrum *white = spectrum_white(range, space);
    double y = white ? luminance(white, range) : 0;
    struct spectrum *light = y > 0 ? spectrum_scaled(white, (float)(1 / y)) : NULL;
    spectrum_destroy(white);
    return light;
}

static const struct spectrum *session_white(const struct place *place)
{
    stokes_session *session = place->message->session;
    if (!session->white)
        session->white = make_white(message_range(place->message), &session->color.working_space);
    if (!session->white)
        place_fail(place, "the transport range holds no white light");
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
    struct spectrum *color = white ? rgb_spectrum(place->message, RGB_SIGMOID, rgb) : NULL;
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
    if (count > EXPRESSION_TERMS) {
        place_fail(place, "has %zu terms; at most %d are taken", count, EXPRESSION_TERMS);
        return NULL;
    }
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
