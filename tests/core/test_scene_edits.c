/* Editing: changes show after the next commit, in what they concern and nowhere else, and their order does
   not matter. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scenes.h"
#include "statistics.h"

#include <cmocka.h>

/* A quad of two triangles over [0,2] × [0,1] in the plane z = 0. */
static void add_quad(struct scene *scene)
{
    struct vec3 points[6] = {vec3(0, 0, 0), vec3(2, 0, 0), vec3(2, 1, 0),
                             vec3(0, 0, 0), vec3(2, 1, 0), vec3(0, 1, 0)};
    scenes_mesh(scene, "quad", points, 2);
}

static bool look_down(const struct scene *scene, float x, float y, struct hit *hit,
                      const struct material **material)
{
    struct ray ray = {vec3(x, y, 5), vec3(0, 0, -1), 0, INFINITY, RAY_CAMERA};
    return scene_intersect(scene, &ray, hit, material);
}

static const char *seen(const struct scene *scene, float x, float y)
{
    struct hit hit;
    const struct material *material;
    return look_down(scene, x, y, &hit, &material) ? material_name(material) : "nothing";
}

static struct closure *textured_emitter(const struct image *image, const char *layer)
{
    struct closure *closure = scenes_emitter(1, true);
    emission_node_destroy(closure->emission);
    closure->emission = scenes_texture_emission(image, 1);
    closure->emission->two_sided = true;
    strcpy(closure->emission->texture->uv_name, layer);
    return closure;
}

static void edits_show_after_the_next_commit(void **state)
{
    (void)state;
    struct scene *scene = scene_create();
    struct transform moved = scenes_identity;
    moved.m[3] = 10;
    add_quad(scene);
    scenes_material(scene, "one", scenes_grey());
    scenes_material(scene, "two", scenes_grey());
    scenes_instance(scene, "thing", "quad", "one", &scenes_identity, 1);
    scenes_commit(scene);
    assert_string_equal(seen(scene, 1, 0.2f), "one");
    scenes_instance(scene, "thing", "quad", "two", &moved, 1);
    scenes_commit(scene);
    assert_string_equal(seen(scene, 1, 0.2f), "nothing");
    assert_string_equal(seen(scene, 11, 0.2f), "two");
    scenes_material(scene, "two", scenes_emitter(1, true));
    scenes_commit(scene);
    assert_int_equal(scene_light_count(scene), 1);
    assert_string_equal(scene_light_name(scene, 0), "thing");
    assert_true(scene_remove(scene, "instances", "thing", NULL));
    scenes_commit(scene);
    assert_string_equal(seen(scene, 11, 0.2f), "nothing");
    assert_int_equal(scene_light_count(scene), 0);
    assert_false(scene_remove(scene, "instances", "thing", NULL));
    assert_false(scene_remove(scene, "planets", "thing", NULL));
    scene_destroy(scene);
}

static bool stop_at(void *user)
{
    int *left = user;
    return --*left < 0;
}

/* However far it came, a commit that was stopped is taken up by the next. */
static void a_stopped_commit_is_taken_up_by_the_next(void **state)
{
    (void)state;
    enum { SIDE = 300 };
    struct vec3 *points = malloc(3 * SIDE * SIDE * sizeof *points);
    for (int i = 0; i < SIDE * SIDE; i++) {
        struct vec3 at = vec3((float)(i % SIDE), (float)(i / SIDE), 0);
        points[3 * i] = at;
        points[3 * i + 1] = add(at, vec3(1, 0, 0));
        points[3 * i + 2] = add(at, vec3(0, 1, 0));
    }
    struct transform transforms[2] = {scenes_identity, scenes_identity};
    transforms[1].m[11] = -1;
    struct scene *scene = scene_create();
    scenes_mesh(scene, "grid", points, SIDE * SIDE);
    free(points);
    scenes_instance(scene, "grid", "grid", "", transforms, 2);
    add_quad(scene);
    scenes_instance(scene, "quad", "quad", "", &scenes_identity, 1);
    for (int steps = 0; steps < 4; steps++) {
        int left = steps;
        stokes_error err = {0};
        struct scene_setup setup = {.range = SCENES_RANGE, .threads = 1, .user = &left, .stop = stop_at};
        working_space_rec709(&setup.working_space);
        if (!scene_commit(scene, &setup, &err))
            assert_string_equal(err.text, "cancelled");
        assert_true(steps > 0 || err.text[0]);
    }
    scenes_commit(scene);
    assert_string_equal(seen(scene, 250.2f, 17.2f), "default material");
    assert_string_equal(seen(scene, 250.8f, 17.9f), "nothing");
    scene_destroy(scene);
}

static void an_image_sent_again_shows_in_the_materials_that_use_it(void **state)
{
    (void)state;
    static const float black[1] = {0}, white[1] = {1};
    struct scene *scene = scene_create();
    struct image *image = image_create("picture", 1, 1, 1, false, white, sizeof white, NULL);
    struct hit hit;
    const struct material *material;
    assert_true(scene_add_image(scene, image, NULL));
    add_quad(scene);
    scenes_material(scene, "light", textured_emitter(scene_find_image(scene, "picture"), ""));
    scenes_instance(scene, "quad", "quad", "light", &scenes_identity, 1);
    for (int pass = 0; pass < 3; pass++) {
        if (pass == 1)
            assert_true(scene_add_image(
                scene, image_create("picture", 1, 1, 1, false, black, sizeof black, NULL), NULL));
        if (pass == 2) {
            assert_true(scene_remove(scene, "image", "picture", NULL));
            assert_null(scene_find_image(scene, "picture"));
            scenes_commit(scene);
            assert_true(scene_add_image(
                scene, image_create("picture", 1, 1, 1, false, white, sizeof white, NULL), NULL));
        }
        scenes_commit(scene);
        assert_true(look_down(scene, 1, 0.2f, &hit, &material));
        assert_int_equal(material_emission(material, &hit, vec3(0, 0, 1), 550) > 0, pass != 1);
    }
    scene_destroy(scene);
}

