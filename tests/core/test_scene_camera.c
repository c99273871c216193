/* The camera: rays and connections are each other's inverse with one density, which integrates to 1 over the
   frame; lenses. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include "material/hit_mesh.h"
#include "scenes.h"
#include "statistics.h"

#include <cmocka.h>

#define WIDTH 64
#define HEIGHT 48
#define BATCHES 32
#define DRAWS 40000

static struct camera_input perspective(void)
{
    struct frame f = frame_about(normalize(vec3(0.4f, 0.6f, 0.2f)));
    return (struct camera_input){.transform = {{2 * f.s.x, 2 * f.t.x, 2 * f.n.x, 1, 2 * f.s.y, 2 * f.t.y,
                                                2 * f.n.y, -2, 2 * f.s.z, 2 * f.t.z, 2 * f.n.z, 0.5f}},
                                 .frame = {-0.9f, 0.5f, -0.3f, 0.8f},
                                 .resolution = {WIDTH, HEIGHT},
                                 .border = {3, 4, 20, 30},
                                 .clip = {0.1f, 100},
                                 .focus_distance = 4,
                                 .aspect = 1};
}

static struct camera_input with_lens(int blades)
{
    struct camera_input camera = perspective();
    camera.lens_radius = 0.3f;
    camera.blades = blades;
    camera.blade_rotation = 0.4f;
    camera.aspect = 1.5f;
    return camera;
}

static struct camera_input orthographic(void)
{
    struct camera_input camera = perspective();
    camera.orthographic = true;
    return camera;
}

static struct camera_input orthographic_with_lens(int blades)
{
    struct camera_input camera = with_lens(blades);
    camera.orthographic = true;
    return camera;
}

static struct scene *make(struct camera_input camera)
{
    stokes_error err;
    struct scene *scene = scene_create();
    assert_true(scene_set_camera(scene, &camera, &err));
    scenes_commit(scene);
    return scene;
}

static void draw(uint64_t seed, uint64_t i, float *u, uint64_t count)
{
    for (uint64_t k = 0; k < count; k++)
        u[k] = (float)independent(seed, i * count + k);
}

static const struct transform wide = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};

static void connections_invert_rays(void **state)
{
    (void)state;
    struct camera_input cameras[] = {perspective(), with_lens(0),   with_lens(3),
                                     with_lens(6),  orthographic(), orthographic_with_lens(0)};
    for (size_t k = 0; k < sizeof cameras / sizeof *cameras; k++) {
        struct scene *scene = make(cameras[k]);
        for (uint64_t i = 0; i < 5000; i++) {
            float u[5], pdf, pdf_back, film[2];
            struct camera_point lens, back;
            draw(k, i, u, 5);
            float x = u[0] * WIDTH, y = u[1] * HEIGHT;
            struct ray ray = scene_camera_ray(scene, x, y, u + 2, &lens, &pdf);
            struct vec3 from =
                along(ray.origin, ray.direction, ray.near + u[4] * fminf(ray.far - ray.near, 30) + 0.01f);
            assert_true(scene_camera_connect(scene, from, 1, u + 2, &back, film, &pdf_back));
            assert_float_equal(film[0], x, 1e-3);
            assert_float_equal(film[1], y, 1e-3);
            assert_float_equal(pdf_back / pdf, 1, 1e-4);
            assert_true(length(sub(back.position, lens.position)) < 1e-4f);
            assert_true(length(sub(back.axis, lens.axis)) == 0);
            if (cameras[k].orthographic)
                assert_true(length(sub(ray.direction, lens.axis)) == 0);
        }
        scene_destroy(scene);
    }
}

/* ∫ over directions of the density of those that fall inside the frame, per projected solid angle: uniform
   directions. */
static void density_integrates_to_one_over_the_frame(void **state)
{
    (void)state;
    struct camera_input cameras[] = {perspective(), with_lens(0), with_lens(5)};
    struct batches found[3] = {0};
    double exact[3] = {1, 1, 1};
    for (size_t k = 0; k < 3; k++) {
        struct scene *scene = make(cameras[k]);
        for (uint64_t b = 0; b < BATCHES; b++) {
            double sum = 0;
            for (uint64_t i = 0; i < DRAWS; i++) {
                float u[2], film[2], pdf;
                struct camera_point lens;
                draw(20 + k, b * DRAWS + i, u, 2);
                /* the lens point is known before the direction, so aim from it */
                scene_camera_ray(scene, 0, 0, u, &lens, &pdf);
                struct vec3 d = scenes_direction(30 + k, b * DRAWS + i);
                if (scene_camera_connect(scene, along(lens.position, d, 20), 0, u, &lens, film, &pdf))
                    sum += pdf * dot(d, lens.axis);
            }
            batches_add(&found[k], 4 * M_PI * sum / DRAWS);
        }
        scene_destroy(scene);
    }
    assert_unbiased(found, exact, 3, (struct power){.sees_error = 0.05});
}

