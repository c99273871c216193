/* Typed, bounded access to a message's members. */
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "stream/members.h"

#define BLOB_ALIGN 16

void message_free(struct message *message)
{
    for (size_t i = 0; i < message->copy_count; i++)
        free(message->copies[i]);
    free(message->copies);
    message->copies = NULL;
    message->copy_count = 0;
}

/* --- Places ------------------------------------------------------------------------------------------------ */

struct place place_root(struct message *message, json_t *root)
{
    return (struct place){.message = message, .value = root};
}

struct place place_member(const struct place *place, const char *key)
{
    return (struct place){place->message, place, key, 0, json_object_get(place->value, key)};
}

struct place place_element(const struct place *place, size_t index)
{
    return (struct place){place->message, place, NULL, index, json_array_get(place->value, index)};
}

/* Writes "surface.mix[1].factor" and returns its length; what does not fit is left off at the end. */
static size_t write_path(const struct place *place, char *text, size_t room)
{
    if (!place->up)
        return 0;
    size_t used = write_path(place->up, text, room);
    if (used >= room)
        return used;
    int more = place->key ? snprintf(text + used, room - used, "%s%s", used ? "." : "", place->key)
                          : snprintf(text + used, room - used, "[%zu]", place->index);
    return used + (size_t)more;
}

bool place_fail(const struct place *place, const char *format, ...)
{
    const struct message *message = place->message;
    char path[128] = "", text[320];
    write_path(place, path, sizeof path);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return fail(message->err, message->object ? message->object : message->name, path, "%s", text);
}

static const char *type_name(json_type type)
{
    switch (type) {
    case JSON_OBJECT: return "an object";
    case JSON_ARRAY: return "an array";
    case JSON_STRING: return "text";
    case JSON_INTEGER:
    case JSON_REAL: return "a number";
    case JSON_TRUE:
    case JSON_FALSE: return "true or false";
    case JSON_NULL: return "null";
    }
    return "unknown";
}

static bool wrong_type(const struct place *place, json_type wanted)
{
    if (!place->value)
        return place_fail(place, "is missing");
    return place_fail(place, "is %s; %s is wanted", type_name(json_typeof(place->value)), type_name(wanted));
}

bool place_is(const struct place *place, json_type type)
{
    return (place->value && json_typeof(place->value) == type) || wrong_type(place, type);
}

bool place_has(const struct place *place, const char *key)
{
    return json_object_get(place->value, key) != NULL;
}

/* --- Values ------------------------------------------------------------------------------------------------ */

bool read_number(const struct place *place, double low, double high, double *value)
{
    if (!place->value || !json_is_number(place->value))
        return wrong_type(place, JSON_REAL);
    double number = json_number_value(place->value);
    if (!(number >= low && number <= high))
        return place_fail(place, "%g is not within %g and %g", number, low, high);
    *value = number;
    return true;
}

bool read_whole(const struct place *place, double low, double high, double *value)
{
    double number = 0;
    if (!read_number(place, low, high, &number))
        return false;
    if (number != floor(number))
        return place_fail(place, "%g is not a whole number", number);
    *value = number;
    return true;
}

bool read_flag(const struct place *place, bool *value)
{
    if (!place->value || !json_is_boolean(place->value))
        return wrong_type(place, JSON_TRUE);
    *value = json_is_true(place->value);
    return true;
}

bool read_text(const struct place *place, const char **value)
{
    if (!place_is(place, JSON_STRING))
        return false;
    *value = json_string_value(place->value);
    return true;
}

bool read_choice(const struct place *place, const char *const *choices, int *value)
{
    const char *text;
    if (!read_text(place, &text))
        return false;
    for (int i = 0; choices[i]; i++)
        if (strcmp(choices[i], text) == 0) {
            *value = i;
            return true;
        }
    return place_fail(place, "'%.100s' is unknown", text);
}

bool read_floats(const struct place *place, float *values, size_t count)
{
    if (!place_is(place, JSON_ARRAY))
        return false;
    if (json_array_size(place->value) != count)
        return place_fail(place, "has %zu numbers; %zu are wanted", json_array_size(place->value), count);
    for (size_t i = 0; i < count; i++) {
        struct place element = place_element(place, i);
        double value;
        if (!read_number(&element, -FLT_MAX, FLT_MAX, &value))
            return false;
        values[i] = (float)value;
    }
    return true;
}

