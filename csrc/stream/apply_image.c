/* `image`: pixels, brought into the working space as they come. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "stream/messages.h"

#define IMAGE_SIDE_MAX 65536

struct image_size {
    uint32_t width, height;
    int channels;
};

/* Linear Rec.709 to the working space, by XYZ. */
static void from_rec709(const struct working_space *space, float *rgba, size_t count)
{
    struct working_space rec709;
    double m[9] = {0};
    working_space_rec709(&rec709);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < 3; k++)
                m[3 * r + c] += space->xyz_to_rgb[3 * r + k] * rec709.rgb_to_xyz[3 * k + c];
    for (size_t i = 0; i < count; i++) {
        float *p = rgba + 4 * i, in[3] = {p[0], p[1], p[2]};
        for (int r = 0; r < 3; r++)
            p[r] = (float)(m[3 * r] * in[0] + m[3 * r + 1] * in[1] + m[3 * r + 2] * in[2]);
    }
}

/* The spaces that every Blender has, for when no config is open. */
static bool convert_without_config(const struct place *colorspace, const char *name,
                                   const struct session_color *color, float *rgba, size_t count)
{
    bool encoded = strcmp(name, "sRGB") == 0;
    if (strcmp(name, "Non-Color") == 0 || strcmp(name, "Raw") == 0)
        return true;
    if (!encoded && strcmp(name, "Linear") != 0 && strcmp(name, "Linear Rec.709") != 0)
        return place_fail(colorspace, "'%.100s' needs an OpenColorIO config, and none is open", name);
    for (size_t i = 0; encoded && i < 4 * count; i++)
        if (i % 4 != 3)
            rgba[i] = srgb_to_linear(rgba[i]);
    from_rec709(&color->working_space, rgba, count);
    return true;
}

/* Cycles filters the bytes of an sRGB picture as they are stored, and decodes what it has looked up. */
static bool is_filtered_encoded(const char *name, const struct session_color *color)
{
    struct working_space rec709;
    working_space_rec709(&rec709);
    for (int i = 0; i < 9; i++)
        if (fabs(rec709.rgb_to_xyz[i] - color->working_space.rgb_to_xyz[i]) > 1e-3)
            return false;
    return strcmp(name, "sRGB") == 0;
}

static void find_mean(struct image *image)
{
    size_t count = (size_t)image->width * image->height;
    double sum[4] = {0};
    for (size_t i = 0; i < 4 * count; i++)
        sum[i % 4] += image->rgba[i];
    for (int i = 0; i < 4; i++)
        image->mean[i] = (float)(sum[i] / (double)count);
}

static bool convert(const struct place *colorspace, const char *name, const struct session_color *color,
                    struct image *image, stokes_error *err)
{
    size_t count = (size_t)image->width * image->height;
    if (!*name || strcmp(name, "data") == 0 || strcmp(name, color->name) == 0)
        return true;
    if (is_filtered_encoded(name, color) && !image_keep_encoded(image))
        return place_fail(colorspace, "no memory for the picture's encoded colours");
    if (color->config ? !color_config_to_working(color->config, name, color->name, image->rgba, count, 4, err)
                      : !convert_without_config(colorspace, name, color, image->rgba, count))
        return false;
    for (size_t i = 0; i < 4 * count; i++)
        if (!isfinite(image->rgba[i]))
            return place_fail(colorspace, "'%.100s' makes pixel %zu not finite", name, i / 4);
    find_mean(image);
    return true;
}

bool apply_image(const struct place *root)
{
    static const char *const formats[] = {"f32", "u8", NULL};
    static const struct field fields[] = {
        {"width", FIELD_U32, true, offsetof(struct image_size, width), 0, 1, IMAGE_SIDE_MAX},
        {"height", FIELD_U32, true, offsetof(struct image_size, height), 0, 1, IMAGE_SIDE_MAX},
        {"channels", FIELD_INT, true, offsetof(struct image_size, channels), 0, 1, 4},
    };
    struct image_size size;
    struct message *message = root->message;
    struct place format = place_member(root, "format"), colorspace = place_member(root, "colorspace");
    struct place pixels = place_member(root, "pixels");
    const char *space = "";
    const void *data;
    size_t bytes;
    int eight_bit;
    if (!read_fields(root, fields, 3, &size) || !read_choice(&format, formats, &eight_bit) ||
        (colorspace.value && !read_text(&colorspace, &space)) || !read_blob(&pixels, 1, &data, &bytes))
        return false;
    struct image *image = image_create(message->object, size.width, size.height, size.channels, eight_bit,
                                       data, bytes, message->err);
    if (!image)
        return false;
    if (!convert(&colorspace, space, &message->session->color, image, message->err)) {
        image_destroy(image);
        return false;
    }
    return scene_add_image(message->session->scene, image, message->err);
}
