/* Value programs: numbers that vary over a surface, by texture, by side, or with the angle of view.
   Where such a number is a mix factor its view stays symbolic (a + b·φ), because it belongs to the camera's direction. */
#include "material/hit_mesh.h"
#include "material/microfacet.h"

void texture_at(const struct texture *t, const struct shading_point *p, float rgba[4])
{
    texture_lookup(t, hit_coordinates(p->hit, t), rgba);
}

static float texture_value(const struct texture *t, const struct shading_point *p)
{
    float rgba[4];
    texture_at(t, p, rgba);
    return texture_channel_value(t, rgba, p->context->luminance);
}

/* φ of the functions, as the Fresnel and Layer Weight nodes of Cycles define them. */
static float view_function(enum view_function function, float parameter, float cosine, bool back)
{
    switch (function) {
    case VIEW_FRESNEL: return fresnel_dielectric(fabsf(cosine), back ? 1 / parameter : parameter);
    case VIEW_FACING: {
        float blend = clampf(parameter, 0, 1 - 1e-5f);
        float exponent = blend < 0.5f ? 2 * blend : 0.5f / (1 - blend);
        return 1 - (exponent == 1 ? fabsf(cosine) : powf(fabsf(cosine), exponent));
    }
    case VIEW_BACKFACING: return back ? 1 : 0;
    }
    return 0;
}

float view_factor_eval(const struct view_factor *f, struct vec3 direction, struct vec3 ng, struct vec3 ns)
{
    float phi =
        view_function(f->function, f->parameter, fminf(1, fabsf(dot(direction, ns))), dot(direction, ng) < 0);
    return clampf(f->a + f->b * phi, 0, 1);
}

/* A factor that holds no view function has b = 0 and reads as a constant. */
static struct view_factor constant(float a)
{
    return (struct view_factor){.a = a};
}

bool value_by_view(const struct value_node *v, const struct shading_point *p, struct view_factor *out)
{
    struct view_factor x = constant(0), y = constant(0);
    switch (v->kind) {
    case VALUE_CONSTANT: *out = constant(v->constant); return true;
    case VALUE_TEXTURE: *out = constant(texture_value(v->texture, p)); return true;
    case VALUE_FRESNEL:
        *out = (struct view_factor){VIEW_FRESNEL, 0, 1, fmaxf(v->constant, 1e-5f)};
        return true;
    case VALUE_FACING: *out = (struct view_factor){VIEW_FACING, 0, 1, v->constant}; return true;
    case VALUE_BACKFACING: *out = (struct view_factor){VIEW_BACKFACING, 0, 1, 0}; return true;
    case VALUE_SCALE_OFFSET:
        if (!value_by_view(v->child[0], p, &x))
            return false;
        *out = (struct view_factor){x.function, x.a * v->scale + v->offset, x.b * v->scale, x.parameter};
        return true;
    case VALUE_PRODUCT:
        if (!value_by_view(v->child[0], p, &x) || !value_by_view(v->child[1], p, &y) ||
            (x.b != 0 && y.b != 0))
            return false;
        *out = y.b != 0 ? (struct view_factor){y.function, y.a * x.a, y.b * x.a, y.parameter}
                        : (struct view_factor){x.function, x.a * y.a, x.b * y.a, x.parameter};
        return true;
    }
    return false;
}

float value_eval(const struct value_node *v, const struct shading_point *p)
{
    float cosine = fminf(1, fabsf(dot(p->viewing, p->ns)));
    bool back = dot(p->viewing, p->hit->ng) < 0;
    switch (v->kind) {
    case VALUE_CONSTANT: return v->constant;
    case VALUE_TEXTURE: return texture_value(v->texture, p);
    case VALUE_SCALE_OFFSET: return value_eval(v->child[0], p) * v->scale + v->offset;
    case VALUE_FRESNEL: return view_function(VIEW_FRESNEL, fmaxf(v->constant, 1e-5f), cosine, back);
    case VALUE_FACING: return view_function(VIEW_FACING, v->constant, cosine, back);
    case VALUE_BACKFACING: return back ? 1 : 0;
    case VALUE_PRODUCT: return value_eval(v->child[0], p) * value_eval(v->child[1], p);
    }
    return 0;
}

