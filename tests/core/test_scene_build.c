/* Building and editing: what is refused and says why, what hits carry of their mesh, and that edits show
   after the next commit. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scenes.h"
#include "statistics.h"

#include <cmocka.h>

/* A quad of two triangles over [0,2] × [0,1] in the plane z = 0, with everything that a mesh may carry. */
static const float quad_positions[12] = {0, 0, 0, 2, 0, 0, 2, 1, 0, 0, 1, 0};
static const uint32_t quad_triangles[6] = {0, 1, 2, 0, 2, 3};
static const uint32_t quad_material[2] = {1, 7};
static const float quad_uv[8] = {0, 0, 1, 0, 1, 1, 0, 1}, mirrored_uv[8] = {1, 0, 0, 0, 0, 1, 1, 1};
static const float quad_normals[12] = {-1, 0, 1, 1, 0, 1, 1, 0, 1, -1, 0, 1};
static const struct mesh_uv quad_layers[2] = {{"first", quad_uv}, {"second", mirrored_uv}};

static struct mesh_input quad(void)
{
    return (struct mesh_input){.name = "quad",
                               .positions = quad_positions,
                               .vertex_count = 4,
                               .triangles = quad_triangles,
                               .triangle_count = 2,
                               .corners = quad_triangles,
                               .corner_count = 4};
}

static bool add_mesh(struct scene *scene, struct mesh_input mesh)
{
    return scene_add_mesh(scene, &mesh, NULL);
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

static bool commit(struct scene *scene, stokes_error *err)
{
    struct scene_setup setup = {.range = SCENES_RANGE, .uv_rule = UV_HOLD, .threads = 1};
    working_space_rec709(&setup.working_space);
    return scene_commit(scene, &setup, err);
}

/* --- Checks ------------------------------------------------------------------------------------------ */

static void bad_meshes_are_refused_and_change_nothing(void **state)
{
    (void)state;
    float nan[12], far[12];
    memcpy(nan, quad_positions, sizeof nan);
    memcpy(far, quad_positions, sizeof far);
    nan[4] = NAN;
    far[7] = 1e30f;
    uint32_t outside[6] = {0, 1, 2, 0, 2, 4};
    float normals[12] = {0};
    normals[11] = INFINITY;
    struct mesh_input bad[6] = {quad(), quad(), quad(), quad(), quad(), quad()};
    static const char *const property[6] = {"positions", "positions",      "triangles",
                                            "corners",   "corner_normals", "uv layer"};
    struct mesh_uv layer = {"uv layer", nan};
    bad[0].positions = nan;
    bad[1].positions = far;
    bad[2].triangles = outside;
    bad[3].corners = outside;
    bad[4].corner_normals = normals;
    bad[5].uv = &layer;
    bad[5].uv_count = 1;
    struct scene *scene = scene_create();
    assert_true(add_mesh(scene, quad()));
    scenes_instance(scene, "quad", "quad", "", &scenes_identity, 1);
    for (int i = 0; i < 6; i++) {
        stokes_error err = {0};
        assert_false(scene_add_mesh(scene, &bad[i], &err));
        assert_string_equal(err.object, "quad");
        assert_string_equal(err.property, property[i]);
    }
    scenes_commit(scene);
    assert_string_equal(seen(scene, 1.5f, 0.5f), "default material");
    scene_destroy(scene);
}

static void degenerate_triangles_and_empty_meshes_are_harmless(void **state)
{
    (void)state;
    struct scene *scene = scene_create();
    struct vec3 points[12] = {vec3(0, 0, 0), vec3(0, 0, 0), vec3(0, 0, 0), vec3(0, 0, 0),
                              vec3(1, 0, 0), vec3(2, 0, 0), vec3(0, 0, 1), vec3(1, 0, 1),
                              vec3(0, 1, 1), vec3(3, 3, 0), vec3(3, 3, 0), vec3(5, 5, 0)};
    scenes_mesh(scene, "points", points, 4);
    scenes_mesh(scene, "empty", points, 0);
    scenes_material(scene, "light", scenes_emitter(1, true));
    scenes_instance(scene, "points", "points", "light", &scenes_identity, 1);
    scenes_instance(scene, "empty", "empty", "light", &scenes_identity, 1);
    scenes_instance(scene, "none", "points", "light", &scenes_identity, 0);
    scenes_commit(scene);
    for (uint64_t i = 0; i < 1000; i++) {
        struct light_point point;
        float u[3] = {(float)independent(1, 3 * i), (float)independent(1, 3 * i + 1),
                      (float)independent(1, 3 * i + 2)},
              pdf;
        assert_true(scene_sample_light(scene, u, &point, &pdf));
        assert_int_equal(point.hit.primitive, 2);
        assert_float_equal(pdf, 2, 1e-5);
    }
    assert_string_equal(seen(scene, 0.2f, 0.2f), "light");
    scene_destroy(scene);
}

static void an_object_scaled_flat_is_still_seen(void **state)
{
    (void)state;
    struct scene *scene = scene_create();
    struct transform flat = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 2}}, both[2] = {flat, flat};
    both[1].m[3] = 5;
    assert_true(add_mesh(scene, quad()));
    scenes_instance(scene, "quad", "quad", "", both, 2);
    scenes_commit(scene);
    struct hit hit;
    const struct material *material;
    assert_true(look_down(scene, 6, 0.5f, &hit, &material));
    assert_float_equal(hit.position.z, 2, 1e-6);
    assert_float_equal(hit.ng.z, 1, 1e-6);
    scene_destroy(scene);
}

