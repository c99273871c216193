/* Frames of the stream: head, JSON, blob area (STREAM.md, "Frames"). Read from anything that gives bytes. */
#ifndef STREAM_FRAME_H
#define STREAM_FRAME_H

#include "stokes.h"

#define FRAME_MAGIC "STKS"
#define FRAME_HEAD_BYTES 48
#define FRAME_NAME_BYTES 24
#define FRAME_ALIGN 16
#define FRAME_JSON_MAX ((uint64_t)64 << 20)
#define FRAME_BLOB_MAX ((uint64_t)64 << 30)

/* Fills `data` with as many bytes as there are, at most `bytes`; less only at the end. */
typedef size_t (*frame_source)(void *user, void *data, size_t bytes);

struct stream_frame {
    char name[FRAME_NAME_BYTES + 1];
    bool mandatory;
    char *json;
    size_t json_bytes;
    unsigned char *blobs; /* aligned to 16 */
    size_t blob_bytes;
};

enum frame_result { FRAME_READ, FRAME_END, FRAME_BROKEN };

/* The next frame, yours (frame_free). END: the source ended between two frames. BROKEN: *err says how. What a head claims
   is allocated only as the bytes arrive. On END and BROKEN there is nothing to free. */
enum frame_result frame_read(frame_source, void *user, struct stream_frame *, stokes_error *err);
void frame_free(struct stream_frame *);

/* A whole frame without blobs, padded. Yours: free. NULL without memory. */
unsigned char *frame_build(const char *name, bool mandatory, const char *json, size_t json_bytes,
                           size_t *bytes);

/* Bytes in memory as a source. */
struct frame_memory {
    const unsigned char *data;
    size_t left;
};
size_t frame_memory_source(void *memory, void *data, size_t bytes);

#endif
