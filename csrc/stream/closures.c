/* Closure trees. What a BSDF takes is said by its signature (material/closure.h), so a new one needs nothing here. */
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "stream/expressions.h"

/* --- Index of refraction ------------------------------------------------------------------------------------ */

static bool read_sellmeier(const struct place *place, double term[6])
{
    if (!place_is(place, JSON_ARRAY))
        return false;
    size_t count = json_array_size(place->value);
    if (count < 1 || count > 3)
        return place_fail(place, "has %zu pairs; 1 to 3 are taken", count);
    for (size_t i = 0; i < count; i++) {
        struct place pair = place_element(place, i);
        float value[2];
        if (!read_floats(&pair, value, 2))
            return false;
        term[2 * i] = json_number_value(json_array_get(pair.value, 0));
        term[2 * i + 1] = json_number_value(json_array_get(pair.value, 1));
    }
    return true;
}

static bool read_ior(const struct place *place, struct ior *ior)
{
    static const struct field abbe[] = {{"n_d", FIELD_DOUBLE, true, 0, 0, 0.1, 10},
                                        {"abbe", FIELD_DOUBLE, true, sizeof(double), 0, 0.1, 1e6}};
    static const struct field cauchy[] = {{"cauchy", FIELD_DOUBLE, true, 0, 3, -1e3, 1e3}};
    struct place sellmeier = place_member(place, "sellmeier"), library = place_member(place, "library");
    const char *name;
    *ior = (struct ior){.kind = IOR_CONSTANT, .term = {1.5}};
    if (!place->value)
        return true;
    if (json_is_number(place->value))
        return read_number(place, 0.1, 10, &ior->term[0]);
    if (!place_is(place, JSON_OBJECT))
        return false;
    if (place_has(place, "n_d")) {
        ior->kind = IOR_ABBE;
        return read_fields(place, abbe, 2, ior->term);
    }
    if (place_has(place, "cauchy")) {
        ior->kind = IOR_CAUCHY;
        return read_fields(place, cauchy, 1, ior->term);
    }
    if (sellmeier.value) {
        *ior = (struct ior){.kind = IOR_SELLMEIER};
        return read_sellmeier(&sellmeier, ior->term);
    }
    if (library.value)
        return read_text(&library, &name) &&
               (ior_library(name, ior) || place_fail(&library, "'%.100s' is unknown", name));
    return place_fail(place,
                      "is no index of refraction (a number, n_d and abbe, cauchy, sellmeier or library)");
}

/* --- A BSDF by its signature --------------------------------------------------------------------------------- */

/* STREAM.md, S: a table of what is absorbed or emitted is zero outside of what was measured. */
static enum beyond beyond_of(const char *color)
{
    return strcmp(color, "absorption") == 0 || strcmp(color, "emission") == 0 ? BEYOND_ZERO : BEYOND_HOLD;
}

static bool read_colors(const struct place *place, const struct bsdf_signature *signature,
                        struct closure *closure)
{
    for (int i = 0; i < CLOSURE_COLORS && signature->color_names[i]; i++) {
        struct place member = place_member(place, signature->color_names[i]);
        if (!member.value)
            continue;
        closure->color[i] = read_color(&member, beyond_of(signature->color_names[i]), EXPRESSION_DEPTH);
        if (!closure->color[i])
            return false;
    }
    return true;
}

static bool read_values(const struct place *place, const struct bsdf_signature *signature,
                        struct closure *closure)
{
    for (int i = 0; i < CLOSURE_VALUES && signature->value_names[i]; i++) {
        struct place member = place_member(place, signature->value_names[i]);
        if (member.value && !(closure->value[i] = read_value(&member, EXPRESSION_DEPTH)))
            return false;
    }
    return true;
}

/* Text, true or false, or a whole number: a choice's name is how JSON writes it. */
static bool read_option(const struct place *place, const char *const choices[4], int *chosen)
{
    char written[64] = "";
    if (json_is_string(place->value))
        snprintf(written, sizeof written, "%s", json_string_value(place->value));
    else if (json_is_boolean(place->value))
        strcpy(written, json_is_true(place->value) ? "true" : "false");
    else if (json_is_integer(place->value))
        snprintf(written, sizeof written, "%lld", (long long)json_integer_value(place->value));
    for (int i = 0; i < 4 && choices[i]; i++)
        if (strcmp(choices[i], written) == 0) {
            *chosen = i;
            return true;
        }
    char list[128] = "";
    for (int i = 0; i < 4 && choices[i]; i++) {
        strncat(list, i ? ", " : "", sizeof list - strlen(list) - 1);
        strncat(list, choices[i], sizeof list - strlen(list) - 1);
    }
    return place_fail(place, "'%s' is not one of %s", written, list);
}

static bool read_options(const struct place *place, const struct bsdf_signature *signature,
                         struct closure *closure)
{
    for (int i = 0; i < 4 && signature->option_names[i]; i++) {
        struct place member = place_member(place, signature->option_names[i]);
        if (member.value && !read_option(&member, signature->option_choices[i], &closure->option[i]))
            return false;
    }
    for (int i = 0; i < 4 && signature->number_names[i]; i++) {
        struct place member = place_member(place, signature->number_names[i]);
        closure->number[i] = signature->number_defaults[i];
        if (member.value && !read_number(&member, -FLT_MAX, FLT_MAX, &closure->number[i]))
            return false;
    }
    return true;
}

