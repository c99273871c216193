/* Reading and building frames. A head is believed in nothing: lengths have limits, and memory is taken as bytes arrive,
   so that a head alone cannot ask for 64 GiB. */
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "stream/frame.h"

#define FIRST_READ ((size_t)1 << 20)

static uint64_t little_endian(const unsigned char *bytes, int count)
{
    uint64_t value = 0;
    for (int i = count - 1; i >= 0; i--)
        value = value << 8 | bytes[i];
    return value;
}

static void put_little_endian(unsigned char *bytes, int count, uint64_t value)
{
    for (int i = 0; i < count; i++)
        bytes[i] = (unsigned char)(value >> (8 * i));
}

static size_t padding(uint64_t bytes)
{
    return (size_t)(-bytes & (FRAME_ALIGN - 1));
}

static bool check_name(const unsigned char *bytes, char *name, stokes_error *err)
{
    memcpy(name, bytes, FRAME_NAME_BYTES);
    name[FRAME_NAME_BYTES] = '\0';
    size_t used = strlen(name);
    for (size_t i = 0; i < FRAME_NAME_BYTES; i++)
        if (i < used ? bytes[i] < 0x21 || bytes[i] > 0x7e : bytes[i] != 0)
            return fail(err, "stream", "name", "a message's name is not ASCII padded with NUL");
    return used > 0 || fail(err, "stream", "name", "a message has no name");
}

struct head {
    uint64_t json_bytes, blob_bytes;
};

static bool read_head(const unsigned char *bytes, struct stream_frame *frame, struct head *head,
                      stokes_error *err)
{
    if (memcmp(bytes, FRAME_MAGIC, 4) != 0)
        return fail(err, "stream", "magic", "a frame does not begin with " FRAME_MAGIC);
    uint64_t flags = little_endian(bytes + 4, 4);
    if (!check_name(bytes + 8, frame->name, err))
        return false;
    head->json_bytes = little_endian(bytes + 32, 8);
    head->blob_bytes = little_endian(bytes + 40, 8);
    frame->mandatory = flags & 1;
    if (flags & ~(uint64_t)1)
        return fail(err, frame->name, "flags", "unknown flags %#llx",
                    (unsigned long long)(flags & ~(uint64_t)1));
    if (head->json_bytes > FRAME_JSON_MAX)
        return fail(err, frame->name, "json", "%llu bytes; at most 64 MiB are taken",
                    (unsigned long long)head->json_bytes);
    if (head->blob_bytes > FRAME_BLOB_MAX)
        return fail(err, frame->name, "blob", "%llu bytes; at most 64 GiB are taken",
                    (unsigned long long)head->blob_bytes);
    return true;
}

/* Reads `bytes` and their padding. Yours; never NULL on success. */
static unsigned char *read_area(frame_source read, void *user, uint64_t bytes, const char *name,
                                const char *area, stokes_error *err)
{
    uint64_t total = bytes + padding(bytes), have = 0;
    size_t room = total < FIRST_READ ? (size_t)total : FIRST_READ;
    unsigned char *data = malloc(room ? room : 1);
    while (data && have < total) {
        size_t got = read(user, data + have, room - have);
        have += got;
        if (have < room) {
            fail(err, name, area, "the stream ends after %llu of %llu bytes", (unsigned long long)have,
                 (unsigned long long)total);
            free(data);
            return NULL;
        }
        if (have == total)
            break;
        room = room < total / 2 ? room * 2 : (size_t)total;
        unsigned char *more = realloc(data, room);
        if (!more)
            free(data);
        data = more;
    }
    if (!data)
        fail(err, name, area, "no memory for %llu bytes", (unsigned long long)total);
    return data;
}

enum frame_result frame_read(frame_source read, void *user, struct stream_frame *frame, stokes_error *err)
{
    unsigned char bytes[FRAME_HEAD_BYTES];
    struct head head = {0};
    *frame = (struct stream_frame){0};
    size_t got = read(user, bytes, sizeof bytes);
    if (got == 0)
        return FRAME_END;
    if (got < sizeof bytes) {
        fail(err, "stream", "head", "the stream ends after %zu of %d bytes of a frame's head", got,
             FRAME_HEAD_BYTES);
        return FRAME_BROKEN;
    }
    if (!read_head(bytes, frame, &head, err))
        return FRAME_BROKEN;
    frame->json = (char *)read_area(read, user, head.json_bytes, frame->name, "json", err);
    if (frame->json)
        frame->blobs = read_area(read, user, head.blob_bytes, frame->name, "blob", err);
    if (!frame->blobs) {
        frame_free(frame);
        return FRAME_BROKEN;
    }
    frame->json_bytes = (size_t)head.json_bytes;
    frame->blob_bytes = (size_t)head.blob_bytes;
    return FRAME_READ;
}

void frame_free(struct stream_frame *frame)
{
    free(frame->json);
    free(frame->blobs);
    *frame = (struct stream_frame){0};
}

unsigned char *frame_build(const char *name, bool mandatory, const char *json, size_t json_bytes,
                           size_t *bytes)
{
    *bytes = FRAME_HEAD_BYTES + json_bytes + padding(json_bytes);
    unsigned char *frame = calloc(1, *bytes);
    if (!frame)
        return NULL;
    memcpy(frame, FRAME_MAGIC, 4);
    put_little_endian(frame + 4, 4, mandatory);
    memcpy(frame + 8, name, strnlen(name, FRAME_NAME_BYTES));
    put_little_endian(frame + 32, 8, json_bytes);
    memcpy(frame + FRAME_HEAD_BYTES, json, json_bytes);
    return frame;
}

size_t frame_memory_source(void *user, void *data, size_t bytes)
{
    struct frame_memory *memory = user;
    size_t count = bytes < memory->left ? bytes : memory->left;
    if (count > 0)
        memcpy(data, memory->data, count);
    memory->data += count;
    memory->left -= count;
    return count;
}
