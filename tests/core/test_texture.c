/* Textures: bilinear and closest look-up, the four extensions, transforms, channels, and what image_create
   refuses. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "image/texture.h"

#include <cmocka.h>

#define W 4
#define H 3

static struct image *numbered(void)
{
    float pixels[W * H];
    for (int i = 0; i < W * H; i++)
        pixels[i] = (float)(i % W) + 10.0f * (float)(i / W); /* x + 10 y */
    struct image *image = image_create("numbered", W, H, 1, false, pixels, sizeof pixels, NULL);
    assert_non_null(image);
    return image;
}

static float at(const struct image *image, enum texture_interpolation interpolation,
                enum texture_extension extension, float x, float y)
{
    struct texture texture = {.image = image,
                              .transform = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},
                              .interpolation = interpolation,
                              .extension = extension};
    float rgba[4];
    texture_lookup(&texture, vec3(x / W, y / H, 0), rgba);
    assert_float_equal(rgba[0], rgba[1], 0);
    return rgba[0];
}

static void texel_centres_are_at_half_integers(void **state)
{
    (void)state;
    struct image *image = numbered();
    for (int extension = TEXTURE_REPEAT; extension <= TEXTURE_MIRROR; extension++)
        for (int y = 0; y < H; y++)
            for (int x = 0; x < W; x++)
                for (int i = TEXTURE_LINEAR; i <= TEXTURE_CLOSEST; i++)
                    assert_float_equal(at(image, (enum texture_interpolation)i,
                                          (enum texture_extension)extension, (float)x + 0.5f,
                                          (float)y + 0.5f),
                                       (float)x + 10.0f * (float)y, 1e-5);
    image_destroy(image);
}

static void linear_look_up_is_linear_between_centres(void **state)
{
    (void)state;
    struct image *image = numbered();
    assert_float_equal(at(image, TEXTURE_LINEAR, TEXTURE_EXTEND, 1.75f, 0.5f), 1.25f, 1e-5);
    assert_float_equal(at(image, TEXTURE_LINEAR, TEXTURE_EXTEND, 1.75f, 1.0f), 6.25f, 1e-5);
    assert_float_equal(at(image, TEXTURE_CLOSEST, TEXTURE_EXTEND, 1.99f, 1.01f), 11, 1e-5);
    image_destroy(image);
}

/* In texels: repeat wraps, extend holds, clip is transparent black, mirror folds; at one texel beyond each
   edge and far off. */
static void extensions_say_what_lies_beyond_the_edges(void **state)
{
    (void)state;
    static const float x[] = {-0.5f, 4.5f, -4.5f, 9.5f};
    static const float expected[4][4] = {{3, 0, 3, 1}, {0, 3, 0, 3}, {0, 0, 0, 0}, {0, 3, 3, 1}};
    struct image *image = numbered();
    for (int extension = TEXTURE_REPEAT; extension <= TEXTURE_MIRROR; extension++)
        for (int i = 0; i < 4; i++)
            for (int k = TEXTURE_LINEAR; k <= TEXTURE_CLOSEST; k++)
                assert_float_equal(
                    at(image, (enum texture_interpolation)k, (enum texture_extension)extension, x[i], 0.5f),
                    expected[extension][i], 1e-5);
    assert_float_equal(at(image, TEXTURE_LINEAR, TEXTURE_REPEAT, 0, 0.5f), 1.5f, 1e-5);
    assert_float_equal(at(image, TEXTURE_LINEAR, TEXTURE_CLIP, 4, 0.5f), 1.5f, 1e-5);
    image_destroy(image);
}

static void coordinates_that_are_not_finite_look_up_something_finite(void **state)
{
    (void)state;
    static const float bad[] = {NAN, INFINITY, -INFINITY, 1e30f, -1e30f};
    struct image *image = numbered();
    for (int extension = TEXTURE_REPEAT; extension <= TEXTURE_MIRROR; extension++)
        for (int i = 0; i < 5; i++)
            for (int k = TEXTURE_LINEAR; k <= TEXTURE_CLOSEST; k++)
                assert_true(isfinite(at(image, (enum texture_interpolation)k,
                                        (enum texture_extension)extension, bad[i], bad[4 - i])));
    image_destroy(image);
}

static void transform_applies_to_the_coordinates(void **state)
{
    (void)state;
    struct image *image = numbered();
    struct texture texture = {.image = image,
                              .transform = {{0, 2, 0, 0.125f, 1, 0, 0, 0.5f, 0, 0, 1, 0}},
                              .interpolation = TEXTURE_CLOSEST};
    float rgba[4];
    texture_lookup(&texture, vec3(0.1f, 0.25f, 0), rgba); /* (0.625, 0.6): texel 2, 1 */
    assert_float_equal(rgba[2], 12, 1e-5);
    image_destroy(image);
}

static void channels_are_those_of_the_texel(void **state)
{
    (void)state;
    static const float weights[3] = {0.2f, 0.7f, 0.1f}, rgba[4] = {1, 2, 3, 0.25f};
    static const float expected[] = {1.9f, 0.25f, 1, 2, 3, 1.9f};
    for (int channel = TEXTURE_COLOR; channel <= TEXTURE_LUMINANCE; channel++) {
        struct texture texture = {.channel = (enum texture_channel)channel};
        assert_float_equal(texture_channel_value(&texture, rgba, weights), expected[channel], 1e-6);
    }
}

static void bytes_and_missing_channels_become_floats(void **state)
{
    (void)state;
    static const uint8_t rgb[6] = {0, 51, 255, 255, 0, 102};
    struct image *image = image_create("bytes", 2, 1, 3, true, rgb, sizeof rgb, NULL);
    static const float expected[8] = {0, 0.2f, 1, 1, 1, 0, 0.4f, 1};
    for (int i = 0; i < 8; i++)
        assert_float_equal(image->rgba[i], expected[i], 1e-6);
    assert_float_equal(image->mean[0], 0.5f, 1e-6);
    assert_float_equal(image->mean[2], 0.7f, 1e-6);
    image_destroy(image);
}

static void bad_images_are_refused_by_name(void **state)
{
    (void)state;
    float pixels[4] = {0, 1, NAN, 0};
    stokes_error err;
    assert_null(image_create("nan", 2, 2, 1, false, pixels, sizeof pixels, &err));
    assert_string_equal(err.object, "nan");
    assert_string_equal(err.property, "pixels");
    assert_null(image_create("short", 2, 2, 1, false, pixels, sizeof pixels - 1, &err));
    assert_null(image_create("empty", 0, 2, 1, false, pixels, 0, &err));
    assert_string_equal(err.property, "size");
    assert_null(image_create("two", 1, 2, 2, false, pixels, sizeof pixels, &err));
    assert_string_equal(err.property, "channels");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texel_centres_are_at_half_integers),
        cmocka_unit_test(linear_look_up_is_linear_between_centres),
        cmocka_unit_test(extensions_say_what_lies_beyond_the_edges),
        cmocka_unit_test(coordinates_that_are_not_finite_look_up_something_finite),
        cmocka_unit_test(transform_applies_to_the_coordinates),
        cmocka_unit_test(channels_are_those_of_the_texel),
        cmocka_unit_test(bytes_and_missing_channels_become_floats),
        cmocka_unit_test(bad_images_are_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
