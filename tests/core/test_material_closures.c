/* From closure trees to surfaces: flattening, weights, textures, normal maps, mixes by the angle of view, transparency, emission, and
   the errors and warnings of compiling. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "material/microfacet.h"
#include "material_kit.h"

#include <cmocka.h>

#define UP vec3(0, 0, 1)
#define TOP (1 / (double)PI_F)

static struct closure *diffuse(float reflectance)
{
    struct closure *c = kit_bsdf("diffuse");
    c->color[0] = kit_constant(reflectance);
    return c;
}

static struct closure *transparent(float color)
{
    struct closure *c = kit_bsdf("transparent");
    c->color[0] = kit_constant(color);
    return c;
}

static struct closure *emission(float value, bool two_sided)
{
    struct closure *c = calloc(1, sizeof *c);
    c->kind = CLOSURE_EMISSION;
    c->emission = calloc(1, sizeof *c->emission);
    *c->emission = (struct emission_node){
        .spectrum = spectrum_constant(KIT_RANGE, value), .scale = 1, .two_sided = two_sided};
    return c;
}

static struct value_node *value(enum value_kind kind, float constant, struct value_node *a,
                                struct value_node *b)
{
    struct value_node *v = calloc(1, sizeof *v);
    *v = (struct value_node){.kind = kind, .constant = constant, .child = {a, b}};
    return v;
}

static double reflected(const struct material *m)
{
    struct surface s = kit_surface(m, UP, UP);
    return surface_elastic(&s, UP, UP, 500);
}

/* --- Trees ------------------------------------------------------------------------------------------------- */

static void mix_and_add_flatten_with_products_of_factors(void **state)
{
    (void)state;
    struct material *m = kit_compile(kit_mix(
        diffuse(0.1f), kit_mix(diffuse(0.5f), kit_add(diffuse(0.2f), diffuse(0.3f)), kit_value(0.25f)),
        kit_value(0.4f)));
    assert_int_equal(m->lobe_count, 4);
    assert_float_equal(reflected(m), (0.6 * 0.1 + 0.4 * (0.75 * 0.5 + 0.25 * 0.5)) * TOP, 1e-6);
    material_destroy(m);
}

static void branches_without_weight_and_black_lobes_are_dropped(void **state)
{
    (void)state;
    struct material *m =
        kit_compile(kit_mix(kit_add(diffuse(0.5f), diffuse(0)), transparent(1), kit_value(0)));
    assert_int_equal(m->lobe_count, 1);
    assert_false(material_may_be_transparent(m));
    material_destroy(m);
    m = kit_compile(NULL);
    struct surface s = kit_surface(m, UP, UP);
    assert_int_equal(s.lobe_count, 0);
    assert_true(surface_elastic(&s, UP, UP, 500) == 0);
    assert_true(surface_pdf_elastic(&s, SIDE_LIGHT, UP, UP, 500) == 0);
    struct scatter d;
    assert_false(surface_sample(&s, SIDE_CAMERA, UP, 500, (const float[4]){0.5f, 0.5f, 0.5f, 0.5f}, &d));
    material_destroy(m);
}

static void mixing_twice_with_one_varying_factor_is_a_square(void **state)
{
    (void)state;
    /* facing at normal incidence: 1 − cos^1 = 0; along 60° it is ½. */
    struct material *m = kit_compile(
        kit_mix(diffuse(0.2f), kit_mix(diffuse(0.2f), diffuse(0.8f), value(VALUE_FACING, 0.5f, NULL, NULL)),
                value(VALUE_FACING, 0.5f, NULL, NULL)));
    struct surface s = kit_surface(m, UP, UP);
    struct vec3 slanted = vec3(sqrtf(0.75f), 0, 0.5f);
    assert_float_equal(surface_elastic(&s, UP, slanted, 500), (0.75 * 0.2 + 0.25 * 0.8) * TOP, 1e-6);
    assert_float_equal(surface_elastic(&s, slanted, UP, 500), 0.2 * TOP, 1e-6);
    material_destroy(m);
}

/* --- Mixes by the angle of view ------------------------------------------------------------------------------ */

