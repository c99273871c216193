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
    char text[sizeof ((stokes_error *)0)->text];
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

struct range compiler_range(const struct compiler *c) { return c->material->context.range; }

bool compiler_check_ior(struct compiler *c, const struct ior *ior)
{
    return ior_check(ior, compiler_range(c), c->material->name, c->err);
}

static bool factor_depends_on_view(const struct compiler *c, int i)
{
    return value_depends_on_view(c->material->factor[c->factors.at[i].index]);
}

struct lobe_plan *compiler_add(struct compiler *c, const struct closure *closure,
                               bool (*shade)(const struct lobe_plan *, const struct inputs *, struct lobe *), void *data,
                               void (*free_data)(void *))
{
    struct material *m = c->material;
    int views = 0;
    for (int i = 0; i < c->factors.count; i++)
        views += factor_depends_on_view(c, i);
    if (views > LOBE_VIEW_FACTORS)
        compiler_warn(c, "factor", "more than %d nested mixes by the angle of view: the rest look along each sub-path",
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
        compiler_warn(c, name, "depends on the angle of view: light sub-paths take their own direction for it");
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
        compiler_warn(c, "factor", "multiplies functions of the angle of view: light sub-paths take their own direction");
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
                return compiler_fail(c, "factor", "more mixes than %d, or more than %d nested", MATERIAL_FACTORS,
                                     PLAN_FACTORS);
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
    case CLOSURE_BSDF:
        fine = compile_bsdf(c, closure);
        break;
    case CLOSURE_EMISSION:
        fine = add_emission(c, closure->emission);
        break;
    case CLOSURE_MIX:
        fine = walk_mix(c, closure);
        break;
    case CLOSURE_ADD:
        fine = walk(c, closure->child[0]) && walk(c, closure->child[1]);
        break;
    case CLOSURE_NULL:
        break;
    }
    c->depth--;
    return fine;
}

/* --- Textures -------------------------------------------------------------------------------------------- */

static void visit_value(const struct value_node *v, void (*visit)(void *, struct texture *, bool), void *user)
{
    if (!v)
        return;
    if (v->texture)
        visit(user, v->texture, false);
    visit_value(v->child[0], visit, user);
    visit_value(v->child[1], visit, user);
}

/* Calls visit for every texture of the tree, saying whether it is a colour. */
static void visit_textures(const struct closure *c, void (*visit)(void *, struct texture *, bool), void *user)
{
    if (!c)
        return;
    visit_value(c->factor, visit, user);
    if (c->emission && c->emission->texture)
        visit(user, c->emission->texture, true);
    for (int i = 0; i < CLOSURE_COLORS; i++)
        if (c->color[i] && c->color[i]->texture)
            visit(user, c->color[i]->texture, true);
    for (int i = 0; i < CLOSURE_VALUES; i++)
        visit_value(c->value[i], visit, user);
    if (c->normal_map)
        visit(user, c->normal_map, false);
    visit_textures(c->child[0], visit, user);
    visit_textures(c->child[1], visit, user);
}

static void note_color(void *user, struct texture *t, bool is_color)
{
    (void)t;
    *(bool *)user |= is_color;
}

bool material_needs_rgb_table(const struct closure *c)
{
    bool needs = false;
    visit_textures(c, note_color, &needs);
    return needs;
}

static void count_texture(void *user, struct texture *t, bool is_color)
{
    (void)t, (void)is_color;
    ++*(size_t *)user;
}

static void collect_texture(void *user, struct texture *t, bool is_color)
{
    (void)is_color;
    struct material *m = user;
    m->texture[m->texture_count++] = t;
}

static bool collect_textures(struct compiler *c)
{
    struct material *m = c->material;
    size_t count = 0;
    visit_textures(m->closure, count_texture, &count);
    m->texture = calloc(count + 1, sizeof(struct texture *));
    if (!m->texture)
        return compiler_fail(c, "", "out of memory");
    visit_textures(m->closure, collect_texture, m);
    for (size_t i = 0; i < m->texture_count; i++)
        if (m->texture[i]->projection == TEXTURE_WINDOW) {
            compiler_warn(c, "texture", "window coordinates are not known at a surface; UV coordinates are used");
            m->texture[i]->projection = TEXTURE_UV;
        }
    return true;
}

