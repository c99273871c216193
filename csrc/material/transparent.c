/* Straight through without a change of index: a δ lobe that shadow rays see as a transmittance. */
#include "material/lobe.h"

static float transmittance(const struct lobe *lobe, float z, float lambda)
{
    (void)z;
    return spectral_value_eval(&lobe->color[0], lambda);
}

static bool scatter(const struct lobe *lobe, enum side side, struct vec3 arriving, float lambda, float u,
                    struct delta *out)
{
    (void)side, (void)u;
    *out = (struct delta){
        .leaving = negate(arriving),
        .coefficient = spectral_value_eval(&lobe->color[0], lambda),
        .probability = 1,
        .n_squared = 1,
        .depth_class = SCATTER_TRANSPARENT,
    };
    return true;
}

static const struct lobe_kind lobe_transparent = {
    .name = "transparent",
    .nature = LOBE_DELTA,
    .reflects_as = SCATTER_TRANSPARENT,
    .albedo = transmittance,
    .scatter = scatter,
};

static bool shade(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    (void)plan;
    lobe->color[0] = in->color[0];
    lobe->kind = &lobe_transparent;
    /* Geometry alone decides what is straight: no shading normal may reject it. */
    lobe->frame = in->geometric;
    return true;
}

static bool compile(struct compiler *compiler, const struct closure *closure)
{
    if (!closure_color_is_present(closure, 0))
        return true;
    struct lobe_plan *plan = compiler_add(compiler, closure, shade, NULL, NULL);
    if (plan)
        plan->is_transparent = true;
    return plan;
}

const struct bsdf_kind bsdf_transparent = {
    .signature = {.name = "transparent", .color_names = {"color"}},
    .color_defaults = {1},
    .compile = compile,
};