static void a_fresnel_mix_belongs_to_the_cameras_direction_from_both_sides(void **state)
{
    (void)state;
    struct material *m = kit_compile(kit_mix(diffuse(0), diffuse(1), value(VALUE_FRESNEL, 1.5f, NULL, NULL)));
    for (int back = 0; back < 2; back++) {
        float z = back ? -0.3f : 0.3f;
        struct vec3 camera = vec3(sqrtf(1 - z * z), 0, z), light = vec3(0, 0, back ? -1 : 1);
        struct hit hit = kit_hit(UP, UP);
        struct surface from_camera, from_light;
        material_shade(m, &hit, camera, &from_camera);
        material_shade(m, &hit, light, &from_light);
        double expected = fresnel_dielectric(0.3f, back ? 1 / 1.5f : 1.5f) * TOP;
        assert_float_equal(surface_elastic(&from_camera, light, camera, 500), expected, 1e-6);
        assert_float_equal(surface_elastic(&from_light, light, camera, 500), expected, 1e-6);
        assert_true(surface_pdf_elastic(&from_light, SIDE_LIGHT, light, camera, 500) > 0);
    }
    material_destroy(m);
}

/* Head-on, facing is 0: a light sub-path must not rule out what cameras elsewhere see. */
static void light_sub_paths_give_a_chance_to_what_some_view_can_see(void **state)
{
    (void)state;
    struct material *m = kit_compile(
        kit_mix(diffuse(0.5f), kit_dye(0.5f, 1, 420, 560, 1, false), value(VALUE_FACING, 0.5f, NULL, NULL)));
    struct surface s = kit_surface(m, UP, UP);
    struct vec3 slanted = normalize(vec3(1, 0, 0.5f));
    assert_true(surface_fluorescent(&s, 0, UP, slanted, 420, 560) > 0);
    assert_true(surface_pdf_fluorescent(&s, SIDE_LIGHT, 0, UP, slanted, 420, 560) > 0);
    material_destroy(m);
}

static void a_scaled_and_offset_fresnel_is_clamped_as_a_mix_factor(void **state)
{
    (void)state;
    struct value_node *v = value(VALUE_SCALE_OFFSET, 0, value(VALUE_FRESNEL, 1.5f, NULL, NULL), NULL);
    v->scale = 2;
    v->offset = 0.5f;
    struct material *m = kit_compile(kit_mix(diffuse(0), diffuse(1), v));
    struct surface s = kit_surface(m, UP, UP);
    struct vec3 grazing = normalize(vec3(1, 0, 0.05f));
    assert_float_equal(surface_elastic(&s, UP, UP, 500), (0.5 + 2 * 0.04) * TOP, 1e-5);
    assert_float_equal(surface_elastic(&s, UP, grazing, 500), TOP, 1e-5);
    material_destroy(m);
}

static void what_a_factor_cannot_keep_symbolic_is_warned_of(void **state)
{
    (void)state;
    int warnings = 0;
    struct value_node *v = value(VALUE_PRODUCT, 0, value(VALUE_FRESNEL, 1.5f, NULL, NULL),
                                 value(VALUE_FACING, 0.5f, NULL, NULL));
    material_destroy(kit_try_compile(kit_mix(diffuse(0.2f), diffuse(1), v), &warnings, NULL));
    assert_int_equal(warnings, 1);
    struct closure *glossy = kit_bsdf("glossy");
    glossy->value[0] = value(VALUE_FACING, 0.5f, NULL, NULL);
    warnings = 0;
    material_destroy(kit_try_compile(glossy, &warnings, NULL));
    assert_int_equal(warnings, 1);
}

static void backfacing_tells_the_sides_apart(void **state)
{
    (void)state;
    struct material *m =
        kit_compile(kit_mix(diffuse(0.1f), diffuse(0.9f), value(VALUE_BACKFACING, 0, NULL, NULL)));
    struct surface s = kit_surface(m, UP, UP);
    assert_float_equal(surface_elastic(&s, UP, UP, 500), 0.1 * TOP, 1e-6);
    assert_float_equal(surface_elastic(&s, negate(UP), negate(UP), 500), 0.9 * TOP, 1e-6);
    material_destroy(m);
}

/* --- Transparency -------------------------------------------------------------------------------------------- */

