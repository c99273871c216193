/* `stokes serve`: the stream on two file descriptors. The parent's frames are applied in order; each is answered by one
   `done` or `error`, and a render tells of itself in between. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "base/error.h"
#include "base/os.h"
#include "session/session.h"
#include "stream/inbox.h"
#include "stream/render_request.h"

struct server {
    struct inbox *inbox;
    stokes_session *session;
    struct os_memory memory, film;
    int out_fd, memory_fd, film_fd;
    uint64_t rendering; /* number of the `render` frame under way */
    bool deaf;          /* the parent reads no more */
};

/* --- Replies ----------------------------------------------------------------------------------------------- */

/* Takes `members`. */
static void reply(struct server *server, const char *name, json_t *members)
{
    char *json = members ? json_dumps(members, JSON_COMPACT) : NULL;
    size_t bytes = 0;
    unsigned char *frame = json ? frame_build(name, false, json, strlen(json), &bytes) : NULL;
    if (!frame || !os_write_all(server->out_fd, frame, bytes))
        server->deaf = true;
    free(frame);
    free(json);
    json_decref(members);
}

static void reply_error(struct server *server, const stokes_error *err, const uint64_t *of)
{
    json_t *members =
        json_pack("{s:s, s:s, s:s}", "object", err->object, "property", err->property, "text", err->text);
    if (members && of)
        json_object_set_new(members, "of", json_integer((json_int_t)*of));
    reply(server, "error", members);
}

static void reply_done(struct server *server, uint64_t number)
{
    reply(server, "done", json_pack("{s:I}", "of", (json_int_t)number));
}

static void on_warning(void *user, const stokes_error *what)
{
    reply(
        user, "warning",
        json_pack("{s:s, s:s, s:s}", "object", what->object, "property", what->property, "text", what->text));
}

static void on_progress(void *user, int sample, int samples, double seconds, double remaining)
{
    char text[64];
    snprintf(text, sizeof text, "Sample %d/%d", sample, samples);
    reply(user, "progress",
          json_pack("{s:i, s:i, s:f, s:f, s:s}", "sample", sample, "samples", samples, "seconds", seconds,
                    "remaining", remaining, "text", text));
}

static void on_tile(void *user, const int rect[4], int samples)
{
    reply(user, "tile",
          json_pack("{s:[i,i,i,i], s:i}", "rect", rect[0], rect[1], rect[2], rect[3], "samples", samples));
}

static bool on_cancelled(void *user)
{
    struct server *server = user;
    return inbox_stops(server->inbox, server->rendering);
}

/* --- Rendering --------------------------------------------------------------------------------------------- */

static json_t *report_lines(const stokes_session *session)
{
    json_t *lines = json_array();
    const char *text = stokes_session_report(session);
    while (*text) {
        size_t length = strcspn(text, "\n");
        json_array_append_new(lines, json_stringn(text, length));
        text += length + (text[length] == '\n');
    }
    return lines;
}

static bool find_picture(struct server *server, const struct render_request *request, float **picture,
                         size_t *floats, stokes_error *err)
{
    *picture = NULL;
    *floats = 0;
    if (!request->has_film)
        return true;
    if (server->film_fd < 0 || request->film_fd != server->film_fd)
        return fail(err, "render", "film.shared_fd", "descriptor %d was not handed down by --film",
                    request->film_fd);
    if (!os_memory_map(&server->film, server->film_fd, true, err))
        return false;
    if (request->film_bytes > server->film.bytes)
        return fail(err, "render", "film.bytes", "%llu are more than the memory's %zu",
                    (unsigned long long)request->film_bytes, server->film.bytes);
    *picture = (float *)server->film.data;
    *floats = (size_t)request->film_bytes / sizeof(float);
    return true;
}

static bool render(struct server *server, const struct stream_frame *frame, uint64_t number,
                   stokes_error *err)
{
    struct render_request request;
    float *picture;
    size_t floats;
    if (!render_request_read(frame, &request, err) || !find_picture(server, &request, &picture, &floats, err))
        return false;
    stokes_overrides overrides = stokes_overrides_default();
    overrides.first_sample = request.first_sample;
    overrides.end_sample = request.end_sample;
    server->rendering = number;
    if (!stokes_session_render(server->session, &overrides, picture, floats, err))
        return false;
    reply(server, "finished",
          json_pack("{s:i, s:b, s:o}", "samples", stokes_session_samples(server->session), "cancelled",
                    server->session->cancelled, "report", report_lines(server->session)));
    return true;
}

/* --- The loop ---------------------------------------------------------------------------------------------- */

static bool handle(struct server *server, const struct stream_frame *frame, uint64_t number,
                   stokes_error *err)
{
    if (strcmp(frame->name, "cancel") == 0 || strcmp(frame->name, "quit") == 0)
        return true;
    if (strcmp(frame->name, "render") == 0)
        return render(server, frame, number, err);
    if (server->memory_fd >= 0 && !os_memory_map(&server->memory, server->memory_fd, false, err))
        return false;
    return stokes_session_apply(server->session, frame->name, frame->mandatory, frame->json,
                                frame->json_bytes, frame->blobs, frame->blob_bytes, server->memory.data,
                                server->memory.bytes, err);
}

/* Returns the exit status. */
static int serve(struct server *server)
{
    struct stream_frame frame;
    uint64_t number = 0;
    stokes_error err = {0};
    enum frame_result result = FRAME_END;
    while (!server->deaf && (result = inbox_take(server->inbox, &frame, &number, &err)) == FRAME_READ) {
        bool quits = strcmp(frame.name, "quit") == 0;
        if (handle(server, &frame, number, &err))
            reply_done(server, number);
        else
            reply_error(server, &err, &number);
        frame_free(&frame);
        if (quits)
            return 0;
    }
    if (result == FRAME_BROKEN)
        reply_error(server, &err, NULL);
    return result == FRAME_BROKEN || server->deaf;
}

int stokes_serve(int in_fd, int out_fd, int memory_fd, int film_fd)
{
    struct server server = {.out_fd = out_fd,
                            .memory_fd = memory_fd,
                            .film_fd = film_fd,
                            .memory = {.fd = -1},
                            .film = {.fd = -1}};
    const stokes_listener listener = {.user = &server,
                                      .warning = on_warning,
                                      .progress = on_progress,
                                      .tile = on_tile,
                                      .cancelled = on_cancelled};
    int status = 1;
    signal(SIGPIPE, SIG_IGN); /* a parent that reads no more is seen by write */
    server.session = stokes_session_create(&listener);
    server.inbox = server.session ? inbox_open(in_fd) : NULL;
    if (server.inbox)
        status = serve(&server);
    inbox_close(server.inbox);
    stokes_session_destroy(server.session);
    os_memory_unmap(&server.memory);
    os_memory_unmap(&server.film);
    return status;
}
