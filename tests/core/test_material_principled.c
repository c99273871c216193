/* Principled against Cycles' own: directional albedos, white furnaces, and what its inputs promise at their ends. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "material_kit.h"
#include "statistics.h"

#include <cmocka.h>

#define UP vec3(0, 0, 1)

struct principled_case {
    int model, multi_scatter;
    float roughness, metallic, specular, transmission, base, degrees; /* below 0: from the back */
    float albedo;
};

/* Radiance of a plane of this material under a uniform world of radiance 1, rendered by Cycles (Blender 3.4.1 for model 3, 4.2.23 for
   model 4; index 1.45, 131 072 samples; no number is off by more than 0.002). */
static const struct principled_case cycles[] = {
    {3, 0, 0.2, 0, 0.5, 0, 0.5, 5, 0.5340},    {3, 0, 0.2, 0, 0.5, 0, 0.5, 80, 0.7901},
    {3, 0, 0.2, 0, 1, 0, 0.5, 5, 0.5739},      {3, 0, 0.2, 0, 1, 0, 0.5, 80, 0.8210},
    {3, 0, 0.2, 1, 0.5, 0, 0.5, 5, 0.4992},    {3, 0, 0.2, 1, 0.5, 0, 0.5, 80, 0.6458},
    {3, 0, 0.2, 0.5, 0.5, 0, 0.5, 5, 0.5166},  {3, 0, 0.2, 0.5, 0.5, 0, 0.5, 80, 0.7179},
    {3, 0, 0.2, 0, 0.5, 1, 0.5, 5, 0.5149},    {3, 0, 0.2, 0, 0.5, 1, 0.5, 60, 0.5388},
    {3, 0, 0.2, 0, 0.5, 1, 0.5, -30, 0.5189},  {3, 0, 0.2, 0, 0.5, 0.5, 0.5, 5, 0.5247},
    {3, 0, 0.2, 0, 0.5, 0.5, 0.5, 60, 0.5592}, {3, 0, 0.2, 0, 0.5, 0.5, 0.5, -30, 0.5270},
    {3, 0, 0.5, 0, 0.5, 0, 0.5, 5, 0.5402},    {3, 0, 0.5, 0, 0.5, 0, 0.5, 80, 0.6495},
    {3, 0, 0.5, 0, 0.5, 0, 1, 5, 1.0431},      {3, 0, 0.5, 0, 0.5, 0, 1, 80, 1.1623},
    {3, 0, 0.5, 0, 1, 0, 0.5, 5, 0.5768},      {3, 0, 0.5, 0, 1, 0, 0.5, 80, 0.6833},
    {3, 0, 0.5, 1, 0.5, 0, 0.5, 5, 0.4579},    {3, 0, 0.5, 1, 0.5, 0, 0.5, 80, 0.4715},
    {3, 0, 0.5, 1, 0.5, 0, 1, 5, 0.9153},      {3, 0, 0.5, 1, 0.5, 0, 1, 80, 0.8351},
    {3, 0, 0.5, 0.5, 0.5, 0, 0.5, 5, 0.4990},  {3, 0, 0.5, 0.5, 0.5, 0, 0.5, 80, 0.5605},
    {3, 0, 0.5, 0, 0.5, 1, 0.5, 5, 0.5119},    {3, 0, 0.5, 0, 0.5, 1, 0.5, 60, 0.5210},
    {3, 0, 0.5, 0, 0.5, 1, 0.5, -30, 0.4332},  {3, 0, 0.5, 0, 0.5, 0.5, 0.5, 5, 0.5262},
    {3, 0, 0.5, 0, 0.5, 0.5, 0.5, 60, 0.5461}, {3, 0, 0.5, 0, 0.5, 0.5, 0.5, -30, 0.4875},
    {3, 0, 0.9, 0, 0.5, 0, 0.5, 5, 0.5322},    {3, 0, 0.9, 0, 0.5, 0, 0.5, 80, 0.6569},
    {3, 0, 0.9, 0, 1, 0, 0.5, 5, 0.5491},      {3, 0, 0.9, 0, 1, 0, 0.5, 80, 0.6821},
    {3, 0, 0.9, 1, 0.5, 0, 0.5, 5, 0.2105},    {3, 0, 0.9, 1, 0.5, 0, 0.5, 80, 0.3136},
    {3, 0, 0.9, 0.5, 0.5, 0, 0.5, 5, 0.3713},  {3, 0, 0.9, 0.5, 0.5, 0, 0.5, 80, 0.4852},
    {3, 0, 0.9, 0, 0.5, 1, 0.5, 5, 0.4870},    {3, 0, 0.9, 0, 0.5, 1, 0.5, 60, 0.4042},
    {3, 0, 0.9, 0, 0.5, 1, 0.5, -30, 0.2652},  {3, 0, 0.9, 0, 0.5, 0.5, 0.5, 5, 0.5098},
    {3, 0, 0.9, 0, 0.5, 0.5, 0.5, 60, 0.4776}, {3, 0, 0.9, 0, 0.5, 0.5, 0.5, -30, 0.3990},
    {4, 0, 0.5, 0, 0.5, 0, 0.5, 5, 0.5142},    {4, 0, 0.5, 0, 0.5, 0, 0.5, 80, 0.5515},
    {4, 0, 0.5, 0, 0.5, 0, 1, 5, 0.9970},      {4, 0, 0.5, 0, 0.5, 0, 1, 80, 0.9674},
    {4, 0, 0.5, 0, 1, 0, 0.5, 5, 0.5282},      {4, 0, 0.5, 0, 1, 0, 0.5, 80, 0.5655},
    {4, 0, 0.5, 1, 0.5, 0, 0.5, 5, 0.4578},    {4, 0, 0.5, 1, 0.5, 0, 0.5, 80, 0.4819},
    {4, 0, 0.5, 1, 0.5, 0, 1, 5, 0.9155},      {4, 0, 0.5, 1, 0.5, 0, 1, 80, 0.8555},
    {4, 0, 0.5, 0.5, 0.5, 0, 0.5, 5, 0.4860},  {4, 0, 0.5, 0.5, 0.5, 0, 0.5, 80, 0.5167},
    {4, 0, 0.5, 0, 0.5, 1, 0.5, 5, 0.7084},    {4, 0, 0.5, 0, 0.5, 1, 0.5, 60, 0.6960},
    {4, 0, 0.5, 0, 0.5, 1, 0.5, -30, 0.6852},  {4, 0, 0.5, 0, 0.5, 0.5, 0.5, 5, 0.6117},
    {4, 0, 0.5, 0, 0.5, 0.5, 0.5, 60, 0.6103}, {4, 0, 0.5, 0, 0.5, 0.5, 0.5, -30, 0.6000},
    {4, 1, 0.2, 0, 0.5, 0, 0.5, 5, 0.5169},    {4, 1, 0.2, 0, 0.5, 0, 0.5, 80, 0.6710},
    {4, 1, 0.2, 0, 1, 0, 0.5, 5, 0.5337},      {4, 1, 0.2, 0, 1, 0, 0.5, 80, 0.6881},
    {4, 1, 0.2, 1, 0.5, 0, 0.5, 5, 0.4996},    {4, 1, 0.2, 1, 0.5, 0, 0.5, 80, 0.6664},
    {4, 1, 0.2, 0.5, 0.5, 0, 0.5, 5, 0.5082},  {4, 1, 0.2, 0.5, 0.5, 0, 0.5, 80, 0.6687},
    {4, 1, 0.2, 0, 0.5, 1, 0.5, 5, 0.7143},    {4, 1, 0.2, 0, 0.5, 1, 0.5, 60, 0.7292},
    {4, 1, 0.2, 0, 0.5, 1, 0.5, -30, 0.7222},  {4, 1, 0.2, 0, 0.5, 0.5, 0.5, 5, 0.6160},
    {4, 1, 0.2, 0, 0.5, 0.5, 0.5, 60, 0.6350}, {4, 1, 0.2, 0, 0.5, 0.5, 0.5, -30, 0.6198},
    {4, 1, 0.5, 0, 0.5, 0, 0.5, 5, 0.5157},    {4, 1, 0.5, 0, 0.5, 0, 0.5, 80, 0.5643},
    {4, 1, 0.5, 0, 0.5, 0, 1, 5, 0.9999},      {4, 1, 0.5, 0, 0.5, 0, 1, 80, 0.9915},
    {4, 1, 0.5, 0, 1, 0, 0.5, 5, 0.5314},      {4, 1, 0.5, 0, 1, 0, 0.5, 80, 0.5817},
    {4, 1, 0.5, 1, 0.5, 0, 0.5, 5, 0.4787},    {4, 1, 0.5, 1, 0.5, 0, 0.5, 80, 0.5219},
    {4, 1, 0.5, 1, 0.5, 0, 1, 5, 1.0006},      {4, 1, 0.5, 1, 0.5, 0, 1, 80, 0.9995},
    {4, 1, 0.5, 0.5, 0.5, 0, 0.5, 5, 0.4972},  {4, 1, 0.5, 0.5, 0.5, 0, 0.5, 80, 0.5431},
    {4, 1, 0.5, 0, 0.5, 1, 0.5, 5, 0.7122},    {4, 1, 0.5, 0, 0.5, 1, 0.5, 60, 0.7160},
    {4, 1, 0.5, 0, 0.5, 1, 0.5, -30, 0.7318},  {4, 1, 0.5, 0, 0.5, 0.5, 0.5, 5, 0.6144},
    {4, 1, 0.5, 0, 0.5, 0.5, 0.5, 60, 0.6231}, {4, 1, 0.5, 0, 0.5, 0.5, 0.5, -30, 0.6242},
    {4, 1, 0.9, 0, 0.5, 0, 0.5, 5, 0.5077},    {4, 1, 0.9, 0, 0.5, 0, 0.5, 80, 0.5246},
    {4, 1, 0.9, 0, 1, 0, 0.5, 5, 0.5158},      {4, 1, 0.9, 0, 1, 0, 0.5, 80, 0.5385},
    {4, 1, 0.9, 1, 0.5, 0, 0.5, 5, 0.3134},    {4, 1, 0.9, 1, 0.5, 0, 0.5, 80, 0.4225},
    {4, 1, 0.9, 0.5, 0.5, 0, 0.5, 5, 0.4106},  {4, 1, 0.9, 0.5, 0.5, 0, 0.5, 80, 0.4736},
    {4, 1, 0.9, 0, 0.5, 1, 0.5, 5, 0.6933},    {4, 1, 0.9, 0, 0.5, 1, 0.5, 60, 0.6676},
    {4, 1, 0.9, 0, 0.5, 1, 0.5, -30, 0.6034},  {4, 1, 0.9, 0, 0.5, 0.5, 0.5, 5, 0.6010},
    {4, 1, 0.9, 0, 0.5, 0.5, 0.5, 60, 0.5905}, {4, 1, 0.9, 0, 0.5, 0.5, 0.5, -30, 0.5560},
};
#define CASES (sizeof cycles / sizeof *cycles)