static void objects_scaled_to_nothing_or_out_of_bounds_are_no_trap(void **state)
{
    (void)state;
    struct scene *scene = scene_create();
    struct transform transforms[3] = {{{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}},
                                      {{1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 1}},
                                      {{1e-6f, 0, 0, 0, 0, 1e-6f, 0, 0, 0, 0, 1e-6f, 1}}};
    assert_true(add_mesh(scene, quad()));
    scenes_material(scene, "light", scenes_emitter(1, true));
    scenes_instance(scene, "quad", "quad", "light", transforms, 3);
    scenes_commit(scene);
    assert_string_equal(seen(scene, 1e-6f, 2e-7f), "light");
    assert_string_equal(seen(scene, 1, 1), "nothing");
    transforms[0].m[0] = transforms[0].m[5] = transforms[0].m[10] = 1e12f;
    transforms[0].m[3] = -1e12f;
    scenes_instance(scene, "far", "quad", "light", transforms, 1);
    stokes_error err;
    assert_true(commit(scene, &err));
    struct mesh_input mesh = quad();
    float positions[12];
    for (int i = 0; i < 12; i++)
        positions[i] = 5e11f * quad_positions[i];
    mesh.positions = positions;
    assert_true(add_mesh(scene, mesh));
    assert_false(commit(scene, &err));
    assert_string_equal(err.property, "bounds");
    scene_destroy(scene);
}

static void dangling_names_fail_the_commit_and_say_so(void **state)
{
    (void)state;
    struct scene *scene = scene_create();
    stokes_error err = {0};
    scenes_instance(scene, "thing", "nowhere", "", &scenes_identity, 1);
    assert_false(commit(scene, &err));
    assert_string_equal(err.object, "thing");
    assert_string_equal(err.property, "mesh");
    assert_true(add_mesh(scene, quad()));
    scenes_instance(scene, "thing", "quad", "unheard of", &scenes_identity, 1);
    assert_false(commit(scene, &err));
    assert_string_equal(err.property, "materials");
    assert_non_null(strstr(err.text, "unheard of"));
    scenes_material(scene, "unheard of", scenes_grey());
    assert_true(commit(scene, &err));
    assert_string_equal(seen(scene, 1, 0.2f), "unheard of");
    scene_destroy(scene);
}

static void bad_lights_name_what_is_wrong(void **state)
{
    (void)state;
    struct light_input bad[5] = {{.shape = LIGHT_RECTANGLE, .size = {1, 0}},
                                 {.shape = LIGHT_SPHERE, .radius = -1},
                                 {.shape = LIGHT_SPOT, .angle = 0},
                                 {.shape = LIGHT_SPOT, .angle = 1, .blend = 2},
                                 {.shape = LIGHT_SUN, .angle = 4}};
    static const char *const property[5] = {"size", "radius", "angle", "blend", "angle"};
    struct scene *scene = scene_create();
    for (int i = 0; i < 5; i++) {
        stokes_error err = {0};
        bad[i].name = "lamp";
        bad[i].transform = scenes_identity;
        bad[i].emission = scenes_emission(1);
        assert_false(scene_add_light(scene, &bad[i], &err));
        assert_string_equal(err.object, "lamp");
        assert_string_equal(err.property, property[i]);
    }
    scenes_commit(scene);
    assert_int_equal(scene_light_count(scene), 0);
    assert_null(scene_lamp_spectrum(scene));
    scene_destroy(scene);
}

