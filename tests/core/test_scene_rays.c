/* Rays against meshes: what scene_intersect and scene_visibility find is what exact geometry says. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include "scenes.h"
#include "statistics.h"

#include <cmocka.h>

#define TRIANGLES 60
#define COPIES 12
#define RAYS 20000

/* --- Brute force, in doubles ------------------------------------------------------------------------- */

struct brute_hit {
    double t, margin; /* margin: the smallest barycentric coordinate, how far from an edge */
    uint32_t triangle;
};

static double dot_d(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross_d(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void difference(struct vec3 a, struct vec3 b, double out[3])
{
    out[0] = (double)a.x - b.x;
    out[1] = (double)a.y - b.y;
    out[2] = (double)a.z - b.z;
}

/* Möller and Trumbore's test; false where the ray misses the triangle. */
static bool brute_triangle(const struct vec3 p[3], const struct ray *ray, double *t, double *margin)
{
    double d[3] = {ray->direction.x, ray->direction.y, ray->direction.z}, e1[3], e2[3], s[3], h[3], q[3];
    difference(p[1], p[0], e1);
    difference(p[2], p[0], e2);
    difference(ray->origin, p[0], s);
    cross_d(d, e2, h);
    double determinant = dot_d(e1, h);
    if (determinant == 0)
        return false;
    double u = dot_d(s, h) / determinant;
    cross_d(s, e1, q);
    double v = dot_d(d, q) / determinant;
    *t = dot_d(e2, q) / determinant;
    *margin = fmin(fmin(u, v), 1 - u - v);
    return *margin > -1e-4 && *t > 0;
}

/* The nearest hit; its margin is the least of all candidates', so that a near miss is known for one. */
static bool brute_force(const struct vec3 *points, uint32_t triangles, const struct ray *ray,
                        struct brute_hit *hit)
{
    *hit = (struct brute_hit){INFINITY, INFINITY, 0};
    bool found = false;
    double least = INFINITY;
    for (uint32_t i = 0; i < triangles; i++) {
        double t, margin;
        if (!brute_triangle(points + 3 * i, ray, &t, &margin))
            continue;
        least = fmin(least, fabs(margin));
        if (margin > 0 && t < hit->t) {
            *hit = (struct brute_hit){t, margin, i};
            found = true;
        }
    }
    hit->margin = least;
    return found;
}

/* --- Scenes ------------------------------------------------------------------------------------------ */

static void random_triangles(uint64_t seed, float size, struct vec3 *points)
{
    for (uint64_t i = 0; i < 3 * TRIANGLES; i++) {
        float c[3];
        for (uint64_t k = 0; k < 3; k++)
            c[k] = size * (2 * (float)independent(seed, 3 * (i / 3) + k) - 1) +
                   0.4f * size * (2 * (float)independent(seed + 1, 3 * i + k) - 1);
        points[i] = vec3(c[0], c[1], c[2]);
    }
}

struct placed {
    struct scene *scene;
    struct transform transform[COPIES];
    struct vec3 world[3 * TRIANGLES * COPIES];
};

/* One mesh placed `copies` times: one copy is flattened, several are instances. `stretch` flattens what the
   rest of the transform has turned: along z, and by as much the other way along x. */
static struct placed *place_stretched(uint32_t copies, float size, float reach, float stretch)
{
    struct placed *placed = calloc(1, sizeof *placed);
    struct vec3 local[3 * TRIANGLES];
    random_triangles(7, 1, local);
    placed->scene = scene_create();
    for (uint32_t c = 0; c < copies; c++) {
        placed->transform[c] = scenes_transform(100 + c, size, reach);
        for (int i = 0; i < 3; i++) {
            placed->transform[c].m[i] *= stretch;
            placed->transform[c].m[8 + i] /= stretch;
        }
        for (uint32_t i = 0; i < 3 * TRIANGLES; i++)
            placed->world[c * 3 * TRIANGLES + i] = transform_point(&placed->transform[c], local[i]);
    }
    scenes_mesh(placed->scene, "mesh", local, TRIANGLES);
    scenes_instance(placed->scene, "instances", "mesh", "", placed->transform, copies);
    scenes_commit(placed->scene);
    return placed;
}

static struct placed *place(uint32_t copies, float size, float reach)
{
    return place_stretched(copies, size, reach, 1);
}

static void unplace(struct placed *placed)
{
    scene_destroy(placed->scene);
    free(placed);
}

static struct ray random_ray(uint64_t i, float reach)
{
    struct vec3 from = scale(scenes_direction(31, i), reach);
    struct vec3 to = scale(scenes_direction(32, i), 0.5f * reach * (float)independent(33, i));
    return (struct ray){from, normalize(sub(to, from)), 0, INFINITY, RAY_CAMERA};
}

/* --- Claims ------------------------------------------------------------------------------------------ */

static void check_against_brute_force(uint32_t copies)
{
    struct placed *placed = place(copies, 1, copies > 1 ? 3 : 0);
    int hits = 0;
    for (uint64_t i = 0; i < RAYS / copies; i++) {
        struct ray ray = random_ray(i, 6);
        struct brute_hit brute;
        struct hit hit;
        const struct material *material;
        bool expected = brute_force(placed->world, TRIANGLES * copies, &ray, &brute);
        if (brute.margin < 1e-4) /* too near an edge to call */
            continue;
        assert_int_equal(expected, scene_intersect(placed->scene, &ray, &hit, &material));
        if (!expected)
            continue;
        hits++;
        assert_int_equal(brute.triangle, hit.instance * TRIANGLES + hit.primitive);
        double at[3], d[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
        difference(hit.position, ray.origin, at);
        for (int k = 0; k < 3; k++)
            at[k] -= brute.t * d[k];
        /* a grazing ray slides along the surface by the error over the cosine; the test of a triangle rounds,
           some eight times, by the ray's length too */
        double bound = hit.error + 8 * 0x1p-24 * brute.t;
        assert_true(sqrt(dot_d(at, at)) * fabsf(dot(ray.direction, hit.ng)) <= bound);
        assert_non_null(material);
    }
    assert_true(hits > RAYS / 10 / (int)copies);
    unplace(placed);
}

static void flattened_mesh_is_hit_where_brute_force_says(void **state)
{
    (void)state;
    check_against_brute_force(1);
}

static void instances_are_hit_where_brute_force_says(void **state)
{
    (void)state;
    check_against_brute_force(COPIES);
}

/* ng is the transformed plane's normal, on the side of the local winding's normal under the inverse
   transpose. */
static void normals_are_right_under_mirroring_transforms(void **state)
{
    (void)state;
    for (uint32_t copies = 1; copies <= COPIES; copies += COPIES - 1) {
        struct placed *placed = place(copies, 1, 3);
        for (uint64_t i = 0; i < 4000; i++) {
            struct ray ray = random_ray(i, 6);
            struct hit hit;
            const struct material *material;
            if (!scene_intersect(placed->scene, &ray, &hit, &material))
                continue;
            const struct vec3 *p = placed->world + 3 * (hit.instance * TRIANGLES + hit.primitive);
            struct vec3 normal = normalize(cross(sub(p[1], p[0]), sub(p[2], p[0])));
            bool mirrored = (100 + hit.instance) & 1;
            assert_float_equal(dot(hit.ng, normal), mirrored ? -1 : 1, 1e-4);
            assert_float_equal(length(hit.ng), 1, 1e-5);
            assert_memory_equal(&hit.ng, &hit.ns, sizeof hit.ng);
        }
        unplace(placed);
    }
}

static void check_offsets(const struct placed *placed, uint32_t copies, float size)
{
    int left = 0;
    for (uint64_t i = 0; i < 3000; i++) {
        const struct transform *transform = &placed->transform[(uint32_t)i % copies];
        struct vec3 target = transform_point(transform, scale(scenes_direction(5, i), 0.8f));
        struct vec3 from = along(target, scenes_direction(6, i), 5 * size);
        struct ray ray = {from, normalize(sub(target, from)), 0, INFINITY, RAY_CAMERA};
        struct hit hit, again;
        const struct material *material;
        if (!scene_intersect(placed->scene, &ray, &hit, &material))
            continue;
        struct vec3 away = scenes_direction(8, i);
        struct ray next = {scene_offset(&hit, away), away, 0, INFINITY, RAY_DIFFUSE};
        if (scene_intersect(placed->scene, &next, &again, &material))
            assert_false(again.primitive == hit.primitive && again.instance == hit.instance);
        assert_true(length(sub(next.origin, hit.position)) <=
                    1.01f * hit.error + 1e-6f * length(hit.position));
        left++;
    }
    assert_true(left > 100);
}

/* A ray that leaves a triangle by scene_offset does not meet that triangle again, near or far from the
   origin, small or large, flattened or not. */
static void offset_rays_never_hit_their_own_triangle(void **state)
{
    (void)state;
    static const float sizes[] = {1e-3f, 1, 1e3f}, reaches[] = {0, 10, 1e4f};
    for (uint32_t copies = 1; copies <= COPIES; copies += COPIES - 1)
        for (int k = 0; k < 9; k++) {
            struct placed *placed = place(copies, sizes[k / 3], reaches[k % 3]);
            check_offsets(placed, copies, sizes[k / 3]);
            unplace(placed);
            placed = place_stretched(copies, 1, reaches[k % 3], 100);
            check_offsets(placed, copies, 1);
            unplace(placed);
        }
}

/* The bound is small where coordinates are: some millionths of them. */
static void offsets_are_small(void **state)
{
    (void)state;
    for (uint32_t copies = 1; copies <= COPIES; copies += COPIES - 1) {
        struct placed *placed = place(copies, 1, 10);
        for (uint64_t i = 0; i < 3000; i++) {
            struct ray ray = random_ray(i, 20);
            struct hit hit;
            const struct material *material;
            if (scene_intersect(placed->scene, &ray, &hit, &material))
                assert_true(hit.error < 2e-4f);
        }
        unplace(placed);
    }
}

/* The segment between two surface points, offset from both, is open unless something lies between them. */
static void visibility_agrees_with_brute_force(void **state)
{
    (void)state;
    struct placed *placed = place(COPIES, 1, 3);
    int open = 0, blocked = 0;
    for (uint64_t i = 0; i < 2000; i++) {
        struct ray a = random_ray(2 * i, 6), b = random_ray(2 * i + 1, 6);
        struct hit hit_a, hit_b;
        const struct material *material;
        if (!scene_intersect(placed->scene, &a, &hit_a, &material) ||
            !scene_intersect(placed->scene, &b, &hit_b, &material))
            continue;
        struct vec3 between = sub(hit_b.position, hit_a.position);
        if (length(between) < 0.1f)
            continue;
        struct vec3 from = scene_offset(&hit_a, between), to = scene_offset(&hit_b, negate(between));
        struct ray ray = {from, normalize(sub(to, from)), 0, INFINITY, RAY_SHADOW};
        struct brute_hit brute;
        bool met = brute_force(placed->world, TRIANGLES * COPIES, &ray, &brute);
        double distance = length(sub(to, from));
        if (brute.margin < 1e-4 || (met && fabs(brute.t - distance) < 1e-3))
            brute.t = met && brute.t < distance - 1e-3 ? brute.t : INFINITY;
        if (brute.margin < 1e-4)
            continue;
        bool expected_open = !(met && brute.t < distance);
        assert_true(scene_visibility(placed->scene, from, to, 500, RAY_SHADOW) == (expected_open ? 1 : 0));
        *(expected_open ? &open : &blocked) += 1;
    }
    assert_true(open > 50 && blocked > 50);
    unplace(placed);
}

/* Three parallel panes: transmittances multiply, order and direction do not matter, an opaque one blocks. */
static void transparent_panes_multiply_their_transmittances(void **state)
{
    (void)state;
    static const float colors[3] = {0.5f, 0.8f, 0.25f};
    static const char *const names[3] = {"a", "b", "c"};
    struct scene *scene = scene_create();
    for (int i = 0; i < 3; i++) {
        float z = (float)i;
        struct vec3 pane[3] = {vec3(-3, -3, z), vec3(3, -3, z), vec3(0, 4, z)};
        scenes_mesh(scene, names[i], pane, 1);
        scenes_material(scene, names[i], scenes_transparent(colors[i]));
        scenes_instance(scene, names[i], names[i], names[i], &scenes_identity, 1);
    }
    scenes_commit(scene);
    struct vec3 low = vec3(0.1f, 0.2f, -1), high = vec3(-0.3f, 0.1f, 3);
    assert_float_equal(scene_visibility(scene, low, high, 500, RAY_SHADOW), 0.1f, 1e-6);
    assert_float_equal(scene_visibility(scene, high, low, 500, RAY_SHADOW), 0.1f, 1e-6);
    assert_float_equal(scene_visibility(scene, low, vec3(0, 0, 1.5f), 500, RAY_SHADOW), 0.4f, 1e-6);
    assert_float_equal(scene_visibility_distant(scene, vec3(0, 0, 0.5f), vec3(0, 0, 1), 500, RAY_SHADOW),
                       0.2f, 1e-6);
    scenes_material(scene, "b", scenes_grey());
    scenes_commit(scene);
    assert_true(scene_visibility(scene, low, high, 500, RAY_SHADOW) == 0);
    assert_float_equal(scene_visibility(scene, low, vec3(0, 0, 0.5f), 500, RAY_SHADOW), 0.5f, 1e-6);
    scene_destroy(scene);
}

/* Transparent where it is faced, opaque where grazed: the transmittance of a pane of `facing` is the cosine. */
static void shadow_rays_see_panes_from_their_own_direction(void **state)
{
    (void)state;
    struct scene *scene = scene_create();
    struct vec3 pane[3] = {vec3(-9, -9, 0), vec3(9, -9, 0), vec3(0, 9, 0)};
    struct closure *mix = calloc(1, sizeof *mix);
    struct value_node *facing = calloc(1, sizeof *facing);
    *facing = (struct value_node){.kind = VALUE_FACING, .constant = 0.5f, .scale = 1};
    *mix = (struct closure){
        .kind = CLOSURE_MIX, .child = {scenes_transparent(1), scenes_grey()}, .factor = facing};
    scenes_mesh(scene, "pane", pane, 1);
    scenes_material(scene, "pane", mix);
    scenes_instance(scene, "pane", "pane", "pane", &scenes_identity, 1);
    scenes_commit(scene);
    for (float x = 0; x < 3; x += 0.5f) {
        float cosine = 2 / sqrtf(4 + 4 * x * x);
        assert_float_equal(scene_visibility(scene, vec3(-x, 0, -1), vec3(x, 0, 1), 500, RAY_SHADOW), cosine,
                           1e-5);
        assert_float_equal(scene_visibility(scene, vec3(x, 0, 1), vec3(-x, 0, -1), 500, RAY_SHADOW), cosine,
                           1e-5);
    }
    scene_destroy(scene);
}

static void visibility_flags_hide_objects_from_their_kind_of_ray_alone(void **state)
{
    (void)state;
    static const uint32_t kinds[] = {RAY_CAMERA,       RAY_DIFFUSE, RAY_GLOSSY,
                                     RAY_TRANSMISSION, RAY_SHADOW,  RAY_VOLUME};
    struct vec3 pane[3] = {vec3(-3, -3, 0), vec3(3, -3, 0), vec3(0, 4, 0)};
    for (int hidden = 0; hidden < 6; hidden++) {
        struct scene *scene = scene_create();
        bool flags[6] = {true, true, true, true, true, true};
        flags[hidden] = false;
        scenes_mesh(scene, "pane", pane, 1);
        struct instances_input in = {.name = "pane",
                                     .mesh = "pane",
                                     .transforms = scenes_identity.m,
                                     .transform_count = 1,
                                     .visible = {flags[0], flags[1], flags[2], flags[3], flags[4], flags[5]}};
        assert_true(scene_add_instances(scene, &in, NULL));
        scenes_commit(scene);
        for (int kind = 0; kind < 6; kind++) {
            struct ray ray = {vec3(0, 0, 1), vec3(0, 0, -1), 0, INFINITY, kinds[kind]};
            struct hit hit;
            const struct material *material;
            assert_int_equal(scene_intersect(scene, &ray, &hit, &material), kind != hidden);
            assert_true(scene_visibility(scene, vec3(0, 0, 1), vec3(0, 0, -1), 500, kinds[kind]) ==
                        (kind == hidden ? 1 : 0));
        }
        scene_destroy(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flattened_mesh_is_hit_where_brute_force_says),
        cmocka_unit_test(instances_are_hit_where_brute_force_says),
        cmocka_unit_test(normals_are_right_under_mirroring_transforms),
        cmocka_unit_test(offset_rays_never_hit_their_own_triangle),
        cmocka_unit_test(offsets_are_small),
        cmocka_unit_test(visibility_agrees_with_brute_force),
        cmocka_unit_test(transparent_panes_multiply_their_transmittances),
        cmocka_unit_test(shadow_rays_see_panes_from_their_own_direction),
        cmocka_unit_test(visibility_flags_hide_objects_from_their_kind_of_ray_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