bool value_depends_on_view(const struct value_node *v)
{
    switch (v->kind) {
    case VALUE_CONSTANT:
    case VALUE_TEXTURE: return false;
    case VALUE_FRESNEL:
    case VALUE_FACING:
    case VALUE_BACKFACING: return true;
    case VALUE_SCALE_OFFSET: return value_depends_on_view(v->child[0]);
    case VALUE_PRODUCT: return value_depends_on_view(v->child[0]) || value_depends_on_view(v->child[1]);
    }
    return false;
}

bool value_is_affine_in_view(const struct value_node *v)
{
    switch (v->kind) {
    case VALUE_SCALE_OFFSET: return value_is_affine_in_view(v->child[0]);
    case VALUE_PRODUCT:
        return value_is_affine_in_view(v->child[0]) && value_is_affine_in_view(v->child[1]) &&
               !(value_depends_on_view(v->child[0]) && value_depends_on_view(v->child[1]));
    case VALUE_CONSTANT:
    case VALUE_TEXTURE:
    case VALUE_FRESNEL:
    case VALUE_FACING:
    case VALUE_BACKFACING: return true;
    }
    return false;
}

float value_mean(const struct value_node *v, const float luminance[3])
{
    switch (v->kind) {
    case VALUE_CONSTANT: return v->constant;
    case VALUE_TEXTURE: return texture_channel_value(v->texture, v->texture->image->mean, luminance);
    case VALUE_SCALE_OFFSET: return value_mean(v->child[0], luminance) * v->scale + v->offset;
    case VALUE_FRESNEL: return view_function(VIEW_FRESNEL, fmaxf(v->constant, 1e-5f), 1, false);
    case VALUE_FACING: return view_function(VIEW_FACING, v->constant, 1, false);
    case VALUE_BACKFACING: return 0;
    case VALUE_PRODUCT: return value_mean(v->child[0], luminance) * value_mean(v->child[1], luminance);
    }
    return 0;
}

static void texture_bounds(const struct texture *t, float *low, float *high)
{
    /* Clipping adds zeros; data images may hold anything, so only what is known of every image counts. */
    *low = t->channel == TEXTURE_ALPHA ? 0 : -INFINITY;
    *high = t->channel == TEXTURE_ALPHA ? 1 : INFINITY;
}

void value_bounds(const struct value_node *v, float *low, float *high)
{
    float a[2] = {0, 0}, b[2] = {0, 0};
    switch (v->kind) {
    case VALUE_CONSTANT: *low = *high = v->constant; return;
    case VALUE_TEXTURE: texture_bounds(v->texture, low, high); return;
    case VALUE_FRESNEL:
    case VALUE_FACING:
    case VALUE_BACKFACING:
        *low = 0;
        *high = 1;
        return;
    case VALUE_SCALE_OFFSET:
        value_bounds(v->child[0], &a[0], &a[1]);
        *low = v->scale == 0 ? v->offset : fminf(a[0] * v->scale, a[1] * v->scale) + v->offset;
        *high = v->scale == 0 ? v->offset : fmaxf(a[0] * v->scale, a[1] * v->scale) + v->offset;
        return;
    case VALUE_PRODUCT:
        value_bounds(v->child[0], &a[0], &a[1]);
        value_bounds(v->child[1], &b[0], &b[1]);
        *low = INFINITY;
        *high = -INFINITY;
        for (int i = 0; i < 4; i++) {
            float p = a[i & 1] * b[i >> 1];
            p = isnan(p) ? 0 : p; /* 0 · ∞: the zero is exact */
            *low = fminf(*low, p);
            *high = fmaxf(*high, p);
        }
        return;
    }
}
