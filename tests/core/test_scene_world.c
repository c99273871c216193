/* Lights as rays find them: suns, the world and its image at infinity, lamps along the way. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "lamps.h"
#include "statistics.h"

#include <cmocka.h>

/* A sun's irradiance is that of its message; a constant world of radiance L gives πL; directions' densities
   integrate to 1. */
static void distant_lights_give_their_irradiance(void **state)
{
    (void)state;
    static const struct {
        struct scene *(*make)(void);
        double irradiance;
    } cases[] = {
        {lamps_make_sun, PER_NM}, {lamps_make_sharp_sun, PER_NM}, {lamps_make_constant_world, M_PI * PER_NM}};
    struct vec3 up = normalize(vec3(0.3f, -0.5f, 0.7f)); /* lamps_tilted() */
    struct batches found[3] = {0};
    double exact[3];
    for (size_t k = 0; k < 3; k++) {
        struct scene *scene = cases[k].make();
        for (uint64_t b = 0; b < BATCHES; b++) {
            double sum = 0;
            for (uint64_t i = 0; i < DRAWS; i++) {
                float u[3], pdf;
                struct light_point point;
                lamps_draw(500 + k, b * DRAWS + i, u, 3);
                assert_true(scene_sample_light(scene, u, &point, &pdf) && point.distant);
                sum += scene_light_emission(scene, &point, negate(point.normal), LAMBDA) *
                       fmaxf(0, dot(point.normal, up)) / pdf;
            }
            batches_add(&found[k], sum / DRAWS);
        }
        exact[k] = cases[k].irradiance;
        scene_destroy(scene);
    }
    assert_unbiased(found, exact, 1, (struct power){.sees_error = 0.001});
    assert_float_equal(found[1].mean / exact[1], 1, 1e-5); /* one direction: no variance */
    assert_unbiased(found + 2, exact + 2, 1, (struct power){.sees_error = 0.02});
}

static void world_density_integrates_to_one_and_covers_all_that_shines(void **state)
{
    (void)state;
    struct scene *scene = lamps_make_image_world();
    struct batches found = {0};
    double one = 1;
    for (uint64_t b = 0; b < BATCHES; b++) {
        double sum = 0;
        for (uint64_t i = 0; i < DRAWS; i++) {
            struct light_point point;
            struct ray ray = {vec3(0, 0, 0), scenes_direction(600, b * DRAWS + i), 0, INFINITY, RAY_CAMERA};
            assert_int_equal(scene_distant_along(scene, &ray, &point, 1), 1);
            float pdf = scene_pdf_light(scene, &point);
            sum += pdf;
            assert_true(pdf > 0 || scene_light_emission(scene, &point, negate(ray.direction), LAMBDA) == 0);
        }
        batches_add(&found, 4 * M_PI * sum / DRAWS);
    }
    assert_unbiased(&found, &one, 1, (struct power){.sees_error = 0.03});
    scene_destroy(scene);
}

/* One white texel in a black map of 4 × 2: its centre, by Cycles' layout, and no other texel's shines. */
static void world_images_are_laid_out_as_in_cycles(void **state)
{
    (void)state;
    /* u = 1/8, 3/8, 5/8, 7/8 are azimuths of 135°, 45°, −45°, −135° about z from +x; v = 1/4 is below, 3/4
       above */
    static const float azimuth[4] = {135, 45, -45, -135};
    stokes_error err;
    struct scene *scene = scene_create();
    struct world_input world = {
        .image = "map", .scale = 1, .to_map = scenes_identity, .visible = scenes_visible};
    assert_true(scene_set_world(scene, &world, &err));
    for (int white = 0; white < 8; white++) {
        float pixels[8] = {0};
        pixels[white] = 1;
        assert_true(
            scene_add_image(scene, image_create("map", 4, 2, 1, false, pixels, sizeof pixels, &err), &err));
        scenes_commit(scene);
        for (int i = 0; i < 8; i++) {
            float phi = azimuth[i % 4] * PI_F / 180, z = i < 4 ? -sqrtf(0.5f) : sqrtf(0.5f);
            struct ray ray = {vec3(0, 0, 0), vec3(sqrtf(0.5f) * cosf(phi), sqrtf(0.5f) * sinf(phi), z), 0,
                              INFINITY, RAY_CAMERA};
            struct light_point point;
            assert_int_equal(scene_distant_along(scene, &ray, &point, 1), 1);
            /* white of radiance 1 is D65/∫D65, 1/530 per nm on the average */
            float radiance = scene_light_emission(scene, &point, negate(ray.direction), 560);
            assert_float_equal(radiance * WIDTH, i == white ? 1 : 0, i == white ? 0.5 : 1e-4);
        }
    }
    scene_destroy(scene);
}