static struct closure *principled(const struct principled_case *p)
{
    struct closure *c = kit_bsdf("principled");
    c->color[0] = kit_constant(p->base);
    c->value[0] = kit_value(p->metallic);
    c->value[1] = kit_value(p->roughness);
    c->value[2] = kit_value(p->specular);
    c->value[3] = kit_value(p->transmission);
    c->number[0] = p->model;
    c->number[1] = 1.45;
    c->option[0] = p->multi_scatter;
    return c;
}

/* Albedo toward the camera. Cycles leaves n² of refraction out; both cross the surface once. */
static struct batches albedo(const struct principled_case *p, uint32_t seed)
{
    struct kit_random r = {random_path(seed, 0, 0), 0};
    struct material *m = kit_compile(principled(p));
    struct surface s = kit_surface(m, UP, UP);
    float angle = fabsf(p->degrees) * PI_F / 180;
    struct vec3 w = vec3(sinf(angle), 0, p->degrees < 0 ? -cosf(angle) : cosf(angle));
    struct batches result = {0};
    for (int b = 0; b < 32; b++) {
        double sum = 0;
        enum { DRAWS = 5000 };
        for (int n = 0; n < DRAWS; n++) {
            const float u[4] = {kit_uniform(&r), kit_uniform(&r), kit_uniform(&r), kit_uniform(&r)};
            struct scatter d;
            if (!surface_sample(&s, SIDE_CAMERA, w, 550, u, &d))
                continue;
            bool crosses = d.direction.z * w.z < 0;
            sum += d.value / d.pdf * (!crosses ? 1 : w.z > 0 ? 1.45 * 1.45 : 1 / (1.45 * 1.45));
        }
        batches_add(&result, sum / DRAWS);
    }
    material_destroy(m);
    return result;
}

