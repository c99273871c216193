/* Reads scanline OpenEXR files chunk by chunk, so that memory stays a few rows however large the picture is; nothing in the file is trusted. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "image/exr_file.h"

/* No deflated stream shrinks its data more than this (1032:1). A header that claims more pixels lies, and
   would make us allocate for nothing. */
#define DEFLATE_MAX 1032
#define WIDTH_MAX (1 << 24)

static int64_t read_bytes(exr_const_context_t context, void *user, void *buffer, uint64_t bytes,
                          uint64_t offset, exr_stream_error_func_ptr_t report)
{
    struct exr_file *file = user;
    (void)context, (void)report;
    if (offset > file->bytes || fseeko(file->stream, (off_t)offset, SEEK_SET) != 0)
        return -1;
    size_t got = fread(buffer, 1, (size_t)bytes, file->stream);
    if (got < bytes && ferror(file->stream))
        file->error = errno;
    return (int64_t)got;
}

static int64_t file_bytes(exr_const_context_t context, void *user)
{
    (void)context;
    return (int64_t)((struct exr_file *)user)->bytes;
}

static bool check_part(struct exr_file *file, stokes_error *err)
{
    int parts = 0;
    exr_storage_t storage;
    if (exr_get_count(file->context, &parts) != EXR_ERR_SUCCESS || parts < 1 ||
        exr_get_storage(file->context, PART, &storage) != EXR_ERR_SUCCESS)
        return exr_file_fail(file, "header", err);
    if (storage != EXR_STORAGE_SCANLINE)
        return fail(err, file->path, "header", "is not a scanline picture");
    return true;
}

static bool open_stream(struct exr_file *file, stokes_error *err)
{
    if (!file->stream)
        return exr_file_fail(file, "open", err);
    if (fseeko(file->stream, 0, SEEK_END) != 0 || ftello(file->stream) < 0)
        return fail(err, file->path, "open", "%s", strerror(errno));
    file->bytes = (uint64_t)ftello(file->stream);
    exr_context_initializer_t init = exr_file_initializer(file);
    init.read_fn = read_bytes;
    init.size_fn = file_bytes;
    init.max_image_width = init.max_image_height = WIDTH_MAX;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION | EXR_CONTEXT_FLAG_STRICT_HEADER;
    if (exr_start_read(&file->context, file->path, &init) != EXR_ERR_SUCCESS)
        return exr_file_fail(file, "header", err);
    return check_part(file, err);
}

struct exr_file *exr_open(const char *path, stokes_error *err)
{
    struct exr_file *file = exr_file_create(path, "rb");
    if (!file || !file->path) {
        fail(err, path, "open", "out of memory");
        exr_close(file);
        return NULL;
    }
    if (!open_stream(file, err)) {
        exr_close(file);
        return NULL;
    }
    return file;
}

/* Width and height of a window, or false if it is empty or beyond WIDTH_MAX. */
static bool window_size(const exr_attr_box2i_t *box, int *width, int *height)
{
    int64_t w = (int64_t)box->max.x - box->min.x + 1, h = (int64_t)box->max.y - box->min.y + 1;
    if (w < 1 || h < 1 || w > WIDTH_MAX || h > WIDTH_MAX)
        return false;
    *width = (int)w;
    *height = (int)h;
    return true;
}

bool exr_windows(struct exr_file *file, struct exr_layout *layout, stokes_error *err)
{
    exr_attr_box2i_t display, data;
    if (exr_get_display_window(file->context, PART, &display) != EXR_ERR_SUCCESS ||
        exr_get_data_window(file->context, PART, &data) != EXR_ERR_SUCCESS)
        return exr_file_fail(file, "windows", err);
    if (!window_size(&display, &layout->full_width, &layout->full_height) ||
        !window_size(&data, &layout->width, &layout->height) || data.min.x < display.min.x ||
        data.min.y < display.min.y || data.max.x > display.max.x || data.max.y > display.max.y)
        return fail(err, file->path, "windows", "the data window is not inside the display window");
    layout->x0 = data.min.x - display.min.x;
    layout->y0 = display.max.y - data.max.y;
    return true;
}

size_t exr_text_count(struct exr_file *file)
{
    int32_t count = 0;
    return exr_get_attribute_count(file->context, PART, &count) == EXR_ERR_SUCCESS && count > 0
               ? (size_t)count
               : 0;
}

static const char *text_of(const exr_attribute_t *attribute)
{
    /* The library ends every text with a NUL; one inside it only shortens what we see. */
    return attribute->type == EXR_ATTR_STRING && attribute->string ? attribute->string->str : NULL;
}

const char *exr_text_at(struct exr_file *file, size_t index, const char **name)
{
    const exr_attribute_t *attribute;
    if (exr_get_attribute_by_index(file->context, PART, EXR_ATTR_LIST_FILE_ORDER, (int32_t)index,
                                   &attribute) != EXR_ERR_SUCCESS)
        return NULL;
    *name = attribute->name;
    return text_of(attribute);
}

const char *exr_text_named(struct exr_file *file, const char *name)
{
    for (size_t i = 0; i < exr_text_count(file); i++) {
        const char *found, *text = exr_text_at(file, i, &found);
        if (text && strcmp(found, name) == 0)
            return text;
    }
    return NULL;
}

size_t exr_channel_count(struct exr_file *file)
{
    const exr_attr_chlist_t *list;
    return exr_get_channels(file->context, PART, &list) == EXR_ERR_SUCCESS && list->num_channels > 0
               ? (size_t)list->num_channels
               : 0;
}