/* The radiance of the whole sky, by its own density and by uniform directions. */
static void world_is_drawn_as_its_density_says(void **state)
{
    (void)state;
    struct scene *scene = lamps_make_image_world();
    struct batches drawn = {0}, uniform = {0};
    for (uint64_t b = 0; b < BATCHES; b++) {
        double by_density = 0, by_all = 0;
        for (uint64_t i = 0; i < DRAWS; i++) {
            float u[3], pdf;
            struct light_point point;
            struct vec3 d = scenes_direction(700, b * DRAWS + i);
            lamps_draw(701, b * DRAWS + i, u, 3);
            assert_true(scene_sample_light(scene, u, &point, &pdf));
            float weight = 1 + 0.5f * point.normal.x + 0.3f * point.normal.z;
            by_density += weight * scene_light_emission(scene, &point, negate(point.normal), 620) / pdf;
            struct ray ray = {vec3(0, 0, 0), d, 0, INFINITY, RAY_DIFFUSE};
            scene_distant_along(scene, &ray, &point, 1);
            by_all += (1 + 0.5f * d.x + 0.3f * d.z) * scene_light_emission(scene, &point, negate(d), 620) *
                      4 * M_PI;
        }
        batches_add(&drawn, by_density / DRAWS);
        batches_add(&uniform, by_all / DRAWS);
    }
    assert_same(&drawn, &uniform, 1, (struct power){.sees_error = 0.02});
    scene_destroy(scene);
}

/* Rays see the sun's disk and nothing beside it, and what they see adds up to its irradiance. */
static void rays_see_a_sun_of_its_size(void **state)
{
    (void)state;
    struct scene *scene = lamps_make_sun();
    struct transform t = lamps_tilted(1);
    struct frame frame = {vec3(t.m[0], t.m[4], t.m[8]), vec3(t.m[1], t.m[5], t.m[9]),
                          vec3(t.m[2], t.m[6], t.m[10])};
    const double half = 0.1;
    double irradiance = 0;
    enum { RINGS = 4000 };
    for (int ring = 0; ring < RINGS; ring++) {
        double angle = 2 * half * (ring + 0.5) / RINGS;
        float phi = (float)ring;
        struct vec3 local =
            vec3((float)sin(angle) * cosf(phi), (float)sin(angle) * sinf(phi), (float)cos(angle));
        struct ray ray = {vec3(0, 0, 0), to_world(&frame, local), 0, INFINITY, RAY_CAMERA};
        struct light_point point;
        int count = scene_distant_along(scene, &ray, &point, 1);
        if (fabs(angle - half) > 1e-5)
            assert_int_equal(count, angle < half);
        if (count)
            irradiance += scene_light_emission(scene, &point, negate(ray.direction), LAMBDA) * cos(angle) *
                          2 * M_PI * sin(angle) * (2 * half / RINGS);
    }
    assert_float_equal(irradiance / PER_NM, 1, 1e-3); /* a ring more or less is 1/2000 of the area */
    scene_destroy(scene);
}

/* --- Lamps along rays -------------------------------------------------------------------------------- */

#define CROWD 40

static void add_crowd(struct scene *scene, int first, int end)
{
    static const enum light_shape shapes[] = {LIGHT_RECTANGLE, LIGHT_ELLIPSE, LIGHT_SPHERE, LIGHT_SPOT};
    for (int k = first; k < end; k++) {
        char name[16];
        snprintf(name, sizeof name, "%02d", k);
        scenes_light(scene, (struct light_input){.name = name,
                                                 .shape = shapes[k % 4],
                                                 .transform = scenes_transform(40 + (uint64_t)k, 1, 3),
                                                 .emission = scenes_emission(1),
                                                 .size = {2, 1},
                                                 .radius = 0.5f,
                                                 .angle = 1});
    }
}

/* A crowd is searched through a structure, a few lamps are tried one by one: both find the same, by distance,
   and no dark side. */
