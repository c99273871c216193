/* Sessions that are spoken to, and expressions read from JSON, for the tests of csrc/stream.
   All of these fail the test where something goes wrong that is not expected. */
#ifndef STREAM_KIT_H
#define STREAM_KIT_H

#include "stream/expressions.h"

stokes_session *stream_greeted(void); /* that has had its `hello` */
bool stream_send(stokes_session *, const char *name, const char *json, stokes_error *);
bool stream_send_with(stokes_session *, const char *name, const char *json, const void *blobs, size_t bytes,
                      stokes_error *);
/* A square of two triangles; `last_index` of a vertex that is not there is to be refused. */
void stream_send_mesh(stokes_session *, uint32_t last_index, bool expected);

/* An expression read from JSON in a message named "test" of the object "thing". */
struct reading {
    stokes_session *session;
    struct message message;
    json_t *json;
    stokes_error err;
};

struct place reading_start(struct reading *, const char *json);
void reading_end(struct reading *);

#endif
