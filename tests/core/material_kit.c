/* Building materials for tests: closures by hand, closures at random over the table of kinds, and surfaces of them. */
#include "material_kit.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void *allocate(size_t bytes)
{
    void *p = calloc(1, bytes);
    if (!p)
        abort();
    return p;
}

/* --- Random numbers -------------------------------------------------------------------------------------- */

float kit_uniform(struct kit_random *r)
{
    return random_at(r->path, r->next++);
}

float kit_between(struct kit_random *r, float low, float high)
{
    return low + (high - low) * kit_uniform(r);
}

struct vec3 kit_direction(struct kit_random *r)
{
    float z = kit_between(r, -1, 1), phi = kit_between(r, 0, 2 * PI_F), s = sqrtf(fmaxf(0, 1 - z * z));
    return normalize(vec3(s * cosf(phi), s * sinf(phi), z));
}

struct vec3 kit_direction_about(struct kit_random *r, struct vec3 n, bool other_side)
{
    struct vec3 w = kit_direction(r);
    while (fabsf(dot(w, n)) < 0.05f)
        w = kit_direction(r);
    return (dot(w, n) < 0) != other_side ? negate(w) : w;
}

/* --- Closures -------------------------------------------------------------------------------------------- */

struct closure *kit_bsdf(const char *name)
{
    struct closure *c = allocate(sizeof *c);
    c->kind = CLOSURE_BSDF;
    c->bsdf = bsdf_kind_find(name);
    if (!c->bsdf)
        abort();
    memcpy(c->number, bsdf_kind_signature(c->bsdf)->number_defaults, sizeof c->number);
    return c;
}

static struct color_node *color_of(struct spectrum *s)
{
    struct color_node *c = allocate(sizeof *c);
    if (!s)
        abort();
    *c = (struct color_node){.spectrum = s, .scale = 1};
    return c;
}

struct color_node *kit_constant(float value)
{
    return color_of(spectrum_constant(KIT_RANGE, value));
}

struct color_node *kit_table(const float *lambda, const float *value, size_t count)
{
    return color_of(spectrum_table(KIT_RANGE, lambda, value, count, BEYOND_HOLD, "test", NULL));
}

struct color_node *kit_gaussian(double mean, double sigma, double peak)
{
    return color_of(spectrum_gaussian(KIT_RANGE, mean, sigma, peak, "test", NULL));
}

struct value_node *kit_value(float constant)
{
    struct value_node *v = allocate(sizeof *v);
    v->kind = VALUE_CONSTANT;
    v->constant = constant;
    return v;
}

struct closure *kit_mix(struct closure *a, struct closure *b, struct value_node *factor)
{
    struct closure *c = allocate(sizeof *c);
    *c = (struct closure){.kind = CLOSURE_MIX, .child = {a, b}, .factor = factor};
    return c;
}

struct closure *kit_add(struct closure *a, struct closure *b)
{
    struct closure *c = allocate(sizeof *c);
    *c = (struct closure){.kind = CLOSURE_ADD, .child = {a, b}};
    return c;
}

struct closure *kit_dye(float reflectance, float concentration, double absorbs, double emits, double yield,
                        bool energy)
{
    struct closure *c = kit_bsdf("fluorescent");
    c->color[0] = kit_constant(reflectance);
    c->color[1] = kit_gaussian(absorbs, 30, 0.95);
    c->color[2] = kit_gaussian(emits, 25, 1);
    c->value[0] = kit_value(concentration);
    c->number[0] = yield;
    c->option[0] = energy;
    return c;
}

/* A table that wanders between two bounds. */
static struct color_node *random_table(struct kit_random *r, float low, float high)
{
    float lambda[10], value[10];
    for (int i = 0; i < 10; i++) {
        lambda[i] = 300 + 530 * (float)i / 9;
        value[i] = kit_between(r, low, high);
    }
    return kit_table(lambda, value, 10);
}

static struct color_node *random_color(struct kit_random *r, const char *name)
{
    if (strcmp(name, "eta") == 0)
        return random_table(r, 0.2f, 2.5f);
    if (strcmp(name, "k") == 0)
        return random_table(r, 0.5f, 5);
    if (strcmp(name, "absorption") == 0)
        return kit_gaussian(kit_between(r, 320, 600), kit_between(r, 10, 60), kit_between(r, 0.2f, 1));
    if (strcmp(name, "emission") == 0)
        return kit_gaussian(kit_between(r, 400, 750), kit_between(r, 10, 60), 1);
    return random_table(r, 0, 1);
}

static double random_number(struct kit_random *r, const char *name, double ordinary)
{
    if (strcmp(name, "model") == 0)
        return kit_uniform(r) < 0.5f ? 3 : 4;
    if (strcmp(name, "ior") == 0)
        return kit_between(r, 1.2f, 1.9f);
    if (strcmp(name, "yield") == 0)
        return kit_uniform(r);
    return ordinary;
}

