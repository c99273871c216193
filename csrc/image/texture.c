/* Texture look-up with Cycles' conventions: texel centres at half integers, four kinds of extension beyond
   [0, 1]. */
#include <stddef.h>

#include "image/texture.h"

/* Coordinates beyond this many texels have no fraction left; they and those that are not finite look up texel
   0. */
#define TEXELS_MAX 1e9f

/* Which texel stands for index i of a side of `size`; −1: none, transparent black. */
static int64_t wrap(int64_t i, int64_t size, enum texture_extension extension)
{
    switch (extension) {
    case TEXTURE_REPEAT:
        i %= size;
        return i < 0 ? i + size : i;
    case TEXTURE_EXTEND:
        return i < 0 ? 0 : i >= size ? size - 1 : i;
    case TEXTURE_CLIP:
        return i < 0 || i >= size ? -1 : i;
    case TEXTURE_MIRROR:
        i %= 2 * size;
        i = i < 0 ? i + 2 * size : i;
        return i < size ? i : 2 * size - 1 - i;
    }
    return -1;
}

/* Splits into an integer and a fraction in [0, 1). */
static int64_t split(float x, float *fraction)
{
    if (!(fabsf(x) < TEXELS_MAX))
        x = 0;
    float whole = floorf(x);
    *fraction = x - whole;
    return (int64_t)whole;
}

static void add_texel(const struct image *image, int64_t x, int64_t y, float weight, float rgba[4])
{
    if (x < 0 || y < 0)
        return;
    const float *texels = image->encoded ? image->encoded : image->rgba;
    const float *texel = texels + 4 * ((size_t)y * image->width + (size_t)x);
    for (int c = 0; c < 4; c++)
        rgba[c] += weight * texel[c];
}

static void look_up_closest(const struct texture *texture, float u, float v, float rgba[4])
{
    const struct image *image = texture->image;
    float unused;
    int64_t x = split(u * (float)image->width, &unused), y = split(v * (float)image->height, &unused);
    add_texel(image, wrap(x, image->width, texture->extension), wrap(y, image->height, texture->extension), 1,
              rgba);
}

static void look_up_linear(const struct texture *texture, float u, float v, float rgba[4])
{
    const struct image *image = texture->image;
    float fx, fy;
    int64_t x = split(u * (float)image->width - 0.5f, &fx), y = split(v * (float)image->height - 0.5f, &fy);
    int64_t x0 = wrap(x, image->width, texture->extension),
            x1 = wrap(x + 1, image->width, texture->extension);
    int64_t y0 = wrap(y, image->height, texture->extension),
            y1 = wrap(y + 1, image->height, texture->extension);
    add_texel(image, x0, y0, (1 - fx) * (1 - fy), rgba);
    add_texel(image, x1, y0, fx * (1 - fy), rgba);
    add_texel(image, x0, y1, (1 - fx) * fy, rgba);
    add_texel(image, x1, y1, fx * fy, rgba);
}

void texture_lookup(const struct texture *texture, struct vec3 coordinates, float rgba[4])
{
    struct vec3 at = transform_point(&texture->transform, coordinates);
    for (int c = 0; c < 4; c++)
        rgba[c] = 0;
    switch (texture->interpolation) {
    case TEXTURE_LINEAR:
        look_up_linear(texture, at.x, at.y, rgba);
        break;
    case TEXTURE_CLOSEST:
        look_up_closest(texture, at.x, at.y, rgba);
        break;
    }
    for (int c = 0; c < 3 && texture->image->encoded; c++)
        rgba[c] = srgb_to_linear(rgba[c]);
}

float texture_channel_value(const struct texture *texture, const float rgba[4],
                            const float luminance_weights[3])
{
    switch (texture->channel) {
    case TEXTURE_R:
        return rgba[0];
    case TEXTURE_G:
        return rgba[1];
    case TEXTURE_B:
        return rgba[2];
    case TEXTURE_ALPHA:
        return rgba[3];
    case TEXTURE_COLOR: /* a colour used as a number is its luminance, as in Blender */
    case TEXTURE_LUMINANCE:
        break;
    }
    return luminance_weights[0] * rgba[0] + luminance_weights[1] * rgba[1] + luminance_weights[2] * rgba[2];
}