/* The promise of the room is 2 %; 1.2 % is what the worst of these are off (Cycles' own tables hold 16 angles). */
static void albedos_are_those_of_cycles(void **state)
{
    (void)state;
    double critical = student_critical(C_FALSE_ALARM / (2 * CASES), 31);
    for (size_t i = 0; i < CASES; i++) {
        const struct principled_case *p = &cycles[i];
        struct batches ours = albedo(p, (uint32_t)i);
        double error = batches_error(&ours), allowed = 0.012 * p->albedo + 0.002;
        assert_true(critical * error < 0.03 * p->albedo); /* sees 4 % */
        if (fabs(ours.mean - p->albedo) > allowed + critical * error)
            fail_msg("model %d multi %d roughness %g metallic %g specular %g transmission %g base %g at %g°: "
                     "%g, Cycles %g",
                     p->model, p->multi_scatter, (double)p->roughness, (double)p->metallic,
                     (double)p->specular, (double)p->transmission, (double)p->base, (double)p->degrees,
                     ours.mean, (double)p->albedo);
    }
}

/* White metal, glass and plastic of model 4 keep all energy when compensated. */
static void a_compensated_white_furnace_stays_white(void **state)
{
    (void)state;
    const float kinds[3][2] = {{1, 0}, {0, 1}, {0, 0}}; /* metallic, transmission */
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 9; i++) {
            struct principled_case p = {4,
                                        1,
                                        0.1f + 0.4f * (float)(i / 3),
                                        kinds[k][0],
                                        0.5f,
                                        kinds[k][1],
                                        1,
                                        5 + 35.0f * (float)(i % 3),
                                        1};
            struct batches ours = albedo(&p, 77);
            assert_float_equal(ours.mean, 1, 0.01 + 7 * batches_error(&ours));
        }
}

