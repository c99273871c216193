/* Building a scene: what the stream's messages become. Every function copies or takes what it is given, checks it, and
   on false has changed nothing and says in *err which object's which property is wrong. */
#ifndef SCENE_BUILD_H
#define SCENE_BUILD_H

#include "material/closure.h"
#include "material/volume.h"
#include "scene/scene.h"

struct scene *scene_create(void);
void scene_destroy(struct scene *);

struct mesh_uv {
    char name[64];
    const float *data; /* 2 per corner */
};
/* As the `mesh` message; all pointers borrowed. NULL where the message leaves a member out. */
struct mesh_input {
    const char *name;
    const float *positions;
    size_t vertex_count;
    const uint32_t *triangles;
    size_t triangle_count;
    const uint32_t *corners;
    const float *corner_normals;
    size_t corner_count;
    const struct mesh_uv *uv;
    size_t uv_count;
    const uint32_t *material_index;
};
bool scene_add_mesh(struct scene *, const struct mesh_input *, stokes_error *err);

/* Takes the closure; it is compiled at scene_commit, when working space and Λ are known. */
bool scene_add_material(struct scene *, const char *name, struct closure *, stokes_error *err);
/* The same, with what fills the space that its surfaces enclose: takes the volume, too (NULL: nothing), after volume_finish. */
bool scene_add_material_with(struct scene *, const char *name, struct closure *, struct volume *, stokes_error *err);
/* As compiled by scene_commit; NULL if there is none of that name. */
const struct material *scene_find_material(const struct scene *, const char *name);
/* Takes the image. */
bool scene_add_image(struct scene *, struct image *, stokes_error *err);
const struct image *scene_find_image(const struct scene *, const char *name);

struct visibility {
    bool camera, diffuse, glossy, transmission, shadow, volume;
};
struct instances_input {
    const char *name, *mesh;
    const char *const *materials;
    size_t material_count;
    const float *transforms; /* 12 each */
    size_t transform_count;
    struct visibility visible;
    bool holdout;
};
bool scene_add_instances(struct scene *, const struct instances_input *, stokes_error *err);

enum light_shape { LIGHT_RECTANGLE, LIGHT_ELLIPSE, LIGHT_SPHERE, LIGHT_POINT, LIGHT_SPOT, LIGHT_SUN };
struct light_input {
    const char *name;
    enum light_shape shape;
    struct transform transform;
    struct emission_node *emission; /* taken */
    float size[2], radius, angle, blend;
    bool dimmed; /* a spot: its intensity falls with the cosine, as before Blender 3.5 */
    struct visibility visible;
};
bool scene_add_light(struct scene *, const struct light_input *, stokes_error *err);

struct world_input {
    struct emission_node *emission; /* taken; NULL: an image world */
    const char *image;
    float scale;
    struct transform to_map;
    struct visibility visible;
    struct volume *volume; /* taken, after volume_finish; NULL: none */
};
bool scene_set_world(struct scene *, const struct world_input *, stokes_error *err);

struct camera_input {
    bool orthographic;
    struct transform transform;
    float frame[4]; /* left, right, bottom, top */
    int resolution[2], border[4];
    float clip[2];
    float lens_radius, focus_distance, blade_rotation, aspect;
    int blades;
};
bool scene_set_camera(struct scene *, const struct camera_input *, stokes_error *err);

bool scene_remove(struct scene *, const char *kind, const char *name, stokes_error *err);

/* Compiles materials, builds acceleration structures and the light table; only what changed since the last commit. */
struct scene_setup {
    struct range range;
    enum uv_rule uv_rule;
    struct working_space working_space;
    int threads;
    void (*warn)(void *user, const stokes_error *);
    void *user;
    /* Asked now and then while structures are built, from any thread; may be NULL. True gives up: the commit fails, and the
       next one does what is left. */
    bool (*stop)(void *user);
};
bool scene_commit(struct scene *, const struct scene_setup *, stokes_error *err);

/* Lines for the report: triangles, instances, lights, those at infinity that the world's volume keeps away, colours that no reflectance reaches. */
struct scene_statistics {
    size_t meshes, instances, triangles, lights, lights_lost, materials, images, colors_out_of_reach;
};
struct scene_statistics scene_statistics(const struct scene *);

#endif
