/* Parts of scenes for the tests of csrc/scene. */
#include "scenes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "statistics.h"

#include <cmocka.h>

const struct transform scenes_identity = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
const struct visibility scenes_visible = {true, true, true, true, true, true};

static void must(bool good, const stokes_error *err)
{
    if (!good)
        fail_msg("%s, %s: %s", err->object, err->property, err->text);
}

static struct closure *bsdf(const char *name, float color)
{
    struct closure *closure = calloc(1, sizeof *closure);
    struct color_node *node = calloc(1, sizeof *node);
    *node = (struct color_node){.spectrum = spectrum_constant(SCENES_RANGE, color), .scale = 1};
    *closure = (struct closure){.kind = CLOSURE_BSDF, .bsdf = bsdf_kind_find(name), .color = {node}};
    return closure;
}

struct closure *scenes_grey(void)
{
    return bsdf("diffuse", 0.5f);
}

struct closure *scenes_transparent(float color)
{
    return bsdf("transparent", color);
}

struct emission_node *scenes_emission(float per_nm)
{
    struct emission_node *node = calloc(1, sizeof *node);
    node->spectrum = spectrum_constant(SCENES_RANGE, per_nm);
    node->scale = 1;
    return node;
}

struct emission_node *scenes_texture_emission(const struct image *image, float scale)
{
    struct emission_node *node = calloc(1, sizeof *node);
    node->texture = calloc(1, sizeof *node->texture);
    *node->texture = (struct texture){.image = image, .transform = scenes_identity};
    node->scale = scale;
    return node;
}

struct closure *scenes_emitter(float radiance_per_nm, bool two_sided)
{
    struct closure *closure = calloc(1, sizeof *closure);
    closure->kind = CLOSURE_EMISSION;
    closure->emission = scenes_emission(radiance_per_nm);
    closure->emission->two_sided = two_sided;
    return closure;
}

void scenes_mesh(struct scene *scene, const char *name, const struct vec3 *points, uint32_t triangles)
{
    stokes_error err;
    uint32_t *index = malloc(3 * sizeof *index * triangles + 1);
    for (uint32_t i = 0; i < 3 * triangles; i++)
        index[i] = i;
    struct mesh_input mesh = {.name = name,
                              .positions = &points->x,
                              .vertex_count = 3 * (size_t)triangles,
                              .triangles = index,
                              .triangle_count = triangles};
    must(scene_add_mesh(scene, &mesh, &err), &err);
    free(index);
}

void scenes_instance(struct scene *scene, const char *name, const char *mesh, const char *material,
                     const struct transform *transforms, uint32_t count)
{
    stokes_error err;
    struct instances_input in = {.name = name,
                                 .mesh = mesh,
                                 .materials = &material,
                                 .material_count = 1,
                                 .transforms = transforms->m,
                                 .transform_count = count,
                                 .visible = scenes_visible};
    must(scene_add_instances(scene, &in, &err), &err);
}

void scenes_material(struct scene *scene, const char *name, struct closure *closure)
{
    stokes_error err;
    must(scene_add_material(scene, name, closure, &err), &err);
}

void scenes_light(struct scene *scene, struct light_input light)
{
    stokes_error err;
    light.visible = scenes_visible;
    must(scene_add_light(scene, &light, &err), &err);
}

void scenes_commit(struct scene *scene)
{
    stokes_error err;
    struct scene_setup setup = {.range = SCENES_RANGE, .uv_rule = UV_HOLD, .threads = 1};
    working_space_rec709(&setup.working_space);
    must(scene_commit(scene, &setup, &err), &err);
}

struct transform scenes_transform(uint64_t seed, float size, float reach)
{
    struct frame frame = frame_about(scenes_direction(seed, 0));
    float s[3], shear = (float)independent(seed, 10) - 0.5f;
    for (int i = 0; i < 3; i++)
        s[i] = size * (0.3f + (float)independent(seed, 20 + (uint64_t)i));
    if (seed & 1)
        s[0] = -s[0];
    struct vec3 x = scale(frame.s, s[0]), y = along(scale(frame.t, s[1]), frame.s, shear * size),
                z = scale(frame.n, s[2]);
    float t[3];
    for (int i = 0; i < 3; i++)
        t[i] = reach * (2 * (float)independent(seed, 30 + (uint64_t)i) - 1);
    return (struct transform){{x.x, y.x, z.x, t[0], x.y, y.y, z.y, t[1], x.z, y.z, z.z, t[2]}};
}

struct vec3 scenes_direction(uint64_t seed, uint64_t index)
{
    float z = 1 - 2 * (float)independent(seed, 2 * index + 1000),
          phi = 2 * PI_F * (float)independent(seed, 2 * index + 1001);
    float r = sqrtf(fmaxf(0, 1 - z * z));
    return vec3(r * cosf(phi), r * sinf(phi), z);
}