static double reflected(const struct principled_case *p, struct vec3 light, struct vec3 camera)
{
    struct material *m = kit_compile(principled(p));
    struct surface s = kit_surface(m, UP, UP);
    double value = surface_elastic(&s, light, camera, 550);
    material_destroy(m);
    return value;
}

static void without_specular_and_roughness_model_4_is_lambertian(void **state)
{
    (void)state;
    struct principled_case p = {4, 1, 0.5f, 0, 0, 0, 0.6f, 0, 0};
    struct vec3 a = normalize(vec3(0.4f, 0.1f, 0.5f)), b = normalize(vec3(-0.7f, 0.2f, 0.3f));
    assert_float_equal(reflected(&p, a, b), 0.6 / PI_F, 1e-6);
}

/* Burley 2012, as first published: (1 + (F_D90 − 1) F_L) (1 + (F_D90 − 1) F_V)/π with F_D90 = ½ + 2 roughness cos²θ_d. */
static void model_3_diffuse_is_burleys(void **state)
{
    (void)state;
    struct kit_random r = {random_path(78, 0, 0), 0};
    for (int i = 0; i < 200; i++) {
        struct principled_case p = {3, 0, kit_uniform(&r), 0, 0, 0, 0.7f, 0, 0};
        struct vec3 l = kit_direction_about(&r, UP, false), v = kit_direction_about(&r, UP, false);
        double cosine = dot(normalize(add(l, v)), l), grazing = 0.5 + 2 * p.roughness * cosine * cosine;
        double fl = pow(1 - l.z, 5), fv = pow(1 - v.z, 5);
        double expected = 0.7 / PI_F * (1 + (grazing - 1) * fl) * (1 + (grazing - 1) * fv);
        assert_float_equal(reflected(&p, l, v), expected, 1e-5);
    }
}

static void textured_inputs_keep_every_lobe_that_some_texel_needs(void **state)
{
    (void)state;
    struct principled_case p = {4, 0, 0.5f, 0, 0.5f, 0, 0.8f, 0, 0};
    struct material *m = kit_compile(principled(&p));
    assert_int_equal(m->lobe_count, 2);
    material_destroy(m);
    for (int model = 3; model <= 4; model++) {
        struct closure *c = principled(&p);
        c->number[0] = model;
        /* Facing says anything from 0 to 1. */
        c->value[0]->kind = VALUE_FACING;
        c->value[3]->kind = VALUE_FACING;
        m = kit_compile(c);
        assert_int_equal(m->lobe_count, model == 3 ? 3 : 4);
        material_destroy(m);
    }
}

/* A table over roughness and specular levels says what tables of one row say. */
static void tables_of_varying_inputs_agree_with_those_of_constant_ones(void **state)
{
    (void)state;
    struct vec3 a = normalize(vec3(0.4f, 0.1f, 0.5f)), b = normalize(vec3(-0.7f, 0.2f, 0.5f));
    struct principled_case p = {4, 1, 0.37f, 0, 0.7f, 0, 0.6f, 0, 0};
    struct closure *c = principled(&p);
    float wanted[] = {0.37f, 0.7f};
    for (int i = 0; i < 2; i++) { /* facing at normal incidence is 0, but may be anything */
        struct value_node *v = c->value[1 + i];
        v->kind = VALUE_SCALE_OFFSET;
        v->offset = wanted[i];
        v->scale = 1;
        v->child[0] = kit_value(0.5f);
        v->child[0]->kind = VALUE_FACING;
    }
    struct material *m = kit_compile(c);
    struct surface s = kit_surface(m, UP, UP);
    double exact = reflected(&p, a, b);
    assert_float_equal(surface_elastic(&s, a, b, 550), exact, 0.005 * exact);
    material_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(albedos_are_those_of_cycles),
        cmocka_unit_test(a_compensated_white_furnace_stays_white),
        cmocka_unit_test(without_specular_and_roughness_model_4_is_lambertian),
        cmocka_unit_test(model_3_diffuse_is_burleys),
        cmocka_unit_test(textured_inputs_keep_every_lobe_that_some_texel_needs),
        cmocka_unit_test(tables_of_varying_inputs_agree_with_those_of_constant_ones),
    };
    return cmocka_run_group_tests_name("material, principled", tests, NULL, NULL);
}