/* Rays of uniform film points have the density that they state: ∫ over the frame of projected solid angle is
   the mean of 1/pdf over them, and counts uniform directions that connect. */
static void rays_are_drawn_with_their_density(void **state)
{
    (void)state;
    struct scene *scene = make(with_lens(0));
    struct batches drawn = {0}, uniform = {0};
    for (uint64_t b = 0; b < BATCHES; b++) {
        double by_rays = 0, by_directions = 0;
        for (uint64_t i = 0; i < DRAWS; i++) {
            float u[4], film[2], pdf;
            struct camera_point lens;
            draw(40, b * DRAWS + i, u, 4);
            scene_camera_ray(scene, u[0] * WIDTH, u[1] * HEIGHT, u + 2, &lens, &pdf);
            by_rays += 1 / (double)pdf;
            struct vec3 d = scenes_direction(41, b * DRAWS + i);
            if (scene_camera_connect(scene, along(lens.position, d, 20), 0, u + 2, &lens, film, &pdf))
                by_directions += 4 * M_PI * dot(d, lens.axis);
        }
        batches_add(&drawn, by_rays / DRAWS);
        batches_add(&uniform, by_directions / DRAWS);
    }
    assert_same(&drawn, &uniform, 1, (struct power){.sees_error = 0.05});
    scene_destroy(scene);
}

/* All rays of one film point meet where it is in focus. */
static void lens_rays_meet_in_the_plane_of_focus(void **state)
{
    (void)state;
    struct scene *lens = make(with_lens(0)), *pinhole = make(perspective());
    for (uint64_t i = 0; i < 1000; i++) {
        float u[4], pdf;
        struct camera_point on_lens, centre;
        draw(50, i, u, 4);
        struct ray a = scene_camera_ray(lens, u[0] * WIDTH, u[1] * HEIGHT, u + 2, &on_lens, &pdf);
        struct ray b = scene_camera_ray(pinhole, u[0] * WIDTH, u[1] * HEIGHT, u + 2, &centre, &pdf);
        struct vec3 at_a = along(a.origin, a.direction, 4 / dot(a.direction, on_lens.axis));
        struct vec3 at_b = along(b.origin, b.direction, 4 / dot(b.direction, centre.axis));
        assert_true(length(sub(at_a, at_b)) < 1e-5f);
    }
    scene_destroy(lens);
    scene_destroy(pinhole);
}

/* The same of an orthographic camera; and each point of its lens sees all film points in one direction. */
static void orthographic_lens_rays_meet_in_the_plane_of_focus(void **state)
{
    (void)state;
    struct scene *lens = make(orthographic_with_lens(5)), *plain = make(orthographic());
    float furthest = 0;
    for (uint64_t i = 0; i < 1000; i++) {
        float u[4], pdf;
        struct camera_point on_lens, centre, elsewhere;
        draw(52, i, u, 4);
        struct ray a = scene_camera_ray(lens, u[0] * WIDTH, u[1] * HEIGHT, u + 2, &on_lens, &pdf);
        struct ray b = scene_camera_ray(plain, u[0] * WIDTH, u[1] * HEIGHT, u + 2, &centre, &pdf);
        struct ray c = scene_camera_ray(lens, u[1] * WIDTH, u[0] * HEIGHT, u + 2, &elsewhere, &pdf);
        float to_focus = 4 - 0.1f; /* from the near plane */
        struct vec3 at_a = along(a.origin, a.direction, to_focus / dot(a.direction, b.direction));
        struct vec3 at_b = along(b.origin, b.direction, to_focus);
        assert_true(length(sub(at_a, at_b)) < 1e-5f);
        assert_true(length(sub(a.direction, c.direction)) == 0);
        furthest = fmaxf(furthest, length(sub(a.origin, b.origin)));
    }
    assert_true(furthest > 0.25f && furthest < 0.3f); /* the lens' radius */
    scene_destroy(lens);
    scene_destroy(plain);
}

