/* Lights: every kind's densities integrate to 1 and are those that are drawn from, powers are the ones that
   physics gives, and rays find what sampling draws. Measures as in scene.h. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/random.h"
#include "scenes.h"
#include "statistics.h"

#include <cmocka.h>

#define LAMBDA 500.0f
#define PER_NM 0.01f
#define WIDTH 530.0 /* of Λ */
#define BATCHES 32
#define DRAWS 20000 /* in a batch */

/* --- One light of each kind -------------------------------------------------------------------------- */

/* What a light of spectral density PER_NM (radiance, intensity or irradiance) must do. */
struct sample_light {
    const char *name;
    struct scene *(*make)(void);
    double area;  /* ∫ over points of 1, i.e. the reciprocal of a uniform density; 0: not uniform */
    double power; /* per nm, of the light alone; 0: distant */
};

static struct transform tilted(float size)
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

static struct scene *make_rectangle(void)
{
    return with_lamp(
        (struct light_input){.shape = LIGHT_RECTANGLE, .transform = tilted(2), .size = {0.5f, 1.5f}});
}
static struct scene *make_ellipse(void)
{
    return with_lamp(
        (struct light_input){.shape = LIGHT_ELLIPSE, .transform = tilted(1), .size = {0.5f, 1.5f}});
}
static struct scene *make_sphere(void)
{
    return with_lamp((struct light_input){.shape = LIGHT_SPHERE, .transform = tilted(1), .radius = 0.4f});
}
static struct scene *make_point(void)
{
    return with_lamp((struct light_input){.shape = LIGHT_POINT, .transform = tilted(1)});
}
static struct scene *make_spot(void)
{
    return with_lamp(
        (struct light_input){.shape = LIGHT_SPOT, .transform = tilted(1), .angle = 1.2f, .blend = 0.3f});
}
static struct scene *make_wide_spot(void)
{
    return with_lamp((struct light_input){
        .shape = LIGHT_SPOT, .transform = tilted(1), .angle = 1.2f, .blend = 0.3f, .radius = 0.4f});
}
static struct scene *make_sun(void)
{
    return with_lamp((struct light_input){.shape = LIGHT_SUN, .transform = tilted(1), .angle = 0.2f});
}
static struct scene *make_sharp_sun(void)
{
    return with_lamp((struct light_input){.shape = LIGHT_SUN, .transform = tilted(1)});
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
static struct scene *make_one_sided_mesh(void)
{
    return make_mesh(false, &stretched);
}
static struct scene *make_two_sided_mesh(void)
{
    return make_mesh(true, &stretched);
}
static struct scene *make_similar_mesh(void)
{
    struct transform transform = tilted(2);
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
static struct scene *make_constant_world(void)
{
    return with_world((struct world_input){.emission = scenes_emission(PER_NM)});
}
static struct scene *make_image_world(void)
{
    return with_world((struct world_input){.image = "sky", .scale = 2, .to_map = scenes_transform(3, 1, 0)});
}

#define CONE(half, blend) (2 * M_PI * (1 - cos(half)) * (1 - (blend) / 2))
static const struct sample_light lights[] = {
    {"rectangle", make_rectangle, 3, 3 * M_PI},
    {"ellipse", make_ellipse, 0.75 * M_PI / 4, 0.75 * M_PI / 4 * M_PI},
    {"sphere", make_sphere, 4 * M_PI * 0.16, 4 * M_PI * 0.16 * M_PI},
    {"point", make_point, 1, 4 * M_PI},
    {"spot", make_spot, 1, CONE(0.6, 0.3)},
    {"spot with a radius", make_wide_spot, 4 * M_PI * 0.16, M_PI * 0.16 * CONE(0.6, 0.3)},
    {"sun", make_sun, 2 * M_PI * 0.00499583472, 0},
    {"sharp sun", make_sharp_sun, 1, 0},
    {"one-sided mesh", make_one_sided_mesh, STRETCHED_AREA, STRETCHED_AREA *M_PI},
    {"two-sided mesh", make_two_sided_mesh, STRETCHED_AREA, STRETCHED_AREA * 2 * M_PI},
    {"mesh under a similarity", make_similar_mesh, 4 * (0.5 + 0.7071067812), 4 * (0.5 + 0.7071067812) * M_PI},
    {"constant world", make_constant_world, 4 * M_PI, 0},
    {"image world", make_image_world, 0, 0},
};
#define LIGHTS (sizeof lights / sizeof *lights)

static void draw_numbers(uint64_t seed, uint64_t i, float *u, uint64_t count)
{
    for (uint64_t k = 0; k < count; k++)
        u[k] = (float)independent(seed, i * count + k);
}

/* Estimators without variance are held against rounding (of sums of DRAWS floats), the others against
   statistics. */
static void assert_estimates(const struct batches *found, const double *exact, size_t count,
                             struct power power)
{
    struct batches noisy[LIGHTS];
    double exact_noisy[LIGHTS];
    size_t noisy_count = 0;
    for (size_t i = 0; i < count; i++)
        if (batches_error(&found[i]) > 1e-5 * exact[i]) {
            noisy[noisy_count] = found[i];
            exact_noisy[noisy_count++] = exact[i];
        } else {
            assert_float_equal(found[i].mean / exact[i], 1, 1e-5);
        }
    if (noisy_count)
        assert_unbiased(noisy, exact_noisy, noisy_count, power);
}

/* --- Claims ------------------------------------------------------------------------------------------ */

static void densities_are_those_that_are_drawn_from(void **state)
{
    (void)state;
    for (size_t k = 0; k < LIGHTS; k++) {
        struct scene *scene = lights[k].make();
        assert_int_equal(scene_light_count(scene), 1);
        for (uint64_t i = 0; i < 2000; i++) {
            float u[6], pdf_point, pdf_direction, pdf_lambda;
            struct light_point point;
            struct vec3 origin, direction;
            draw_numbers(k, i, u, 6);
            assert_true(scene_sample_light(scene, u, &point, &pdf_point));
            assert_float_equal(scene_pdf_light(scene, &point) / pdf_point, 1, 1e-5);
            if (lights[k].area > 0)
                assert_float_equal(pdf_point * lights[k].area, 1, 1e-4);
            float lambda = scene_sample_light_lambda(scene, &point, u[5], &pdf_lambda);
            assert_float_equal(scene_pdf_light_lambda(scene, &point, lambda) / pdf_lambda, 1, 1e-5);
            if (!scene_sample_light_direction(scene, &point, u + 3, &origin, &direction, &pdf_direction))
                continue;
            assert_float_equal(scene_pdf_light_direction(scene, &point, direction) / pdf_direction, 1, 1e-5);
            assert_float_equal(length(direction), 1, 1e-5);
        }
        scene_destroy(scene);
    }
}

/* E[1/pdf over a set drawn otherwise]: directions uniform on the sphere, so ∫ pdf · cos dω = 4π E[pdf · cos]. */
static void direction_densities_integrate_to_one(void **state)
{
    (void)state;
    struct batches found[LIGHTS] = {0};
    double exact[LIGHTS];
    size_t count = 0;
    for (size_t k = 0; k < LIGHTS; k++) {
        struct scene *scene = lights[k].make();
        for (uint64_t b = 0; lights[k].power > 0 && b < BATCHES; b++) {
            double sum = 0;
            for (uint64_t i = 0; i < DRAWS; i++) {
                float u[3], pdf;
                struct light_point point;
                struct vec3 direction = scenes_direction(200 + k, b * DRAWS + i);
                draw_numbers(300 + k, b * DRAWS + i, u, 3);
                scene_sample_light(scene, u, &point, &pdf);
                sum += scene_pdf_light_direction(scene, &point, direction) *
                       (point.has_normal ? fabsf(dot(direction, point.normal)) : 1);
            }
            batches_add(&found[count], 4 * M_PI * sum / DRAWS);
        }
        if (lights[k].power > 0)
            /* half of the sphere's points cannot face a narrow cone's directions, which then are not drawn */
            exact[count++] = strcmp(lights[k].name, "spot with a radius") == 0 ? 0.5 : 1;
        scene_destroy(scene);
    }
    assert_estimates(found, exact, count, (struct power){.sees_error = 0.08});
}

static struct scene *make_stretched_spot(void)
{
    return with_lamp((struct light_input){
        .shape = LIGHT_SPOT, .transform = scenes_transform(11, 1, 1), .angle = 1.5f, .blend = 0.6f});
}

/* ∫ of emission, times a function that is not even in any direction, by drawn directions and by uniform ones. */
static void directions_are_drawn_with_their_density(void **state)
{
    (void)state;
    static struct scene *(*const make[])(void) = {make_rectangle, make_spot,           make_stretched_spot,
                                                  make_point,     make_two_sided_mesh, make_one_sided_mesh};
    enum { KINDS = sizeof make / sizeof *make };
    struct batches drawn[KINDS] = {0}, uniform[KINDS] = {0};
    for (size_t k = 0; k < KINDS; k++) {
        struct scene *scene = make[k]();
        for (uint64_t b = 0; b < BATCHES; b++) {
            double by_density = 0, by_all = 0;
            for (uint64_t i = 0; i < DRAWS; i++) {
                float u[5], pdf;
                struct light_point point;
                struct vec3 origin, d, all = scenes_direction(1000 + k, b * DRAWS + i);
                draw_numbers(1100 + k, b * DRAWS + i, u, 5);
                scene_sample_light(scene, u, &point, &pdf);
                if (scene_sample_light_direction(scene, &point, u + 3, &origin, &d, &pdf)) {
                    float cosine = point.has_normal ? fabsf(dot(d, point.normal)) : 1;
                    by_density += (1 + 0.5f * d.x - 0.3f * d.y + cosine) *
                                  scene_light_emission(scene, &point, d, LAMBDA) / pdf;
                }
                float cosine = point.has_normal ? fabsf(dot(all, point.normal)) : 1;
                by_all += (1 + 0.5f * all.x - 0.3f * all.y + cosine) * 4 * PI_F *
                          (point.has_normal ? cosine : 1) * scene_light_emission(scene, &point, all, LAMBDA);
            }
            batches_add(&drawn[k], by_density / DRAWS);
            batches_add(&uniform[k], by_all / DRAWS);
        }
        scene_destroy(scene);
    }
    assert_same(drawn, uniform, KINDS, (struct power){.sees_error = 0.1});
}

/* Cycles' smoothstep between the cone's rim and the cosine that `blend` says, for a cone of half-angle 0.6
   and blend 0.3. */
static void spots_fall_off_between_rim_and_blend(void **state)
{
    (void)state;
    struct scene *scene = make_spot();
    struct transform t = tilted(1);
    float u[3] = {0}, pdf;
    struct light_point point;
    assert_true(scene_sample_light(scene, u, &point, &pdf));
    static const struct {
        double part, value; /* of the way from the rim to the axis, in cosine */
    } steps[] = {{-0.01, 0},  {0.003, 0.0003 - 2e-6}, {0.075, 0.15625},
                 {0.15, 0.5}, {0.225, 0.84375},       {0.31, 1},
                 {0.99, 1}};
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        double z = cos(0.6) + steps[i].part * (1 - cos(0.6)), r = sqrt(1 - z * z);
        for (float phi = 0; phi < 6; phi += 1) {
            struct vec3 local = vec3((float)r * cosf(phi), (float)r * sinf(phi), (float)-z);
            assert_float_equal(scene_light_emission(scene, &point, transform_vector(&t, local), LAMBDA) /
                                   PER_NM,
                               steps[i].value, 2e-5);
        }
    }
    scene_destroy(scene);
}

/* Beside a lamp of known power, a light is chosen by its own; a distant light's falls on the cross-section of
   the scene. */
static void lights_are_chosen_by_the_power_that_physics_gives(void **state)
{
    (void)state;
    for (size_t k = 0; k < LIGHTS; k++) {
        if (lights[k].area == 0)
            continue;
        struct scene *scene = lights[k].make();
        struct vec3 center;
        float radius;
        scenes_light(scene, (struct light_input){.name = "~",
                                                 .shape = LIGHT_POINT,
                                                 .transform = scenes_identity,
                                                 .emission = scenes_emission(PER_NM)});
        scenes_commit(scene);
        scene_bounds(scene, &center, &radius);
        double section = M_PI * radius * radius,
               of_world = lights[k].make == make_constant_world ? 4 * M_PI : 1;
        double power = lights[k].power > 0 ? lights[k].power : section * of_world;
        for (uint64_t i = 0; i < 200; i++) {
            float u[3], pdf;
            struct light_point point;
            draw_numbers(150, i, u, 3);
            assert_true(scene_sample_light(scene, u, &point, &pdf));
            bool other = strcmp(scene_light_name(scene, point.light), "~") == 0;
            double chance = (other ? 4 * M_PI : power) / (power + 4 * M_PI);
            assert_float_equal(pdf * (other ? 1 : lights[k].area) / chance, 1, 1e-4);
        }
        scene_destroy(scene);
    }
}

/* Light that leaves: the mean of L cos / pdf over points and directions is the power that physics gives. */
static void emitted_power_is_what_physics_says(void **state)
{
    (void)state;
    struct batches found[LIGHTS] = {0};
    double exact[LIGHTS];
    size_t count = 0;
    for (size_t k = 0; k < LIGHTS; k++) {
        struct scene *scene = lights[k].make();
        for (uint64_t b = 0; lights[k].power > 0 && b < BATCHES; b++) {
            double sum = 0;
            for (uint64_t i = 0; i < DRAWS; i++) {
                float u[5], pdf_point, pdf_direction;
                struct light_point point;
                struct vec3 origin, direction;
                draw_numbers(400 + k, b * DRAWS + i, u, 5);
                if (scene_sample_light(scene, u, &point, &pdf_point) &&
                    scene_sample_light_direction(scene, &point, u + 3, &origin, &direction, &pdf_direction))
                    sum += scene_light_emission(scene, &point, direction, LAMBDA) /
                           ((double)pdf_point * pdf_direction);
            }
            batches_add(&found[count], sum / DRAWS);
        }
        if (lights[k].power > 0)
            exact[count++] = PER_NM * lights[k].power;
        scene_destroy(scene);
    }
    assert_estimates(found, exact, count, (struct power){.sees_error = 0.03});
}

/* A sun's irradiance is that of its message; a constant world of radiance L gives πL; directions' densities
   integrate to 1. */
static void distant_lights_give_their_irradiance(void **state)
{
    (void)state;
    static const struct {
        struct scene *(*make)(void);
        double irradiance;
    } cases[] = {{make_sun, PER_NM}, {make_sharp_sun, PER_NM}, {make_constant_world, M_PI * PER_NM}};
    struct vec3 up = normalize(vec3(0.3f, -0.5f, 0.7f)); /* tilted() */
    struct batches found[3] = {0};
    double exact[3];
    for (size_t k = 0; k < 3; k++) {
        struct scene *scene = cases[k].make();
        for (uint64_t b = 0; b < BATCHES; b++) {
            double sum = 0;
            for (uint64_t i = 0; i < DRAWS; i++) {
                float u[3], pdf;
                struct light_point point;
                draw_numbers(500 + k, b * DRAWS + i, u, 3);
                assert_true(scene_sample_light(scene, u, &point, &pdf) && point.distant);
                sum += scene_light_emission(scene, &point, negate(point.normal), LAMBDA) *
                       fmaxf(0, dot(point.normal, up)) / pdf;
            }
            batches_add(&found[k], sum / DRAWS);
        }
        exact[k] = cases[k].irradiance;
        scene_destroy(scene);
    }
    assert_estimates(found, exact, 2, (struct power){.sees_error = 0.001});
    assert_unbiased(found + 2, exact + 2, 1, (struct power){.sees_error = 0.02});
}

static void world_density_integrates_to_one_and_covers_all_that_shines(void **state)
{
    (void)state;
    struct scene *scene = make_image_world();
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
    struct scene *scene = make_image_world();
    struct batches drawn = {0}, uniform = {0};
    for (uint64_t b = 0; b < BATCHES; b++) {
        double by_density = 0, by_all = 0;
        for (uint64_t i = 0; i < DRAWS; i++) {
            float u[3], pdf;
            struct light_point point;
            struct vec3 d = scenes_direction(700, b * DRAWS + i);
            draw_numbers(701, b * DRAWS + i, u, 3);
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

/* Radiance received at a point, once by rays in all directions that meet the lamp, once by points on it with
   G. */
static void rays_find_lamps_as_sampling_draws_them(void **state)
{
    (void)state;
    static const size_t kinds[] = {0, 1, 2, 5, 8, 9};
    struct batches met[6] = {0}, drawn[6] = {0};
    for (size_t k = 0; k < 6; k++) {
        struct scene *scene = lights[kinds[k]].make();
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
                draw_numbers(900 + k, b * DRAWS + i, u, 3);
                scene_sample_light(scene, u, &point, &pdf);
                struct vec3 to_lamp = sub(point.position, at), direction = normalize(to_lamp);
                /* of the two triangles of the mesh one may hide the other */
                struct vec3 end =
                    point.on_mesh ? scene_offset(&point.hit, negate(direction)) : point.position;
                if (k < 4 || scene_visibility(scene, at, end, LAMBDA) > 0)
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
        cmocka_unit_test(densities_are_those_that_are_drawn_from),
        cmocka_unit_test(direction_densities_integrate_to_one),
        cmocka_unit_test(lights_are_chosen_by_the_power_that_physics_gives),
        cmocka_unit_test(directions_are_drawn_with_their_density),
        cmocka_unit_test(spots_fall_off_between_rim_and_blend),
        cmocka_unit_test(emitted_power_is_what_physics_says),
        cmocka_unit_test(distant_lights_give_their_irradiance),
        cmocka_unit_test(world_density_integrates_to_one_and_covers_all_that_shines),
        cmocka_unit_test(world_images_are_laid_out_as_in_cycles),
        cmocka_unit_test(world_is_drawn_as_its_density_says),
        cmocka_unit_test(rays_find_lamps_as_sampling_draws_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
