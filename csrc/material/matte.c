/* Matte surfaces — Lambert and dyes about one normal, whoever looks — which most of a fluorescent scene is: a bundle of wavelengths is
   evaluated with its geometry once, and each spectrum once a lane. The formulae are those of surface.c. */
#include "material/surface.h"

bool surface_lobe_is_matte(const struct lobe *lobe)
{
    return (lobe->kind->is_lambert || lobe->kind->nature == LOBE_FLUORESCENT) && lobe->view_count == 0 &&
           !lobe->mapped;
}

/* What the lobes send on at one wavelength: elastically; and by dyes, of what arrives from one side. */
static float elastic_sum(const struct surface *s, float lambda)
{
    float sum = 0;
    for (int i = 0; i < s->lobe_count; i++)
        if (s->lobe[i].kind->nature == LOBE_FINITE)
            sum += s->lobe[i].weight * s->lobe[i].kind->albedo(&s->lobe[i], 1, lambda);
    return sum;
}

static float fluorescent_sum(const struct surface *s, enum side side, float lambda)
{
    float sum = 0;
    for (int f = 0; f < s->fluorescent_count; f++) {
        const struct lobe *lobe = &s->lobe[s->fluorescent[f]];
        sum += lobe->weight * fluorophore_strength(lobe_fluorophore(lobe), side, lambda);
    }
    return sum;
}

/* P_F as surface.c's chances have it. */
static float chance_of_dyes(const struct surface *s, float fluorescent, float elastic)
{
    if (!s->has_elastic)
        return 1;
    return fluorescent > 0 ? fminf(fluorescent / (fluorescent + elastic), FLUORESCENT_CHANCE_MAX) : 0;
}

/* The factor |cos| of light's direction over π, per projected solid angle about ng; 0 where the two directions do not see one side. It is the
   density of directions from the camera, too; from the light it is 1/π. */
static float lambert_factor(const struct surface *s, struct vec3 to_light, struct vec3 to_camera)
{
    float l = dot(to_light, s->lobe[0].frame.n), lg = dot(to_light, s->ng), cg = dot(to_camera, s->ng);
    return l * lg > 0 && lg * cg > 0 ? fabsf(l / lg) / PI_F : 0;
}

static void put(struct surface_steps *out, int i, enum side side, float value, float from_camera,
                float from_light)
{
    out->value[i] = value;
    out->pdf[i] = side == SIDE_CAMERA ? from_camera : from_light;
    out->pdf_other[i] = side == SIDE_CAMERA ? from_light : from_camera;
}

static bool remembers(const struct surface_memo *memo, int lanes, const float lambda[])
{
    bool same = memo->lanes >= lanes;
    for (int i = 0; i < lanes; i++)
        same &= memo->lambda[i] == lambda[i];
    return same;
}

/* The lanes' sums and chances, from memory or made. `own` is for callers without a memory. */
static const struct surface_memo *recall(const struct surface *s, int lanes, const float lambda[],
                                         struct surface_memo *memo, struct surface_memo *own)
{
    if (!memo)
        memo = own;
    else if (remembers(memo, lanes, lambda))
        return memo;
    memo->lanes = lanes;
    for (int i = 0; i < lanes; i++) {
        float elastic = s->has_elastic ? elastic_sum(s, lambda[i]) : 0;
        memo->lambda[i] = lambda[i];
        memo->elastic[i] = elastic;
        for (int side = 0; side < 2; side++)
            memo->dyes[side][i] =
                s->fluorescent_count > 0
                    ? chance_of_dyes(s, fluorescent_sum(s, (enum side)side, lambda[i]), elastic)
                    : 0;
    }
    return memo;
}

static void elastic_steps(const struct surface *s, enum side side, float factor, int lanes,
                          const float lambda[], struct surface_memo *memo, struct surface_steps *out)
{
    struct surface_memo own;
    const struct surface_memo *at = recall(s, lanes, lambda, memo, &own);
    for (int i = 0; i < lanes; i++)
        put(out, i, side, at->elastic[i] * factor, (1 - at->dyes[SIDE_CAMERA][i]) * factor,
            (1 - at->dyes[SIDE_LIGHT][i]) / PI_F);
}

