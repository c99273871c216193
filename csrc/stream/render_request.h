/* The `render` message: it belongs to who drives the session, so it is read apart from the others. */
#ifndef STREAM_RENDER_REQUEST_H
#define STREAM_RENDER_REQUEST_H

#include "stream/frame.h"

struct render_request {
    int first_sample, end_sample;
    bool has_film;
    int film_fd;
    uint64_t film_bytes;
};

bool render_request_read(const struct stream_frame *, struct render_request *, stokes_error *err);

#endif
