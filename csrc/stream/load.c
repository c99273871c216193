/* Replaying a scene file, and listing one. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include <jansson.h>

#include "base/error.h"
#include "session/session.h"
#include "stream/frame.h"
#include "stream/render_request.h"

static size_t file_source(void *file, void *data, size_t bytes)
{
    return fread(data, 1, bytes, file);
}

/* `render` sets what `stokes render` does by default; `cancel` and `quit` mean nothing in a file. */
static bool replay(stokes_session *session, const struct stream_frame *frame, stokes_error *err)
{
    if (strcmp(frame->name, "cancel") == 0 || strcmp(frame->name, "quit") == 0)
        return true;
    if (strcmp(frame->name, "render") != 0)
        return stokes_session_apply(session, frame->name, frame->mandatory, frame->json, frame->json_bytes,
                                    frame->blobs, frame->blob_bytes, NULL, 0, err);
    struct render_request request;
    if (!render_request_read(frame, &request, err))
        return false;
    session->first_sample = request.first_sample;
    session->end_sample = request.end_sample;
    return true;
}

bool stokes_session_load(stokes_session *session, const char *path, stokes_error *err)
{
    FILE *file = fopen(path, "rbe");
    if (!file)
        return fail(err, path, "open", "%s", strerror(errno));
    enum frame_result result;
    struct stream_frame frame;
    size_t frames = 0;
    bool good = true;
    while (good && (result = frame_read(file_source, file, &frame, err)) != FRAME_END) {
        good = result == FRAME_READ && replay(session, &frame, err);
        if (result == FRAME_READ)
            frame_free(&frame);
        frames++;
    }
    if (good && frames == 0)
        good = fail(err, path, "open", "the file is empty");
    fclose(file);
    return good;
}

/* --- Listing ----------------------------------------------------------------------------------------------- */

static void print_frame(const struct stream_frame *frame)
{
    json_t *json = json_loadb(frame->json, frame->json_bytes, 0, NULL);
    const char *name = json_string_value(json_object_get(json, "name"));
    printf("%-12s %-32s json %zu, blobs %zu bytes\n", frame->name, name ? name : "", frame->json_bytes,
           frame->blob_bytes);
    json_decref(json);
}

static bool list_stream(FILE *file, stokes_error *err)
{
    enum frame_result result;
    struct stream_frame frame;
    while ((result = frame_read(file_source, file, &frame, err)) == FRAME_READ) {
        print_frame(&frame);
        frame_free(&frame);
    }
    return result == FRAME_END;
}

static void print_note(void *user, const char *key, const char *value)
{
    (void)user;
    printf("%s: %s\n", key, value);
}

static bool list_exr(const char *path, stokes_error *err)
{
    char fingerprint[SESSION_FINGERPRINT_BYTES];
    struct film *film = film_read_exr(path, fingerprint, sizeof fingerprint, err);
    if (!film)
        return false;
    printf("film: %d x %d pixels at %d, %d of %d x %d\n", film->width, film->height, film->x0, film->y0,
           film->full_width, film->full_height);
    printf("samples: %d to %d of each pixel\n", film->first_sample, film->end_sample);
    if (film->bins > 0)
        printf("bins: %d from %g to %g nm\n", film->bins, (double)film->bin_range.min,
               (double)film->bin_range.max);
    printf("saturated sums: %" PRIu64 ", rejected contributions: %" PRIu64 "\n", film->saturated,
           film->rejected);
    film_destroy(film);
    return film_read_notes(path, NULL, print_note, NULL, err);
}

bool stokes_info(const char *path, stokes_error *err)
{
    static const unsigned char exr_magic[4] = {0x76, 0x2f, 0x31, 0x01};
    unsigned char magic[4] = {0};
    FILE *file = fopen(path, "rbe");
    if (!file)
        return fail(err, path, "open", "%s", strerror(errno));
    bool good, is_exr = fread(magic, 1, 4, file) == 4 && memcmp(magic, exr_magic, 4) == 0;
    rewind(file);
    if (is_exr)
        good = list_exr(path, err);
    else if (memcmp(magic, FRAME_MAGIC, 4) == 0)
        good = list_stream(file, err);
    else
        good = fail(err, path, "open", "is neither a scene file nor an EXR of ours");
    fclose(file);
    return good;
}
