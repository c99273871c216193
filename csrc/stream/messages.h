/* The messages that change a session: one function each, found by name. */
#ifndef STREAM_MESSAGES_H
#define STREAM_MESSAGES_H

#include "stream/members.h"

struct message_kind {
    const char *name;
    bool is_named;    /* has a required `name` member */
    bool is_scene;    /* counts for the scene's fingerprint */
    bool uses_colors; /* what it makes depends on working space, Λ or uv_rule */
    /* Reads all of the message, then changes the session: false changes nothing. */
    bool (*apply)(const struct place *root);
};
const struct message_kind *message_kind_find(const char *name); /* NULL: unknown */

bool apply_settings(const struct place *root);
bool apply_color(const struct place *root);
bool apply_image(const struct place *root);
bool apply_mesh(const struct place *root);
bool apply_instances(const struct place *root);
bool apply_material(const struct place *root);
bool apply_light(const struct place *root);
bool apply_world(const struct place *root);
bool apply_camera(const struct place *root);

#endif
