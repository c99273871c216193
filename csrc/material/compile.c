/* Compiling a closure tree: flattened into lobes and emission terms, each with the factors of its place in the tree. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "material/lobe.h"

#define TREE_DEPTH 64

struct compiler {
    struct material *material;
    struct factors factors; /* of the closure being compiled */
    int depth;
    void (*warn)(void *user, const stokes_error *);
    void *user;
    stokes_error *err;
};

/* --- What BSDFs call ------------------------------------------------------------------------------------- */

bool compiler_fail(struct compiler *c, const char *property, const char *format, ...)
{
    char text[sizeof((stokes_error *)0)->text];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return fail(c->err, c->material->name, property, "%s", text);
}

void compiler_warn(struct compiler *c, const char *property, const char *format, ...)
{
    stokes_error warning;
    char text[sizeof warning.text];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    fail(&warning, c->material->name, property, "%s", text);
    if (c->warn)
        c->warn(c->user, &warning);
}

struct range compiler_range(const struct compiler *c)
{
    return c->material->context.range;
}

bool compiler_check_ior(struct compiler *c, const struct ior *ior)
{
    return ior_check(ior, compiler_range(c), c->material->name, c->err);
}

bool compiler_check_model(struct compiler *c, double model)
{
    return model == 3 || model == 4 || compiler_fail(c, "model", "is %g; known are 3 and 4", model);
}

static bool factor_depends_on_view(const struct compiler *c, int i)
{
    return value_depends_on_view(c->material->factor[c->factors.at[i].index]);
}

struct lobe_plan *compiler_add(struct compiler *c, const struct closure *closure,
                               bool (*shade)(const struct lobe_plan *, const struct inputs *, struct lobe *),
                               void *data, void (*free_data)(void *))
{
    struct material *m = c->material;
    int views = 0;
    for (int i = 0; i < c->factors.count; i++)
        views += factor_depends_on_view(c, i);
    if (views > LOBE_VIEW_FACTORS)
        compiler_warn(c, "factor",
                      "more than %d nested mixes by the angle of view: the rest look along each sub-path",
                      LOBE_VIEW_FACTORS);
    if (m->lobe_count == SURFACE_LOBES) {
        if (free_data)
            free_data(data);
        compiler_fail(c, "surface", "has more than %d lobes", SURFACE_LOBES);
        return NULL;
    }
    struct lobe_plan *plan = &m->lobe[m->lobe_count++];
    *plan = (struct lobe_plan){
        .closure = closure, .shade = shade, .data = data, .free_data = free_data, .factors = c->factors};
    return plan;
}

/* --- Checking one closure -------------------------------------------------------------------------------- */

static bool check_color(struct compiler *c, const struct closure *closure, int i)
{
    const struct color_node *color = closure->color[i];
    const char *name = closure->bsdf->signature.color_names[i];
    const struct spectrum *s = closure_spectrum(closure, i);
    if (!color || !name)
        return true;
    if (color->texture && !c->material->context.rgb_table)
        return compiler_fail(c, name, "a texture needs the table of RGB reflectances");
    if (color->texture && !(color->scale >= 0 && color->scale <= 1))
        return compiler_fail(c, name, "the texture's scale is %g; it must be within 0 and 1", color->scale);
    if (!color->texture && !s)
        return compiler_fail(c, name, "is neither a spectrum nor a texture");
    if (s && spectrum_min(s) < 0)
        return compiler_fail(c, name, "is %g somewhere; it must not be negative", spectrum_min(s));
    if (s && !closure->bsdf->color_may_exceed_1[i] && spectrum_max(s) > 1.0001f)
        return compiler_fail(c, name, "is %g somewhere; it must not exceed 1", spectrum_max(s));
    return true;
}

/* A lobe's own numbers are set once a hit, so a number that depends on the view takes the sub-path's. */
static void check_value(struct compiler *c, const struct closure *closure, int i)
{
    const char *name = closure->bsdf->signature.value_names[i];
    if (name && closure->value[i] && value_depends_on_view(closure->value[i]))
        compiler_warn(c, name,
                      "depends on the angle of view: light sub-paths take their own direction for it");
}

static bool compile_bsdf(struct compiler *c, const struct closure *closure)
{
    if (!closure->bsdf)
        return compiler_fail(c, "bsdf", "is missing");
    for (int i = 0; i < CLOSURE_COLORS; i++)
        if (!check_color(c, closure, i))
            return false;
    for (int i = 0; i < CLOSURE_VALUES; i++)
        check_value(c, closure, i);
    if (closure->bsdf->signature.takes_matrix && !closure->matrix)
        return compiler_fail(c, "matrix", "is missing");
    return closure->bsdf->compile(c, closure);
}

/* --- Walking the tree ------------------------------------------------------------------------------------ */

static bool walk(struct compiler *, const struct closure *);

static bool add_emission(struct compiler *c, const struct emission_node *emission)
{
    struct material *m = c->material;
    if (!emission || (!emission->spectrum && !emission->texture))
        return compiler_fail(c, "emission", "is neither a spectrum nor a texture");
    if (emission->spectrum && spectrum_min(emission->spectrum) < 0)
        return compiler_fail(c, "emission", "is negative somewhere");
    if (emission->texture && !(emission->scale >= 0 && isfinite(emission->scale)))
        return compiler_fail(c, "emission", "the scale is %g; it must not be negative", emission->scale);
    if (emission->texture && !m->context.rgb_table)
        return compiler_fail(c, "emission", "a texture needs the table of RGB reflectances");
    if (emission->spectrum ? !(spectrum_max(emission->spectrum) > 0) : emission->scale == 0)
        return true;
    if (m->emission_count == MATERIAL_EMISSIONS)
        return compiler_fail(c, "emission", "more than %d emissions in one material", MATERIAL_EMISSIONS);
    m->emission[m->emission_count++] = (struct emission_plan){emission, c->factors};
    return true;
}

