/* libFuzzer target: any bytes as a stream, applied to a session; no trees are built and nothing is rendered. */
#include <string.h>

#include "stream/frame.h"
#include "stream/render_request.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct frame_memory memory = {data, size};
    struct stream_frame frame;
    stokes_session *session = stokes_session_create(NULL);
    stokes_error err;
    /* The input serves as shared memory, too. */
    while (session && frame_read(frame_memory_source, &memory, &frame, &err) == FRAME_READ) {
        struct render_request request;
        if (strcmp(frame.name, "render") == 0)
            render_request_read(&frame, &request, &err);
        else
            stokes_session_apply(session, frame.name, frame.mandatory, frame.json, frame.json_bytes,
                                 frame.blobs, frame.blob_bytes, data, size, &err);
        frame_free(&frame);
    }
    stokes_session_destroy(session);
    return 0;
}