static void shadow_rays_see_the_weight_and_colour_of_transparent_lobes(void **state)
{
    (void)state;
    struct material *m = kit_compile(kit_mix(diffuse(0.5f), transparent(0.8f), kit_value(0.25f)));
    struct hit hit = kit_hit(UP, UP);
    assert_true(material_may_be_transparent(m));
    assert_float_equal(material_transmittance(m, &hit, UP, 500), 0.25 * 0.8, 1e-6);
    struct surface s = kit_surface(m, UP, UP);
    struct vec3 slanted = normalize(vec3(0.3f, -0.4f, 0.7f));
    for (int i = 0; i < 100; i++) {
        const float u[4] = {((float)i + 0.5f) / 100, 0.5f, 0.3f, 0.6f};
        struct scatter d;
        assert_true(surface_sample(&s, SIDE_CAMERA, slanted, 500, u, &d));
        if (d.label != LABEL_SPECULAR)
            continue;
        assert_float_equal(length(add(d.direction, slanted)), 0, 1e-6);
        assert_float_equal(d.value, 0.25 * 0.8, 1e-6);
        assert_int_equal(d.depth_class, SCATTER_TRANSPARENT);
        assert_false(d.refracts || d.disperses);
        assert_float_equal(d.pdf, d.pdf_other, 1e-6);
    }
    material_destroy(m);
    m = kit_compile(diffuse(0.5f));
    assert_true(material_transmittance(m, &hit, UP, 500) == 0);
    material_destroy(m);
}

static void a_holdout_is_its_weight_and_scatters_nothing(void **state)
{
    (void)state;
    struct material *m = kit_compile(kit_mix(diffuse(0.5f), kit_bsdf("holdout"), kit_value(0.25f)));
    struct hit hit = kit_hit(UP, UP);
    assert_float_equal(material_holdout(m, &hit, UP), 0.25, 1e-6);
    assert_false(material_may_be_transparent(m));
    struct surface s = kit_surface(m, UP, UP);
    assert_int_equal(s.lobe_count, 1);
    assert_float_equal(surface_elastic(&s, UP, UP, 500), 0.75 * 0.5 / M_PI, 1e-6);
    material_destroy(m);
    m = kit_compile(kit_add(kit_bsdf("holdout"), kit_bsdf("holdout")));
    assert_true(material_holdout(m, &hit, UP) == 1);
    material_destroy(m);
    m = kit_compile(diffuse(0.5f));
    assert_true(material_holdout(m, &hit, UP) == 0);
    material_destroy(m);
}

/* --- Textures ------------------------------------------------------------------------------------------------ */

/* Two texels wide, one high; left black, right `right`. */
struct checker {
    struct image image;
    float texel[8];
};
static void checker_set(struct checker *c, float r, float g, float b, float a)
{
    const float texel[8] = {0, 0, 0, 0, r, g, b, a};
    memcpy(c->texel, texel, sizeof texel);
    c->image =
        (struct image){.width = 2, .height = 1, .rgba = c->texel, .mean = {r / 2, g / 2, b / 2, a / 2}};
}

static struct texture *texture_of(const struct checker *c, enum texture_channel channel)
{
    struct texture *t = calloc(1, sizeof *t);
    *t = (struct texture){.image = &c->image,
                          .transform = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},
                          .interpolation = TEXTURE_CLOSEST,
                          .channel = channel};
    return t;
}

static double reflected_at(const struct material *m, float u, float lambda)
{
    struct hit hit = kit_hit(UP, UP);
    hit.uv[0] = u;
    hit.uv[1] = 0.5f;
    struct surface s;
    material_shade(m, &hit, UP, &s);
    return surface_elastic(&s, UP, UP, lambda);
}

static void a_textured_factor_masks_per_texel(void **state)
{
    (void)state;
    struct checker mask;
    checker_set(&mask, 0.5f, 0.5f, 0.5f, 1);
    struct value_node *v = value(VALUE_TEXTURE, 0, NULL, NULL);
    v->texture = texture_of(&mask, TEXTURE_LUMINANCE);
    struct material *m = kit_compile(kit_mix(diffuse(0.2f), diffuse(0.8f), v));
    assert_int_equal(material_texture_count(m), 1);
    assert_float_equal(reflected_at(m, 0.25f, 500), 0.2 * TOP, 1e-6);
    assert_float_equal(reflected_at(m, 0.75f, 500), 0.5 * TOP, 1e-6);
    material_destroy(m);
}

