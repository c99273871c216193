/* Parts of scenes for the tests of csrc/scene: meshes of raw triangles, plain materials, and a commit that
   must succeed. */
#ifndef SCENES_H
#define SCENES_H

#include "base/error.h"
#include "scene/build.h"

#define SCENES_RANGE ((struct range){300, 830})
extern const struct transform scenes_identity;
extern const struct visibility scenes_visible; /* to all rays */

struct closure *scenes_grey(void);
struct closure *scenes_emitter(float radiance_per_nm, bool two_sided);
struct closure *scenes_transparent(float color);
struct emission_node *scenes_emission(float per_nm);
struct emission_node *scenes_texture_emission(const struct image *, float scale);

/* These fail the test on an error. Triangles: three points each, in a row. */
void scenes_mesh(struct scene *, const char *name, const struct vec3 *points, uint32_t triangles);
void scenes_instance(struct scene *, const char *name, const char *mesh, const char *material,
                     const struct transform *, uint32_t transforms);
void scenes_material(struct scene *, const char *name, struct closure *);
void scenes_light(struct scene *, struct light_input); /* `visible` is set to all */
void scenes_commit(struct scene *);
/* A random transform: rotation, anisotropic scale about `size`, shear, translation within `reach`; mirrored
   for odd seeds. */
struct transform scenes_transform(uint64_t seed, float size, float reach);
struct vec3 scenes_direction(uint64_t seed, uint64_t index); /* uniform on the sphere */

#endif