/* --- Blobs ------------------------------------------------------------------------------------------------- */

/* A private copy: what is validated must be what is used, and the parent may write on. */
static bool keep_copy(const struct place *place, const void *source, size_t bytes, const void **data)
{
    struct message *message = place->message;
    void **copies = realloc(message->copies, (message->copy_count + 1) * sizeof *copies);
    if (!copies)
        return place_fail(place, "out of memory");
    message->copies = copies;
    void *copy = aligned_alloc(BLOB_ALIGN, (bytes + BLOB_ALIGN) / BLOB_ALIGN * BLOB_ALIGN);
    if (!copy)
        return place_fail(place, "no memory for %zu bytes", bytes);
    if (bytes > 0)
        memcpy(copy, source, bytes);
    copies[message->copy_count++] = copy;
    *data = copy;
    return true;
}

bool read_blob(const struct place *place, size_t size, const void **data, size_t *count)
{
    if (!place_is(place, JSON_OBJECT))
        return false;
    struct message *message = place->message;
    bool shared = place_has(place, "shared");
    struct place at_place = place_member(place, shared ? "shared" : "at"),
                 bytes_place = place_member(place, "bytes");
    double at, bytes, area = (double)(shared ? message->shared_bytes : message->blob_bytes);
    if (!read_whole(&at_place, 0, 0x1p53, &at) || !read_whole(&bytes_place, 0, 0x1p53, &bytes))
        return false;
    if (fmod(at, BLOB_ALIGN) != 0)
        return place_fail(&at_place, "%.0f is not a multiple of %d", at, BLOB_ALIGN);
    if (at + bytes > area)
        return place_fail(place, "bytes %.0f to %.0f lie beyond the %.0f of the %s", at, at + bytes, area,
                          shared ? "shared memory" : "frame's blob area");
    if (fmod(bytes, (double)size) != 0)
        return place_fail(&bytes_place, "%.0f is not a multiple of %zu", bytes, size);
    const unsigned char *base = shared ? message->shared : message->blobs;
    const unsigned char *source = base ? base + (size_t)at : (const unsigned char *)"";
    *count = (size_t)bytes / size;
    *data = source;
    if ((shared || (uintptr_t)source % BLOB_ALIGN) && !keep_copy(place, source, (size_t)bytes, data))
        return false;
    /* A recording holds at another place what was shared: contents alone count for the fingerprint. */
    message->blob_hash = session_hash(message->blob_hash, *data, (size_t)bytes);
    json_object_del(place->value, "at");
    json_object_del(place->value, "shared");
    return true;
}

/* --- Tables of fields -------------------------------------------------------------------------------------- */

static bool read_field_value(const struct place *place, const struct field *field, size_t index, void *out)
{
    double number = 0;
    bool whole = field->type == FIELD_INT || field->type == FIELD_U32;
    if (field->type == FIELD_BOOL)
        return read_flag(place, (bool *)out + index);
    if (!(whole ? read_whole : read_number)(place, field->low, field->high, &number))
        return false;
    switch (field->type) {
    case FIELD_FLOAT: ((float *)out)[index] = (float)number; break;
    case FIELD_DOUBLE: ((double *)out)[index] = number; break;
    case FIELD_INT: ((int *)out)[index] = (int)number; break;
    case FIELD_U32: ((uint32_t *)out)[index] = (uint32_t)number; break;
    case FIELD_BOOL: break;
    }
    return true;
}

static bool read_field(const struct place *place, const struct field *field, void *out)
{
    if (field->count <= 1)
        return read_field_value(place, field, 0, out);
    if (!place_is(place, JSON_ARRAY))
        return false;
    if (json_array_size(place->value) != field->count)
        return place_fail(place, "has %zu numbers; %zu are wanted", json_array_size(place->value),
                          field->count);
    for (size_t i = 0; i < field->count; i++) {
        struct place element = place_element(place, i);
        if (!read_field_value(&element, field, i, out))
            return false;
    }
    return true;
}

bool read_fields(const struct place *object, const struct field *fields, size_t count, void *out)
{
    for (size_t i = 0; i < count; i++) {
        struct place place = place_member(object, fields[i].name);
        if (!place.value && !fields[i].required)
            continue;
        if (!read_field(&place, &fields[i], (char *)out + fields[i].offset))
            return false;
    }
    return true;
}
