/* S: spectra from JSON, compiled over the session's Λ as they come. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "spectrum/moments.h"
#include "stream/expressions.h"

#define LAMBDA_MAX_NM 1e6
#define KNOTS_MAX ((size_t)1 << 16)
#define SHARES_MAX ((size_t)RERADIATION_BANDS_MAX * RERADIATION_BANDS_MAX)

struct range message_range(const struct message *message)
{
    const struct integrator_settings *s = &message->session->settings.integrator;
    return (struct range){s->lambda_min, s->lambda_max};
}

struct spectrum *rgb_spectrum(struct message *message, enum rgb_method method, const float rgb[3])
{
    const stokes_session *session = message->session;
    bool outside = false;
    struct spectrum *spectrum = (method == RGB_MOMENTS ? spectrum_rgb_moments : spectrum_rgb)(
        message_range(message), &session->color.working_space, rgb, session->settings.uv_rule, &outside);
    message->colors_outside += outside;
    return spectrum;
}

/* Constructors outside this room know neither message nor member: what they say is put behind the place. */
static struct spectrum *or_fail(const struct place *place, struct spectrum *spectrum, const stokes_error *why)
{
    if (!spectrum)
        place_fail(place, "%s%s%s", why->property, *why->property ? ": " : "",
                   *why->text ? why->text : "out of memory");
    return spectrum;
}

/* --- Forms ------------------------------------------------------------------------------------------------- */

static struct spectrum *read_constant(const struct place *place)
{
    double value;
    stokes_error why = {0};
    if (!read_number(place, -FLT_MAX, FLT_MAX, &value))
        return NULL;
    return or_fail(place, spectrum_constant(message_range(place->message), (float)value), &why);
}

static struct spectrum *read_rgb(const struct place *whole)
{
    static const char *const methods[] = {[RGB_SIGMOID] = "sigmoid", [RGB_MOMENTS] = "moments", NULL};
    struct place place = place_member(whole, "rgb"), method = place_member(whole, "method");
    float rgb[3];
    int chosen = RGB_SIGMOID;
    stokes_error why = {0};
    if (!read_floats(&place, rgb, 3) || (method.value && !read_choice(&method, methods, &chosen)))
        return NULL;
    return or_fail(&place, rgb_spectrum(place.message, (enum rgb_method)chosen, rgb), &why);
}

/* The moments themselves, or those of another spectrum: what k numbers keep of it. */
static struct spectrum *read_moments(const struct place *place, enum beyond beyond, int depth)
{
    static const struct field fields[] = {{"min", FIELD_FLOAT, false, 0, 0, 1, LAMBDA_MAX_NM},
                                          {"max", FIELD_FLOAT, false, sizeof(float), 0, 1, LAMBDA_MAX_NM}};
    struct place given = place_member(place, "c"), of = place_member(place, "of"),
                 number = place_member(place, "count");
    float bounds[2] = {CMF_MIN_NM, CMF_MAX_NM}, c[MOMENTS_MAX];
    double moments[MOMENTS_MAX], count = 0;
    stokes_error why = {0};
    if (!place_is(place, JSON_OBJECT) || !read_fields(place, fields, 2, bounds))
        return NULL;
    if (of.value) {
        if (!read_whole(&number, 1, MOMENTS_MAX, &count))
            return NULL;
        struct spectrum *inner = read_spectrum(&of, beyond, depth - 1);
        if (!inner)
            return NULL;
        /* Beyond Λ nothing is known of it. */
        bounds[0] = fmaxf(bounds[0], spectrum_range(inner).min);
        bounds[1] = fmaxf(fminf(bounds[1], spectrum_range(inner).max), bounds[0] + 1);
        moments_of_spectrum(inner, bounds[0], bounds[1], moments, (int)count);
        spectrum_destroy(inner);
    } else {
        count = json_is_array(given.value) ? (double)json_array_size(given.value) : 1;
        if (count > MOMENTS_MAX || !read_floats(&given, c, (size_t)count)) {
            if (count > MOMENTS_MAX)
                place_fail(&given, "has %.0f numbers; at most %d are taken", count, MOMENTS_MAX);
            return NULL;
        }
        for (int i = 0; i < (int)count; i++)
            moments[i] = c[i];
    }
    return or_fail(place,
                   spectrum_moments(message_range(place->message), moments, (int)count, bounds[0], bounds[1],
                                    "moments", &why),
                   &why);
}