stokes_matrix *kit_matrix(struct kit_random *r)
{
    float step = kit_between(r, 6, 25), first = kit_between(r, 280, 350);
    int shift = (int)kit_between(r, 0, 5), in = (int)kit_between(r, 10, 18),
        out = (int)kit_between(r, 10, 22);
    stokes_matrix *m =
        reradiation_create(first, in, first + step * (float)shift, out, step, "test", NULL);
    if (!m)
        abort();
    for (int o = 0; o < out; o++)
        for (int i = 0; i < in; i++)
            m->share[o * in + i] = o + shift == i  ? kit_between(r, 0, 0.7f)
                                   : o + shift < i ? kit_between(r, 0, 0.002f)
                                                   : kit_between(r, 0, 0.9f) / (float)out;
    return m;
}

struct closure *kit_random_bsdf(struct kit_random *r, const struct bsdf_kind *kind, float roughness)
{
    const struct bsdf_signature *s = bsdf_kind_signature(kind);
    struct closure *c = kit_bsdf(s->name);
    for (int i = 0; i < CLOSURE_COLORS && s->color_names[i]; i++)
        c->color[i] = random_color(r, s->color_names[i]);
    for (int i = 0; i < CLOSURE_VALUES && s->value_names[i]; i++)
        c->value[i] =
            kit_value(kit_between(r, strcmp(s->value_names[i], "roughness") == 0 ? roughness : 0, 1));
    for (int i = 0; i < 4 && s->option_names[i]; i++) {
        int choices = 0;
        while (choices < 4 && s->option_choices[i][choices])
            choices++;
        c->option[i] = (int)(kit_uniform(r) * (float)choices);
    }
    for (int i = 0; i < 4 && s->number_names[i]; i++)
        c->number[i] = random_number(r, s->number_names[i], s->number_defaults[i]);
    if (s->takes_matrix)
        c->matrix = kit_matrix(r);
    if (s->takes_ior)
        c->ior = kit_uniform(r) < 0.5f
                     ? (struct ior){IOR_CONSTANT, {kit_between(r, 1.2f, 2)}}
                     : (struct ior){IOR_ABBE, {kit_between(r, 1.4f, 1.9f), kit_between(r, 20, 70)}};
    return c;
}

void kit_set_roughness(struct closure *c, float roughness)
{
    const struct bsdf_signature *s = bsdf_kind_signature(c->bsdf);
    for (int i = 0; i < CLOSURE_VALUES && s->value_names[i]; i++)
        if (strcmp(s->value_names[i], "roughness") == 0)
            c->value[i]->constant = roughness;
}

const char *kit_describe(const struct closure *c, char text[256])
{
    const struct bsdf_signature *s = bsdf_kind_signature(c->bsdf);
    int n = snprintf(text, 256, "%s", s->name);
    for (int i = 0; i < CLOSURE_VALUES && s->value_names[i]; i++)
        if (c->value[i] && n < 200)
            n += snprintf(text + n, 256 - (size_t)n, " %s %.3g", s->value_names[i],
                          (double)c->value[i]->constant);
    for (int i = 0; i < 4 && s->number_names[i] && n < 200; i++)
        n += snprintf(text + n, 256 - (size_t)n, " %s %.3g", s->number_names[i], c->number[i]);
    for (int i = 0; i < 4 && s->option_names[i] && n < 200; i++)
        n += snprintf(text + n, 256 - (size_t)n, " %s %d", s->option_names[i], c->option[i]);
    return text;
}

/* --- Materials ------------------------------------------------------------------------------------------- */

static void count_warning(void *user, const stokes_error *what)
{
    (void)what;
    if (user)
        ++*(int *)user;
}

struct material *kit_try_compile(struct closure *closure, int *warnings, stokes_error *err)
{
    struct material_context context = {
        .range = KIT_RANGE, .uv_rule = UV_HOLD, .luminance = {0.2126f, 0.7152f, 0.0722f}};
    working_space_rec709(&context.working_space);
    return material_compile("test", closure, &context, count_warning, warnings, err);
}

struct material *kit_compile(struct closure *closure)
{
    stokes_error err;
    struct material *m = kit_try_compile(closure, NULL, &err);
    if (!m) {
        fprintf(stderr, "%s: %s\n", err.property, err.text);
        abort();
    }
    return m;
}

struct hit kit_hit(struct vec3 ng, struct vec3 ns)
{
    return (struct hit){.ng = ng, .ns = ns, .tangent = frame_about(ng).s, .light = -1};
}

struct surface kit_surface(const struct material *m, struct vec3 ng, struct vec3 ns)
{
    struct hit hit = kit_hit(ng, ns);
    struct surface s;
    material_shade(m, &hit, ng, &s);
    return s;
}
