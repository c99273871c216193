/* Lights whose spectra have one shape share one: thousands of lamps of a kind then cost one table of products
   with each dye, and one term of the lamps' spectrum. Shapes are what wavelengths are drawn from, so a scale,
   and rounding, do not matter. */
#include <stdlib.h>
#include <string.h>

#include "base/random.h"
#include "scene/state.h"

/* Scaled copies of one spectrum differ by rounding, far less than this part of their maximum. */
#define SAME_SHAPE 1e-5f

static uint64_t hash_shape(const struct spectrum *s)
{
    float most = spectrum_max(s);
    uint64_t hash = s->count;
    for (uint32_t i = 0; i < 8; i++) {
        uint32_t knot = (uint32_t)((uint64_t)i * s->count / 8), bits;
        memcpy(&bits, &s->lambda[knot], sizeof bits);
        hash = random_mix(hash ^ bits) + (uint64_t)(int64_t)(1024 * (s->value[knot] / most) + 0.5f);
    }
    return hash;
}

static bool same_shape(const struct spectrum *a, const struct spectrum *b)
{
    if (a == b)
        return true;
    if (a->count != b->count || memcmp(a->lambda, b->lambda, a->count * sizeof *a->lambda) != 0)
        return false;
    float scale_a = 1 / spectrum_max(a), scale_b = 1 / spectrum_max(b);
    for (uint32_t i = 0; i < a->count; i++)
        if (!(fabsf(a->value[i] * scale_a - b->value[i] * scale_b) <= SAME_SHAPE))
            return false;
    return true;
}

bool scene_share_spectra(struct scene *scene)
{
    size_t slots = 16;
    while (slots < 2 * scene->light_count)
        slots *= 2;
    uint32_t *slot = calloc(slots, sizeof *slot); /* index into spectra + 1 */
    const struct spectrum **spectra = malloc((scene->light_count + 1) * sizeof *spectra);
    free((void *)scene->spectra);
    scene->spectra = spectra;
    scene->spectrum_count = 0;
    for (size_t i = 0; slot && spectra && i < scene->light_count; i++) {
        struct light *light = &scene->lights[i];
        size_t at = hash_shape(light->spectrum) & (slots - 1);
        while (slot[at] && !same_shape(spectra[slot[at] - 1], light->spectrum))
            at = (at + 1) & (slots - 1);
        if (!slot[at]) {
            spectra[scene->spectrum_count] = light->spectrum;
            slot[at] = (uint32_t)++scene->spectrum_count;
        }
        light->shape = slot[at] - 1;
        light->spectrum = spectra[light->shape];
    }
    bool whole = slot && spectra;
    free(slot);
    return whole;
}

int scene_light_shape_count(const struct scene *scene)
{
    return (int)scene->spectrum_count;
}

int scene_light_shape(const struct scene *scene, int light)
{
    return (int)scene->lights[light].shape;
}