/* --- What hits carry --------------------------------------------------------------------------------- */

static struct scene *full_quad(const struct transform *transform)
{
    static const char *const materials[2] = {"left", "right"};
    struct scene *scene = scene_create();
    struct mesh_input mesh = quad();
    mesh.uv = quad_layers;
    mesh.uv_count = 2;
    mesh.corner_normals = quad_normals;
    mesh.material_index = quad_material;
    assert_true(add_mesh(scene, mesh));
    scenes_material(scene, "left", scenes_grey());
    scenes_material(scene, "right", scenes_grey());
    struct instances_input in = {.name = "quad",
                                 .mesh = "quad",
                                 .materials = materials,
                                 .material_count = 2,
                                 .transforms = transform->m,
                                 .transform_count = 1,
                                 .visible = scenes_visible};
    assert_true(scene_add_instances(scene, &in, NULL));
    scenes_commit(scene);
    return scene;
}

static void hits_carry_coordinates_normals_and_tangent(void **state)
{
    (void)state;
    struct scene *scene = full_quad(&scenes_identity);
    struct hit hit;
    const struct material *material;
    for (uint64_t i = 0; i < 500; i++) {
        float x = 2 * (float)independent(2, 2 * i), y = (float)independent(2, 2 * i + 1);
        if (!look_down(scene, x, y, &hit, &material))
            continue;
        struct vec3 smooth = normalize(vec3(x - 1, 0, 1));
        assert_true(length(sub(hit.position, vec3(x, y, 0))) < 1e-6f);
        assert_true(length(sub(hit.object, vec3(x, y, 0))) < 1e-6f);
        assert_true(length(sub(hit.generated, vec3(x / 2, y, 0.5f))) < 1e-6f);
        assert_true(length(sub(hit.ns, smooth)) < 1e-6f);
        assert_true(length(sub(hit.ng, vec3(0, 0, 1))) < 1e-6f);
        assert_true(length(sub(hit.tangent, vec3(1, 0, 0))) < 1e-6f);
        assert_false(hit.mirrored_uv);
        assert_float_equal(hit.uv[0], x / 2, 1e-6);
        assert_float_equal(hit.uv[1], y, 1e-6);
    }
    scene_destroy(scene);
}

/* (ns × tangent)·∂p/∂v has the sign that mirrored_uv says, whichever of transform and UVs is mirrored. */
static void mirrored_uvs_are_told_under_mirroring_transforms(void **state)
{
    (void)state;
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        struct transform transform = scenes_identity;
        transform.m[0] = mirrored ? -1 : 1; /* ∂p/∂u turns round, ∂p/∂v and ns stay */
        struct scene *scene = full_quad(&transform);
        struct hit hit;
        const struct material *material;
        assert_true(look_down(scene, mirrored ? -0.5f : 0.5f, 0.5f, &hit, &material));
        assert_float_equal(hit.tangent.x, mirrored ? -1 : 1, 1e-6);
        assert_float_equal(hit.ng.z, 1, 1e-6);
        assert_int_equal(hit.mirrored_uv, mirrored);
        scene_destroy(scene);
    }
}

/* With u running backwards the tangent turns round, and ns × tangent with it. */
static void mirrored_uvs_turn_the_tangent(void **state)
{
    (void)state;
    struct scene *scene = scene_create();
    struct mesh_input mesh = quad();
    mesh.uv = quad_layers + 1;
    mesh.uv_count = 1;
    assert_true(add_mesh(scene, mesh));
    scenes_instance(scene, "quad", "quad", "", &scenes_identity, 1);
    scenes_commit(scene);
    struct hit hit;
    const struct material *material;
    for (int i = 0; i < 2; i++) { /* in both triangles */
        assert_true(look_down(scene, i ? 1.5f : 0.5f, 0.5f, &hit, &material));
        assert_float_equal(hit.tangent.x, -1, 1e-6);
        assert_true(hit.mirrored_uv);
    }
    scene_destroy(scene);
}

