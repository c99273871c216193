/* Claims about what stands in a message: spectra, emissions, closures, matrices, and how a fault in them is named. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "stream_kit.h"

static double spectrum_at(const char *json, enum beyond beyond, float lambda_nm)
{
    struct reading reading;
    struct place place = reading_start(&reading, json);
    struct spectrum *spectrum = read_spectrum(&place, beyond, EXPRESSION_DEPTH);
    if (!spectrum)
        print_error("%s: %s\n", json, reading.err.text);
    assert_non_null(spectrum);
    double value = spectrum_eval(spectrum, lambda_nm);
    spectrum_destroy(spectrum);
    reading_end(&reading);
    return value;
}

/* --- S ----------------------------------------------------------------------------------------------------- */

static void every_form_of_a_spectrum_has_its_value(void **state)
{
    (void)state;
    assert_float_equal(spectrum_at("0.25", BEYOND_HOLD, 550), 0.25, 1e-6);
    assert_float_equal(
        spectrum_at("{\"table\": {\"lambda\": [400, 600], \"value\": [0, 1]}}", BEYOND_HOLD, 450), 0.25,
        1e-6);
    assert_float_equal(
        spectrum_at("{\"gaussian\": {\"mean\": 500, \"sigma\": 20, \"peak\": 2}}", BEYOND_ZERO, 520),
        2 * exp(-0.5), 1e-2);
    assert_float_equal(spectrum_at("{\"line\": {\"center\": 500, \"width\": 10}}", BEYOND_ZERO, 504), 1,
                       1e-6);
    assert_float_equal(spectrum_at("{\"line\": {\"center\": 500, \"width\": 10}}", BEYOND_ZERO, 506), 0,
                       1e-6);
    assert_float_equal(spectrum_at("{\"scale\": 3, \"of\": {\"scale\": 0.5, \"of\": 0.5}}", BEYOND_HOLD, 400),
                       0.75, 1e-6);
    assert_float_equal(spectrum_at("{\"sum\": [0.1, 0.2, 0.3]}", BEYOND_HOLD, 700), 0.6, 1e-6);
    assert_float_equal(
        spectrum_at("{\"product\": [0.5, {\"line\": {\"center\": 500, \"width\": 10}}]}", BEYOND_ZERO, 500),
        0.5, 1e-6);
    assert_float_equal(spectrum_at("{\"rgb\": [0.5, 0.5, 0.5]}", BEYOND_HOLD, 550), 0.5, 1e-2);
    assert_true(spectrum_at("{\"blackbody\": 3000}", BEYOND_ZERO, 700) >
                spectrum_at("{\"blackbody\": 3000}", BEYOND_ZERO, 450));
    assert_true(spectrum_at("{\"illuminant\": \"A\"}", BEYOND_ZERO, 700) >
                spectrum_at("{\"illuminant\": \"A\"}", BEYOND_ZERO, 450));
    assert_true(spectrum_at("{\"daylight\": 9000}", BEYOND_ZERO, 450) >
                spectrum_at("{\"daylight\": 9000}", BEYOND_ZERO, 700));
}

static void a_table_ends_as_its_place_says(void **state)
{
    (void)state;
    static const char table[] = "{\"table\": {\"lambda\": [500, 600], \"value\": [0.5, 1]}}";
    assert_float_equal(spectrum_at(table, BEYOND_HOLD, 400), 0.5, 1e-6);
    assert_float_equal(spectrum_at(table, BEYOND_ZERO, 400), 0, 1e-6);
    static const struct {
        const char *color;
        float beyond;
    } places[] = {{"reflectance", 0.5f}, {"absorption", 0}, {"emission", 0}};
    for (int i = 0; i < 3; i++) {
        char json[256];
        struct reading reading;
        snprintf(json, sizeof json, "{\"bsdf\": \"fluorescent\", \"%s\": %s}", places[i].color, table);
        struct place place = reading_start(&reading, json);
        struct closure *closure = read_closure(&place, EXPRESSION_DEPTH);
        assert_non_null(closure);
        for (int c = 0; c < CLOSURE_COLORS; c++)
            if (closure->color[c])
                assert_float_equal(spectrum_eval(closure->color[c]->spectrum, 400), places[i].beyond, 1e-6);
        closure_destroy(closure);
        reading_end(&reading);
    }
}

