/* Pictures in memory: checked copies as RGBA floats, with the mean that light and fallback colours need. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "image/texture.h"

#define SIDE_MAX 65536u

void image_destroy(struct image *image)
{
    if (!image)
        return;
    free(image->name);
    free(image->rgba);
    free(image->encoded);
    free(image);
}

static bool check(const char *name, uint32_t width, uint32_t height, int channels, bool eight_bit,
                  size_t bytes, stokes_error *err)
{
    if (!width || !height || width > SIDE_MAX || height > SIDE_MAX)
        return fail(err, name, "size", "%u × %u is not within 1 … %u", width, height, SIDE_MAX);
    if (channels != 1 && channels != 3 && channels != 4)
        return fail(err, name, "channels", "%d, not 1, 3 or 4", channels);
    size_t expected = (size_t)width * height * (size_t)channels * (eight_bit ? 1 : sizeof(float));
    return bytes == expected || fail(err, name, "pixels", "%zu bytes, not %zu", bytes, expected);
}

static float channel_at(const void *pixels, bool eight_bit, size_t index)
{
    if (eight_bit)
        return ((const uint8_t *)pixels)[index] / 255.0f;
    float value;
    memcpy(&value, (const char *)pixels + index * sizeof value, sizeof value);
    return value;
}

/* Spreads 1, 3 or 4 channels over RGBA; false if one is not finite. */
static bool copy_pixels(struct image *image, int channels, bool eight_bit, const void *pixels)
{
    double sum[4] = {0};
    size_t count = (size_t)image->width * image->height;
    for (size_t i = 0; i < count; i++) {
        float *rgba = image->rgba + 4 * i;
        for (int c = 0; c < 4; c++) {
            int source = channels == 1 && c < 3 ? 0 : c;
            rgba[c] =
                source < channels ? channel_at(pixels, eight_bit, i * (size_t)channels + (size_t)source) : 1;
            if (!isfinite(rgba[c]))
                return false;
            sum[c] += rgba[c];
        }
    }
    for (int c = 0; c < 4; c++)
        image->mean[c] = (float)(sum[c] / (double)count);
    return true;
}

struct image *image_create(const char *name, uint32_t width, uint32_t height, int channels, bool eight_bit,
                           const void *pixels, size_t bytes, stokes_error *err)
{
    if (!check(name, width, height, channels, eight_bit, bytes, err))
        return NULL;
    struct image *image = calloc(1, sizeof *image);
    bool whole = image && (image->name = malloc(strlen(name) + 1)) &&
                 (image->rgba = malloc((size_t)width * height * 4 * sizeof *image->rgba));
    if (!whole) {
        image_destroy(image);
        fail(err, name, "pixels", "no memory for %u × %u", width, height);
        return NULL;
    }
    strcpy(image->name, name);
    image->width = width;
    image->height = height;
    if (!copy_pixels(image, channels, eight_bit, pixels)) {
        image_destroy(image);
        fail(err, name, "pixels", "hold a number that is not finite");
        return NULL;
    }
    return image;
}

bool image_keep_encoded(struct image *image)
{
    size_t bytes = (size_t)image->width * image->height * 4 * sizeof *image->rgba;
    if (!(image->encoded = malloc(bytes)))
        return false;
    memcpy(image->encoded, image->rgba, bytes);
    return true;
}

float srgb_to_linear(float v)
{
    return v <= 0.04045f ? v / 12.92f : powf((v + 0.055f) / 1.055f, 2.4f);
}