/* What a scene answers depends on what is in it, not on the order in which it came. */
static void order_of_messages_changes_nothing(void **state)
{
    (void)state;
    struct scene *scenes[2];
    for (int order = 0; order < 2; order++) {
        scenes[order] = scene_create();
        for (int i = 0; i < 40; i++) {
            char name[32];
            struct transform transform = scenes_identity;
            int k = order ? 39 - i : i;
            transform.m[11] = (float)k;
            snprintf(name, sizeof name, "lamp %d", k);
            scenes_light(scenes[order], (struct light_input){.name = name,
                                                             .shape = LIGHT_SPHERE,
                                                             .radius = 0.3f,
                                                             .transform = transform,
                                                             .emission = scenes_emission((float)k + 1)});
        }
        for (int k = 0; order && k < 40; k += 3) { /* send some again */
            char name[32];
            struct transform transform = scenes_identity;
            transform.m[11] = (float)k;
            snprintf(name, sizeof name, "lamp %d", k);
            assert_true(scene_remove(scenes[1], "light", name, NULL));
            scenes_light(scenes[1], (struct light_input){.name = name,
                                                         .shape = LIGHT_SPHERE,
                                                         .radius = 0.3f,
                                                         .transform = transform,
                                                         .emission = scenes_emission((float)k + 1)});
        }
        scenes_commit(scenes[order]);
    }
    for (uint64_t i = 0; i < 500; i++) {
        struct light_point a, b;
        float u[3] = {(float)independent(9, 3 * i), (float)independent(9, 3 * i + 1),
                      (float)independent(9, 3 * i + 2)},
              p, q;
        assert_true(scene_sample_light(scenes[0], u, &a, &p) && scene_sample_light(scenes[1], u, &b, &q));
        assert_true(p == q && a.light == b.light && a.position.z == b.position.z);
    }
    /* 40 lamps one above the other, all met by a ray, nearest first */
    struct light_point points[64];
    struct ray ray = {vec3(0, 0, 50), vec3(0, 0, -1), 0, 20.2f, RAY_CAMERA};
    assert_int_equal(scene_lamps_along(scenes[0], &ray, points, 64), 10);
    for (int i = 0; i < 10; i++)
        assert_float_equal(points[i].position.z, 39 - i + 0.3f, 1e-4);
    assert_int_equal(scene_lamps_along(scenes[0], &ray, points, 3), 3);
    assert_float_equal(points[2].position.z, 37.3f, 1e-4);
    scene_destroy(scenes[0]);
    scene_destroy(scenes[1]);
}

static void lights_are_chosen_by_power(void **state)
{
    (void)state;
    struct scene *scene = scene_create();
    for (int k = 0; k < 4; k++) {
        char name[16];
        snprintf(name, sizeof name, "%d", k);
        scenes_light(scene, (struct light_input){.name = name,
                                                 .shape = LIGHT_POINT,
                                                 .transform = scenes_identity,
                                                 .emission = scenes_emission((float)(1 << k))});
    }
    scenes_commit(scene);
    for (int k = 0; k < 4; k++)
        assert_float_equal(scene_pdf_light(scene, &(struct light_point){.light = k}), (1 << k) / 15.0, 1e-6);
    const struct spectrum *lamps = scene_lamp_spectrum(scene);
    assert_float_equal(spectrum_pdf(lamps, 500) * 530, 1, 1e-5);
    scene_destroy(scene);
}

/* Of 30 lamps every third is daylight, the others are flat; brightness sets each apart. */
static void lights_of_one_shape_share_their_spectrum(void **state)
{
    (void)state;
    struct scene *scene = scene_create();
    for (int k = 0; k < 30; k++) {
        char name[16];
        snprintf(name, sizeof name, "%d", k);
        struct emission_node *emission = scenes_emission((float)k + 1);
        if (k % 3 == 1) {
            struct spectrum *daylight = spectrum_illuminant(SCENES_RANGE, "D65", name, NULL);
            spectrum_destroy(emission->spectrum);
            emission->spectrum = spectrum_scaled(daylight, 0.1f * (float)(k + 1));
            spectrum_destroy(daylight);
        }
        scenes_light(scene, (struct light_input){.name = name,
                                                 .shape = LIGHT_POINT,
                                                 .transform = scenes_identity,
                                                 .emission = emission});
    }
    scenes_commit(scene);
    assert_int_equal(scene_light_shape_count(scene), 2);
    for (int i = 0; i < 30; i++) {
        const struct spectrum *spectrum = scene_light_spectrum(scene, i);
        bool is_daylight = atoi(scene_light_name(scene, i)) % 3 == 1;
        assert_int_equal(spectrum_eval(spectrum, 400) > 1.5f * spectrum_eval(spectrum, 300), is_daylight);
        for (int j = 0; j < i; j++)
            assert_int_equal(spectrum == scene_light_spectrum(scene, j),
                             scene_light_shape(scene, i) == scene_light_shape(scene, j));
    }
    scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edits_show_after_the_next_commit),
        cmocka_unit_test(a_stopped_commit_is_taken_up_by_the_next),
        cmocka_unit_test(an_image_sent_again_shows_in_the_materials_that_use_it),
        cmocka_unit_test(order_of_messages_changes_nothing),
        cmocka_unit_test(lights_are_chosen_by_power),
        cmocka_unit_test(lights_of_one_shape_share_their_spectrum),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