/* --- L ----------------------------------------------------------------------------------------------------- */

static struct emission_node *emission_of(struct reading *reading, const char *json)
{
    struct place place = reading_start(reading, json);
    struct emission_node *emission = read_emission(&place);
    if (!emission)
        print_error("%s: %s\n", json, reading->err.text);
    assert_non_null(emission);
    return emission;
}

static void spectrum_to_xyz(const struct spectrum *spectrum, struct range range, double xyz[3])
{
    double kappa = cmf_normalization(range.min, range.max);
    xyz[0] = xyz[1] = xyz[2] = 0;
    for (float lambda = CMF_MIN_NM; lambda <= CMF_MAX_NM; lambda += 1) {
        float cmf[3];
        cmf_eval(lambda, cmf);
        for (int i = 0; i < 3; i++)
            xyz[i] += kappa * (double)cmf[i] * (double)spectrum_eval(spectrum, lambda);
    }
}

static void a_white_light_has_the_white_of_the_working_space(void **state)
{
    (void)state;
    static const char *const matrices[] = {
        "0.4124564, 0.3575761, 0.1804375, 0.2126729, 0.7151522, 0.0721750, 0.0193339, 0.1191920, 0.9503041",
        "0.6624542, 0.1340042, 0.1561877, 0.2722287, 0.6740818, 0.0536895, -0.0055746, 0.0040607, 1.0103391"};
    for (int i = 0; i < 2; i++) { /* D65 of Rec.709, D60 of ACEScg */
        char json[512];
        double xyz[3];
        struct reading reading;
        struct place place = reading_start(&reading, "{\"rgb\": [3, 3, 3], \"scale\": 2}");
        snprintf(json, sizeof json, "{\"rgb_to_xyz\": [%s]}", matrices[i]);
        assert_true(stream_send(reading.session, "color", json, &reading.err));
        struct emission_node *emission = read_emission(&place);
        assert_non_null(emission);
        spectrum_to_xyz(emission->spectrum, message_range(&reading.message), xyz);
        const double *m = reading.session->color.working_space.rgb_to_xyz;
        for (int c = 0; c < 3; c++)
            assert_float_equal(xyz[c], 6 * (m[3 * c] + m[3 * c + 1] + m[3 * c + 2]), 6e-3);
        emission_node_destroy(emission);
        reading_end(&reading);
    }
}

static void total_is_the_integral_and_per_nm_the_value(void **state)
{
    (void)state;
    struct reading reading;
    struct emission_node *total =
        emission_of(&reading, "{\"shape\": {\"illuminant\": \"F11\"}, \"scale\": 5}");
    assert_float_equal(spectrum_integral(total->spectrum), 5, 1e-4);
    emission_node_destroy(total);
    reading_end(&reading);
    struct emission_node *per_nm =
        emission_of(&reading, "{\"shape\": 0.5, \"scale\": 4, \"unit\": \"per_nm\"}");
    assert_float_equal(spectrum_eval(per_nm->spectrum, 500), 2, 1e-6);
    emission_node_destroy(per_nm);
    reading_end(&reading);
}

static void emissions_add(void **state)
{
    (void)state;
    struct reading reading;
    struct emission_node *sum =
        emission_of(&reading, "{\"sum\": [{\"shape\": 1, \"scale\": 2}, {\"rgb\": [0, 0, 0]},"
                              " {\"sum\": [{\"shape\": {\"blackbody\": 3000}, \"scale\": 3}]}]}");
    assert_float_equal(spectrum_integral(sum->spectrum), 5, 1e-4);
    emission_node_destroy(sum);
    reading_end(&reading);
}