/* ∫ of the density over a plane across the direction of one lens point is 1. */
static void orthographic_density_integrates_to_one_across_the_direction(void **state)
{
    (void)state;
    struct scene *scene = make(orthographic_with_lens(0));
    struct batches found = {0};
    double exact = 1;
    for (uint64_t b = 0; b < BATCHES; b++) {
        double sum = 0;
        for (uint64_t i = 0; i < DRAWS / 4; i++) {
            float u[4], film[2], pdf;
            struct camera_point lens;
            draw(54, b * DRAWS + i, u, 4);
            scene_camera_ray(scene, WIDTH / 2, HEIGHT / 2, u + 2, &lens, &pdf);
            struct frame across = frame_about(lens.axis);
            struct vec3 centre = along(lens.position, lens.axis, 6);
            struct vec3 from = along(along(centre, across.s, 2 * u[0] - 1), across.t, 2 * u[1] - 1);
            if (scene_camera_connect(scene, from, 0, u + 2, &lens, film, &pdf))
                sum += (double)pdf * 4;
        }
        batches_add(&found, sum / (DRAWS / 4));
    }
    assert_unbiased(&found, &exact, 1, (struct power){.sees_error = 0.03});
    scene_destroy(scene);
}

/* Lens points are uniform over a disk squeezed by the aspect, or over a polygon in it: second moments, and no
   point outside. */
static void lens_points_fill_their_aperture(void **state)
{
    (void)state;
    static const int blades[] = {0, 3, 6};
    for (int k = 0; k < 3; k++) {
        struct scene *scene = make(with_lens(blades[k]));
        const struct camera_input in = with_lens(blades[k]);
        const float *m = in.transform.m;
        struct batches moment[2] = {0};
        /* of the unit disk 1/4; of a regular n-gon with corners at 1: (2 + cos(2π/n))/12 each */
        double each = blades[k] ? (2 + cos(2 * M_PI / blades[k])) / 12 : 0.25;
        double exact[2] = {each, each};
        for (uint64_t b = 0; b < BATCHES; b++) {
            double sum[2] = {0};
            for (uint64_t i = 0; i < DRAWS / 4; i++) {
                float u[2], pdf;
                struct camera_point lens;
                draw(60 + (uint64_t)k, b * DRAWS + i, u, 2);
                scene_camera_ray(scene, 1, 1, u, &lens, &pdf);
                struct vec3 p = sub(lens.position, vec3(m[3], m[7], m[11]));
                double x = dot(p, vec3(m[0], m[4], m[8])) / 2 / 0.3 * 1.5,
                       y = dot(p, vec3(m[1], m[5], m[9])) / 2 / 0.3;
                assert_true(x * x + y * y < 1 + 1e-5);
                sum[0] += x * x;
                sum[1] += y * y;
            }
            for (int c = 0; c < 2; c++)
                batches_add(&moment[c], sum[c] / (DRAWS / 4));
        }
        assert_unbiased(moment, exact, 2, (struct power){.sees_error = 0.03});
        scene_destroy(scene);
    }
}

/* Window coordinates of a hit are where its pixel lies in the frame, 0 … 1. */
static void window_coordinates_are_the_film_point(void **state)
{
    (void)state;
    struct camera_input cameras[] = {perspective(), orthographic()};
    for (size_t k = 0; k < 2; k++) {
        struct scene *scene = scene_create();
        struct vec3 center = vec3(1, -2, 0.5f), axis = normalize(vec3(-0.4f, -0.6f, -0.2f));
        struct frame f = frame_about(normalize(vec3(0.3f, 0.9f, 0.5f)));
        struct vec3 pane[3];
        for (int i = 0; i < 3; i++) {
            float phi = 2 * PI_F * (float)i / 3;
            pane[i] = along(along(along(center, axis, 5), f.s, 60 * cosf(phi)), f.t, 60 * sinf(phi));
        }
        scenes_mesh(scene, "pane", pane, 1);
        scenes_instance(scene, "pane", "pane", "", &scenes_identity, 1);
        assert_true(scene_set_camera(scene, &cameras[k], NULL));
        scenes_commit(scene);
        for (uint64_t i = 0; i < 500; i++) {
            float u[4], pdf;
            struct camera_point lens;
            struct hit hit;
            const struct material *material;
            const struct texture window = {.projection = TEXTURE_WINDOW};
            draw(70, i, u, 4);
            struct ray ray = scene_camera_ray(scene, u[0] * WIDTH, u[1] * HEIGHT, u + 2, &lens, &pdf);
            assert_true(scene_intersect(scene, &ray, &hit, &material));
            struct vec3 at = hit_coordinates(&hit, &window);
            assert_float_equal(at.x, u[0], 1e-4);
            assert_float_equal(at.y, u[1], 1e-4);
        }
        scene_destroy(scene);
    }
}