/* Numbers in JSON, or a blob of f32; *owned is to be freed. */
static bool read_numbers(const struct place *place, size_t most, const float **values, size_t *count,
                         float **owned)
{
    *owned = NULL;
    if (place->value && json_is_object(place->value)) {
        const void *data;
        if (!read_blob(place, sizeof(float), &data, count))
            return false;
        *values = data;
    } else {
        if (!place_is(place, JSON_ARRAY))
            return false;
        *count = json_array_size(place->value);
        *values = *owned = malloc((*count + 1) * sizeof(float));
        if (!*owned)
            return place_fail(place, "out of memory");
        if (!read_floats(place, *owned, *count))
            return false;
    }
    return *count <= most || place_fail(place, "has %zu numbers; at most %zu are taken", *count, most);
}

static struct spectrum *read_table(const struct place *place, enum beyond beyond)
{
    struct place lambda = place_member(place, "lambda"), value = place_member(place, "value");
    const float *lambdas, *values;
    float *own_lambdas = NULL, *own_values = NULL;
    size_t count = 0, value_count = 0;
    struct spectrum *spectrum = NULL;
    stokes_error why = {0};
    if (place_is(place, JSON_OBJECT) && read_numbers(&lambda, KNOTS_MAX, &lambdas, &count, &own_lambdas) &&
        read_numbers(&value, KNOTS_MAX, &values, &value_count, &own_values)) {
        if (count != value_count || count < 1)
            place_fail(place, "has %zu wavelengths and %zu values", count, value_count);
        else
            spectrum = or_fail(
                place,
                spectrum_table(message_range(place->message), lambdas, values, count, beyond, "table", &why),
                &why);
    }
    free(own_lambdas);
    free(own_values);
    return spectrum;
}

static struct spectrum *read_kelvin(const struct place *place,
                                    struct spectrum *make(struct range, double, const char *, stokes_error *))
{
    double kelvin;
    stokes_error why = {0};
    if (!read_number(place, 1, 1e6, &kelvin))
        return NULL;
    return or_fail(place, make(message_range(place->message), kelvin, place->key, &why), &why);
}

static struct spectrum *read_named(const struct place *place,
                                   struct spectrum *make(struct range, const char *, const char *,
                                                         stokes_error *))
{
    const char *name;
    stokes_error why = {0};
    if (!read_text(place, &name))
        return NULL;
    return or_fail(place, make(message_range(place->message), name, place->key, &why), &why);
}

static struct spectrum *read_gaussian(const struct place *place)
{
    static const struct field fields[] = {
        {"mean", FIELD_DOUBLE, true, 0, 0, 0, LAMBDA_MAX_NM},
        {"sigma", FIELD_DOUBLE, true, sizeof(double), 0, 1e-3, LAMBDA_MAX_NM},
        {"peak", FIELD_DOUBLE, false, 2 * sizeof(double), 0, -FLT_MAX, FLT_MAX},
    };
    double g[3] = {0, 0, 1};
    stokes_error why = {0};
    if (!place_is(place, JSON_OBJECT) || !read_fields(place, fields, 3, g))
        return NULL;
    return or_fail(
        place, spectrum_gaussian(message_range(place->message), g[0], g[1], g[2], "gaussian", &why), &why);
}

static struct spectrum *read_line(const struct place *place)
{
    static const struct field fields[] = {
        {"center", FIELD_DOUBLE, true, 0, 0, 0, LAMBDA_MAX_NM},
        {"width", FIELD_DOUBLE, true, sizeof(double), 0, 1, LAMBDA_MAX_NM},
    };
    double line[2];
    stokes_error why = {0};
    if (!place_is(place, JSON_OBJECT) || !read_fields(place, fields, 2, line))
        return NULL;
    return or_fail(place, spectrum_line(message_range(place->message), line[0], line[1], "line", &why), &why);
}