static void a_crowd_of_lamps_is_met_as_each_alone(void **state)
{
    (void)state;
    struct scene *crowd = scene_create(), *alone[CROWD / 4];
    add_crowd(crowd, 0, CROWD);
    scenes_commit(crowd);
    for (int k = 0; k < CROWD / 4; k++) {
        add_crowd(alone[k] = scene_create(), 4 * k, 4 * k + 4);
        scenes_commit(alone[k]);
    }
    int met = 0;
    for (uint64_t i = 0; i < 5000; i++) {
        struct vec3 from = scale(scenes_direction(1200, i), 5), to = scale(scenes_direction(1201, i), 2);
        struct ray ray = {from, normalize(sub(to, from)), 0.5f, 6, RAY_CAMERA};
        struct light_point all[CROWD], few[4];
        int count = scene_lamps_along(crowd, &ray, all, CROWD), expected = 0;
        for (int k = 0; k < CROWD / 4; k++)
            for (int f = scene_lamps_along(alone[k], &ray, few, 4); f > 0; f--, expected++) {
                const char *name = scene_light_name(alone[k], few[f - 1].light);
                bool found = false;
                for (int j = 0; j < count; j++)
                    found = found || (strcmp(scene_light_name(crowd, all[j].light), name) == 0 &&
                                      length(sub(all[j].position, few[f - 1].position)) < 1e-5f);
                assert_true(found);
            }
        assert_int_equal(count, expected);
        for (int j = 0; j < count; j++) {
            float t = dot(sub(all[j].position, from), ray.direction);
            assert_true(t > 0.5f - 1e-4f && t < 6 + 1e-4f && dot(all[j].normal, ray.direction) < 0);
            assert_true(j == 0 || t >= dot(sub(all[j - 1].position, from), ray.direction) - 1e-4f);
        }
        met += count;
    }
    assert_true(met > 2000);
    for (int k = 0; k < CROWD / 4; k++)
        scene_destroy(alone[k]);
    scene_destroy(crowd);
}

static void lights_hidden_from_the_camera_are_seen_by_others_alone(void **state)
{
    (void)state;
    struct scene *scene = scene_create();
    struct light_input lamp = {.name = "lamp",
                               .shape = LIGHT_SPHERE,
                               .radius = 1,
                               .transform = scenes_identity,
                               .emission = scenes_emission(1),
                               .visible = scenes_visible};
    struct world_input world = {.emission = scenes_emission(1), .visible = scenes_visible};
    lamp.visible.camera = world.visible.camera = false;
    assert_true(scene_add_light(scene, &lamp, NULL) && scene_set_world(scene, &world, NULL));
    scenes_commit(scene);
    for (uint32_t kind = RAY_CAMERA; kind <= RAY_TRANSMISSION; kind *= 2) {
        struct ray ray = {vec3(0, 0, 5), vec3(0, 0, -1), 0, INFINITY, kind};
        struct light_point point;
        assert_int_equal(scene_lamps_along(scene, &ray, &point, 1), kind != RAY_CAMERA);
        if (kind != RAY_CAMERA)
            assert_false(scene_light_seen_by_camera(scene, &point));
        assert_int_equal(scene_distant_along(scene, &ray, &point, 1), kind != RAY_CAMERA);
    }
    scene_destroy(scene);
}

/* A spot, two suns and the world, in a volume of all space with this extinction. */
static struct scene *lamps_in_fog(struct spectrum *extinction)
{
    struct scene *scene = scene_create();
    struct volume *fog = volume_create(NULL, extinction, 0);
    assert_true(fog && volume_finish(fog));
    const enum light_shape shapes[] = {LIGHT_SPOT, LIGHT_SUN, LIGHT_SUN};
    const char *names[] = {"spot", "sun", "sharp sun"};
    for (int i = 0; i < 3; i++)
        scenes_light(scene, (struct light_input){.name = names[i],
                                                 .shape = shapes[i],
                                                 .angle = (float)(2 - i),
                                                 .transform = scenes_identity,
                                                 .emission = scenes_emission(1)});
    struct world_input world = {.emission = scenes_emission(1), .visible = scenes_visible, .volume = fog};
    assert_true(scene_set_world(scene, &world, NULL));
    scenes_commit(scene);
    return scene;
}

