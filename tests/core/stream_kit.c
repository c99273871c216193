/* Aids of the stream's tests; the contracts stand in stream_kit.h. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "stream_kit.h"

bool stream_send_with(stokes_session *session, const char *name, const char *json, const void *blobs,
                      size_t bytes, stokes_error *err)
{
    return stokes_session_apply(session, name, true, json, strlen(json), blobs, bytes, NULL, 0, err);
}

bool stream_send(stokes_session *session, const char *name, const char *json, stokes_error *err)
{
    return stream_send_with(session, name, json, NULL, 0, err);
}

stokes_session *stream_greeted(void)
{
    stokes_error err;
    stokes_session *session = stokes_session_create(NULL);
    assert_non_null(session);
    assert_true(stream_send(session, "hello", "{\"version\": 1}", &err));
    return session;
}

struct place reading_start(struct reading *reading, const char *json)
{
    reading->session = stream_greeted();
    reading->message = (struct message){
        .session = reading->session, .name = "test", .object = "thing", .err = &reading->err};
    reading->json = json_loads(json, JSON_DECODE_ANY, NULL);
    assert_non_null(reading->json);
    return place_root(&reading->message, reading->json);
}

void reading_end(struct reading *reading)
{
    message_free(&reading->message);
    json_decref(reading->json);
    stokes_session_destroy(reading->session);
}

static const float square[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
#define MESH_JSON                                                                                            \
    "{\"name\": \"Cube\", \"positions\": {\"at\": 0, \"bytes\": 48}, \"triangles\": {\"at\": 48, "           \
    "\"bytes\": 24}}"

void stream_send_mesh(stokes_session *session, uint32_t last_index, bool expected)
{
    unsigned char blobs[72];
    const uint32_t triangles[6] = {0, 1, 2, 0, 2, last_index};
    stokes_error err = {0};
    memcpy(blobs, square, 48);
    memcpy(blobs + 48, triangles, 24);
    assert_int_equal(stream_send_with(session, "mesh", MESH_JSON, blobs, sizeof blobs, &err), expected);
    if (!expected) {
        assert_string_equal(err.object, "Cube");
        assert_memory_equal(err.property, "mesh.", 5);
    }
}