/* One mesh, two emissive materials and a grey one, placed twice: a light for each object and emissive slot. */
static void each_emissive_slot_of_each_object_is_a_light(void **state)
{
    (void)state;
    static const char *const materials[3] = {"dim", "grey", "bright"};
    static const uint32_t slots[2] = {0, 2};
    struct transform transforms[2] = {scenes_identity, scenes_identity};
    transforms[1].m[3] = 10;
    struct scene *scene = scene_create();
    struct mesh_input mesh = quad();
    mesh.material_index = slots;
    assert_true(add_mesh(scene, mesh));
    scenes_material(scene, "dim", scenes_emitter(1, false));
    scenes_material(scene, "grey", scenes_grey());
    scenes_material(scene, "bright", scenes_emitter(3, false));
    struct instances_input in = {.name = "quad",
                                 .mesh = "quad",
                                 .materials = materials,
                                 .material_count = 3,
                                 .transforms = transforms->m,
                                 .transform_count = 2,
                                 .visible = scenes_visible};
    assert_true(scene_add_instances(scene, &in, NULL));
    scenes_commit(scene);
    assert_int_equal(scene_light_count(scene), 4);
    bool seen_light[4] = {false};
    for (int i = 0; i < 4; i++) {
        struct hit hit;
        const struct material *material;
        struct light_point point;
        bool bright = i & 1;
        assert_true(look_down(scene, (float)(i / 2) * 10 + (bright ? 0.2f : 1.8f), 0.5f, &hit, &material));
        assert_in_range(hit.light, 0, 3);
        assert_false(seen_light[hit.light]);
        seen_light[hit.light] = true;
        scene_light_point_at(scene, &hit, &point);
        assert_float_equal(scene_light_emission(scene, &point, vec3(0, 0, 1), 500), bright ? 3 : 1, 1e-6);
        assert_true(scene_light_emission(scene, &point, vec3(0, 0, -1), 500) == 0);
        assert_float_equal(scene_pdf_light(scene, &point), bright ? 3 / 8.0 : 1 / 8.0,
                           1e-6); /* of area 1 each */
        assert_true(point.on_mesh && scene_light_seen_by_camera(scene, &point));
    }
    scene_destroy(scene);
}

#define SEGMENTS 16

/* A cylinder of SEGMENTS faces about z with smooth normals, u about the axis (the other way if `turn` is −1), v along it. */
static void add_cylinder(struct scene *scene, float turn)
{
    float positions[SEGMENTS * 6], normals[(SEGMENTS + 1) * 6], uv[(SEGMENTS + 1) * 4];
    uint32_t triangles[SEGMENTS * 6], corners[SEGMENTS * 6];
    for (uint32_t i = 0; i <= SEGMENTS; i++)
        for (uint32_t k = 0; k < 2; k++) {
            float phi = 2 * PI_F * (float)i / SEGMENTS;
            uint32_t c = 2 * i + k;
            struct vec3 normal = vec3(cosf(phi), sinf(phi), 0), position = vec3(normal.x, normal.y, (float)k);
            memcpy(normals + 3 * c, &normal, sizeof normal);
            uv[2 * c] = turn * (float)i / SEGMENTS;
            uv[2 * c + 1] = (float)k;
            if (i < SEGMENTS)
                memcpy(positions + 3 * c, &position, sizeof position);
        }
    for (uint32_t i = 0; i < SEGMENTS; i++) {
        uint32_t quad[6] = {2 * i, 2 * i + 2, 2 * i + 3, 2 * i, 2 * i + 3, 2 * i + 1};
        for (uint32_t c = 0; c < 6; c++) {
            corners[6 * i + c] = quad[c];
            triangles[6 * i + c] = quad[c] % (2 * SEGMENTS);
        }
    }
    struct mesh_uv layer = {"map", uv};
    struct mesh_input mesh = quad();
    mesh.positions = positions;
    mesh.vertex_count = 2 * SEGMENTS;
    mesh.triangles = triangles;
    mesh.triangle_count = 2 * SEGMENTS;
    mesh.corners = corners;
    mesh.corner_count = 2 * SEGMENTS + 2;
    mesh.corner_normals = normals;
    mesh.uv = &layer;
    mesh.uv_count = 1;
    assert_true(add_mesh(scene, mesh));
}

/* Interpolated between corners that share it, the tangent is along ∂p/∂u of the smooth surface; a face's own
   would be off by up to half a face's angle, 0.2 rad, and jump at each edge. */
