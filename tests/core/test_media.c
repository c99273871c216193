/* Which volumes a point is in, and what of them a straight edge crosses. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include "base/error.h"
#include "scenes.h"
#include "statistics.h"

#include "scene/media.h"

#include <cmocka.h>

/* --- A scene of boxes ------------------------------------------------------------------------------------------ */

struct body {
    const char *name, *material;
    bool again;      /* another body has brought the material */
    float sigma;     /* 0: no volume */
    float low, high; /* corners of a cube on the diagonal */
    bool mirrored, opaque;
};

static struct closure *surface_of(const struct body *body)
{
    struct closure *c = calloc(1, sizeof *c);
    c->kind = CLOSURE_BSDF;
    c->bsdf = bsdf_kind_find(body->opaque ? "diffuse" : "transparent");
    return c;
}

static struct volume *thin(float sigma)
{
    struct volume *v = volume_create(spectrum_constant(SCENES_RANGE, sigma), NULL, 0);
    assert_true(v && volume_finish(v));
    return v;
}

static void add_body(struct scene *scene, const struct body *body)
{
    static const uint32_t triangles[36] = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                                           2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    float positions[24];
    for (int i = 0; i < 8; i++)
        for (int axis = 0; axis < 3; axis++)
            positions[3 * i + axis] =
                (i >> (2 - axis) & 1 ? body->high : body->low) * (body->mirrored && axis == 0 ? -1 : 1);
    /* Mirrored twice: in its mesh, and by its transform, which keeps what is outside. */
    const float transform[12] = {body->mirrored ? -1.0f : 1.0f, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    uint32_t turned[36];
    for (int i = 0; i < 36; i += 3)
        for (int k = 0; k < 3; k++)
            turned[i + k] = triangles[i + (body->mirrored && k > 0 ? 3 - k : k)];
    struct mesh_input mesh = {.name = body->name,
                              .positions = positions,
                              .vertex_count = 8,
                              .triangles = turned,
                              .triangle_count = 12};
    struct instances_input in = {.name = body->name,
                                 .mesh = body->name,
                                 .materials = &body->material,
                                 .material_count = 1,
                                 .transforms = transform,
                                 .transform_count = 1,
                                 .visible = scenes_visible};
    assert_true(scene_add_mesh(scene, &mesh, NULL));
    if (!body->again)
        assert_true(scene_add_material_with(scene, body->material, surface_of(body),
                                            body->sigma > 0 ? thin(body->sigma) : NULL, NULL));
    assert_true(scene_add_instances(scene, &in, NULL));
}

/* "a" from 0 to 4, "b" in its corner and beyond, "c" inside of both and mirrored, a second body of the first one's volume, "wall" behind all. */
static const struct body bodies[] = {
    {.name = "a", .material = "one", .sigma = 1, .low = 0, .high = 4},
    {.name = "b", .material = "two", .sigma = 2, .low = 3, .high = 6},
    {.name = "c", .material = "three", .sigma = 3, .low = 3.2f, .high = 3.8f, .mirrored = true},
    {.name = "d", .material = "one", .again = true, .sigma = 1, .low = 2, .high = 5},
    {.name = "wall", .material = "wall", .low = 8, .high = 9, .opaque = true}};
enum { BODIES = 4 };

static struct scene *boxes(bool world)
{
    struct scene *scene = scene_create();
    for (int i = 0; i <= BODIES; i++)
        add_body(scene, &bodies[i]);
    if (world) {
        struct world_input in = {.emission = calloc(1, sizeof *in.emission),
                                 .scale = 1,
                                 .visible = scenes_visible,
                                 .volume = thin(0.5f)};
        in.emission->spectrum = spectrum_constant(SCENES_RANGE, 0);
        in.emission->scale = 1;
        assert_true(scene_set_world(scene, &in, NULL));
    }
    scenes_commit(scene);
    return scene;
}

static struct vec3 random_point(uint64_t i)
{
    return vec3(-2 + 9 * (float)independent(3, 3 * i), -2 + 9 * (float)independent(3, 3 * i + 1),
                -2 + 9 * (float)independent(3, 3 * i + 2));
}

static bool is_in(const struct body *body, struct vec3 p)
{
    return p.x > body->low && p.x < body->high && p.y > body->low && p.y < body->high && p.z > body->low &&
           p.z < body->high;
}

/* What of the segment lies in a body, m. */
static double length_in(const struct body *body, struct vec3 from, struct vec3 to)
{
    double first = 0, last = 1;
    const float *a = &from.x, *b = &to.x;
    for (int axis = 0; axis < 3; axis++) {
        double d = (double)b[axis] - a[axis], t0 = (body->low - a[axis]) / d, t1 = (body->high - a[axis]) / d;
        first = fmax(first, fmin(t0, t1));
        last = fmin(last, fmax(t0, t1));
    }
    return fmax(0, last - first) * (double)length(sub(to, from));
}

static double sigma_at(const struct scene *scene, const struct media *media)
{
    return media_rate(scene, media, 0); /* all rates of grey volumes are σt */
}

/* --- Claims ------------------------------------------------------------------------------------------------------- */

static void a_point_is_in_the_bodies_around_it(void **state)
{
    (void)state;
    for (int world = 0; world < 2; world++) {
        struct scene *scene = boxes(world);
        assert_true(scene_has_volumes(scene) && scene_has_bounded_volumes(scene));
        for (uint64_t i = 0; i < 500; i++) {
            struct vec3 p = random_point(i);
            struct media media = scene_media_at(scene, p, normalize(random_point(i + 1000)));
            double expected = world ? 0.5 : 0;
            for (int k = 0; k < BODIES; k++)
                expected += is_in(&bodies[k], p) ? (double)bodies[k].sigma : 0;
            assert_float_equal(sigma_at(scene, &media), expected, 1e-5);
        }
        scene_destroy(scene);
    }
}

static void a_shadow_ray_knows_what_it_crosses_of_each_volume(void **state)
{
    (void)state;
    struct scene *scene = boxes(true);
    for (uint64_t i = 0; i < 500; i++) {
        struct vec3 a = random_point(i), b = random_point(i + 500), d = normalize(sub(b, a));
        struct media at_a = scene_media_at(scene, a, d), at_b = scene_media_at(scene, b, d);
        struct crossing there, back;
        assert_float_equal(scene_visibility_through(scene, a, b, 500, RAY_SHADOW, &at_a, &there), 1, 0);
        assert_float_equal(scene_visibility_through(scene, b, a, 500, RAY_SHADOW, &at_b, &back), 1, 0);
        double depth = 0.5 * (double)length(sub(b, a));
        for (int k = 0; k < BODIES; k++)
            depth += (double)bodies[k].sigma * length_in(&bodies[k], a, b);
        assert_float_equal(crossing_depth(scene, &there, 0), depth, 1e-4);
        assert_float_equal(crossing_depth(scene, &back, 0), depth, 1e-4);
        assert_float_equal(crossing_transmittance(scene, &there, 500), exp(-depth), 1e-4);
    }
    /* The wall stops it all the same. */
    struct media open = scene_open_media(scene);
    struct crossing crossing;
    assert_float_equal(scene_visibility_through(scene, vec3(-1, 8.5f, 8.3f), vec3(12, 8.6f, 8.4f), 500,
                                                RAY_SHADOW, &open, &crossing),
                       0, 0);
    scene_destroy(scene);
}

static void nothing_arrives_from_infinity_through_a_world_that_extinguishes(void **state)
{
    (void)state;
    for (int world = 0; world < 2; world++) {
        struct scene *scene = boxes(world);
        struct vec3 from = vec3(3.5f, 3.4f, 3.3f), d = normalize(vec3(-1, -0.9f, -0.8f));
        struct media media = scene_media_at(scene, from, d);
        struct crossing crossing;
        assert_float_equal(
            scene_visibility_distant_through(scene, from, d, 500, RAY_SHADOW, &media, &crossing), 1, 0);
        double depth = 0, left = crossing_transmittance(scene, &crossing, 500);
        for (int k = 0; k < BODIES; k++)
            depth += (double)bodies[k].sigma * length_in(&bodies[k], from, along(from, d, 20));
        assert_float_equal(left, world ? 0 : exp(-depth), 1e-5);
        double density[VOLUME_RATES];
        crossing_densities(scene, &crossing, NULL, density);
        for (int k = 0; k < VOLUME_RATES; k++)
            assert_float_equal(density[k], left, 1e-6);
        scene_destroy(scene);
    }
}

static void sets_hold_what_fits_and_forget_what_is_left(void **state)
{
    (void)state;
    struct media media = {.count = 0};
    for (int i = 0; i < MEDIA_MAX + 3; i++)
        media_pass(&media, i, true);
    assert_int_equal(media.count, MEDIA_MAX);
    media_pass(&media, 2, true);
    media_pass(&media, MEDIA_MAX + 1, false); /* never got in */
    for (int i = 0; i < MEDIA_MAX + 3; i++)
        media_pass(&media, i, false);
    assert_int_equal(media.count, 1); /* 2 was entered twice */
    assert_int_equal(media.in[0].volume, 2);
    media_pass(&media, 2, false);
    media_pass(&media, 2, false);
    assert_int_equal(media.count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_point_is_in_the_bodies_around_it),
        cmocka_unit_test(a_shadow_ray_knows_what_it_crosses_of_each_volume),
        cmocka_unit_test(nothing_arrives_from_infinity_through_a_world_that_extinguishes),
        cmocka_unit_test(sets_hold_what_fits_and_forget_what_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