/* `metal` stands for the library's η and k. */
static bool read_metal(const struct place *place, const struct bsdf_signature *signature,
                       struct closure *closure)
{
    struct place metal = place_member(place, "metal");
    const char *name;
    if (!signature->takes_metal || !metal.value)
        return true;
    if (!read_text(&metal, &name))
        return false;
    for (int i = 0; i < CLOSURE_COLORS && signature->color_names[i]; i++) {
        const char *part = signature->color_names[i];
        char entry[96];
        if (closure->color[i] || (strcmp(part, "eta") != 0 && strcmp(part, "k") != 0))
            continue;
        snprintf(entry, sizeof entry, "metal/%.64s/%s", name, part);
        closure->color[i] = calloc(1, sizeof *closure->color[i]);
        if (!closure->color[i])
            return place_fail(&metal, "out of memory");
        closure->color[i]->scale = 1;
        closure->color[i]->spectrum = spectrum_library(message_range(place->message), entry, entry, NULL);
        if (!closure->color[i]->spectrum)
            return place_fail(&metal, "'%.64s' is not in the library (see `stokes spectrum list`)", name);
    }
    return true;
}

static bool read_normal(const struct place *place, struct closure *closure)
{
    struct place normal = place_member(place, "normal"), texture = place_member(&normal, "texture");
    struct place strength = place_member(&normal, "strength");
    double value = 1;
    if (!normal.value)
        return true;
    if (!place_is(&normal, JSON_OBJECT) || (strength.value && !read_number(&strength, 0, 1e3, &value)))
        return false;
    closure->normal_strength = (float)value;
    closure->normal_map = read_texture(&texture);
    return closure->normal_map != NULL;
}

static bool read_bands(const struct place *place, const struct bsdf_signature *signature,
                       struct closure *closure)
{
    struct place matrix = place_member(place, "matrix");
    return !signature->takes_matrix || (closure->matrix = read_matrix(&matrix));
}

static bool read_bsdf(const struct place *place, struct closure *closure)
{
    struct place name_place = place_member(place, "bsdf"), ior = place_member(place, "ior");
    const char *name;
    if (!read_text(&name_place, &name))
        return false;
    closure->kind = CLOSURE_BSDF;
    closure->bsdf = bsdf_kind_find(name);
    if (!closure->bsdf)
        return place_fail(&name_place, "'%.64s' is unknown", name);
    const struct bsdf_signature *signature = bsdf_kind_signature(closure->bsdf);
    return read_colors(place, signature, closure) && read_values(place, signature, closure) &&
           read_options(place, signature, closure) && read_metal(place, signature, closure) &&
           read_bands(place, signature, closure) &&
           (!signature->takes_ior || read_ior(&ior, &closure->ior)) && read_normal(place, closure);
}

/* --- Trees ------------------------------------------------------------------------------------------------- */

static bool read_pair(const struct place *place, struct closure *closure, int depth)
{
    if (!place_is(place, JSON_ARRAY))
        return false;
    if (json_array_size(place->value) != 2)
        return place_fail(place, "has %zu closures; 2 are wanted", json_array_size(place->value));
    for (size_t i = 0; i < 2; i++) {
        struct place element = place_element(place, i);
        closure->child[i] = read_closure(&element, depth - 1);
        if (!closure->child[i])
            return false;
    }
    return true;
}

static bool read_mix(const struct place *place, struct closure *closure, int depth)
{
    struct place mix = place_member(place, "mix"), factor = place_member(place, "factor");
    closure->kind = CLOSURE_MIX;
    closure->factor = read_value(&factor, EXPRESSION_DEPTH);
    return closure->factor && read_pair(&mix, closure, depth);
}

static bool read_emitter(const struct place *place, struct closure *closure)
{
    struct place emission = place_member(place, "emission"), sides = place_member(place, "two_sided");
    bool two_sided = true;
    closure->kind = CLOSURE_EMISSION;
    if (sides.value && !read_flag(&sides, &two_sided))
        return false;
    closure->emission = read_emission(&emission);
    if (closure->emission)
        closure->emission->two_sided = two_sided;
    return closure->emission != NULL;
}

struct closure *read_closure(const struct place *place, int depth)
{
    bool null = place->value && json_is_null(place->value);
    if (!null && !place_is(place, JSON_OBJECT))
        return NULL;
    struct closure *closure = calloc(1, sizeof *closure);
    struct place add = place_member(place, "add");
    bool good = false;
    if (!closure) {
        place_fail(place, "out of memory");
    } else if (depth <= 0) {
        place_fail(place, "is nested too deeply");
    } else if (null) {
        closure->kind = CLOSURE_NULL;
        good = true;
    } else if (place_has(place, "bsdf")) {
        good = read_bsdf(place, closure);
    } else if (place_has(place, "emission")) {
        good = read_emitter(place, closure);
    } else if (place_has(place, "mix")) {
        good = read_mix(place, closure, depth);
    } else if (add.value) {
        closure->kind = CLOSURE_ADD;
        good = read_pair(&add, closure, depth);
    } else {
        place_fail(place, "is no closure (bsdf, emission, mix, add or null)");
    }
    if (!good) {
        closure_destroy(closure);
        return NULL;
    }
    return closure;
}
