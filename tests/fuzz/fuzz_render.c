/* libFuzzer target: any stream, with a small camera and short paths put at its end, rendered for one sample by a pixel: what
   the parser lets through must neither crash the scene nor the integrators. */
#include <string.h>

#include "stream/frame.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void send(stokes_session *session, const char *name, const char *json)
{
    stokes_error err;
    stokes_session_apply(session, name, true, json, strlen(json), NULL, 0, NULL, 0, &err);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct frame_memory memory = {data, size};
    struct stream_frame frame;
    stokes_session *session = stokes_session_create(NULL);
    stokes_overrides overrides = stokes_overrides_default();
    stokes_error err;
    while (session && frame_read(frame_memory_source, &memory, &frame, &err) == FRAME_READ) {
        /* Textures need a table of colours that takes a second to build: a thousand runs instead of a hundred thousand. */
        if (strcmp(frame.name, "camera") != 0 && strcmp(frame.name, "image") != 0)
            stokes_session_apply(session, frame.name, false, frame.json, frame.json_bytes, frame.blobs,
                                 frame.blob_bytes, data, size, &err);
        frame_free(&frame);
    }
    if (!session)
        return 0;
    send(session, "camera",
         "{\"kind\": \"perspective\", \"transform\": [1,0,0,0, 0,1,0,0, 0,0,1,4],"
         "\"frame\": [-0.3, 0.3, -0.3, 0.3], \"resolution\": [6, 6], \"clip\": [0.1, 100]}");
    overrides.integrator = size / FRAME_ALIGN % 2 ? "mbdpt" : "pt_nee";
    overrides.threads = 1;
    overrides.max_path = 4;
    overrides.spectral_bins = 0;
    overrides.time_limit_s = 1;
    overrides.first_sample = 0;
    overrides.end_sample = 1;
    stokes_session_render(session, &overrides, NULL, 0, &err);
    stokes_session_destroy(session);
    return 0;
}
