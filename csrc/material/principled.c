/* The Principled BSDF's face to the stream: model 3 is that of Blender 3.x, model 4 that of 4.x and later. */
#include "material/principled.h"

static bool compile(struct compiler *compiler, const struct closure *closure)
{
    double model = closure->number[PRINCIPLED_MODEL], ior = closure->number[PRINCIPLED_IOR];
    if (!compiler_check_model(compiler, model))
        return false;
    if (!(ior >= 0.2 && ior <= 8))
        return compiler_fail(compiler, "ior", "is %g; it must be within 0.2 and 8", ior);
    return model == 3 ? principled3_compile(compiler, closure) : principled4_compile(compiler, closure);
}

const struct bsdf_kind bsdf_principled = {
    .signature =
        {
            .name = "principled",
            .color_names = {"base_color", "specular_tint"},
            .value_names = {"metallic", "roughness", "specular", "transmission"},
            .option_names = {"multi_scatter"},
            .option_choices = {{"false", "true"}},
            .number_names = {"model", "ior"},
            .number_defaults = {4, 1.5},
        },
    .color_defaults = {0.8f, 1},
    .value_defaults = {0, 0.5f, 0.5f, 0},
    .compile = compile,
};
