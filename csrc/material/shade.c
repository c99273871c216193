/* What a material is at a hit: textures, mix factors and normals evaluated; its lobes and its transparency. */
#include "material/surface.h"

/* A shading normal keeps at least this cosine with the geometric one. */
#define NORMAL_MIN_COSINE 1e-3f

/* --- Factors --------------------------------------------------------------------------------------------- */

/* Those that depend on the view beyond a + b·φ look along the sub-path. */
static struct view_factor factor_at(struct factor_values *f, int index)
{
    if (!(f->known >> index & 1)) {
        const struct value_node *node = f->material->factor[index];
        if (!value_by_view(node, f->point, &f->value[index]))
            f->value[index] = (struct view_factor){.a = value_eval(node, f->point)};
        f->known |= 1u << index;
    }
    return f->value[index];
}

static struct view_factor inverted(struct view_factor v)
{
    return (struct view_factor){v.function, 1 - v.a, -v.b, v.parameter};
}

/* The constant part of a product of factors; those of the view go to view[], at most `most`. */
static float weight_of(const struct factors *factors, struct factor_values *values, struct view_factor *view,
                       uint32_t most, uint32_t *view_count)
{
    const struct shading_point *p = values->point;
    float weight = factors->weight;
    *view_count = 0;
    for (int i = 0; i < factors->count && weight > 0; i++) {
        struct view_factor v = factor_at(values, factors->at[i].index);
        if (factors->at[i].inverted)
            v = inverted(v);
        if (v.b == 0)
            weight *= clampf(v.a, 0, 1);
        else if (*view_count < most)
            view[(*view_count)++] = v;
        else
            weight *= view_factor_eval(&v, p->viewing, p->hit->ng, p->ns);
    }
    return weight;
}

float factors_weight(const struct factors *factors, struct factor_values *values, struct vec3 direction)
{
    struct view_factor view[PLAN_FACTORS];
    uint32_t count;
    float weight = weight_of(factors, values, view, PLAN_FACTORS, &count);
    for (uint32_t i = 0; i < count; i++)
        weight *= view_factor_eval(&view[i], direction, values->point->hit->ng, values->point->ns);
    return weight;
}

/* --- Inputs ---------------------------------------------------------------------------------------------- */

static struct spectral_value textured(const struct color_node *color, const struct shading_point *p,
                                      float *luminance)
{
    const struct material_context *context = p->context;
    float rgba[4];
    texture_at(color->texture, p, rgba);
    for (int i = 0; i < 3; i++)
        rgba[i] = clampf(rgba[i], 0, 1);
    *luminance = color->scale * (rgba[0] * context->luminance[0] + rgba[1] * context->luminance[1] +
                                 rgba[2] * context->luminance[2]);
    return (struct spectral_value){.form = SPECTRAL_CURVE,
                                   .uv_rule = context->uv_rule,
                                   .scale = color->scale,
                                   .curve = rgb_table_lookup(context->rgb_table, rgba)};
}

static struct spectral_value color_at(const struct closure *c, int i, const struct shading_point *p,
                                      float *luminance)
{
    *luminance = 0;
    if (!c->color[i])
        return spectral_flat(c->bsdf->color_defaults[i]);
    if (c->color[i]->texture)
        return textured(c->color[i], p, luminance);
    return spectral_of(c->color[i]->spectrum);
}

/* Tangent-space normal map, as Cycles reads it: about the interpolated normal, with the tangent of the default UV layer. */
static struct vec3 mapped_normal(const struct closure *c, const struct shading_point *p)
{
    const struct hit *hit = p->hit;
    float rgba[4];
    struct vec3 n = dot(hit->ns, p->ns) < 0 ? negate(p->ns) : p->ns; /* as interpolated */
    struct vec3 t = normalize(along(hit->tangent, n, -dot(hit->tangent, n)));
    if (length_squared(t) == 0)
        return p->ns;
    struct vec3 b = scale(cross(n, t), hit->mirrored_uv ? -1 : 1);
    texture_at(c->normal_map, p, rgba);
    struct vec3 m =
        normalize(add(add(scale(t, 2 * rgba[0] - 1), scale(b, 2 * rgba[1] - 1)), scale(n, 2 * rgba[2] - 1)));
    m = normalize(along(n, sub(m, n), fmaxf(c->normal_strength, 0)));
    if (length_squared(m) == 0)
        return p->ns;
    return dot(n, p->ns) < 0 ? negate(m) : m;
}

