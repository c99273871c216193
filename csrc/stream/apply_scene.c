/* `mesh`, `instances`, `material`, `light`, `world`, `camera`: geometry and what it is made of. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "stream/expressions.h"
#include "stream/messages.h"

#define FINITE -FLT_MAX, FLT_MAX
#define UV_LAYERS_MAX 64

/* --- Shared members ---------------------------------------------------------------------------------------- */

static bool read_visibility(const struct place *root, struct visibility *visible)
{
    static const struct field fields[] = {
        {"camera", FIELD_BOOL, false, offsetof(struct visibility, camera), 0, 0, 0},
        {"diffuse", FIELD_BOOL, false, offsetof(struct visibility, diffuse), 0, 0, 0},
        {"glossy", FIELD_BOOL, false, offsetof(struct visibility, glossy), 0, 0, 0},
        {"transmission", FIELD_BOOL, false, offsetof(struct visibility, transmission), 0, 0, 0},
        {"shadow", FIELD_BOOL, false, offsetof(struct visibility, shadow), 0, 0, 0},
        {"volume", FIELD_BOOL, false, offsetof(struct visibility, volume), 0, 0, 0},
    };
    struct place place = place_member(root, "visible");
    *visible = (struct visibility){true, true, true, true, true, true};
    return !place.value || (place_is(&place, JSON_OBJECT) &&
                            read_fields(&place, fields, sizeof fields / sizeof *fields, visible));
}

/* --- Mesh -------------------------------------------------------------------------------------------------- */

/* A blob of `count` items (any number, if it is 0) or nothing. */
static bool read_optional_blob(const struct place *root, const char *key, size_t size, size_t expected,
                               const void **data, size_t *count)
{
    struct place place = place_member(root, key);
    *data = NULL;
    *count = 0;
    if (!place.value)
        return true;
    if (!read_blob(&place, size, data, count))
        return false;
    return expected == 0 || *count == expected ||
           place_fail(&place, "holds %zu entries; %zu are wanted", *count, expected);
}

/* One UV layer: {name, data}. */
static bool read_uv_layer(const struct place *layer, size_t corners, struct mesh_uv *uv)
{
    struct place name_place = place_member(layer, "name"), data_place = place_member(layer, "data");
    const char *name;
    const void *data;
    size_t count;
    if (!place_is(layer, JSON_OBJECT) || !read_text(&name_place, &name))
        return false;
    if (strlen(name) >= sizeof uv->name)
        return place_fail(&name_place, "is longer than %zu bytes", sizeof uv->name - 1);
    if (!read_blob(&data_place, 2 * sizeof(float), &data, &count))
        return false;
    if (count != corners)
        return place_fail(&data_place, "holds %zu corners; %zu are wanted", count, corners);
    strcpy(uv->name, name);
    uv->data = data;
    return true;
}

/* *layers is to be freed. */
static bool read_uv_layers(const struct place *root, size_t corners, struct mesh_uv **layers, size_t *count)
{
    struct place place = place_member(root, "uv");
    *layers = NULL;
    *count = 0;
    if (!place.value)
        return true;
    if (!place_is(&place, JSON_ARRAY))
        return false;
    *count = json_array_size(place.value);
    if (*count > UV_LAYERS_MAX)
        return place_fail(&place, "has %zu layers; at most %d are taken", *count, UV_LAYERS_MAX);
    *layers = calloc(*count + 1, sizeof **layers);
    if (!*layers)
        return place_fail(&place, "out of memory");
    for (size_t i = 0; i < *count; i++) {
        struct place layer = place_element(&place, i);
        if (!read_uv_layer(&layer, corners, &(*layers)[i]))
            return false;
    }
    return true;
}

/* Corners are as many as the normals say; without normals, as the first UV layer says; without both they mean nothing. */
static size_t count_corners(const struct place *root, size_t normals)
{
    struct place uv = place_member(root, "uv");
    json_t *data = json_object_get(json_array_get(uv.value, 0), "data");
    json_int_t bytes = json_integer_value(json_object_get(data, "bytes"));
    return normals ? normals : bytes > 0 ? (size_t)bytes / (2 * sizeof(float)) : 0;
}

