/* Pictures in memory and their look-up. Values are in the working space (or raw data), converted when they came in. */
#ifndef IMAGE_TEXTURE_H
#define IMAGE_TEXTURE_H

#include <stdint.h>

#include "base/vec.h"
#include "color/color.h"
#include "stokes.h"

struct image {
    char *name;
    uint32_t width, height;
    float *rgba; /* first row at the bottom; alpha 1 where the source has none */
    /* The same with colours as they were stored, by the curve of sRGB, or NULL: Cycles decodes what it has
       interpolated. Meaningful in a working space with the primaries of Rec.709 alone. */
    float *encoded;
    float mean[4];
};

/* Copies pixels (1, 3 or 4 channels, f32 or u8). Yours: image_destroy. NULL with *err on bad sizes or non-finite texels. */
struct image *image_create(const char *name, uint32_t width, uint32_t height, int channels, bool eight_bit,
                           const void *pixels, size_t bytes, stokes_error *err);
void image_destroy(struct image *);
/* Keeps what `rgba` holds now as `encoded`. False if there is no memory for it. */
bool image_keep_encoded(struct image *);
float srgb_to_linear(float);

enum texture_interpolation { TEXTURE_LINEAR, TEXTURE_CLOSEST };
enum texture_extension { TEXTURE_REPEAT, TEXTURE_EXTEND, TEXTURE_CLIP, TEXTURE_MIRROR };
enum texture_channel { TEXTURE_COLOR, TEXTURE_ALPHA, TEXTURE_R, TEXTURE_G, TEXTURE_B, TEXTURE_LUMINANCE };
enum texture_projection { TEXTURE_UV, TEXTURE_GENERATED, TEXTURE_OBJECT, TEXTURE_WINDOW };

struct texture {
    const struct image *image; /* borrowed */
    int uv_layer;              /* index into hit_mesh.uv, set by scene_commit from uv_name; 0 is the default layer */
    char uv_name[64];
    struct transform transform;
    enum texture_interpolation interpolation;
    enum texture_extension extension;
    enum texture_channel channel;
    enum texture_projection projection;
};

/* Interpolated RGBA at texture coordinates, to which the texture's transform is applied first, as Cycles looks it up: texel
   centres at half integers. */
void texture_lookup(const struct texture *, struct vec3 coordinates, float rgba[4]);
/* The texture's channel of what was looked up. */
float texture_channel_value(const struct texture *, const float rgba[4], const float luminance_weights[3]);

#endif
