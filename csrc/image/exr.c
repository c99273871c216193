/* Scanline OpenEXR files through OpenEXRCore. Both directions work chunk by chunk, so that memory stays a
   few rows however large the picture is; reading and writing go through stdio, so that an error is known
   where it happens. */
#include "image/exr.h"

#include <errno.h>
#include <openexr.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/os.h"

#define PART 0
/* No deflated stream shrinks its data more than this (1032:1). A header that claims more pixels lies, and
   would make us allocate for nothing. */
#define DEFLATE_MAX 1032
#define WIDTH_MAX (1 << 24)

struct exr_file {
    exr_context_t context;
    FILE *stream;
    uint64_t bytes; /* of the file, when reading */
    int error;      /* the first errno of the stream */
    char why[256];  /* the library's last message */
    char *path;
};

static void remember_why(exr_const_context_t context, exr_result_t code, const char *message)
{
    void *user = NULL;
    (void)code;
    if (exr_get_user_data(context, &user) == EXR_ERR_SUCCESS && user) {
        struct exr_file *file = user;
        snprintf(file->why, sizeof file->why, "%s", message);
    }
}

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

static int64_t write_bytes(exr_const_context_t context, void *user, const void *buffer, uint64_t bytes,
                           uint64_t offset, exr_stream_error_func_ptr_t report)
{
    struct exr_file *file = user;
    (void)context, (void)report;
    if (fseeko(file->stream, (off_t)offset, SEEK_SET) != 0 ||
        fwrite(buffer, 1, (size_t)bytes, file->stream) != (size_t)bytes) {
        if (!file->error)
            file->error = errno;
        return -1;
    }
    return (int64_t)bytes;
}

static exr_context_initializer_t initializer(struct exr_file *file)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = remember_why;
    init.user_data = file;
    return init;
}

/* The stream's own error says more than what the library makes of it. */
static bool fail_file(struct exr_file *file, const char *property, stokes_error *err)
{
    if (file->error)
        return fail(err, file->path, property, "%s", strerror(file->error));
    return fail(err, file->path, property, "%s", file->why[0] ? file->why : "OpenEXR gives no reason");
}

static struct exr_file *file_create(const char *path, const char *mode)
{
    struct exr_file *file = calloc(1, sizeof *file);
    if (!file)
        return NULL;
    file->path = strdup(path);
    file->stream = file->path ? fopen(path, mode) : NULL;
    file->error = file->stream ? 0 : errno;
    return file;
}

void exr_close(struct exr_file *file)
{
    if (!file)
        return;
    if (file->context)
        exr_finish(&file->context);
    if (file->stream)
        fclose(file->stream);
    free(file->path);
    free(file);
}

/* --- Writing --------------------------------------------------------------------------------------- */

static bool set_header(struct exr_file *file, const struct exr_layout *layout)
{
    int top = layout->full_height - layout->y0 - layout->height;
    exr_attr_box2i_t display = {{.x = 0, .y = 0},
                                {.x = layout->full_width - 1, .y = layout->full_height - 1}};
    exr_attr_box2i_t data = {{.x = layout->x0, .y = top},
                             {.x = layout->x0 + layout->width - 1, .y = top + layout->height - 1}};
    exr_attr_v2f_t center = {.x = 0, .y = 0};
    int part;
    exr_context_t context = file->context;
    bool good =
        exr_add_part(context, "stokes", EXR_STORAGE_SCANLINE, &part) == EXR_ERR_SUCCESS &&
        exr_initialize_required_attr(context, PART, &display, &data, 1, &center, 1,
                                     EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP) == EXR_ERR_SUCCESS;
    for (size_t i = 0; good && i < layout->channel_count; i++)
        good = exr_add_channel(context, PART, layout->channels[i].name,
                               layout->channels[i].integer ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT,
                               EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1) == EXR_ERR_SUCCESS;
    for (size_t i = 0; good && i < layout->text_count; i++)
        good = exr_attr_set_string(context, PART, layout->texts[i].name, layout->texts[i].text) ==
               EXR_ERR_SUCCESS;
    if (good && layout->chromaticities) {
        exr_attr_chromaticities_t c;
        memcpy(&c, layout->chromaticities, sizeof c);
        good = exr_attr_set_chromaticities(context, PART, "chromaticities", &c) == EXR_ERR_SUCCESS;
    }
    return good && exr_write_header(context) == EXR_ERR_SUCCESS;
}

/* The channel of that name; `count` if there is none. The search begins behind the last one found, as both lists tend to have one order. */
static size_t channel_index(const struct exr_channel *channels, size_t count, const char *name, size_t *last)
{
    for (size_t i = 0; i < count; i++) {
        size_t at = (*last + 1 + i) % count;
        if (strcmp(channels[at].name, name) == 0)
            return *last = at;
    }
    return count;
}

/* One chunk's rows, planar: every channel of the file in turn, `height` rows each. */
struct chunk_writer {
    const struct exr_layout *layout;
    exr_source source;
    const void *user;
    size_t *source_channel; /* of each channel in the file's (alphabetical) order */
    unsigned char *rows;
    int rows_per_chunk;
};

