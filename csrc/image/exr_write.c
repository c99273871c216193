/* Writes scanline OpenEXR files chunk by chunk, so that memory stays a few rows however large the picture is. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/os.h"
#include "image/exr_file.h"

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
            w->source_channel[c] = exr_channel_index(w->layout->channels, w->layout->channel_count,
                                                     channel->channel_name, &last);
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
    exr_context_initializer_t init = exr_file_initializer(file);
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
    struct exr_file *file = exr_file_create(temporary, "wbx");
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