static void scale_of_the_transform_does_not_matter_but_mirroring_does(void **state)
{
    (void)state;
    struct camera_input in = perspective();
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        in.transform = (struct transform){{mirrored ? -3 : 3, 0, 0, 0, 0, 2, 0, 0, 0, 0, 5, 0}};
        struct scene *scene = make(in);
        float u[2] = {0, 0}, pdf;
        struct camera_point lens;
        struct ray ray = scene_camera_ray(scene, WIDTH, HEIGHT, u, &lens, &pdf);
        struct vec3 expected = normalize(vec3(mirrored ? -0.5f : 0.5f, 0.8f, -1));
        assert_true(length(sub(ray.direction, expected)) < 1e-6f);
        scene_destroy(scene);
    }
}

static void points_outside_frame_or_clip_range_do_not_connect(void **state)
{
    (void)state;
    struct camera_input in = perspective();
    in.transform = wide; /* looks along −z from the origin; pixels are 1.4/64 wide at distance 1 */
    struct scene *scene = make(in);
    float u[2] = {0, 0}, film[2], pdf;
    struct camera_point lens;
    assert_true(scene_camera_connect(scene, vec3(0, 0, -1), 0, u, &lens, film, &pdf));
    assert_false(scene_camera_connect(scene, vec3(0, 0, 1), 0, u, &lens, film, &pdf));
    assert_false(scene_camera_connect(scene, vec3(0, 0, -0.05f), 0, u, &lens, film, &pdf));
    assert_false(scene_camera_connect(scene, vec3(0, 0, -101), 0, u, &lens, film, &pdf));
    assert_false(scene_camera_connect(scene, vec3(0.51f, 0, -1), 0, u, &lens, film, &pdf));
    assert_true(scene_camera_connect(scene, vec3(0.51f, 0, -1), 1, u, &lens, film, &pdf));
    assert_false(scene_camera_connect(scene, vec3(-1.0f, 0, -1), 1, u, &lens, film, &pdf));
    int full[2], border[4];
    scene_camera_size(scene, full, border);
    assert_int_equal(full[0], WIDTH);
    assert_int_equal(border[3], 30);
    scene_destroy(scene);
}

static void bad_cameras_name_what_is_wrong(void **state)
{
    (void)state;
    struct camera_input bad[5] = {perspective(), perspective(), perspective(), with_lens(0), perspective()};
    static const char *const property[5] = {"frame", "clip", "border", "focus_distance", "transform"};
    bad[0].frame[1] = -0.9f;
    bad[1].clip[1] = 0.05f;
    bad[2].border[2] = WIDTH + 1;
    bad[3].focus_distance = 0;
    for (int i = 0; i < 12; i++)
        bad[4].transform.m[i] = 0;
    struct scene *scene = scene_create();
    for (int i = 0; i < 5; i++) {
        stokes_error err = {0};
        assert_false(scene_set_camera(scene, &bad[i], &err));
        assert_string_equal(err.property, property[i]);
    }
    scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(connections_invert_rays),
        cmocka_unit_test(density_integrates_to_one_over_the_frame),
        cmocka_unit_test(rays_are_drawn_with_their_density),
        cmocka_unit_test(lens_rays_meet_in_the_plane_of_focus),
        cmocka_unit_test(orthographic_lens_rays_meet_in_the_plane_of_focus),
        cmocka_unit_test(orthographic_density_integrates_to_one_across_the_direction),
        cmocka_unit_test(lens_points_fill_their_aperture),
        cmocka_unit_test(window_coordinates_are_the_film_point),
        cmocka_unit_test(scale_of_the_transform_does_not_matter_but_mirroring_does),
        cmocka_unit_test(points_outside_frame_or_clip_range_do_not_connect),
        cmocka_unit_test(bad_cameras_name_what_is_wrong),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