/* --- Closures ---------------------------------------------------------------------------------------------- */

static void every_bsdf_of_the_page_is_read_with_its_defaults(void **state)
{
    (void)state;
    static const char *const names[] = {"diffuse", "fluorescent", "dielectric",  "conductor",
                                        "glossy",  "transparent", "translucent", "principled"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char json[64];
        struct reading reading;
        snprintf(json, sizeof json, "{\"bsdf\": \"%s\"}", names[i]);
        struct place place = reading_start(&reading, json);
        struct closure *closure = read_closure(&place, EXPRESSION_DEPTH);
        assert_non_null(closure);
        assert_ptr_equal(closure->bsdf, bsdf_kind_find(names[i]));
        closure_destroy(closure);
        reading_end(&reading);
    }
}

static void a_metal_stands_for_eta_and_k(void **state)
{
    (void)state;
    struct reading reading;
    struct place place = reading_start(&reading, "{\"bsdf\": \"conductor\", \"metal\": \"Au\"}");
    struct closure *closure = read_closure(&place, EXPRESSION_DEPTH);
    assert_non_null(closure);
    int filled = 0;
    for (int i = 0; i < CLOSURE_COLORS; i++)
        filled += closure->color[i] != NULL;
    assert_int_equal(filled, 2);
    closure_destroy(closure);
    reading_end(&reading);
}

