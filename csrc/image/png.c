/* Writing PNG through libpng: encoded in memory, then put under its name in one go. */
#include "image/png.h"

#include <png.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/os.h"

struct buffer {
    unsigned char *data;
    size_t count, room;
    char why[128];
};

static void keep_why(png_structp png, png_const_charp message)
{
    struct buffer *buffer = png_get_error_ptr(png);
    snprintf(buffer->why, sizeof buffer->why, "%s", message);
    png_longjmp(png, 1);
}

static void ignore_warning(png_structp png, png_const_charp message)
{
    (void)png, (void)message;
}

static void append(png_structp png, png_bytep bytes, size_t count)
{
    struct buffer *buffer = png_get_io_ptr(png);
    if (count > buffer->room - buffer->count) {
        size_t room = 2 * buffer->room + count;
        unsigned char *data = realloc(buffer->data, room);
        if (!data)
            png_error(png, "out of memory");
        buffer->data = data;
        buffer->room = room;
    }
    memcpy(buffer->data + buffer->count, bytes, count);
    buffer->count += count;
}

static void flush_nothing(png_structp png)
{
    (void)png;
}

static unsigned char eight_bits(float value)
{
    return value > 0 ? (unsigned char)((value < 1 ? value : 1) * 255 + 0.5f) : 0;
}

/* `row` is the caller's, so that nothing allocated here is lost when libpng jumps out. */
static bool encode(png_structp png, png_infop info, int width, int height, const float *rgba,
                   unsigned char *row)
{
    if (setjmp(png_jmpbuf(png)))
        return false;
    png_set_user_limits(png, 0x7fffffff, 0x7fffffff);
    png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, 8, PNG_COLOR_TYPE_RGBA,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    for (int y = height - 1; y >= 0; y--) { /* PNG begins at the top */
        const float *source = rgba + (size_t)y * (size_t)width * 4;
        for (size_t i = 0; i < (size_t)width * 4; i++)
            row[i] = eight_bits(source[i]);
        png_write_row(png, row);
    }
    png_write_end(png, info);
    return true;
}

bool png_write_rgba(int width, int height, const float *rgba, const char *path, stokes_error *err)
{
    if (width < 1 || height < 1)
        return fail(err, path, "write", "%d × %d is not a picture", width, height);
    struct buffer buffer = {.why = "out of memory"};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &buffer, keep_why, ignore_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    unsigned char *row = malloc((size_t)width * 4);
    bool good = info && row;
    if (good) {
        png_set_write_fn(png, &buffer, append, flush_nothing);
        good = encode(png, info, width, height, rgba, row);
    }
    good = good ? os_write_file(path, buffer.data, buffer.count, err)
                : fail(err, path, "write", "%s", buffer.why);
    png_destroy_write_struct(&png, &info);
    free(row);
    free(buffer.data);
    return good;
}
