/* Cycles' Holdout: a hole in the picture. Camera rays that nothing has scattered yet see no light there, and alpha 0
   (material_holdout); to all other light it is black. */
#include "material/lobe.h"

static bool shade(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    (void)plan, (void)in, (void)lobe;
    return false;
}

static bool compile(struct compiler *compiler, const struct closure *closure)
{
    struct lobe_plan *plan = compiler_add(compiler, closure, shade, NULL, NULL);
    if (plan)
        plan->is_holdout = true;
    return plan;
}

const struct bsdf_kind bsdf_holdout = {.signature = {.name = "holdout"}, .compile = compile};