/* The chance of lobe f, which would scatter `own` of what arrives from a side with this wavelength. */
static float chance_of_dye(const struct surface *s, enum side side, float lambda, float own)
{
    if (s->lobe_count == 1)
        return 1;
    float all = s->fluorescent_count == 1 ? own : fluorescent_sum(s, side, lambda);
    float p_f = chance_of_dyes(s, all, s->has_elastic ? elastic_sum(s, lambda) : 0);
    return all > 0 ? p_f * own / all : p_f / (float)s->fluorescent_count;
}

/* Value, strengths and densities of a dye between two wavelengths: of a separable one each is made of the same two numbers. */
struct dye_step {
    float value, strength[2], draw[2]; /* by side */
};

static struct dye_step dye_between(const struct fluorophore *dye, float in, float out)
{
    if (dye->bands)
        return (struct dye_step){.value = fluorophore_value(dye, in, out),
                                 .strength = {[SIDE_LIGHT] = fluorophore_strength(dye, SIDE_LIGHT, in),
                                              [SIDE_CAMERA] = fluorophore_strength(dye, SIDE_CAMERA, out)},
                                 .draw = {[SIDE_LIGHT] = fluorophore_pdf(dye, SIDE_LIGHT, in, out),
                                          [SIDE_CAMERA] = fluorophore_pdf(dye, SIDE_CAMERA, out, in)}};
    float a = spectrum_eval(dye->reradiation, in), e = spectrum_eval(dye->emission, out);
    float strength = (float)dye->strength;
    return (struct dye_step){
        .value = a * e,
        .strength = {[SIDE_LIGHT] = a, [SIDE_CAMERA] = e * strength},
        .draw = {[SIDE_LIGHT] = e * dye->per_emission, [SIDE_CAMERA] = a * dye->per_strength}};
}

static void fluorescent_steps(const struct surface *s, enum side side, int f, float factor, int lanes,
                              const float arriving[], const float leaving[], struct surface_memo *memo,
                              struct surface_steps *out)
{
    const struct lobe *lobe = &s->lobe[s->fluorescent[f]];
    enum side other = side == SIDE_CAMERA ? SIDE_LIGHT : SIDE_CAMERA;
    const float *in = side == SIDE_CAMERA ? leaving : arriving,
                *back = side == SIDE_CAMERA ? arriving : leaving;
    struct surface_memo own;
    bool alone = s->fluorescent_count == 1;
    const struct surface_memo *at = alone ? recall(s, lanes, arriving, memo, &own) : NULL;
    for (int i = 0; i < lanes; i++) {
        struct dye_step dye = dye_between(lobe_fluorophore(lobe), in[i], back[i]);
        float here = alone ? at->dyes[side][i]
                           : chance_of_dye(s, side, arriving[i], lobe->weight * dye.strength[side]);
        float there = chance_of_dye(s, other, leaving[i], lobe->weight * dye.strength[other]);
        float from_camera = side == SIDE_CAMERA ? here : there,
              from_light = side == SIDE_CAMERA ? there : here;
        put(out, i, side, lobe->weight * dye.value * factor, from_camera * dye.draw[SIDE_CAMERA] * factor,
            from_light * dye.draw[SIDE_LIGHT] / PI_F);
        out->draw[i] = dye.draw[side];
        out->draw_other[i] = dye.draw[other];
    }
}

void surface_matte_steps(const struct surface *s, enum side side, enum label label, int f,
                         struct vec3 arriving, struct vec3 leaving, int lanes, const float lambda_arriving[],
                         const float lambda_leaving[], struct surface_memo memo[MEMOS],
                         struct surface_steps *out)
{
    bool camera = side == SIDE_CAMERA;
    float factor = lambert_factor(s, camera ? leaving : arriving, camera ? arriving : leaving);
    if (factor == 0) {
        for (int i = 0; i < lanes; i++) {
            put(out, i, side, 0, 0, 0);
            out->draw[i] = out->draw_other[i] = 0;
        }
    } else if (label == LABEL_ELASTIC) {
        elastic_steps(s, side, factor, lanes, lambda_arriving, memo ? &memo[MEMO_OTHERS] : NULL, out);
    } else {
        fluorescent_steps(s, side, f, factor, lanes, lambda_arriving, lambda_leaving,
                          memo ? &memo[MEMO_ARRIVING] : NULL, out);
    }
}
