/* One frame applied to a session: the table of messages, and what holds for all of them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "stream/frame.h"
#include "stream/messages.h"

#define STREAM_VERSION 1
#define NAME_BYTES_MAX 1024

static bool apply_hello(const struct place *root)
{
    struct place version = place_member(root, "version");
    double number;
    if (!read_whole(&version, 0, 1e9, &number))
        return false;
    if (number != STREAM_VERSION)
        return place_fail(&version, "%.0f is not %d, which this core speaks", number, STREAM_VERSION);
    root->message->session->greeted = true;
    return true;
}

static bool apply_remove(const struct place *root)
{
    struct place kind = place_member(root, "kind");
    struct message *message = root->message;
    const char *text;
    if (!read_text(&kind, &text) ||
        !scene_remove(message->session->scene, text, message->object, message->err))
        return false;
    tally_set(message->session->outside, text, message->object, 0);
    return true;
}

static const struct message_kind kinds[] = {
    {.name = "hello", .apply = apply_hello},
    {.name = "settings", .apply = apply_settings},
    {.name = "color", .apply = apply_color},
    {.name = "image", .is_named = true, .is_scene = true, .uses_colors = true, .apply = apply_image},
    {.name = "mesh", .is_named = true, .is_scene = true, .apply = apply_mesh},
    {.name = "material", .is_named = true, .is_scene = true, .uses_colors = true, .apply = apply_material},
    {.name = "instances", .is_named = true, .is_scene = true, .apply = apply_instances},
    {.name = "light", .is_named = true, .is_scene = true, .uses_colors = true, .apply = apply_light},
    {.name = "world", .is_scene = true, .uses_colors = true, .apply = apply_world},
    {.name = "camera", .is_scene = true, .apply = apply_camera},
    {.name = "remove", .is_named = true, .is_scene = true, .apply = apply_remove},
};

const struct message_kind *message_kind_find(const char *name)
{
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strcmp(kinds[i].name, name) == 0)
            return &kinds[i];
    return NULL;
}

/* Rooms name object and property; the message is put before the property here, once for all. */
static void name_message(stokes_error *err, const char *name)
{
    char property[FRAME_NAME_BYTES + sizeof err->property + 2];
    if (!err || strcmp(err->object, name) == 0)
        return;
    snprintf(property, sizeof property, "%s%s%s", name, *err->property ? "." : "", err->property);
    fail(err, err->object, property, "%s", err->text);
}

static bool read_name(const struct place *root, struct message *message)
{
    struct place place = place_member(root, "name");
    const char *name;
    if (!read_text(&place, &name))
        return false;
    if (!*name || strlen(name) > NAME_BYTES_MAX)
        return place_fail(&place, "has %zu bytes; 1 to %d are taken", strlen(name), NAME_BYTES_MAX);
    message->object = name;
    return true;
}

/* What the fingerprint sees: names, members in one order, and contents of blobs wherever they lay. */
static void count_for_fingerprint(const struct message *message, json_t *root)
{
    char *text = json_dumps(root, JSON_COMPACT | JSON_SORT_KEYS);
    uint64_t *hash = &message->session->scene_hash;
    *hash = session_hash(*hash, message->name, strlen(message->name));
    *hash = session_hash(*hash, &message->blob_hash, sizeof message->blob_hash);
    if (text)
        *hash = session_hash(*hash, text, strlen(text));
    free(text);
}

static bool apply_kind(const struct message_kind *kind, struct message *message, json_t *json)
{
    stokes_session *session = message->session;
    struct place root = place_root(message, json);
    if (!json_is_object(json))
        return fail(message->err, message->name, "json", "is no object");
    if (kind->is_named && !read_name(&root, message))
        return false;
    if (!session->greeted && kind->apply != apply_hello)
        return fail(message->err, message->name, "", "comes before `hello`");
    if (!kind->apply(&root))
        return false;
    session->uses_colors |= kind->uses_colors;
    if (kind->uses_colors)
        tally_set(session->outside, kind->name, message->object ? message->object : "",
                  message->colors_outside);
    if (kind->is_scene)
        count_for_fingerprint(message, json);
    return true;
}

bool stokes_session_apply(stokes_session *session, const char *name, bool mandatory, const char *json,
                          size_t json_bytes, const void *blobs, size_t blob_bytes, const void *shared,
                          size_t shared_bytes, stokes_error *err)
{
    const struct message_kind *kind = message_kind_find(name);
    struct message message = {.session = session,
                              .name = name,
                              .blobs = blobs,
                              .blob_bytes = blob_bytes,
                              .shared = shared,
                              .shared_bytes = shared_bytes,
                              .err = err};
    json_error_t why;
    if (!kind)
        return !mandatory || fail(err, name, "", "is an unknown message, and mandatory");
    json_t *root = json_loadb(json, json_bytes, JSON_REJECT_DUPLICATES, &why);
    if (!root)
        return fail(err, name, "json", "line %d, column %d: %s", why.line, why.column, why.text);
    bool good = apply_kind(kind, &message, root);
    if (!good)
        name_message(err, name);
    message_free(&message);
    json_decref(root);
    return good;
}
