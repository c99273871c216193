/* What a material emits: at a hit, and its mean spectrum, from which lights and wavelengths are chosen. */
#include "material/lobe.h"

/* Its greatest channel, and the colour relative to that. 0 if none is above 0. */
static float split_color(const float rgb[3], float relative[3])
{
    float most = fmaxf(rgb[0], fmaxf(rgb[1], rgb[2]));
    if (!(most > 0))
        return 0;
    for (int i = 0; i < 3; i++)
        relative[i] = fmaxf(rgb[i], 0) / most;
    return most;
}

/* --- The mean -------------------------------------------------------------------------------------------- */

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
    float relative[3], most = split_color(e->texture->image->mean, relative);
    if (most == 0)
        return NULL;
    struct spectrum *color =
        spectrum_rgb(m->context.range, &m->context.working_space, relative, m->context.uv_rule, NULL);
    struct spectrum *lit = color ? spectrum_product(color, m->white) : NULL;
    struct spectrum *scaled = lit ? spectrum_scaled(lit, e->scale * most) : NULL;
    spectrum_destroy(color);
    spectrum_destroy(lit);
    return scaled;
}

static bool make_shape(struct material *m, struct compiler *c)
{
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

/* The white of textured emission, of unit integral over Λ (algorithm.md §10). */
static bool make_white(struct material *m, struct compiler *c)
{
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

bool material_prepare_emission(struct material *m, struct compiler *c)
{
    return make_white(m, c) && make_shape(m, c);
}

/* --- At a hit -------------------------------------------------------------------------------------------- */

/* k · max(rgb) · upsample(rgb/max) · white/∫white (STREAM.md, L). */
static float textured_emission(const struct material *m, const struct emission_node *e,
                               const struct shading_point *p, float lambda)
{
    float rgba[4];
    texture_at(e->texture, p, rgba);
    float relative[3], most = split_color(rgba, relative);
    if (most == 0)
        return 0;
    struct rgb_curve curve = rgb_table_lookup(m->context.rgb_table, relative);
    return e->scale * most * rgb_curve_eval(&curve, lambda, m->context.uv_rule) *
           spectrum_eval(m->white, lambda);
}

float material_emission(const struct material *m, const struct hit *hit, struct vec3 out, float lambda)
{
    struct shading_point point = shading_point_of(m, hit, out);
    struct factor_values factors = {.material = m, .point = &point};
    bool front = dot(out, hit->ng) > 0;
    float sum = 0;
    for (int i = 0; i < m->emission_count; i++) {
        const struct emission_node *e = m->emission[i].emission;
        if (!front && !e->two_sided)
            continue;
        float weight = factors_weight(&m->emission[i].factors, &factors, out);
        if (weight > 0)
            sum += weight * (e->texture ? textured_emission(m, e, &point, lambda)
                                        : spectrum_eval(e->spectrum, lambda));
    }
    return sum;
}

bool material_emits(const struct material *m)
{
    return m->emission_count > 0;
}

const struct spectrum *material_emission_shape(const struct material *m)
{
    return m->emission_shape;
}

bool material_emits_on_both_sides(const struct material *m)
{
    for (int i = 0; i < m->emission_count; i++)
        if (m->emission[i].emission->two_sided)
            return true;
    return false;
}
