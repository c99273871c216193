/* W: volumes from JSON. Coefficients are spectra over Λ as they come, so a tree becomes one volume while it is read. */
#include <float.h>

#include "stream/expressions.h"

/* 1/m: a mean free path of a nanometre. */
#define COEFFICIENT_MAX 1e9

/* --- Coefficients -------------------------------------------------------------------------------------------- */

/* A colour, or its default; never negative. */
static struct spectrum *read_tint(const struct place *whole, const char *member, float otherwise,
                                  enum beyond beyond)
{
    struct place place = place_member(whole, member);
    struct spectrum *color = place.value ? read_spectrum(&place, beyond, EXPRESSION_DEPTH)
                                         : spectrum_constant(message_range(whole->message), otherwise);
    if (!color && !place.value)
        place_fail(&place, "out of memory");
    if (color && spectrum_min(color) < 0) {
        place_fail(&place, "is %g somewhere; it must not be negative", (double)spectrum_min(color));
        spectrum_destroy(color);
        return NULL;
    }
    return color;
}

/* max(1 − color, 0); takes the colour. */
static struct spectrum *absorbed(const struct place *place, struct spectrum *color)
{
    bool given = color;
    struct spectrum *one = color ? spectrum_constant(spectrum_range(color), 1) : NULL;
    struct spectrum *less = color ? spectrum_scaled(color, -1) : NULL;
    struct spectrum *rest = one && less ? spectrum_sum(one, less) : NULL;
    struct spectrum *clamped = rest ? spectrum_clamped(rest, 0, FLT_MAX) : NULL;
    spectrum_destroy(color);
    spectrum_destroy(one);
    spectrum_destroy(less);
    spectrum_destroy(rest);
    if (given && !clamped)
        place_fail(place, "out of memory");
    return clamped;
}

/* density × color; takes the colour. */
static struct spectrum *thickened(const struct place *place, struct spectrum *color, double density)
{
    bool given = color;
    struct spectrum *sigma = color ? spectrum_scaled(color, (float)density) : NULL;
    spectrum_destroy(color);
    if (sigma && spectrum_max(sigma) <= (float)COEFFICIENT_MAX)
        return sigma;
    if (sigma)
        place_fail(place, "makes a coefficient of %g per metre; at most %g is taken",
                   (double)spectrum_max(sigma), COEFFICIENT_MAX);
    else if (given)
        place_fail(place, "out of memory, or coefficients that floats cannot hold");
    spectrum_destroy(sigma);
    return NULL;
}

static bool read_density(const struct place *place, double *density)
{
    struct place member = place_member(place, "density");
    *density = 1;
    return !member.value || read_number(&member, 0, COEFFICIENT_MAX, density);
}

static bool read_anisotropy(const struct place *place, float *g)
{
    struct place member = place_member(place, "anisotropy");
    double value = 0;
    if (member.value && !read_number(&member, -1, 1, &value))
        return false;
    *g = (float)value;
    return fabsf(*g) < 1 || place_fail(&member, "is %g; it must lie between -1 and 1", value);
}

static struct volume *make(const struct place *place, struct spectrum *scattering,
                           struct spectrum *absorption, float g)
{
    struct volume *volume = volume_create(scattering, absorption, g);
    if (!volume)
        place_fail(place, "out of memory");
    return volume;
}

/* --- Forms --------------------------------------------------------------------------------------------------- */

enum form { FORM_SCATTER, FORM_ABSORPTION, FORM_PRINCIPLED, FORM_COEFFICIENTS };
static const char *const forms[] = {"scatter", "absorption", "principled", "coefficients", NULL};

static struct volume *read_scatter(const struct place *place)
{
    double density;
    float g;
    if (!read_density(place, &density) || !read_anisotropy(place, &g))
        return NULL;
    struct spectrum *sigma = thickened(place, read_tint(place, "color", 0.8f, BEYOND_HOLD), density);
    return sigma ? make(place, sigma, NULL, g) : NULL;
}

static struct volume *read_absorption(const struct place *place)
{
    double density;
    if (!read_density(place, &density))
        return NULL;
    struct spectrum *sigma =
        thickened(place, absorbed(place, read_tint(place, "color", 0.8f, BEYOND_HOLD)), density);
    return sigma ? make(place, NULL, sigma, 0) : NULL;
}