static bool read_mesh(const struct place *root, struct mesh_input *mesh, struct mesh_uv **layers)
{
    struct place positions = place_member(root, "positions"), triangles = place_member(root, "triangles");
    const void *position_data, *triangle_data, *corner_data, *normal_data, *material_data;
    size_t normals, count;
    if (!read_blob(&positions, 3 * sizeof(float), &position_data, &mesh->vertex_count) ||
        !read_blob(&triangles, 3 * sizeof(uint32_t), &triangle_data, &mesh->triangle_count))
        return false;
    size_t expected = mesh->triangle_count;
    if (!read_optional_blob(root, "corners", 3 * sizeof(uint32_t), expected, &corner_data, &count) ||
        !read_optional_blob(root, "material_index", sizeof(uint32_t), expected, &material_data, &count) ||
        !read_optional_blob(root, "corner_normals", 3 * sizeof(float), corner_data ? 0 : 3 * expected,
                            &normal_data, &normals))
        return false;
    mesh->corner_count = corner_data ? count_corners(root, normals) : 3 * expected;
    if (!read_uv_layers(root, mesh->corner_count, layers, &mesh->uv_count))
        return false;
    mesh->positions = position_data;
    mesh->triangles = triangle_data;
    mesh->corners = mesh->corner_count ? corner_data : NULL;
    mesh->corner_normals = normals ? normal_data : NULL;
    mesh->uv = *layers;
    mesh->material_index = material_data;
    return true;
}

bool apply_mesh(const struct place *root)
{
    struct message *message = root->message;
    struct mesh_input mesh = {.name = message->object};
    struct mesh_uv *layers = NULL;
    bool good =
        read_mesh(root, &mesh, &layers) && scene_add_mesh(message->session->scene, &mesh, message->err);
    free(layers);
    return good;
}

/* --- Instances --------------------------------------------------------------------------------------------- */

bool apply_instances(const struct place *root)
{
    struct message *message = root->message;
    struct instances_input input = {.name = message->object};
    struct place mesh = place_member(root, "mesh"), materials = place_member(root, "materials");
    struct place transforms = place_member(root, "transforms"), holdout = place_member(root, "holdout");
    const void *data;
    if (!read_text(&mesh, &input.mesh) || (materials.value && !place_is(&materials, JSON_ARRAY)) ||
        !read_blob(&transforms, 12 * sizeof(float), &data, &input.transform_count) ||
        !read_visibility(root, &input.visible) || (holdout.value && !read_flag(&holdout, &input.holdout)))
        return false;
    input.transforms = data;
    input.material_count = json_array_size(materials.value);
    const char **names = calloc(input.material_count + 1, sizeof *names);
    bool good = names || place_fail(root, "out of memory");
    for (size_t i = 0; good && i < input.material_count; i++) {
        struct place name = place_element(&materials, i);
        good = read_text(&name, &names[i]);
    }
    input.materials = names;
    good = good && scene_add_instances(message->session->scene, &input, message->err);
    free(names);
    return good;
}

/* --- Material ---------------------------------------------------------------------------------------------- */

bool apply_material(const struct place *root)
{
    struct message *message = root->message;
    struct place surface = place_member(root, "surface"), inside = place_member(root, "volume");
    struct volume *volume = NULL;
    struct closure *closure = read_closure(&surface, EXPRESSION_DEPTH);
    if (!closure || (inside.value && !(volume = read_volume(&inside)))) {
        closure_destroy(closure);
        return false;
    }
    return scene_add_material_with(message->session->scene, message->object, closure, volume, message->err);
}

/* --- Lights and world -------------------------------------------------------------------------------------- */

static const char *const light_kinds[] = {"rectangle", "ellipse", "sphere", "point", "spot", "sun", NULL};

static bool read_light(const struct place *root, struct light_input *light)
{
    static const struct field common[] = {
        {"transform", FIELD_FLOAT, true, offsetof(struct light_input, transform), 12, FINITE},
    };
    static const struct field area[] = {
        {"size", FIELD_FLOAT, true, offsetof(struct light_input, size), 2, 0, FLT_MAX}};
    static const struct field sphere[] = {
        {"radius", FIELD_FLOAT, true, offsetof(struct light_input, radius), 0, 0, FLT_MAX}};
    static const struct field spot[] = {
        {"radius", FIELD_FLOAT, false, offsetof(struct light_input, radius), 0, 0, FLT_MAX},
        {"angle", FIELD_FLOAT, true, offsetof(struct light_input, angle), 0, 0, 6.2832},
        {"blend", FIELD_FLOAT, false, offsetof(struct light_input, blend), 0, 0, 1},
        {"dimmed", FIELD_BOOL, false, offsetof(struct light_input, dimmed), 0, 0, 0}};
    static const struct field sun[] = {
        {"angle", FIELD_FLOAT, false, offsetof(struct light_input, angle), 0, 0, 6.2832}};
    struct place kind = place_member(root, "kind");
    int shape;
    if (!read_choice(&kind, light_kinds, &shape) || !read_fields(root, common, 1, light) ||
        !read_visibility(root, &light->visible))
        return false;
    light->shape = (enum light_shape)shape;
    switch (light->shape) {
    case LIGHT_RECTANGLE:
    case LIGHT_ELLIPSE: return read_fields(root, area, 1, light);
    case LIGHT_SPHERE: return read_fields(root, sphere, 1, light);
    case LIGHT_POINT: return true;
    case LIGHT_SPOT: return read_fields(root, spot, 4, light);
    case LIGHT_SUN: return read_fields(root, sun, 1, light);
    }
    return false;
}