static struct spectrum *read_scaled(const struct place *place, enum beyond beyond, int depth)
{
    struct place factor = place_member(place, "scale"), of = place_member(place, "of");
    double scale;
    stokes_error why = {0};
    if (!read_number(&factor, -FLT_MAX, FLT_MAX, &scale))
        return NULL;
    struct spectrum *inner = read_spectrum(&of, beyond, depth - 1);
    struct spectrum *scaled = inner ? or_fail(place, spectrum_scaled(inner, (float)scale), &why) : NULL;
    spectrum_destroy(inner);
    return scaled;
}

static struct spectrum *read_list(const struct place *place, enum beyond beyond, int depth,
                                  struct spectrum *join(const struct spectrum *, const struct spectrum *))
{
    if (!place_is(place, JSON_ARRAY))
        return NULL;
    size_t count = json_array_size(place->value);
    struct spectrum *all = NULL;
    stokes_error why = {0};
    if (count < 1 || count > EXPRESSION_TERMS) {
        place_fail(place, "has %zu terms; 1 to %d are taken", count, EXPRESSION_TERMS);
        return NULL;
    }
    for (size_t i = 0; i < count; i++) {
        struct place element = place_element(place, i);
        struct spectrum *next = read_spectrum(&element, beyond, depth - 1);
        struct spectrum *joined = next && all ? or_fail(&element, join(all, next), &why) : NULL;
        if (i == 0) {
            all = next;
        } else {
            spectrum_destroy(next);
            spectrum_destroy(all);
            all = joined;
        }
        if (!all)
            return NULL;
    }
    return all;
}

enum form {
    FORM_RGB,
    FORM_TABLE,
    FORM_BLACKBODY,
    FORM_ILLUMINANT,
    FORM_DAYLIGHT,
    FORM_GAUSSIAN,
    FORM_LINE,
    FORM_LIBRARY,
    FORM_MOMENTS,
    FORM_SCALE,
    FORM_SUM,
    FORM_PRODUCT,
    FORM_COUNT
};

static const char *const form_members[FORM_COUNT] = {
    [FORM_RGB] = "rgb",
    [FORM_TABLE] = "table",
    [FORM_BLACKBODY] = "blackbody",
    [FORM_ILLUMINANT] = "illuminant",
    [FORM_DAYLIGHT] = "daylight",
    [FORM_GAUSSIAN] = "gaussian",
    [FORM_LINE] = "line",
    [FORM_LIBRARY] = "library",
    [FORM_MOMENTS] = "moments",
    [FORM_SCALE] = "scale",
    [FORM_SUM] = "sum",
    [FORM_PRODUCT] = "product",
};

static enum form form_of(const struct place *place)
{
    enum form form = 0;
    while (form < FORM_COUNT && !place_has(place, form_members[form]))
        form++;
    return form;
}

struct spectrum *read_spectrum(const struct place *place, enum beyond beyond, int depth)
{
    if (place->value && json_is_number(place->value))
        return read_constant(place);
    if (!place_is(place, JSON_OBJECT))
        return NULL;
    if (depth <= 0) {
        place_fail(place, "is nested too deeply");
        return NULL;
    }
    enum form form = form_of(place);
    struct place inner = place_member(place, form < FORM_COUNT ? form_members[form] : "");
    switch (form) {
    case FORM_RGB: return read_rgb(place);
    case FORM_MOMENTS: return read_moments(&inner, beyond, depth);
    case FORM_TABLE: return read_table(&inner, beyond);
    case FORM_BLACKBODY: return read_kelvin(&inner, spectrum_blackbody);
    case FORM_ILLUMINANT: return read_named(&inner, spectrum_illuminant);
    case FORM_DAYLIGHT: return read_kelvin(&inner, spectrum_daylight);
    case FORM_GAUSSIAN: return read_gaussian(&inner);
    case FORM_LINE: return read_line(&inner);
    case FORM_LIBRARY: return read_named(&inner, spectrum_library);
    case FORM_SCALE: return read_scaled(place, beyond, depth);
    case FORM_SUM: return read_list(&inner, beyond, depth, spectrum_sum);
    case FORM_PRODUCT: return read_list(&inner, beyond, depth, spectrum_product);
    case FORM_COUNT: break;
    }
    place_fail(place, place_has(place, "texture") ? "cannot vary over the surface here"
                                                  : "is no spectrum (rgb, table, blackbody, illuminant, …)");
    return NULL;
}