static void a_textured_concentration_varies_the_dye(void **state)
{
    (void)state;
    struct checker mask;
    checker_set(&mask, 0.5f, 0.5f, 0.5f, 1);
    struct closure *dye = kit_dye(0.6f, 1, 420, 520, 1, false);
    dye->value[0]->kind = VALUE_TEXTURE;
    dye->value[0]->texture = texture_of(&mask, TEXTURE_R);
    struct material *m = kit_compile(dye);
    struct hit hit = kit_hit(UP, UP);
    struct surface s;
    hit.uv[0] = 0.25f;
    material_shade(m, &hit, UP, &s);
    assert_int_equal(s.fluorescent_count, 0);
    assert_float_equal(surface_elastic(&s, UP, UP, 420), 0.6 * TOP, 1e-5);
    hit.uv[0] = 0.75f;
    material_shade(m, &hit, UP, &s);
    assert_int_equal(s.fluorescent_count, 1);
    assert_float_equal(surface_elastic(&s, UP, UP, 420), 0.6 * (1 - 0.5 * 0.95) * TOP, 1e-3);
    material_destroy(m);
}

static void colour_textures_are_upsampled_reflectances_and_emissions(void **state)
{
    (void)state;
    struct material_context context = {
        .range = KIT_RANGE, .uv_rule = UV_HOLD, .luminance = {0.2126f, 0.7152f, 0.0722f}};
    working_space_rec709(&context.working_space);
    struct rgb_table *table = rgb_table_create(&context.working_space, 2);
    context.rgb_table = table;
    struct checker red;
    checker_set(&red, 0.7f, 0.1f, 0.1f, 1);
    struct closure *c = kit_bsdf("diffuse"), *e = emission(1, false);
    c->color[0] = calloc(1, sizeof *c->color[0]);
    *c->color[0] = (struct color_node){.texture = texture_of(&red, TEXTURE_COLOR), .scale = 0.5f};
    spectrum_destroy(e->emission->spectrum);
    *e->emission = (struct emission_node){.texture = texture_of(&red, TEXTURE_COLOR), .scale = 3};
    struct closure *both = kit_add(c, e);
    assert_true(material_needs_rgb_table(both));
    struct material *m = material_compile("test", both, &context, NULL, NULL, NULL);
    assert_non_null(m);
    const float rgb[3] = {0.7f, 0.1f, 0.1f}, relative[3] = {1, 1 / 7.0f, 1 / 7.0f};
    struct rgb_curve curve = rgb_table_lookup(table, rgb), lamp = rgb_table_lookup(table, relative);
    struct hit hit = kit_hit(UP, UP);
    hit.uv[0] = 0.75f;
    for (float l = 400; l < 700; l += 50) {
        assert_float_equal(reflected_at(m, 0.75f, l), 0.5 * rgb_curve_eval(&curve, l, UV_HOLD) * TOP, 1e-6);
        double white = spectrum_eval(m->white, l);
        assert_float_equal(material_emission(m, &hit, UP, l),
                           3 * 0.7 * rgb_curve_eval(&lamp, l, UV_HOLD) * white, 1e-7);
    }
    assert_float_equal(spectrum_integral(m->white), 1, 1e-5);
    assert_true(spectrum_eval(material_emission_shape(m), 620) >
                3 * spectrum_eval(material_emission_shape(m), 480));
    hit.uv[0] = 0.25f;
    assert_true(material_emission(m, &hit, UP, 500) == 0);
    material_destroy(m);
    rgb_table_destroy(table);
}

/* --- Normals ------------------------------------------------------------------------------------------------- */

static struct vec3 mapped(struct checker *map, float strength, struct hit *hit)
{
    struct closure *c = diffuse(1);
    c->normal_map = texture_of(map, TEXTURE_COLOR);
    c->normal_strength = strength;
    struct material *m = kit_compile(c);
    struct surface s;
    hit->uv[0] = 0.75f;
    material_shade(m, hit, UP, &s);
    material_destroy(m);
    return s.lobe[0].frame.n;
}

static void normal_maps_turn_the_frame_in_tangent_space(void **state)
{
    (void)state;
    struct checker map;
    struct hit hit = kit_hit(UP, UP);
    hit.tangent = vec3(1, 0, 0);
    checker_set(&map, 0.5f + 0.3f, 0.5f, 0.5f + 0.4f, 1); /* (0.6, 0, 0.8) */
    struct vec3 n = mapped(&map, 1, &hit);
    assert_float_equal(n.x, 0.6, 1e-6);
    assert_float_equal(n.z, 0.8, 1e-6);
    checker_set(&map, 0.5f, 0.5f + 0.3f, 0.5f + 0.4f, 1);
    assert_float_equal(mapped(&map, 1, &hit).y, 0.6, 1e-6);
    hit.mirrored_uv = true;
    assert_float_equal(mapped(&map, 1, &hit).y, -0.6, 1e-6);
    assert_float_equal(mapped(&map, 0, &hit).z, 1, 1e-6);
}

