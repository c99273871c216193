/* V and T: numbers that vary over a surface, and texture look-ups. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "stream/expressions.h"

static bool read_texture_choices(const struct place *place, struct texture *texture)
{
    static const char *const interpolations[] = {"linear", "closest", NULL};
    static const char *const extensions[] = {"repeat", "extend", "clip", "mirror", NULL};
    static const char *const channels[] = {"color", "alpha", "r", "g", "b", "luminance", NULL};
    static const char *const projections[] = {"uv", "generated", "object", "window", NULL};
    static const struct {
        const char *member, *const *choices;
    } members[] = {{"interpolation", interpolations},
                   {"extension", extensions},
                   {"channel", channels},
                   {"projection", projections}};
    int chosen[4] = {0};
    for (size_t i = 0; i < 4; i++) {
        struct place member = place_member(place, members[i].member);
        if (member.value && !read_choice(&member, members[i].choices, &chosen[i]))
            return false;
    }
    texture->interpolation = (enum texture_interpolation)chosen[0];
    texture->extension = (enum texture_extension)chosen[1];
    texture->channel = (enum texture_channel)chosen[2];
    texture->projection = (enum texture_projection)chosen[3];
    return true;
}

static bool fill_texture(const struct place *place, struct texture *texture)
{
    struct place image = place_member(place, "image"), uv = place_member(place, "uv");
    struct place transform = place_member(place, "transform");
    const char *name, *layer = "";
    if (!place_is(place, JSON_OBJECT) || !read_text(&image, &name) || (uv.value && !read_text(&uv, &layer)))
        return false;
    texture->image = scene_find_image(place->message->session->scene, name);
    if (!texture->image)
        return place_fail(&image, "image '%.100s' has not been sent", name);
    if (strlen(layer) >= sizeof texture->uv_name)
        return place_fail(&uv, "is longer than %zu bytes", sizeof texture->uv_name - 1);
    strcpy(texture->uv_name, layer);
    return (!transform.value || read_floats(&transform, texture->transform.m, 12)) &&
           read_texture_choices(place, texture);
}

struct texture *read_texture(const struct place *place)
{
    struct texture *texture = calloc(1, sizeof *texture);
    if (!texture) {
        place_fail(place, "out of memory");
        return NULL;
    }
    texture->transform = (struct transform){{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    if (fill_texture(place, texture))
        return texture;
    free(texture);
    return NULL;
}

/* --- V ----------------------------------------------------------------------------------------------------- */

static struct value_node *node(const struct place *place, enum value_kind kind, double constant)
{
    struct value_node *value = calloc(1, sizeof *value);
    if (!value) {
        place_fail(place, "out of memory");
        return NULL;
    }
    value->kind = kind;
    value->constant = (float)constant;
    value->scale = 1;
    return value;
}

static struct value_node *read_constant(const struct place *place, enum value_kind kind, double low,
                                        double high)
{
    double value;
    return read_number(place, low, high, &value) ? node(place, kind, value) : NULL;
}

static struct value_node *read_textured(const struct place *place)
{
    struct texture *texture = read_texture(place);
    struct value_node *value = texture ? node(place, VALUE_TEXTURE, 0) : NULL;
    if (value)
        value->texture = texture;
    else
        free(texture);
    return value;
}

static struct value_node *read_scale_offset(const struct place *place, int depth)
{
    static const struct field fields[] = {
        {"scale", FIELD_DOUBLE, false, 0, 0, -FLT_MAX, FLT_MAX},
        {"offset", FIELD_DOUBLE, false, sizeof(double), 0, -FLT_MAX, FLT_MAX},
    };
    double number[2] = {1, 0};
    struct place of = place_member(place, "of");
    if (!read_fields(place, fields, 2, number))
        return NULL;
    struct value_node *inner = read_value(&of, depth - 1);
    struct value_node *value = inner ? node(place, VALUE_SCALE_OFFSET, 0) : NULL;
    if (!value) {
        value_node_destroy(inner);
        return NULL;
    }
    value->scale = (float)number[0];
    value->offset = (float)number[1];
    value->child[0] = inner;
    return value;
}

/* [a, b, c] becomes (a · b) · c. */
static struct value_node *read_product(const struct place *place, int depth)
{
    struct value_node *all = NULL;
    if (!place_is(place, JSON_ARRAY))
        return NULL;
    size_t count = json_array_size(place->value);
    if (count < 1 || count > EXPRESSION_TERMS) {
        place_fail(place, "has %zu factors; 1 to %d are taken", count, EXPRESSION_TERMS);
        return NULL;
    }
    for (size_t i = 0; i < count; i++) {
        struct place element = place_element(place, i);
        struct value_node *next = read_value(&element, depth - 1);
        struct value_node *product = next && all ? node(place, VALUE_PRODUCT, 0) : NULL;
        if (!next || (all && !product)) {
            value_node_destroy(next);
            value_node_destroy(all);
            return NULL;
        }
        if (product) {
            product->child[0] = all;
            product->child[1] = next;
        }
        all = product ? product : next;
    }
    return all;
}

struct value_node *read_value(const struct place *place, int depth)
{
    if (place->value && json_is_number(place->value))
        return read_constant(place, VALUE_CONSTANT, -FLT_MAX, FLT_MAX);
    if (!place_is(place, JSON_OBJECT))
        return NULL;
    struct place texture = place_member(place, "texture"), fresnel = place_member(place, "fresnel");
    struct place facing = place_member(place, "facing"), product = place_member(place, "product");
    if (depth <= 0)
        place_fail(place, "is nested too deeply");
    else if (texture.value)
        return read_textured(&texture);
    else if (fresnel.value)
        return read_constant(&fresnel, VALUE_FRESNEL, 1e-3, 1e3);
    else if (facing.value)
        return read_constant(&facing, VALUE_FACING, 0, 1);
    else if (place_has(place, "backfacing"))
        return node(place, VALUE_BACKFACING, 0);
    else if (product.value)
        return read_product(&product, depth);
    else if (place_has(place, "of"))
        return read_scale_offset(place, depth);
    else
        place_fail(place, "is no value (a number, texture, fresnel, facing, …)");
    return NULL;
}