/* --- M: a reradiation matrix --------------------------------------------------------------------------------- */

static stokes_matrix *read_shares(const struct place *place)
{
    static const struct field fields[] = {
        {"incident", FIELD_DOUBLE, true, 0, 2, 0, LAMBDA_MAX_NM},
        {"outgoing", FIELD_DOUBLE, true, 2 * sizeof(double), 2, 0, LAMBDA_MAX_NM},
        {"step", FIELD_DOUBLE, true, 4 * sizeof(double), 0, 0, LAMBDA_MAX_NM},
    };
    struct place share = place_member(place, "share");
    const float *values;
    float *owned = NULL;
    size_t count = 0;
    double bands[5];
    stokes_error why = {0};
    stokes_matrix *m = NULL;
    if (!read_fields(place, fields, 3, bands) || !read_numbers(&share, SHARES_MAX, &values, &count, &owned)) {
        free(owned);
        return NULL;
    }
    m = reradiation_create(bands[0], (int)bands[1], bands[2], (int)bands[3], bands[4], "matrix", &why);
    bool good = m != NULL;
    if (good && count != (size_t)m->count_in * (size_t)m->count_out) {
        good = place_fail(&share, "has %zu numbers for %d × %d bands", count, m->count_in, m->count_out);
    } else if (good) {
        memcpy(m->share, values, count * sizeof *values);
        good = reradiation_check(m, "matrix", &why) || place_fail(&share, "%s", why.text);
    } else {
        place_fail(place, "%s: %s", why.property, why.text);
    }
    free(owned);
    if (!good) {
        reradiation_destroy(m);
        return NULL;
    }
    return m;
}

stokes_matrix *read_matrix(const struct place *place)
{
    struct place library = place_member(place, "library");
    const char *name;
    stokes_error why = {0};
    if (!place_is(place, JSON_OBJECT))
        return NULL;
    if (!library.value)
        return read_shares(place);
    if (!read_text(&library, &name))
        return NULL;
    stokes_matrix *m = reradiation_library(name, name, NULL, NULL, &why);
    if (!m)
        place_fail(&library, "%s", why.text);
    return m;
}

/* --- Where a BSDF takes a colour ---------------------------------------------------------------------------- */

struct color_node *read_color(const struct place *place, enum beyond beyond, int depth)
{
    struct place texture = place_member(place, "texture"), of = place_member(place, "of");
    struct color_node *color = NULL;
    bool scaled = place_has(place, "scale") && (place_has(&of, "texture") || place_has(&of, "scale"));
    if (depth <= 0) {
        place_fail(place, "is nested too deeply");
    } else if (scaled) { /* k times a texture, maybe: the factor stays beside it */
        struct place factor = place_member(place, "scale");
        double scale;
        if (!read_number(&factor, -FLT_MAX, FLT_MAX, &scale) || !(color = read_color(&of, beyond, depth - 1)))
            return NULL;
        color->scale *= (float)scale;
    } else if ((color = calloc(1, sizeof *color))) {
        color->scale = 1;
        if (texture.value)
            color->texture = read_texture(&texture);
        else
            color->spectrum = read_spectrum(place, beyond, depth);
        if (!color->texture && !color->spectrum) {
            color_node_destroy(color);
            color = NULL;
        }
    } else {
        place_fail(place, "out of memory");
    }
    return color;
}
