/* libFuzzer's mutations of a stream: a frame's JSON or blobs, with the lengths put right, as random bytes seldom get past a
   head. */
#include <stdlib.h>
#include <string.h>

#include "stream/frame.h"

#define FRAMES_MAX 64

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed);

static size_t padded(size_t bytes)
{
    return (bytes + FRAME_ALIGN - 1) / FRAME_ALIGN * FRAME_ALIGN;
}

static size_t emit(uint8_t *out, size_t room, const struct stream_frame *frame)
{
    size_t total = FRAME_HEAD_BYTES + padded(frame->json_bytes) + padded(frame->blob_bytes);
    if (total > room)
        return 0;
    memset(out, 0, total);
    memcpy(out, FRAME_MAGIC, 4);
    out[4] = frame->mandatory;
    memcpy(out + 8, frame->name, strlen(frame->name));
    for (int i = 0; i < 8; i++) {
        out[32 + i] = (uint8_t)((uint64_t)frame->json_bytes >> (8 * i));
        out[40 + i] = (uint8_t)((uint64_t)frame->blob_bytes >> (8 * i));
    }
    memcpy(out + FRAME_HEAD_BYTES, frame->json, frame->json_bytes);
    memcpy(out + FRAME_HEAD_BYTES + padded(frame->json_bytes), frame->blobs, frame->blob_bytes);
    return total;
}

/* One of a frame's two areas, mutated; it may grow to twice its size. */
static bool mutate_area(void **area, size_t *bytes)
{
    size_t room = 2 * *bytes + 64;
    void *grown = realloc(*area, room);
    if (!grown)
        return false;
    *area = grown;
    *bytes = LLVMFuzzerMutate(grown, *bytes, room);
    return true;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed)
{
    struct frame_memory memory = {data, size};
    struct stream_frame frames[FRAMES_MAX];
    size_t count = 0, used = 0;
    while (count < FRAMES_MAX && frame_read(frame_memory_source, &memory, &frames[count], NULL) == FRAME_READ)
        count++;
    if (count > 0 && seed % 8 != 0) {
        struct stream_frame *chosen = &frames[(seed >> 4) % count];
        void *area = seed >> 3 & 1 && chosen->blob_bytes ? (void *)chosen->blobs : (void *)chosen->json;
        bool blobs = area == chosen->blobs;
        if (mutate_area(&area, blobs ? &chosen->blob_bytes : &chosen->json_bytes)) {
            if (blobs)
                chosen->blobs = area;
            else
                chosen->json = area;
            for (size_t i = 0; i < count; i++)
                used += emit(data + used, max_size - used, &frames[i]);
        }
    }
    for (size_t i = 0; i < count; i++)
        frame_free(&frames[i]);
    return used ? used : LLVMFuzzerMutate(data, size, max_size);
}