static void tangents_of_smooth_meshes_follow_the_smooth_surface(void **state)
{
    (void)state;
    static const float blue[4] = {0.5f, 0.5f, 1, 1};
    for (int turn = -1; turn < 2; turn += 2) {
        struct scene *scene = scene_create();
        assert_true(
            scene_add_image(scene, image_create("bumps", 1, 1, 4, false, blue, sizeof blue, NULL), NULL));
        struct closure *closure = scenes_grey();
        closure->normal_map = calloc(1, sizeof *closure->normal_map);
        *closure->normal_map =
            (struct texture){.image = scene_find_image(scene, "bumps"), .transform = scenes_identity};
        closure->normal_strength = 1;
        scenes_material(scene, "bumpy", closure);
        add_cylinder(scene, (float)turn);
        scenes_instance(scene, "thing", "quad", "bumpy", &scenes_identity, 1);
        scenes_commit(scene);
        for (uint64_t i = 0; i < 2000; i++) {
            struct vec3 out = vec3(cosf((float)i), sinf((float)i), 0);
            struct ray ray = {vec3(5 * out.x, 5 * out.y, (float)independent(3, i)), negate(out), 0, INFINITY,
                              RAY_CAMERA};
            struct hit hit;
            const struct material *material;
            assert_true(scene_intersect(scene, &ray, &hit, &material));
            assert_true((float)turn * dot(hit.tangent, vec3(-hit.ns.y, hit.ns.x, 0)) > cosf(0.01f));
            assert_int_equal(hit.mirrored_uv, turn < 0);
        }
        scene_destroy(scene);
    }
}

/* A material index beyond the slots takes the last slot, as in Blender. */
static void faces_have_their_own_materials(void **state)
{
    (void)state;
    struct scene *scene = full_quad(&scenes_identity);
    assert_string_equal(seen(scene, 1.5f, 0.2f), "right");
    assert_string_equal(seen(scene, 0.2f, 0.5f), "right");
    struct mesh_input mesh = quad();
    static const uint32_t swapped[2] = {0, 1};
    mesh.material_index = swapped;
    assert_true(add_mesh(scene, mesh));
    scenes_commit(scene);
    assert_string_equal(seen(scene, 1.5f, 0.2f), "left");
    assert_string_equal(seen(scene, 0.2f, 0.5f), "right");
    scene_destroy(scene);
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

/* Black on the left half, white on the right: the layer that a texture names decides which end of the quad
   shines. */
static void textures_look_up_the_layer_that_they_name(void **state)
{
    (void)state;
    static const float pixels[2] = {0, 1};
    static const char *const layers[4] = {"", "first", "second", "missing"};
    static const bool lit_left[4] = {false, false, true, false}, lit_right[4] = {true, true, false, false};
    for (int i = 0; i < 4; i++) {
        struct scene *scene = scene_create();
        struct image *image = image_create("halves", 2, 1, 1, false, pixels, sizeof pixels, NULL);
        assert_true(scene_add_image(scene, image, NULL));
        struct mesh_input mesh = quad();
        mesh.uv = quad_layers;
        mesh.uv_count = 2;
        assert_true(add_mesh(scene, mesh));
        struct closure *closure = textured_emitter(image, layers[i]);
        closure->emission->texture->interpolation = TEXTURE_CLOSEST;
        scenes_material(scene, "light", closure);
        scenes_instance(scene, "quad", "quad", "light", &scenes_identity, 1);
        scenes_commit(scene);
        struct hit hit;
        const struct material *material;
        assert_true(look_down(scene, 0.5f, 0.4f, &hit, &material));
        assert_int_equal(material_emission(material, &hit, vec3(0, 0, 1), 550) > 0, lit_left[i]);
        assert_true(look_down(scene, 1.5f, 0.4f, &hit, &material));
        assert_int_equal(material_emission(material, &hit, vec3(0, 0, 1), 550) > 0, lit_right[i]);
        scene_destroy(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_meshes_are_refused_and_change_nothing),
        cmocka_unit_test(degenerate_triangles_and_empty_meshes_are_harmless),
        cmocka_unit_test(an_object_scaled_flat_is_still_seen),
        cmocka_unit_test(objects_scaled_to_nothing_or_out_of_bounds_are_no_trap),
        cmocka_unit_test(dangling_names_fail_the_commit_and_say_so),
        cmocka_unit_test(bad_lights_name_what_is_wrong),
        cmocka_unit_test(hits_carry_coordinates_normals_and_tangent),
        cmocka_unit_test(mirrored_uvs_are_told_under_mirroring_transforms),
        cmocka_unit_test(tangents_of_smooth_meshes_follow_the_smooth_surface),
        cmocka_unit_test(mirrored_uvs_turn_the_tangent),
        cmocka_unit_test(each_emissive_slot_of_each_object_is_a_light),
        cmocka_unit_test(faces_have_their_own_materials),
        cmocka_unit_test(textures_look_up_the_layer_that_they_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