static void a_sunk_normal_stays_on_the_side_of_the_geometry(void **state)
{
    (void)state;
    struct checker map;
    struct hit hit = kit_hit(UP, normalize(vec3(0.9f, 0, 0.3f)));
    hit.tangent = normalize(vec3(0.3f, 0, -0.9f));
    checker_set(&map, 1, 0.5f, 0.5f, 1);
    float z = mapped(&map, 1, &hit).z;
    assert_true(z > 0 && z < 0.01f);
    /* Normals against the winding are turned with it. */
    hit = kit_hit(UP, vec3(0, 0, -1));
    checker_set(&map, 0.5f, 0.5f, 1, 1);
    assert_float_equal(mapped(&map, 1, &hit).z, 1, 1e-6);
}

static void a_normal_maps_terminator_is_softened_for_diffuse_lobes(void **state)
{
    (void)state;
    struct checker map;
    struct hit hit = kit_hit(UP, UP);
    hit.tangent = vec3(1, 0, 0);
    hit.uv[0] = 0.75f;
    checker_set(&map, 0.5f + 0.3f, 0.5f, 0.5f + 0.4f, 1); /* (0.6, 0, 0.8) */
    struct closure *c = kit_mix(diffuse(1), kit_dye(0, 1, 420, 560, 1, false), kit_value(0.5f));
    for (int i = 0; i < 2; i++) {
        c->child[i]->normal_map = texture_of(&map, TEXTURE_COLOR);
        c->child[i]->normal_strength = 1;
    }
    struct material *m = kit_compile(c);
    struct surface s;
    material_shade(m, &hit, UP, &s);
    const struct vec3 n = {0.6f, 0, 0.8f};
    for (float x = -0.9f; x < 1; x += 0.2f) {
        struct vec3 light = vec3(x, 0, sqrtf(1 - x * x));
        double cosine = dot(n, light), g = light.z / (cosine * 0.8),
               soft = g >= 1 ? 1 : g + g * g - g * g * g;
        double lambert = cosine > 0 ? 0.5 * TOP * cosine / light.z * soft : 0;
        double dye = spectrum_eval(surface_fluorescent_absorption(&s, 0), 430) *
                     spectrum_eval(surface_fluorescent_emission(&s, 0), 570);
        assert_float_equal(surface_elastic(&s, light, UP, 500), lambert, 1e-5);
        assert_float_equal(surface_fluorescent(&s, 0, light, UP, 430, 570), lambert * dye, 1e-5);
    }
    material_destroy(m);
}

static void directions_between_the_two_normals_horizons_get_no_light(void **state)
{
    (void)state;
    struct material *m = kit_compile(diffuse(1));
    struct vec3 ns = normalize(vec3(0.6f, 0, 0.8f));
    struct surface s = kit_surface(m, UP, ns);
    struct vec3 below_ns = normalize(vec3(-0.9f, 0, 0.2f)), below_ng = normalize(vec3(0.9f, 0, -0.2f));
    assert_true(dot(below_ns, ns) < 0 && dot(below_ng, ns) > 0);
    assert_true(surface_elastic(&s, below_ns, UP, 500) == 0 && surface_elastic(&s, below_ng, UP, 500) == 0);
    assert_true(surface_pdf_elastic(&s, SIDE_CAMERA, UP, below_ns, 500) == 0);
    assert_true(surface_pdf_elastic(&s, SIDE_LIGHT, below_ns, UP, 500) == 0);
    assert_true(surface_pdf_elastic(&s, SIDE_CAMERA, UP, below_ng, 500) == 0);
    struct vec3 fine = normalize(vec3(0.2f, 0.5f, 0.6f));
    assert_float_equal(surface_elastic(&s, fine, UP, 500), TOP * dot(fine, ns) / dot(fine, UP), 1e-6);
    assert_float_equal(surface_pdf_elastic(&s, SIDE_LIGHT, fine, UP, 500), TOP, 1e-6);
    material_destroy(m);
}