/* --- The emission's mean --------------------------------------------------------------------------------- */

static float mean_weight(const struct material *m, const struct factors *f)
{
    float weight = f->weight;
    for (int i = 0; i < f->count; i++) {
        float mean = clampf(value_mean(m->factor[f->at[i].index], m->context.luminance), 0, 1);
        weight *= f->at[i].inverted ? 1 - mean : mean;
    }
    return weight;
}

/* The spectrum of one term over its image's mean colour; NULL if that is black, or if memory runs out. */
static struct spectrum *mean_emission(const struct material *m, const struct emission_node *e)
{
    if (e->spectrum)
        return spectrum_scaled(e->spectrum, 1);
    const float *rgb = e->texture->image->mean;
    float most = fmaxf(rgb[0], fmaxf(rgb[1], rgb[2]));
    if (!(most > 0))
        return NULL;
    const float relative[3] = {fmaxf(rgb[0], 0) / most, fmaxf(rgb[1], 0) / most, fmaxf(rgb[2], 0) / most};
    struct spectrum *color =
        spectrum_rgb(m->context.range, &m->context.working_space, relative, m->context.uv_rule, NULL);
    struct spectrum *lit = color ? spectrum_product(color, m->white) : NULL;
    struct spectrum *scaled = lit ? spectrum_scaled(lit, e->scale * most) : NULL;
    spectrum_destroy(color);
    spectrum_destroy(lit);
    return scaled;
}

static bool make_emission_shape(struct compiler *c)
{
    struct material *m = c->material;
    for (int i = 0; i < m->emission_count; i++) {
        struct spectrum *mean = mean_emission(m, m->emission[i].emission);
        if (!mean)
            continue;
        /* A term that is off in the mean may be on somewhere: it keeps a small share of what is drawn. */
        float weight = fmaxf(mean_weight(m, &m->emission[i].factors), 1e-3f * m->emission[i].factors.weight);
        struct spectrum *scaled = spectrum_scaled(mean, weight);
        struct spectrum *sum = m->emission_shape && scaled ? spectrum_sum(m->emission_shape, scaled) : scaled;
        if (sum != scaled)
            spectrum_destroy(scaled);
        spectrum_destroy(mean);
        spectrum_destroy(m->emission_shape);
        m->emission_shape = sum;
        if (!sum)
            return compiler_fail(c, "emission", "out of memory");
    }
    return true;
}

/* The white of textured emission, of unit integral over Λ (architecture.md, "Colour and scale"). */
static bool make_white(struct compiler *c)
{
    struct material *m = c->material;
    bool needed = false;
    for (int i = 0; i < m->emission_count; i++)
        needed = needed || m->emission[i].emission->texture;
    if (!needed)
        return true;
    struct spectrum *white = spectrum_white(m->context.range, &m->context.working_space);
    m->white = white ? spectrum_scaled(white, (float)(1 / spectrum_integral(white))) : NULL;
    spectrum_destroy(white);
    return m->white || compiler_fail(c, "emission", "out of memory");
}

/* --- The material ---------------------------------------------------------------------------------------- */

struct material *material_compile(const char *name, struct closure *closure, const struct material_context *context,
                                  void (*warn)(void *user, const stokes_error *), void *user, stokes_error *err)
{
    struct material *m = calloc(1, sizeof *m);
    if (!m) {
        closure_destroy(closure);
        fail(err, name, "", "out of memory");
        return NULL;
    }
    struct compiler compiler = {.material = m, .factors = {.weight = 1}, .warn = warn, .user = user, .err = err};
    snprintf(m->name, sizeof m->name, "%s", name);
    m->closure = closure;
    m->context = *context;
    if (!collect_textures(&compiler) || !walk(&compiler, closure) || !make_white(&compiler) ||
        !make_emission_shape(&compiler)) {
        material_destroy(m);
        return NULL;
    }
    for (int i = 0; i < m->lobe_count; i++)
        m->may_be_transparent = m->may_be_transparent || m->lobe[i].is_transparent;
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

const char *material_name(const struct material *m) { return m->name; }

size_t material_texture_count(const struct material *m) { return m->texture_count; }
struct texture *material_texture(const struct material *m, size_t index) { return m->texture[index]; }

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