static struct volume *read_principled(const struct place *place)
{
    double density;
    float g;
    if (!read_density(place, &density) || !read_anisotropy(place, &g))
        return NULL;
    struct spectrum *color = read_tint(place, "color", 0.5f, BEYOND_HOLD);
    struct spectrum *scattering = color ? thickened(place, spectrum_scaled(color, 1), density) : NULL;
    struct spectrum *kept = absorbed(place, color);
    struct spectrum *lost =
        kept ? absorbed(place, read_tint(place, "absorption_color", 0, BEYOND_HOLD)) : NULL;
    struct spectrum *both = scattering && lost ? spectrum_product(kept, lost) : NULL;
    struct spectrum *absorption = thickened(place, both, density);
    if (scattering && lost && !both)
        place_fail(place, "out of memory");
    spectrum_destroy(kept);
    spectrum_destroy(lost);
    if (absorption)
        return make(place, scattering, absorption, g);
    spectrum_destroy(scattering);
    return NULL;
}

static struct volume *read_coefficients(const struct place *place)
{
    float g;
    if (!read_anisotropy(place, &g))
        return NULL;
    struct spectrum *scattering = thickened(place, read_tint(place, "scattering", 0, BEYOND_ZERO), 1);
    struct spectrum *absorption =
        scattering ? thickened(place, read_tint(place, "absorption", 0, BEYOND_ZERO), 1) : NULL;
    if (absorption)
        return make(place, scattering, absorption, g);
    spectrum_destroy(scattering);
    return NULL;
}

static struct volume *read_form(const struct place *place)
{
    struct place name = place_member(place, "volume");
    int form;
    if (!read_choice(&name, forms, &form))
        return NULL;
    switch ((enum form)form) {
    case FORM_SCATTER: return read_scatter(place);
    case FORM_ABSORPTION: return read_absorption(place);
    case FORM_PRINCIPLED: return read_principled(place);
    case FORM_COEFFICIENTS: return read_coefficients(place);
    }
    return NULL;
}

/* --- Trees --------------------------------------------------------------------------------------------------- */

static struct volume *read_tree(const struct place *, int depth);

static struct volume *read_pair(const struct place *place, double a, double b, int depth)
{
    stokes_error why = {0};
    if (!place_is(place, JSON_ARRAY))
        return NULL;
    if (json_array_size(place->value) != 2) {
        place_fail(place, "has %zu volumes; 2 are wanted", json_array_size(place->value));
        return NULL;
    }
    struct place first_place = place_element(place, 0), second_place = place_element(place, 1);
    struct volume *first = read_tree(&first_place, depth - 1);
    struct volume *second = first ? read_tree(&second_place, depth - 1) : NULL;
    if (!second) {
        volume_destroy(first);
        return NULL;
    }
    struct volume *sum = volume_blend(first, a, second, b, &why);
    if (!sum)
        place_fail(place, "%s: %s", why.property, why.text);
    return sum;
}

static struct volume *read_tree(const struct place *place, int depth)
{
    struct place add = place_member(place, "add"), mix = place_member(place, "mix"),
                 factor = place_member(place, "factor");
    double share;
    if (depth <= 0) {
        place_fail(place, "is nested too deeply");
        return NULL;
    }
    if (place->value && json_is_null(place->value))
        return make(place, NULL, NULL, 0);
    if (!place_is(place, JSON_OBJECT))
        return NULL;
    if (place_has(place, "volume"))
        return read_form(place);
    if (add.value)
        return read_pair(&add, 1, 1, depth);
    if (mix.value)
        return read_number(&factor, 0, 1, &share) ? read_pair(&mix, 1 - share, share, depth) : NULL;
    place_fail(place, "is no volume (volume, add, mix or null)");
    return NULL;
}

struct volume *read_volume(const struct place *place)
{
    struct volume *volume = read_tree(place, EXPRESSION_DEPTH);
    if (volume && !volume_finish(volume)) {
        place_fail(place, "out of memory, or coefficients that floats cannot hold");
        volume_destroy(volume);
        return NULL;
    }
    return volume;
}