/* A bump that turns away from the camera is not black: what it sends out is the same in all directions. */
static void a_diffuse_surface_is_seen_from_all_of_its_geometric_side(void **state)
{
    (void)state;
    struct closure *dye = kit_dye(0.5f, 0.5f, 420, 560, 1, false);
    struct material *m = kit_compile(kit_mix(diffuse(1), dye, kit_value(0.5f)));
    struct vec3 ns = normalize(vec3(0.6f, 0, 0.8f)), below_ns = normalize(vec3(-0.9f, 0, 0.2f));
    struct surface s = kit_surface(m, UP, ns);
    assert_float_equal(surface_elastic(&s, UP, below_ns, 500), surface_elastic(&s, UP, UP, 500), 1e-6);
    assert_float_equal(surface_fluorescent(&s, 0, UP, below_ns, 430, 570),
                       surface_fluorescent(&s, 0, UP, UP, 430, 570), 1e-8);
    assert_true(surface_pdf_elastic(&s, SIDE_LIGHT, UP, below_ns, 500) > 0);
    assert_true(surface_pdf_elastic(&s, SIDE_CAMERA, below_ns, UP, 500) > 0);
    assert_true(surface_elastic(&s, UP, negate(below_ns), 500) == 0);
    material_destroy(m);
}

/* --- Emission ------------------------------------------------------------------------------------------------ */

static void emission_is_weighted_and_one_sided_unless_asked(void **state)
{
    (void)state;
    struct hit hit = kit_hit(UP, UP);
    struct material *m = kit_compile(kit_mix(diffuse(0.5f), emission(4, false), kit_value(0.25f)));
    assert_true(material_emits(m) && !material_emits_on_both_sides(m));
    assert_float_equal(material_emission(m, &hit, UP, 500), 1, 1e-6);
    assert_true(material_emission(m, &hit, negate(UP), 500) == 0);
    assert_float_equal(spectrum_eval(material_emission_shape(m), 500), 1, 1e-6);
    material_destroy(m);
    m = kit_compile(kit_add(emission(1, false), emission(2, true)));
    assert_true(material_emits_on_both_sides(m));
    assert_float_equal(material_emission(m, &hit, UP, 500), 3, 1e-6);
    assert_float_equal(material_emission(m, &hit, negate(UP), 500), 2, 1e-6);
    material_destroy(m);
    m = kit_compile(diffuse(0.5f));
    assert_true(!material_emits(m) && !material_emission_shape(m));
    material_destroy(m);
}

/* --- Oren–Nayar ---------------------------------------------------------------------------------------------- */

/* ∫ f cos over the hemisphere, by the midpoint rule. */
static double diffuse_albedo(float roughness, bool multi_scatter, float cosine)
{
    enum { N = 300 };
    struct closure *c = diffuse(1);
    c->value[0] = kit_value(roughness);
    c->option[0] = multi_scatter;
    struct material *m = kit_compile(c);
    struct surface s = kit_surface(m, UP, UP);
    struct vec3 camera = vec3(sqrtf(1 - cosine * cosine), 0, cosine);
    double sum = 0;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            double z = (i + 0.5) / N, phi = 2 * M_PI * (j + 0.5) / N, r = sqrt(1 - z * z);
            struct vec3 light = vec3((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z);
            sum += surface_elastic(&s, light, camera, 500) * z * 2 * M_PI / ((double)N * N);
        }
    material_destroy(m);
    return sum;
}

static void white_oren_nayar_loses_what_further_bounces_give_back(void **state)
{
    (void)state;
    for (float cosine = 0.15f; cosine < 1; cosine += 0.2f) {
        assert_float_equal(diffuse_albedo(0, true, cosine), 1, 1e-4);
        assert_true(diffuse_albedo(0.8f, false, cosine) < 0.98);
        assert_float_equal(diffuse_albedo(0.8f, true, cosine), 1, 2e-3);
    }
}

/* --- Errors -------------------------------------------------------------------------------------------------- */

static void expect_error(struct closure *c, const char *property)
{
    stokes_error err = {0};
    assert_null(kit_try_compile(c, NULL, &err));
    assert_string_equal(err.object, "test");
    assert_string_equal(err.property, property);
    assert_true(err.text[0]);
}

static struct closure *glass(struct ior ior)
{
    struct closure *c = kit_bsdf("dielectric");
    c->ior = ior;
    return c;
}