static void lights_at_infinity_are_no_lights_where_nothing_of_them_arrives(void **state)
{
    (void)state;
    static const float at[] = {300, 500, 510, 830}, clears[] = {1, 1, 0, 0};
    const struct {
        struct spectrum *extinction;
        int lights;
    } fogs[] = {{spectrum_constant(SCENES_RANGE, 1e-6f), 1},
                {spectrum_constant(SCENES_RANGE, 0), 4},
                {spectrum_table(SCENES_RANGE, at, clears, 4, BEYOND_HOLD, "fog", NULL), 4}};
    for (size_t i = 0; i < 3; i++) {
        struct scene *scene = lamps_in_fog(fogs[i].extinction);
        struct scene_statistics told = scene_statistics(scene);
        assert_int_equal(told.lights, fogs[i].lights);
        assert_int_equal(told.lights_lost, 4 - fogs[i].lights);
        struct light_point point;
        struct ray ray = {vec3(0, 0, 5), vec3(0, 0, 1), 0, INFINITY, RAY_DIFFUSE};
        assert_int_equal(scene_distant_along(scene, &ray, &point, 1), fogs[i].lights > 1);
        float u[3] = {0.3f, 0.6f, 0.9f}, pdf;
        assert_true(scene_sample_light(scene, u, &point, &pdf));
        if (fogs[i].lights == 1) {
            assert_string_equal(scene_light_name(scene, point.light), "spot");
            assert_float_equal(pdf, 1, 0);
            /* And they are back once the volume is gone. */
            struct world_input world = {.emission = scenes_emission(1), .visible = scenes_visible};
            assert_true(scene_set_world(scene, &world, NULL));
            scenes_commit(scene);
            assert_int_equal(scene_light_count(scene), 4);
        }
        scene_destroy(scene);
    }
}

/* Radiance received at a point, once by rays in all directions that meet the lamp, once by points on it with
   G. */
static void rays_find_lamps_as_sampling_draws_them(void **state)
{
    (void)state;
    static const size_t kinds[] = {0, 1, 2, 5, 8, 9};
    struct batches met[6] = {0}, drawn[6] = {0};
    for (size_t k = 0; k < 6; k++) {
        struct scene *scene = lamps[kinds[k]].make();
        struct vec3 at = k < 4 ? vec3(0.2f, -0.4f, 0.9f) : vec3(-1, 1.6f, 4.9f);
        for (uint64_t b = 0; b < BATCHES; b++) {
            double by_rays = 0, by_points = 0;
            for (uint64_t i = 0; i < DRAWS; i++) {
                struct ray ray = {at, scenes_direction(800 + k, b * DRAWS + i), 0, INFINITY, RAY_DIFFUSE};
                struct light_point point;
                struct hit hit;
                const struct material *material;
                float u[3], pdf;
                bool found = scene_lamps_along(scene, &ray, &point, 1) == 1;
                if (!found && scene_intersect(scene, &ray, &hit, &material) && hit.light >= 0) {
                    scene_light_point_at(scene, &hit, &point);
                    found = true;
                }
                if (found)
                    by_rays += 4 * M_PI * scene_light_emission(scene, &point, negate(ray.direction), LAMBDA);
                lamps_draw(900 + k, b * DRAWS + i, u, 3);
                scene_sample_light(scene, u, &point, &pdf);
                struct vec3 to_lamp = sub(point.position, at), direction = normalize(to_lamp);
                /* of the two triangles of the mesh one may hide the other */
                struct vec3 end =
                    point.on_mesh ? scene_offset(&point.hit, negate(direction)) : point.position;
                if (k < 4 || scene_visibility(scene, at, end, LAMBDA, RAY_SHADOW) > 0)
                    by_points += scene_light_emission(scene, &point, negate(direction), LAMBDA) *
                                 fabsf(dot(direction, point.normal)) / (length_squared(to_lamp) * pdf);
            }
            batches_add(&met[k], by_rays / DRAWS);
            batches_add(&drawn[k], by_points / DRAWS);
        }
        scene_destroy(scene);
    }
    assert_same(met, drawn, 6, (struct power){.sees_error = 0.12});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distant_lights_give_their_irradiance),
        cmocka_unit_test(world_density_integrates_to_one_and_covers_all_that_shines),
        cmocka_unit_test(world_images_are_laid_out_as_in_cycles),
        cmocka_unit_test(world_is_drawn_as_its_density_says),
        cmocka_unit_test(rays_see_a_sun_of_its_size),
        cmocka_unit_test(a_crowd_of_lamps_is_met_as_each_alone),
        cmocka_unit_test(lights_hidden_from_the_camera_are_seen_by_others_alone),
        cmocka_unit_test(lights_at_infinity_are_no_lights_where_nothing_of_them_arrives),
        cmocka_unit_test(rays_find_lamps_as_sampling_draws_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
