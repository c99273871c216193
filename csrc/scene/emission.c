/* What lamps and the world emit: a spectrum, and a texture whose colours are upsampled under the working
   space's white (algorithm.md §10): scale · max(c) · upsample(c/max c) · D65/∫D65, where
   white is D65. */
#include "base/error.h"
#include "scene/state.h"

/* Part of a textured light's wavelengths that is drawn from plain white, so that every texel's colour has
   support. */
#define WHITE_PART 0.2f

void emission_free(struct emission *emission)
{
    spectrum_destroy(emission->own_shape);
    emission->shape = emission->own_shape = NULL;
}

struct spectrum *emission_white(const struct scene *scene)
{
    struct range range = scene->context.range;
    struct spectrum *white = spectrum_white(range, &scene->context.working_space);
    double luminance = 0;
    for (float lambda = CMF_MIN_NM; white && lambda <= CMF_MAX_NM; lambda += 1) {
        float xyz[3];
        cmf_eval(lambda, xyz);
        luminance += (double)xyz[1] * spectrum_eval(white, lambda);
    }
    luminance *= cmf_normalization(range.min, range.max);
    struct spectrum *light = luminance > 0 ? spectrum_scaled(white, (float)(1 / luminance)) : NULL;
    spectrum_destroy(white);
    return light;
}

static float clamp_positive(float x)
{
    return x > 0 ? x : 0;
}

/* Spectrum of the texture's mean colour, mixed with white. */
static struct spectrum *texture_shape(const struct scene *scene, const float mean_color[3], float factor,
                                      bool *outside)
{
    float mean[3], most = 0;
    for (int i = 0; i < 3; i++)
        most = fmaxf(most, mean[i] = clamp_positive(mean_color[i]));
    if (!(most > 0) || !(factor > 0))
        return spectrum_constant(scene->context.range, 0);
    for (int i = 0; i < 3; i++)
        mean[i] = (1 - WHITE_PART) * mean[i] / most + WHITE_PART;
    struct spectrum *color =
        spectrum_rgb(scene->context.range, &scene->context.working_space, mean, UV_HOLD, outside);
    struct spectrum *lit = color ? spectrum_product(color, scene->illuminant) : NULL;
    struct spectrum *scaled = lit ? spectrum_scaled(lit, factor * most) : NULL;
    spectrum_destroy(color);
    spectrum_destroy(lit);
    return scaled;
}

bool emission_compile(struct emission *emission, const struct scene *scene, const struct emission_node *node,
                      const float mean[3], const char *name, stokes_error *err)
{
    emission_free(emission);
    *emission = (struct emission){.fixed = node->spectrum,
                                  .texture = node->texture,
                                  .scale = node->scale,
                                  .table = scene->rgb_table,
                                  .illuminant = scene->illuminant};
    if (emission->fixed && !(spectrum_min(emission->fixed) >= 0))
        return fail(err, name, "emission", "is negative (%g) somewhere",
                    (double)spectrum_min(emission->fixed));
    if (emission->texture && !emission->texture->image)
        return fail(err, name, "emission", "its texture has no image");
    if (emission->texture && !(emission->scale >= 0 && isfinite(emission->scale)))
        return fail(err, name, "scale", "is %g", (double)emission->scale);
    if (emission->texture)
        emission->own_shape = texture_shape(scene, mean, emission->scale, &emission->out_of_reach);
    emission->shape = emission->texture ? emission->own_shape : emission->fixed;
    if (!emission->shape)
        return fail(err, name, "emission", "no memory for its spectrum");
    emission->total = spectrum_integral(emission->shape);
    return true;
}

static float texel_at(const struct emission *emission, struct vec3 coordinates, float lambda)
{
    float rgba[4], most = 0;
    texture_lookup(emission->texture, coordinates, rgba);
    for (int i = 0; i < 3; i++)
        most = fmaxf(most, rgba[i] = clamp_positive(rgba[i]));
    if (!(most > 0))
        return 0;
    for (int i = 0; i < 3; i++)
        rgba[i] /= most;
    struct rgb_curve curve = rgb_table_lookup(emission->table, rgba);
    return emission->scale * most * rgb_curve_eval(&curve, lambda, UV_HOLD) *
           spectrum_eval(emission->illuminant, lambda);
}

float emission_at(const struct emission *emission, struct vec3 coordinates, float lambda)
{
    return emission->texture ? texel_at(emission, coordinates, lambda)
                             : spectrum_eval(emission->fixed, lambda);
}