/* A frame about the closure's normal, raised above the horizon of ng where a map sank it. */
static struct frame frame_of(const struct closure *c, const struct shading_point *p)
{
    struct vec3 ng = p->hit->ng, n = c->normal_map ? mapped_normal(c, p) : p->ns;
    float cosine = dot(n, ng);
    if (cosine < NORMAL_MIN_COSINE)
        n = normalize(along(n, ng, NORMAL_MIN_COSINE - cosine));
    return frame_about(n);
}

static void inputs_at(const struct closure *c, const struct shading_point *p, struct inputs *in)
{
    const struct bsdf_kind *kind = c->bsdf;
    for (int i = 0; i < CLOSURE_COLORS && kind->signature.color_names[i]; i++)
        in->color[i] = color_at(c, i, p, &in->luminance[i]);
    for (int i = 0; i < CLOSURE_VALUES && kind->signature.value_names[i]; i++)
        in->value[i] = c->value[i] ? value_eval(c->value[i], p) : kind->value_defaults[i];
    in->frame = frame_of(c, p);
    in->geometric = frame_about(p->hit->ng);
}

/* --- Lobes ----------------------------------------------------------------------------------------------- */

struct shading_point shading_point_of(const struct material *m, const struct hit *hit, struct vec3 viewing)
{
    float cosine = dot(hit->ns, hit->ng);
    struct vec3 ns = cosine > 0 ? hit->ns : cosine < 0 ? negate(hit->ns) : hit->ng;
    return (struct shading_point){hit, viewing, ns, &m->context};
}

static void register_lobe(struct surface *s)
{
    uint8_t index = s->lobe_count++;
    switch (s->lobe[index].kind->nature) {
    case LOBE_FINITE: s->has_elastic = s->connects = true; break;
    case LOBE_FLUORESCENT:
        s->fluorescent[s->fluorescent_count++] = index;
        s->connects = true;
        break;
    case LOBE_DELTA: s->specular[s->specular_count++] = index; break;
    }
}

void material_shade(const struct material *m, const struct hit *hit, struct vec3 viewing, struct surface *s)
{
    struct shading_point point = shading_point_of(m, hit, viewing);
    struct factor_values factors = {.material = m, .point = &point};
    const struct closure *known = NULL;
    struct inputs in;
    s->ng = hit->ng;
    s->ns = point.ns;
    s->lobe_count = s->fluorescent_count = s->specular_count = 0;
    s->has_elastic = s->connects = false;
    s->is_matte = true;
    s->in_volume = false;
    s->material = m;
    for (int i = 0; i < m->lobe_count; i++) {
        const struct lobe_plan *plan = &m->lobe[i];
        struct lobe *lobe = &s->lobe[s->lobe_count];
        if (plan->is_transparent || plan->is_holdout) /* the path code asks for these by themselves */
            continue;
        lobe->weight = weight_of(&plan->factors, &factors, lobe->view, LOBE_VIEW_FACTORS, &lobe->view_count);
        if (!(lobe->weight > 0))
            continue;
        if (known != plan->closure)
            inputs_at(known = plan->closure, &point, &in);
        lobe->data = plan->data;
        lobe->frame = in.frame;
        if (!plan->shade(plan, &in, lobe))
            continue;
        lobe->mapped = plan->closure->normal_map;
        register_lobe(s);
        s->is_matte &= surface_lobe_is_matte(lobe);
    }
    s->is_matte &= s->lobe_count > 0;
}

float material_transmittance(const struct material *m, const struct hit *hit, struct vec3 viewing,
                             float lambda)
{
    struct shading_point point = shading_point_of(m, hit, viewing);
    struct factor_values factors = {.material = m, .point = &point};
    float sum = 0, luminance;
    for (int i = 0; i < m->lobe_count; i++) {
        if (!m->lobe[i].is_transparent)
            continue;
        float weight = factors_weight(&m->lobe[i].factors, &factors, viewing);
        if (weight > 0) {
            struct spectral_value color = color_at(m->lobe[i].closure, 0, &point, &luminance);
            sum += weight * spectral_value_eval(&color, lambda);
        }
    }
    return sum;
}

float material_holdout(const struct material *m, const struct hit *hit, struct vec3 viewing)
{
    struct shading_point point = shading_point_of(m, hit, viewing);
    struct factor_values factors = {.material = m, .point = &point};
    float sum = 0;
    for (int i = 0; i < m->lobe_count; i++)
        if (m->lobe[i].is_holdout)
            sum += factors_weight(&m->lobe[i].factors, &factors, viewing);
    return fminf(sum, 1);
}

bool material_may_be_transparent(const struct material *m)
{
    return m->may_be_transparent;
}

bool material_is_clear(const struct material *m)
{
    return m->is_clear;
}

int material_volume(const struct material *m)
{
    return m->volume;
}

void material_set_volume(struct material *m, int volume)
{
    m->volume = volume;
}