const char *exr_channel_at(struct exr_file *file, size_t index, bool *integer)
{
    const exr_attr_chlist_t *list;
    if (index >= exr_channel_count(file) || exr_get_channels(file->context, PART, &list) != EXR_ERR_SUCCESS)
        return NULL;
    *integer = list->entries[index].pixel_type == EXR_PIXEL_UINT;
    return list->entries[index].name.str;
}

/* All wanted channels exist, with their type and at full resolution, and the file can hold what it claims. */
static bool check_channels(struct exr_file *file, const struct exr_channel *channels, size_t count,
                           stokes_error *err)
{
    const exr_attr_chlist_t *list;
    if (exr_get_channels(file->context, PART, &list) != EXR_ERR_SUCCESS)
        return exr_file_fail(file, "channels", err);
    int found = -1;
    for (size_t i = 0; i < count; i++) {
        int tried = 0;
        do
            found = (found + 1) % (list->num_channels > 0 ? list->num_channels : 1);
        while (tried++ < list->num_channels && strcmp(list->entries[found].name.str, channels[i].name) != 0);
        if (tried > list->num_channels)
            return fail(err, file->path, "channels", "%s is missing", channels[i].name);
        const exr_attr_chlist_entry_t *entry = &list->entries[found];
        if ((entry->pixel_type == EXR_PIXEL_UINT) != channels[i].integer || entry->x_sampling != 1 ||
            entry->y_sampling != 1)
            return fail(err, file->path, "channels", "%s is not made of %s at every pixel", channels[i].name,
                        channels[i].integer ? "32-bit integers" : "floats");
    }
    struct exr_layout window;
    if (!exr_windows(file, &window, err))
        return false;
    if ((double)window.width * window.height * 4 * (double)count > (double)file->bytes * DEFLATE_MAX)
        return fail(err, file->path, "windows", "the file is too short for %d × %d pixels", window.width,
                    window.height);
    return true;
}

/* One chunk's rows of the wanted channels, planar. */
struct chunk_reader {
    const struct exr_channel *channels;
    size_t count;
    exr_sink sink;
    void *user;
    struct exr_layout window;
    int rows_per_chunk, first; /* first: y of the top row, in EXR's counting */
    unsigned char *rows;
};

static bool decode_chunk(struct exr_file *file, struct chunk_reader *r, exr_decode_pipeline_t *pipeline,
                         int top, exr_chunk_info_t *info)
{
    exr_context_t context = file->context;
    size_t row_bytes = (size_t)r->window.width * 4;
    if (exr_read_scanline_chunk_info(context, PART, r->first + top, info) != EXR_ERR_SUCCESS ||
        info->height > r->rows_per_chunk || info->width != r->window.width ||
        (top == 0 ? exr_decoding_initialize(context, PART, info, pipeline)
                  : exr_decoding_update(context, PART, info, pipeline)) != EXR_ERR_SUCCESS)
        return false;
    size_t last = 0;
    for (int c = 0; c < pipeline->channel_count; c++) {
        exr_coding_channel_info_t *channel = &pipeline->channels[c];
        size_t index = exr_channel_index(r->channels, r->count, channel->channel_name, &last);
        channel->user_bytes_per_element = 4;
        channel->user_data_type = channel->data_type == EXR_PIXEL_HALF ? EXR_PIXEL_FLOAT : channel->data_type;
        channel->user_pixel_stride = 4;
        channel->user_line_stride = (int32_t)row_bytes;
        channel->decode_to_ptr =
            index < r->count ? r->rows + index * (size_t)r->rows_per_chunk * row_bytes : NULL;
    }
    return (top > 0 || exr_decoding_choose_default_routines(context, PART, pipeline) == EXR_ERR_SUCCESS) &&
           exr_decoding_run(context, PART, pipeline) == EXR_ERR_SUCCESS;
}

static bool read_chunks(struct exr_file *file, struct chunk_reader *r, exr_decode_pipeline_t *pipeline,
                        stokes_error *err)
{
    size_t row_bytes = (size_t)r->window.width * 4;
    for (int top = 0; top < r->window.height; top += r->rows_per_chunk) {
        exr_chunk_info_t info;
        if (!decode_chunk(file, r, pipeline, top, &info))
            return exr_file_fail(file, "pixels", err);
        for (size_t c = 0; c < r->count; c++)
            for (int row = 0; row < info.height && top + row < r->window.height; row++)
                if (!r->sink(r->user, c, r->window.height - 1 - top - row,
                             r->rows + (c * (size_t)r->rows_per_chunk + (size_t)row) * row_bytes, err))
                    return false;
    }
    return true;
}

bool exr_read(struct exr_file *file, const struct exr_channel *channels, size_t count, exr_sink sink,
              void *user, stokes_error *err)
{
    struct chunk_reader r = {.channels = channels, .count = count, .sink = sink, .user = user};
    exr_attr_box2i_t data;
    if (!check_channels(file, channels, count, err) || !exr_windows(file, &r.window, err))
        return false;
    if (exr_get_scanlines_per_chunk(file->context, PART, &r.rows_per_chunk) != EXR_ERR_SUCCESS ||
        exr_get_data_window(file->context, PART, &data) != EXR_ERR_SUCCESS)
        return exr_file_fail(file, "pixels", err);
    r.first = data.min.y;
    r.rows = calloc(count * (size_t)r.rows_per_chunk, (size_t)r.window.width * 4);
    if (!r.rows)
        return fail(err, file->path, "pixels", "out of memory");
    exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
    bool good = read_chunks(file, &r, &pipeline, err);
    exr_decoding_destroy(file->context, &pipeline);
    free(r.rows);
    return good;
}