bool apply_light(const struct place *root)
{
    struct message *message = root->message;
    struct light_input light = {.name = message->object};
    struct place emission = place_member(root, "emission");
    if (!read_light(root, &light))
        return false;
    light.emission = read_emission(&emission);
    return light.emission && scene_add_light(message->session->scene, &light, message->err);
}

bool apply_world(const struct place *root)
{
    static const char *const kinds[] = {"constant", "image", NULL};
    static const struct field fields[] = {
        {"scale", FIELD_FLOAT, false, offsetof(struct world_input, scale), 0, 0, FLT_MAX},
        {"transform", FIELD_FLOAT, false, offsetof(struct world_input, to_map), 12, FINITE},
    };
    struct message *message = root->message;
    struct world_input world = {.scale = 1, .to_map = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}}};
    struct place kind = place_member(root, "kind"), image = place_member(root, "image");
    struct place emission = place_member(root, "emission"), inside = place_member(root, "volume");
    int chosen;
    if (!read_choice(&kind, kinds, &chosen) || !read_fields(root, fields, 2, &world) ||
        !read_visibility(root, &world.visible))
        return false;
    if (chosen == 1 && !read_text(&image, &world.image))
        return false;
    if (chosen == 1 && !scene_find_image(message->session->scene, world.image))
        return place_fail(&image, "image '%.100s' has not been sent", world.image);
    if (inside.value && !(world.volume = read_volume(&inside)))
        return false;
    if (chosen == 0 && !(world.emission = read_emission(&emission))) {
        volume_destroy(world.volume);
        return false;
    }
    return scene_set_world(message->session->scene, &world, message->err);
}

/* --- Camera ------------------------------------------------------------------------------------------------ */

#define PIXELS_MAX 65536

static bool check_border(const struct place *root, const struct camera_input *camera)
{
    struct place place = place_member(root, "border");
    const int *b = camera->border, *size = camera->resolution;
    if (b[0] < b[2] && b[1] < b[3] && b[2] <= size[0] && b[3] <= size[1])
        return true;
    return place_fail(&place, "[%d, %d, %d, %d] is no rectangle within %d x %d pixels", b[0], b[1], b[2],
                      b[3], size[0], size[1]);
}

bool apply_camera(const struct place *root)
{
    static const char *const kinds[] = {"perspective", "orthographic", NULL};
#define AT(member) offsetof(struct camera_input, member)
    static const struct field fields[] = {
        {"transform", FIELD_FLOAT, true, AT(transform), 12, FINITE},
        {"frame", FIELD_FLOAT, true, AT(frame), 4, FINITE},
        {"border", FIELD_INT, false, AT(border), 4, 0, PIXELS_MAX},
        {"clip", FIELD_FLOAT, false, AT(clip), 2, FINITE},
        {"lens_radius", FIELD_FLOAT, false, AT(lens_radius), 0, 0, FLT_MAX},
        {"focus_distance", FIELD_FLOAT, false, AT(focus_distance), 0, 0, FLT_MAX},
        {"blades", FIELD_INT, false, AT(blades), 0, 0, 1024},
        {"blade_rotation", FIELD_FLOAT, false, AT(blade_rotation), 0, FINITE},
        {"aspect", FIELD_FLOAT, false, AT(aspect), 0, 1e-6, 1e6},
    };
    static const struct field resolution = {"resolution", FIELD_INT, true, AT(resolution), 2, 1, PIXELS_MAX};
#undef AT
    struct message *message = root->message;
    struct camera_input camera = {.clip = {0, FLT_MAX}, .focus_distance = 10, .aspect = 1};
    struct place kind = place_member(root, "kind");
    int chosen;
    if (!read_choice(&kind, kinds, &chosen) || !read_fields(root, &resolution, 1, &camera))
        return false;
    camera.orthographic = chosen == 1;
    camera.border[2] = camera.resolution[0];
    camera.border[3] = camera.resolution[1];
    if (!read_fields(root, fields, sizeof fields / sizeof *fields, &camera) || !check_border(root, &camera) ||
        !scene_set_camera(message->session->scene, &camera, message->err))
        return false;
    message->session->has_camera = true;
    return true;
}