static void moments_stand_for_a_spectrum(void **state)
{
    (void)state;
    static const struct {
        const char *json, *why; /* NULL: good */
        double at_550;
    } cases[] = {
        {"{\"moments\": {\"c\": [0.5]}}", NULL, 0.5},
        {"{\"moments\": {\"c\": [0.3], \"min\": 400, \"max\": 700}}", NULL, 0.3},
        {"{\"moments\": {\"of\": 0.7, \"count\": 5}}", NULL, 0.7},
        {"{\"moments\": {\"of\": {\"library\": \"colorchecker/cyan\"}, \"count\": 64}}", NULL, 0.18},
        {"{\"rgb\": [0.4, 0.4, 0.4], \"method\": \"moments\"}", NULL, 0.4},
        {"{\"rgb\": [0.4, 0.4, 0.4], \"method\": \"other\"}", "other", 0},
        {"{\"moments\": {\"c\": [2]}}", "none beyond 1", 0},
        {"{\"moments\": {\"c\": [0.1, 0.4]}}", "belong to no reflectance", 0},
        {"{\"moments\": {\"c\": []}}", "are 0", 0},
        {"{\"moments\": {\"c\": 3}}", "", 0},
        {"{\"moments\": {\"c\": [0.5], \"min\": 700, \"max\": 400}}", "lie over", 0},
        {"{\"moments\": {\"of\": 0.5, \"count\": 65}}", "is not within", 0},
        {"{\"moments\": {\"of\": 0.5, \"count\": 2, \"min\": 900, \"max\": 1000}}", NULL, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct reading reading = {0};
        struct place place = reading_start(&reading, cases[i].json);
        struct spectrum *s = read_spectrum(&place, BEYOND_HOLD, EXPRESSION_DEPTH);
        assert_true((s != NULL) == (cases[i].why == NULL));
        assert_true(!cases[i].why || strstr(reading.err.text, cases[i].why));
        if (s)
            assert_float_equal(spectrum_eval(s, 550), cases[i].at_550, 0.02);
        spectrum_destroy(s);
        reading_end(&reading);
    }
}

static void a_matrix_has_bands_on_one_grid_and_a_share_for_each_pair(void **state)
{
    (void)state;
    static const struct {
        const char *json, *why; /* NULL: good */
    } cases[] = {
        {"{\"incident\": [380, 2], \"outgoing\": [400, 1], \"step\": 20, \"share\": [0.1, 0.2]}", NULL},
        {"{\"library\": \"matrix/yellow_note\"}", NULL},
        {"{\"library\": \"matrix/none\"}", "no matrix named"},
        {"{\"incident\": [380, 2], \"outgoing\": [390, 1], \"step\": 20, \"share\": [0.1, 0.2]}",
         "on one grid"},
        {"{\"incident\": [380, 2], \"outgoing\": [400, 1], \"step\": 20, \"share\": [0.1]}", "has 1 numbers"},
        {"{\"incident\": [380, 2], \"outgoing\": [400, 1], \"step\": 20, \"share\": [0.1, -1]}", "negative"},
        {"{\"incident\": [380, 1e9], \"outgoing\": [400, 1], \"step\": 20, \"share\": []}", "is not within"},
        {"{\"incident\": [380, 700], \"outgoing\": [400, 1], \"step\": 20, \"share\": []}", "are taken"},
        {"{\"incident\": [380], \"outgoing\": [400, 1], \"step\": 20, \"share\": []}", "2 are wanted"},
        {"7", ""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct reading reading;
        char json[512];
        snprintf(json, sizeof json, "{\"bsdf\": \"reradiation_matrix\", \"matrix\": %s}", cases[i].json);
        struct place place = reading_start(&reading, json);
        struct closure *closure = read_closure(&place, EXPRESSION_DEPTH);
        assert_true((closure != NULL) == (cases[i].why == NULL));
        assert_true(!cases[i].why || strstr(reading.err.text, cases[i].why));
        if (closure && i == 0)
            assert_float_equal(closure->matrix->share[1], 0.2, 1e-6);
        closure_destroy(closure);
        reading_end(&reading);
    }
}

static void a_fault_is_named_by_its_path(void **state)
{
    (void)state;
    struct reading reading;
    struct place place =
        reading_start(&reading, "{\"add\": [null, {\"mix\": [null, {\"bsdf\": \"diffuse\", \"reflectance\":"
                                " {\"sum\": [0.1, {\"rgb\": [1, 2, \"x\"]}]}}], \"factor\": 0}]}");
    assert_null(read_closure(&place, EXPRESSION_DEPTH));
    assert_string_equal(reading.err.object, "thing");
    assert_memory_equal(reading.err.property, "add[1].mix[1].reflectance.sum[1].rgb[2]", 39);
    reading_end(&reading);
}

static void a_product_of_values_is_a_chain_of_pairs(void **state)
{
    (void)state;
    struct reading reading;
    struct place place = reading_start(
        &reading, "{\"product\": [0.5, {\"facing\": 0.3}, {\"scale\": 2, \"offset\": 1, \"of\": 4}]}");
    struct value_node *value = read_value(&place, EXPRESSION_DEPTH);
    assert_non_null(value);
    assert_int_equal(value->kind, VALUE_PRODUCT);
    assert_int_equal(value->child[0]->kind, VALUE_PRODUCT);
    assert_int_equal(value->child[0]->child[1]->kind, VALUE_FACING);
    assert_int_equal(value->child[1]->kind, VALUE_SCALE_OFFSET);
    assert_float_equal(value->child[1]->offset, 1, 0);
    assert_float_equal(value->child[1]->child[0]->constant, 4, 0);
    value_node_destroy(value);
    reading_end(&reading);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_form_of_a_spectrum_has_its_value),
        cmocka_unit_test(a_table_ends_as_its_place_says),
        cmocka_unit_test(a_white_light_has_the_white_of_the_working_space),
        cmocka_unit_test(total_is_the_integral_and_per_nm_the_value),
        cmocka_unit_test(emissions_add),
        cmocka_unit_test(every_bsdf_of_the_page_is_read_with_its_defaults),
        cmocka_unit_test(a_metal_stands_for_eta_and_k),
        cmocka_unit_test(moments_stand_for_a_spectrum),
        cmocka_unit_test(a_matrix_has_bands_on_one_grid_and_a_share_for_each_pair),
        cmocka_unit_test(a_fault_is_named_by_its_path),
        cmocka_unit_test(a_product_of_values_is_a_chain_of_pairs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