/* The factor's place among the material's, where a node that two branches share is kept once. */
static int factor_index(struct compiler *c, const struct value_node *factor)
{
    struct material *m = c->material;
    for (int i = 0; i < m->factor_count; i++)
        if (m->factor[i] == factor)
            return i;
    if (m->factor_count == MATERIAL_FACTORS)
        return -1;
    if (!value_is_affine_in_view(factor))
        compiler_warn(c, "factor",
                      "multiplies functions of the angle of view: light sub-paths take their own direction");
    m->factor[m->factor_count] = factor;
    return m->factor_count++;
}

static bool walk_mix(struct compiler *c, const struct closure *closure)
{
    float low = 0.5f, high = 0.5f;
    struct factors outer = c->factors;
    bool fine = true;
    if (closure->factor)
        value_bounds(closure->factor, &low, &high);
    for (int side = 0; side < 2 && fine; side++) {
        c->factors = outer;
        if (low == high) {
            float factor = clampf(low, 0, 1);
            c->factors.weight *= side ? factor : 1 - factor;
        } else {
            int index = factor_index(c, closure->factor);
            if (index < 0 || outer.count == PLAN_FACTORS)
                return compiler_fail(c, "factor", "more mixes than %d, or more than %d nested",
                                     MATERIAL_FACTORS, PLAN_FACTORS);
            c->factors.at[c->factors.count].index = (uint8_t)index;
            c->factors.at[c->factors.count++].inverted = side == 0;
        }
        fine = c->factors.weight == 0 || walk(c, closure->child[side]);
    }
    c->factors = outer;
    return fine;
}

static bool walk(struct compiler *c, const struct closure *closure)
{
    if (!closure)
        return true;
    if (c->depth == TREE_DEPTH)
        return compiler_fail(c, "surface", "is nested more than %d deep", TREE_DEPTH);
    c->depth++;
    bool fine = true;
    switch (closure->kind) {
    case CLOSURE_BSDF: fine = compile_bsdf(c, closure); break;
    case CLOSURE_EMISSION: fine = add_emission(c, closure->emission); break;
    case CLOSURE_MIX: fine = walk_mix(c, closure); break;
    case CLOSURE_ADD: fine = walk(c, closure->child[0]) && walk(c, closure->child[1]); break;
    case CLOSURE_NULL: break;
    }
    c->depth--;
    return fine;
}

/* --- The material ---------------------------------------------------------------------------------------- */

static bool is_clear(const struct material *m)
{
    const struct lobe_plan *plan = m->lobe;
    if (m->lobe_count != 1 || m->emission_count || !plan->is_transparent || plan->factors.count ||
        plan->factors.weight != 1)
        return false;
    const struct spectrum *color = closure_spectrum(plan->closure, 0);
    return color ? spectrum_min(color) == 1 && spectrum_max(color) == 1 : !plan->closure->color[0];
}

struct material *material_compile(const char *name, struct closure *closure,
                                  const struct material_context *context,
                                  void (*warn)(void *user, const stokes_error *), void *user,
                                  stokes_error *err)
{
    struct material *m = calloc(1, sizeof *m);
    if (!m) {
        closure_destroy(closure);
        fail(err, name, "", "out of memory");
        return NULL;
    }
    struct compiler compiler = {
        .material = m, .factors = {.weight = 1}, .warn = warn, .user = user, .err = err};
    snprintf(m->name, sizeof m->name, "%s", name);
    m->closure = closure;
    m->context = *context;
    if (!material_collect_textures(m, &compiler) || !walk(&compiler, closure) ||
        !material_prepare_emission(m, &compiler)) {
        material_destroy(m);
        return NULL;
    }
    for (int i = 0; i < m->lobe_count; i++)
        m->may_be_transparent = m->may_be_transparent || m->lobe[i].is_transparent;
    m->is_clear = is_clear(m);
    m->volume = -1;
    return m;
}

void material_destroy(struct material *m)
{
    if (!m)
        return;
    for (int i = 0; i < m->lobe_count; i++)
        if (m->lobe[i].free_data)
            m->lobe[i].free_data(m->lobe[i].data);
    closure_destroy(m->closure);
    spectrum_destroy(m->emission_shape);
    spectrum_destroy(m->white);
    free(m->texture);
    free(m);
}

const char *material_name(const struct material *m)
{
    return m->name;
}

static struct fluorophore *fluorophore(const struct material *m, int index)
{
    for (int i = 0; i < m->lobe_count; i++)
        if (m->lobe[i].fluorophore && index-- == 0)
            return m->lobe[i].fluorophore;
    return NULL;
}

int material_fluorophore_count(const struct material *m)
{
    int count = 0;
    while (fluorophore(m, count))
        count++;
    return count;
}

void material_set_fluorophores(struct material *m, int first)
{
    struct fluorophore *f;
    for (int i = 0; (f = fluorophore(m, i)); i++)
        f->index = first + i;
}

const struct spectrum *material_fluorophore_emission(const struct material *m, int index)
{
    return fluorophore(m, index)->emission;
}

const struct spectrum *material_fluorophore_absorption(const struct material *m, int index)
{
    return fluorophore(m, index)->reradiation;
}

float material_fluorophore_pdf(const struct material *m, int index, enum side side, float lambda_in,
                               float lambda_out)
{
    const struct fluorophore *f = fluorophore(m, index);
    return side == SIDE_LIGHT ? fluorophore_pdf(f, side, lambda_in, lambda_out)
                              : fluorophore_pdf(f, side, lambda_out, lambda_in);
}