static bool write_chunk(struct exr_file *file, struct chunk_writer *w, exr_encode_pipeline_t *pipeline,
                        int top)
{
    exr_chunk_info_t info;
    int first = w->layout->full_height - w->layout->y0 - w->layout->height;
    size_t row_bytes = (size_t)w->layout->width * 4;
    if (exr_write_scanline_chunk_info(file->context, PART, first + top, &info) != EXR_ERR_SUCCESS)
        return false;
    exr_result_t result = top == 0 ? exr_encoding_initialize(file->context, PART, &info, pipeline)
                                   : exr_encoding_update(file->context, PART, &info, pipeline);
    if (result != EXR_ERR_SUCCESS)
        return false;
    size_t last = 0;
    for (int c = 0; c < pipeline->channel_count; c++) {
        exr_coding_channel_info_t *channel = &pipeline->channels[c];
        unsigned char *rows = w->rows + (size_t)c * (size_t)w->rows_per_chunk * row_bytes;
        if (top == 0)
            w->source_channel[c] =
                channel_index(w->layout->channels, w->layout->channel_count, channel->channel_name, &last);
        for (int row = 0; row < info.height; row++)
            w->source(w->user, w->source_channel[c], w->layout->height - 1 - top - row,
                      rows + (size_t)row * row_bytes);
        channel->user_pixel_stride = 4;
        channel->user_line_stride = (int32_t)row_bytes;
        channel->encode_from_ptr = rows;
    }
    if (top == 0 && exr_encoding_choose_default_routines(file->context, PART, pipeline) != EXR_ERR_SUCCESS)
        return false;
    return exr_encoding_run(file->context, PART, pipeline) == EXR_ERR_SUCCESS;
}

static bool write_chunks(struct exr_file *file, struct chunk_writer *w)
{
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    bool good = true;
    for (int top = 0; good && top < w->layout->height; top += w->rows_per_chunk)
        good = write_chunk(file, w, &pipeline, top);
    exr_encoding_destroy(file->context, &pipeline);
    return good;
}

static bool write_pixels(struct exr_file *file, const struct exr_layout *layout, exr_source source,
                         const void *user)
{
    struct chunk_writer w = {.layout = layout, .source = source, .user = user};
    if (exr_get_scanlines_per_chunk(file->context, PART, &w.rows_per_chunk) != EXR_ERR_SUCCESS)
        return false;
    w.rows = malloc(layout->channel_count * (size_t)w.rows_per_chunk * (size_t)layout->width * 4);
    w.source_channel = calloc(layout->channel_count, sizeof *w.source_channel);
    bool good = w.rows && w.source_channel;
    if (good)
        good = write_chunks(file, &w);
    else
        file->error = ENOMEM;
    free(w.rows);
    free(w.source_channel);
    return good;
}

static bool write_stream(struct exr_file *file, const struct exr_layout *layout, exr_source source,
                         const void *user)
{
    exr_context_initializer_t init = initializer(file);
    init.write_fn = write_bytes;
    bool good =
        exr_start_write(&file->context, file->path, EXR_WRITE_FILE_DIRECTLY, &init) == EXR_ERR_SUCCESS &&
        set_header(file, layout) && write_pixels(file, layout, source, user);
    /* The table of chunks is written last; a full disk may show here, or when the stream is flushed. */
    if (file->context)
        good &= exr_finish(&file->context) == EXR_ERR_SUCCESS;
    file->context = NULL;
    if (fclose(file->stream) != 0 && !file->error)
        file->error = errno;
    file->stream = NULL;
    return good && !file->error;
}

bool exr_write(const struct exr_layout *layout, exr_source source, const void *user, const char *path,
               stokes_error *err)
{
    size_t room = strlen(path) + 32;
    char *temporary = malloc(room);
    if (!temporary)
        return fail(err, path, "write", "out of memory");
    /* Two writers of one name get two temporary files, as the clock never stands still for both and "x" is
       exclusive. */
    snprintf(temporary, room, "%s.part-%llx", path, (unsigned long long)(os_seconds() * 1e9));
    struct exr_file *file = file_create(temporary, "wbx");
    bool good = file && file->stream;
    if (good) {
        good = write_stream(file, layout, source, user);
        if (!good)
            remove(temporary);
    }
    if (good)
        good = os_commit_file(temporary, path, err);
    else if (file && (file->error || file->why[0]))
        fail(err, path, "write", "%s", file->error ? strerror(file->error) : file->why);
    else
        fail(err, path, "write", "out of memory");
    exr_close(file);
    free(temporary);
    return good;
}

/* --- Reading --------------------------------------------------------------------------------------- */

static bool check_part(struct exr_file *file, stokes_error *err)
{
    int parts = 0;
    exr_storage_t storage;
    if (exr_get_count(file->context, &parts) != EXR_ERR_SUCCESS || parts < 1 ||
        exr_get_storage(file->context, PART, &storage) != EXR_ERR_SUCCESS)
        return fail_file(file, "header", err);
    if (storage != EXR_STORAGE_SCANLINE)
        return fail(err, file->path, "header", "is not a scanline picture");
    return true;
}

static bool open_stream(struct exr_file *file, stokes_error *err)
{
    if (!file->stream)
        return fail_file(file, "open", err);
    if (fseeko(file->stream, 0, SEEK_END) != 0 || ftello(file->stream) < 0)
        return fail(err, file->path, "open", "%s", strerror(errno));
    file->bytes = (uint64_t)ftello(file->stream);
    exr_context_initializer_t init = initializer(file);
    init.read_fn = read_bytes;
    init.size_fn = file_bytes;
    init.max_image_width = init.max_image_height = WIDTH_MAX;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION | EXR_CONTEXT_FLAG_STRICT_HEADER;
    if (exr_start_read(&file->context, file->path, &init) != EXR_ERR_SUCCESS)
        return fail_file(file, "header", err);
    return check_part(file, err);
}

struct exr_file *exr_open(const char *path, stokes_error *err)
{
    struct exr_file *file = file_create(path, "rb");
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
        return fail_file(file, "windows", err);
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
        return fail_file(file, "channels", err);
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
        size_t index = channel_index(r->channels, r->count, channel->channel_name, &last);
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
            return fail_file(file, "pixels", err);
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
        return fail_file(file, "pixels", err);
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
