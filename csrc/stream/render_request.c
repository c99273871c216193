/* Reading a `render` message. */
#include <limits.h>

#include "base/error.h"
#include "stream/members.h"
#include "stream/render_request.h"

#define SAMPLES_MAX (1 << 30)

static bool read_samples(const struct place *root, struct render_request *request)
{
    static const struct field field = {"samples", FIELD_INT, true, 0, 2, 0, SAMPLES_MAX};
    struct place place = place_member(root, "samples");
    int samples[2];
    if (!read_fields(root, &field, 1, samples))
        return false;
    request->first_sample = samples[0];
    request->end_sample = samples[1];
    return samples[0] < samples[1] || place_fail(&place, "[%d, %d) is empty", samples[0], samples[1]);
}

static bool read_film(const struct place *root, struct render_request *request)
{
    struct place film = place_member(root, "film");
    struct place fd_place = place_member(&film, "shared_fd"), bytes_place = place_member(&film, "bytes");
    double fd = -1, bytes = 0;
    if (!film.value || json_is_null(film.value))
        return true;
    if (!place_is(&film, JSON_OBJECT) || !read_whole(&fd_place, 0, INT_MAX, &fd) ||
        !read_whole(&bytes_place, 0, 0x1p53, &bytes))
        return false;
    request->has_film = true;
    request->film_fd = (int)fd;
    request->film_bytes = (uint64_t)bytes;
    return true;
}

bool render_request_read(const struct stream_frame *frame, struct render_request *request, stokes_error *err)
{
    struct message message = {.name = frame->name, .err = err};
    json_error_t why;
    json_t *json = json_loadb(frame->json, frame->json_bytes, JSON_REJECT_DUPLICATES, &why);
    *request = (struct render_request){.film_fd = -1};
    if (!json)
        return fail(err, frame->name, "json", "line %d, column %d: %s", why.line, why.column, why.text);
    struct place root = place_root(&message, json);
    bool good = place_is(&root, JSON_OBJECT) && read_samples(&root, request) && read_film(&root, request);
    json_decref(json);
    return good;
}