static void bad_input_names_its_property(void **state)
{
    (void)state;
    expect_error(diffuse(1.2f), "reflectance");
    expect_error(diffuse(-0.1f), "reflectance");
    expect_error(emission(-1, false), "emission");
    expect_error(kit_bsdf("conductor"), "eta");
    expect_error(kit_bsdf("fluorescent"), "absorption");
    expect_error(kit_dye(0.5f, 1, 400, 500, -1, false), "yield");
    expect_error(glass((struct ior){IOR_CONSTANT, {50}}), "ior");
    expect_error(glass((struct ior){IOR_ABBE, {1.5, 0}}), "ior");
    expect_error(glass((struct ior){IOR_SELLMEIER, {1, 0.2}}), "ior"); /* a pole at 447 nm */
    struct closure *c = kit_bsdf("principled");
    c->number[0] = 5;
    expect_error(c, "model");
    c = diffuse(0.1f);
    for (int i = 0; i < SURFACE_LOBES; i++)
        c = kit_add(c, diffuse(0.1f));
    expect_error(c, "surface");
}

static void every_kind_has_a_signature_that_finds_it(void **state)
{
    (void)state;
    for (size_t i = 0; bsdf_kind_at(i); i++) {
        const struct bsdf_signature *s = bsdf_kind_signature(bsdf_kind_at(i));
        assert_true(bsdf_kind_find(s->name) == bsdf_kind_at(i));
    }
    assert_null(bsdf_kind_find("velvet"));
}

/* --- Indices of refraction ------------------------------------------------------------------------------------- */

static void indices_meet_their_definitions(void **state)
{
    (void)state;
    struct ior abbe = {IOR_ABBE, {1.5168, 64.17}}, bk7;
    double nf = ior_eval(&abbe, 486.134f), nd = ior_eval(&abbe, 589.294f), nc = ior_eval(&abbe, 656.281f);
    assert_float_equal(nd, 1.5168, 1e-6);
    assert_float_equal((nd - 1) / (nf - nc), 64.17, 0.01);
    assert_true(ior_library("BK7", &bk7));
    assert_float_equal(ior_eval(&bk7, 587.56f), 1.5168, 2e-5); /* SCHOTT's data sheet */
    assert_float_equal(ior_eval(&bk7, 486.13f), 1.52238, 2e-5);
    assert_false(ior_library("jelly", &bk7));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mix_and_add_flatten_with_products_of_factors),
        cmocka_unit_test(branches_without_weight_and_black_lobes_are_dropped),
        cmocka_unit_test(mixing_twice_with_one_varying_factor_is_a_square),
        cmocka_unit_test(a_fresnel_mix_belongs_to_the_cameras_direction_from_both_sides),
        cmocka_unit_test(light_sub_paths_give_a_chance_to_what_some_view_can_see),
        cmocka_unit_test(a_scaled_and_offset_fresnel_is_clamped_as_a_mix_factor),
        cmocka_unit_test(what_a_factor_cannot_keep_symbolic_is_warned_of),
        cmocka_unit_test(backfacing_tells_the_sides_apart),
        cmocka_unit_test(shadow_rays_see_the_weight_and_colour_of_transparent_lobes),
        cmocka_unit_test(a_holdout_is_its_weight_and_scatters_nothing),
        cmocka_unit_test(a_textured_factor_masks_per_texel),
        cmocka_unit_test(a_textured_concentration_varies_the_dye),
        cmocka_unit_test(colour_textures_are_upsampled_reflectances_and_emissions),
        cmocka_unit_test(normal_maps_turn_the_frame_in_tangent_space),
        cmocka_unit_test(a_sunk_normal_stays_on_the_side_of_the_geometry),
        cmocka_unit_test(a_normal_maps_terminator_is_softened_for_diffuse_lobes),
        cmocka_unit_test(directions_between_the_two_normals_horizons_get_no_light),
        cmocka_unit_test(a_diffuse_surface_is_seen_from_all_of_its_geometric_side),
        cmocka_unit_test(emission_is_weighted_and_one_sided_unless_asked),
        cmocka_unit_test(white_oren_nayar_loses_what_further_bounces_give_back),
        cmocka_unit_test(bad_input_names_its_property),
        cmocka_unit_test(every_kind_has_a_signature_that_finds_it),
        cmocka_unit_test(indices_meet_their_definitions),
    };
    return cmocka_run_group_tests_name("material, closures", tests, NULL, NULL);
}
