/* One light of each kind, each in a scene of its own. */
#include "lamps.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include "statistics.h"

#include <cmocka.h>

struct transform lamps_tilted(float size)
{
    struct frame f = frame_about(normalize(vec3(0.3f, -0.5f, 0.7f)));
    return (struct transform){{size * f.s.x, size * f.t.x, size * f.n.x, 0.5f, size * f.s.y, size * f.t.y,
                               size * f.n.y, -1, size * f.s.z, size * f.t.z, size * f.n.z, 2}};
}

static struct scene *with_lamp(struct light_input light)
{
    struct scene *scene = scene_create();
    struct vec3 floor[3] = {vec3(-2, -2, 0), vec3(2, -2, 0), vec3(0, 2, 1)};
    scenes_mesh(scene, "floor", floor, 1);
    scenes_material(scene, "grey", scenes_grey());
    scenes_instance(scene, "floor", "floor", "grey", &scenes_identity, 1);
    light.name = "lamp";
    light.emission = scenes_emission(PER_NM);
    scenes_light(scene, light);
    scenes_commit(scene);
    return scene;
}

struct scene *lamps_make_rectangle(void)
{
    return with_lamp(
        (struct light_input){.shape = LIGHT_RECTANGLE, .transform = lamps_tilted(2), .size = {0.5f, 1.5f}});
}
struct scene *lamps_make_ellipse(void)
{
    return with_lamp(
        (struct light_input){.shape = LIGHT_ELLIPSE, .transform = lamps_tilted(1), .size = {0.5f, 1.5f}});
}
struct scene *lamps_make_sphere(void)
{
    return with_lamp(
        (struct light_input){.shape = LIGHT_SPHERE, .transform = lamps_tilted(1), .radius = 0.4f});
}
struct scene *lamps_make_point(void)
{
    return with_lamp((struct light_input){.shape = LIGHT_POINT, .transform = lamps_tilted(1)});
}
struct scene *lamps_make_spot(void)
{
    return with_lamp((struct light_input){
        .shape = LIGHT_SPOT, .transform = lamps_tilted(1), .angle = 1.2f, .blend = 0.3f});
}
struct scene *lamps_make_wide_spot(void)
{
    return with_lamp((struct light_input){
        .shape = LIGHT_SPOT, .transform = lamps_tilted(1), .angle = 1.2f, .blend = 0.3f, .radius = 0.4f});
}
struct scene *lamps_make_sun(void)
{
    return with_lamp((struct light_input){.shape = LIGHT_SUN, .transform = lamps_tilted(1), .angle = 0.2f});
}
struct scene *lamps_make_sharp_sun(void)
{
    return with_lamp((struct light_input){.shape = LIGHT_SUN, .transform = lamps_tilted(1)});
}

/* A bent quad under a transform that stretches its triangles unlike each other. */
static struct scene *make_mesh(bool two_sided, const struct transform *transform)
{
    struct vec3 points[6] = {vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0),
                             vec3(1, 0, 0), vec3(1, 0, 1), vec3(0, 1, 0)};
    struct scene *scene = scene_create();
    scenes_mesh(scene, "lamp", points, 2);
    scenes_material(scene, "light", scenes_emitter(PER_NM, two_sided));
    scenes_instance(scene, "lamp", "lamp", "light", transform, 1);
    scenes_commit(scene);
    return scene;
}
static const struct transform stretched = {{-3, 0, 0, 1, 0, 1, 0, 2, 0, 0.5f, 2, 3}};
#define STRETCHED_AREA (0.5 * 3 * 1.118033989 + 0.5 * 6.32455532)
struct scene *lamps_make_one_sided_mesh(void)
{
    return make_mesh(false, &stretched);
}
struct scene *lamps_make_two_sided_mesh(void)
{
    return make_mesh(true, &stretched);
}
struct scene *lamps_make_similar_mesh(void)
{
    struct transform transform = lamps_tilted(2);
    return make_mesh(false, &transform);
}

static struct scene *with_world(struct world_input world)
{
    struct scene *scene = scene_create();
    stokes_error err;
    struct vec3 floor[3] = {vec3(-2, -2, 0), vec3(2, -2, 0), vec3(0, 2, 1)};
    scenes_mesh(scene, "floor", floor, 1);
    scenes_instance(scene, "floor", "floor", "", &scenes_identity, 1);
    if (world.image) {
        float pixels[8 * 4 * 3];
        for (uint64_t i = 0; i < 8 * 4 * 3; i++)
            pixels[i] = i < 9 ? 0 : 4 * (float)(independent(77, i) * independent(78, i));
        assert_true(
            scene_add_image(scene, image_create("sky", 8, 4, 3, false, pixels, sizeof pixels, &err), &err));
    }
    world.visible = scenes_visible;
    assert_true(scene_set_world(scene, &world, &err));
    scenes_commit(scene);
    return scene;
}
struct scene *lamps_make_constant_world(void)
{
    return with_world((struct world_input){.emission = scenes_emission(PER_NM)});
}
struct scene *lamps_make_image_world(void)
{
    return with_world((struct world_input){.image = "sky", .scale = 2, .to_map = scenes_transform(3, 1, 0)});
}

#define CONE(half, blend) (2 * M_PI * (1 - cos(half)) * (1 - (blend) / 2))
const struct sample_light lamps[LAMPS] = {
    {"rectangle", lamps_make_rectangle, 3, 3 * M_PI},
    {"ellipse", lamps_make_ellipse, 0.75 * M_PI / 4, 0.75 * M_PI / 4 * M_PI},
    {"sphere", lamps_make_sphere, 4 * M_PI * 0.16, 4 * M_PI * 0.16 * M_PI},
    {"point", lamps_make_point, 1, 4 * M_PI},
    {"spot", lamps_make_spot, 1, CONE(0.6, 0.3)},
    {"spot with a radius", lamps_make_wide_spot, 4 * M_PI * 0.16, M_PI * 0.16 * CONE(0.6, 0.3)},
    {"sun", lamps_make_sun, 2 * M_PI * 0.00499583472, 0},
    {"sharp sun", lamps_make_sharp_sun, 1, 0},
    {"one-sided mesh", lamps_make_one_sided_mesh, STRETCHED_AREA, STRETCHED_AREA *M_PI},
    {"two-sided mesh", lamps_make_two_sided_mesh, STRETCHED_AREA, STRETCHED_AREA * 2 * M_PI},
    {"mesh under a similarity", lamps_make_similar_mesh, 4 * (0.5 + 0.7071067812),
     4 * (0.5 + 0.7071067812) * M_PI},
    {"constant world", lamps_make_constant_world, 4 * M_PI, 0},
    {"image world", lamps_make_image_world, 0, 0},
};

void lamps_draw(uint64_t seed, uint64_t i, float *u, uint64_t count)
{
    for (uint64_t k = 0; k < count; k++)
        u[k] = (float)independent(seed, i * count + k);
}

struct scene *lamps_make_stretched_spot(void)
{
    return with_lamp((struct light_input){
        .shape = LIGHT_SPOT, .transform = scenes_transform(11, 1, 1), .angle = 1.5f, .blend = 0.6f});
}
