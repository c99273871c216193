/* Members of a message: typed, bounded access to its JSON and blobs. A fault fills the message's error with the message,
   the object and the member's path. */
#ifndef STREAM_MEMBERS_H
#define STREAM_MEMBERS_H

#include <jansson.h>

#include "session/session.h"

/* One frame while it is applied. */
struct message {
    stokes_session *session;
    const char *name;   /* of the message */
    const char *object; /* the `name` member, or NULL */
    const unsigned char *blobs, *shared;
    size_t blob_bytes, shared_bytes;
    stokes_error *err;
    void **copies; /* of shared bytes, freed with the message */
    size_t copy_count;
    size_t colors_outside; /* colours of this message that no reflectance reaches */
    uint64_t blob_hash;
};
void message_free(struct message *);

/* A value and the way to it, for errors: a chain on the stack. */
struct place {
    struct message *message;
    const struct place *up; /* NULL: the message's object */
    const char *key;        /* NULL: element `index` of an array */
    size_t index;
    json_t *value; /* NULL: absent */
};
struct place place_root(struct message *, json_t *root);
struct place place_member(const struct place *, const char *key);
struct place place_element(const struct place *, size_t index);
bool place_fail(const struct place *, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Fails unless the value is there and of the type. */
bool place_is(const struct place *, json_type);
/* True if the object has this member. */
bool place_has(const struct place *, const char *key);

/* The value itself. Numbers must be finite and within [low, high]; whole ones must be whole. Text is borrowed. */
bool read_number(const struct place *, double low, double high, double *);
bool read_whole(const struct place *, double low, double high, double *);
bool read_flag(const struct place *, bool *);
bool read_text(const struct place *, const char **);
/* The index of the text in a list that NULL ends. */
bool read_choice(const struct place *, const char *const *choices, int *);
/* An array of exactly `count` numbers. */
bool read_floats(const struct place *, float *, size_t count);

/* Bytes of a blob, borrowed for the message's life, aligned to 16; `size` divides their number, and *count = bytes/size. */
bool read_blob(const struct place *, size_t size, const void **data, size_t *count);

/* A struct filled from a table: one line a member. */
enum field_type { FIELD_FLOAT, FIELD_DOUBLE, FIELD_INT, FIELD_U32, FIELD_BOOL };
struct field {
    const char *name;
    enum field_type type;
    bool required;
    size_t offset;
    size_t count; /* 0 or 1: one; more: an array of exactly so many */
    double low, high;
};
/* Absent members that are not required leave the struct as it is. */
bool read_fields(const struct place *object, const struct field *, size_t count, void *out);

#endif
