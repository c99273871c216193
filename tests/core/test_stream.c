/* Claims about csrc/stream and csrc/session: frames, expressions, settings, what a failed frame leaves, fingerprints, the inbox. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#undef fail /* cmocka's; ours fills an error */

#include "base/os.h"
#include "stream/expressions.h"
#include "stream/frame.h"
#include "stream/inbox.h"

/* --- Help -------------------------------------------------------------------------------------------------- */

static bool send_with(stokes_session *session, const char *name, const char *json, const void *blobs,
                      size_t bytes, stokes_error *err)
{
    return stokes_session_apply(session, name, true, json, strlen(json), blobs, bytes, NULL, 0, err);
}

static bool send(stokes_session *session, const char *name, const char *json, stokes_error *err)
{
    return send_with(session, name, json, NULL, 0, err);
}

static stokes_session *greeted(void)
{
    stokes_error err;
    stokes_session *session = stokes_session_create(NULL);
    assert_non_null(session);
    assert_true(send(session, "hello", "{\"version\": 1}", &err));
    return session;
}

/* An expression read from JSON in a message named "test" of the object "thing". */
struct reading {
    stokes_session *session;
    struct message message;
    json_t *json;
    stokes_error err;
};

static struct place start_reading(struct reading *reading, const char *json)
{
    reading->session = greeted();
    reading->message = (struct message){
        .session = reading->session, .name = "test", .object = "thing", .err = &reading->err};
    reading->json = json_loads(json, JSON_DECODE_ANY, NULL);
    assert_non_null(reading->json);
    return place_root(&reading->message, reading->json);
}

static void end_reading(struct reading *reading)
{
    message_free(&reading->message);
    json_decref(reading->json);
    stokes_session_destroy(reading->session);
}

static double spectrum_at(const char *json, enum beyond beyond, float lambda_nm)
{
    struct reading reading;
    struct place place = start_reading(&reading, json);
    struct spectrum *spectrum = read_spectrum(&place, beyond, EXPRESSION_DEPTH);
    if (!spectrum)
        print_error("%s: %s\n", json, reading.err.text);
    assert_non_null(spectrum);
    double value = spectrum_eval(spectrum, lambda_nm);
    spectrum_destroy(spectrum);
    end_reading(&reading);
    return value;
}

/* --- Frames ------------------------------------------------------------------------------------------------ */

static void a_frame_is_read_as_it_was_built(void **state)
{
    (void)state;
    static const char *const texts[] = {"", "{}", "{\"a\": \"0123456789abcdef\"}", "0123456789abcdef"};
    for (size_t i = 0; i < 4; i++) {
        size_t bytes;
        unsigned char *built = frame_build("progress", i & 1, texts[i], strlen(texts[i]), &bytes);
        struct frame_memory memory = {built, bytes};
        struct stream_frame frame;
        stokes_error err;
        assert_int_equal(bytes % FRAME_ALIGN, 0);
        assert_int_equal(frame_read(frame_memory_source, &memory, &frame, &err), FRAME_READ);
        assert_string_equal(frame.name, "progress");
        assert_int_equal(frame.mandatory, i & 1);
        assert_int_equal(frame.json_bytes, strlen(texts[i]));
        assert_memory_equal(frame.json, texts[i], strlen(texts[i]));
        frame_free(&frame);
        assert_int_equal(frame_read(frame_memory_source, &memory, &frame, &err), FRAME_END);
        free(built);
    }
}

static void a_frame_cut_anywhere_is_broken(void **state)
{
    (void)state;
    size_t bytes;
    unsigned char *built = frame_build("mesh", true, "{\"name\": \"Cube\"}  ", 18, &bytes);
    for (size_t cut = 1; cut < bytes; cut++) {
        struct frame_memory memory = {built, cut};
        struct stream_frame frame;
        stokes_error err = {0};
        assert_int_equal(frame_read(frame_memory_source, &memory, &frame, &err), FRAME_BROKEN);
        assert_non_null(strstr(err.text, "the stream ends after"));
    }
    free(built);
}

static void a_strange_head_is_broken(void **state)
{
    (void)state;
    static const struct {
        size_t at;
        unsigned char byte;
        const char *property, *text;
    } faults[] = {{0, 'x', "magic", "STKS"},   {4, 3, "flags", "0x2"},     {8, 0, "name", "ASCII"},
                  {8, 0x80, "name", "ASCII"},  {14, 'x', "name", "ASCII"}, {39, 0x80, "json", "64 MiB"},
                  {47, 0x80, "blob", "64 GiB"}};
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        size_t bytes;
        unsigned char *built = frame_build("mesh", true, "{}", 2, &bytes);
        built[faults[i].at] = faults[i].byte;
        struct frame_memory memory = {built, bytes};
        struct stream_frame frame;
        stokes_error err = {0};
        assert_int_equal(frame_read(frame_memory_source, &memory, &frame, &err), FRAME_BROKEN);
        assert_string_equal(err.property, faults[i].property);
        assert_non_null(strstr(err.text, faults[i].text));
        free(built);
    }
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
        struct place place = start_reading(&reading, json);
        struct closure *closure = read_closure(&place, EXPRESSION_DEPTH);
        assert_non_null(closure);
        for (int c = 0; c < CLOSURE_COLORS; c++)
            if (closure->color[c])
                assert_float_equal(spectrum_eval(closure->color[c]->spectrum, 400), places[i].beyond, 1e-6);
        closure_destroy(closure);
        end_reading(&reading);
    }
}

/* --- L ----------------------------------------------------------------------------------------------------- */

static struct emission_node *emission_of(struct reading *reading, const char *json)
{
    struct place place = start_reading(reading, json);
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
        struct place place = start_reading(&reading, "{\"rgb\": [3, 3, 3], \"scale\": 2}");
        snprintf(json, sizeof json, "{\"rgb_to_xyz\": [%s]}", matrices[i]);
        assert_true(send(reading.session, "color", json, &reading.err));
        struct emission_node *emission = read_emission(&place);
        assert_non_null(emission);
        spectrum_to_xyz(emission->spectrum, message_range(&reading.message), xyz);
        const double *m = reading.session->color.working_space.rgb_to_xyz;
        for (int c = 0; c < 3; c++)
            assert_float_equal(xyz[c], 6 * (m[3 * c] + m[3 * c + 1] + m[3 * c + 2]), 6e-3);
        emission_node_destroy(emission);
        end_reading(&reading);
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
    end_reading(&reading);
    struct emission_node *per_nm =
        emission_of(&reading, "{\"shape\": 0.5, \"scale\": 4, \"unit\": \"per_nm\"}");
    assert_float_equal(spectrum_eval(per_nm->spectrum, 500), 2, 1e-6);
    emission_node_destroy(per_nm);
    end_reading(&reading);
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
    end_reading(&reading);
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
        struct place place = start_reading(&reading, json);
        struct closure *closure = read_closure(&place, EXPRESSION_DEPTH);
        assert_non_null(closure);
        assert_ptr_equal(closure->bsdf, bsdf_kind_find(names[i]));
        closure_destroy(closure);
        end_reading(&reading);
    }
}

static void a_metal_stands_for_eta_and_k(void **state)
{
    (void)state;
    struct reading reading;
    struct place place = start_reading(&reading, "{\"bsdf\": \"conductor\", \"metal\": \"Au\"}");
    struct closure *closure = read_closure(&place, EXPRESSION_DEPTH);
    assert_non_null(closure);
    int filled = 0;
    for (int i = 0; i < CLOSURE_COLORS; i++)
        filled += closure->color[i] != NULL;
    assert_int_equal(filled, 2);
    closure_destroy(closure);
    end_reading(&reading);
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
        struct place place = start_reading(&reading, cases[i].json);
        struct spectrum *s = read_spectrum(&place, BEYOND_HOLD, EXPRESSION_DEPTH);
        assert_true((s != NULL) == (cases[i].why == NULL));
        assert_true(!cases[i].why || strstr(reading.err.text, cases[i].why));
        if (s)
            assert_float_equal(spectrum_eval(s, 550), cases[i].at_550, 0.02);
        spectrum_destroy(s);
        end_reading(&reading);
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
        struct place place = start_reading(&reading, json);
        struct closure *closure = read_closure(&place, EXPRESSION_DEPTH);
        assert_true((closure != NULL) == (cases[i].why == NULL));
        assert_true(!cases[i].why || strstr(reading.err.text, cases[i].why));
        if (closure && i == 0)
            assert_float_equal(closure->matrix->share[1], 0.2, 1e-6);
        closure_destroy(closure);
        end_reading(&reading);
    }
}

static void a_fault_is_named_by_its_path(void **state)
{
    (void)state;
    struct reading reading;
    struct place place =
        start_reading(&reading, "{\"add\": [null, {\"mix\": [null, {\"bsdf\": \"diffuse\", \"reflectance\":"
                                " {\"sum\": [0.1, {\"rgb\": [1, 2, \"x\"]}]}}], \"factor\": 0}]}");
    assert_null(read_closure(&place, EXPRESSION_DEPTH));
    assert_string_equal(reading.err.object, "thing");
    assert_memory_equal(reading.err.property, "add[1].mix[1].reflectance.sum[1].rgb[2]", 39);
    end_reading(&reading);
}

static void a_product_of_values_is_a_chain_of_pairs(void **state)
{
    (void)state;
    struct reading reading;
    struct place place = start_reading(
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
    end_reading(&reading);
}

/* --- Sessions ---------------------------------------------------------------------------------------------- */

static const float square[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
#define MESH_JSON                                                                                            \
    "{\"name\": \"Cube\", \"positions\": {\"at\": 0, \"bytes\": 48}, \"triangles\": {\"at\": 48, "           \
    "\"bytes\": 24}}"

static void send_mesh(stokes_session *session, uint32_t last_index, bool expected)
{
    unsigned char blobs[72];
    const uint32_t triangles[6] = {0, 1, 2, 0, 2, last_index};
    stokes_error err = {0};
    memcpy(blobs, square, 48);
    memcpy(blobs + 48, triangles, 24);
    assert_int_equal(send_with(session, "mesh", MESH_JSON, blobs, sizeof blobs, &err), expected);
    if (!expected) {
        assert_string_equal(err.object, "Cube");
        assert_memory_equal(err.property, "mesh.", 5);
    }
}

static void a_failed_frame_changes_nothing(void **state)
{
    (void)state;
    static const struct {
        const char *name, *json;
    } faults[] = {
        {"settings", "{\"seed\": 5, \"d0\": 10, \"threads\": \"many\"}"},
        {"settings", "{\"integrator\": \"pt\", \"techniques\": [[2, 2], [1]]}"},
        {"color", "{\"display\": \"sRGB\", \"rgb_to_xyz\": [1, 2, 3]}"},
        {"color", "{\"rgb_to_xyz\": [1, 1, 1, 1, 1, 1, 1, 1, 1]}"},
        {"material", "{\"name\": \"m\", \"surface\": {\"bsdf\": \"diffuse\", \"reflectance\": {\"rgb\": [9, "
                     "0, 0]}, \"roughness\": []}}"},
        {"light", "{\"name\": \"l\", \"kind\": \"point\", \"emission\": {\"rgb\": [1, 1, 1]}}"},
        {"camera", "{\"kind\": \"fisheye\"}"},
        {"world", "{\"kind\": \"constant\", \"emission\": {\"rgb\": [9, 9]}}"},
        {"remove", "{\"kind\": \"mesh\", \"name\": \"none\"}"},
        {"mesh", "{\"name\": \"\"}"},
        {"hello", "{\"version\": 7}"},
    };
    stokes_session *session = greeted();
    stokes_error err;
    send_mesh(session, 3, true);
    assert_true(send(session, "material", "{\"name\": \"m\", \"surface\": null}", &err));
    struct session_settings settings = session->settings;
    struct scene_statistics scene = scene_statistics(session->scene);
    uint64_t hash = session->scene_hash;
    send_mesh(session, 4, false);
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        assert_false(send(session, faults[i].name, faults[i].json, &err));
        assert_true(*err.object && *err.text);
    }
    struct scene_statistics after = scene_statistics(session->scene);
    assert_memory_equal(&session->settings, &settings, sizeof settings);
    assert_memory_equal(&after, &scene, sizeof scene);
    assert_int_equal(session->scene_hash, hash);
    assert_int_equal(tally_sum(session->outside), 0);
    assert_string_equal(session->color.display, "");
    assert_false(session->has_camera);
    stokes_session_destroy(session);
}

static void settings_that_are_not_named_stay(void **state)
{
    (void)state;
    stokes_session *session = greeted();
    stokes_error err;
    assert_true(send(session, "settings",
                     "{\"seed\": 7, \"techniques\": [[2, 1]], \"mollify_side\": \"camera\"}", &err));
    assert_true(
        send(session, "settings", "{\"spectral_bins\": {\"count\": 8, \"min\": 400, \"max\": 700}}", &err));
    assert_true(send(session, "settings", "{}", &err));
    const struct integrator_settings *s = &session->settings.integrator;
    assert_int_equal(s->seed, 7);
    assert_int_equal(s->mollify_side, SIDE_CAMERA);
    assert_int_equal(s->spectral_bins, 8);
    assert_true(!s->all_techniques && s->technique[2][1] && !s->technique[1][2]);
    assert_true(send(session, "settings", "{\"techniques\": [], \"spectral_bins\": null}", &err));
    assert_true(s->all_techniques && s->spectral_bins == 0);
    stokes_session_destroy(session);
}

static void defaults_are_those_of_the_page(void **state)
{
    (void)state;
    stokes_session *session = greeted();
    struct session_settings before = session->settings;
    stokes_error err;
    assert_true(
        send(session, "settings",
             "{\"integrator\": \"mbdpt\", \"seed\": 0, \"d0\": 50, \"shrink\": 0.2, \"kernel\": \"constant\","
             "\"mollify_side\": \"light\", \"max_path\": 32, \"max_camera\": 32, \"max_light\": 32, "
             "\"max_diffuse\": 32,"
             "\"max_glossy\": 32, \"max_transmission\": 32, \"max_transparent\": 32, \"roulette_start\": 4,"
             "\"lambda_min\": 300, \"lambda_max\": 830, \"uv_rule\": \"hold\", \"filter_width\": 1.5,"
             "\"film_transparent\": false, \"techniques\": [], \"spectral_bins\": null, \"threads\": 0,"
             "\"time_limit\": 0}",
             &err));
    assert_string_equal(session->settings.integrator.name, before.integrator.name);
    before.integrator.name = session->settings.integrator.name; /* the same name may stand in two places */
    assert_memory_equal(&session->settings, &before, sizeof before);
    stokes_session_destroy(session);
}

static void what_colours_rest_on_cannot_change_under_them(void **state)
{
    (void)state;
    stokes_session *session = greeted();
    stokes_error err;
    assert_true(send(session, "settings", "{\"lambda_min\": 320}", &err));
    assert_true(send(session, "material", "{\"name\": \"m\", \"surface\": {\"bsdf\": \"diffuse\"}}", &err));
    assert_true(send(session, "settings", "{\"lambda_min\": 320, \"seed\": 3}", &err));
    assert_false(send(session, "settings", "{\"lambda_min\": 300}", &err));
    assert_false(send(session, "settings", "{\"uv_rule\": \"zero\"}", &err));
    assert_false(send(session, "color", "{\"rgb_to_xyz\": [1, 0, 0, 0, 1, 0, 0, 0, 1]}", &err));
    assert_true(send(session, "color", "{\"exposure\": 1}", &err));
    stokes_session_destroy(session);
}

static void colours_out_of_reach_are_counted_once_for_each_object(void **state)
{
    (void)state;
    static const char red[] =
        "{\"name\": \"m\", \"surface\": {\"bsdf\": \"diffuse\", \"reflectance\": {\"rgb\": [1.5, 0, 0]}}}";
    static const char grey[] = "{\"name\": \"m\", \"surface\": {\"bsdf\": \"diffuse\", \"reflectance\": "
                               "{\"rgb\": [0.5, 0.5, 0.5]}}}";
    stokes_session *session = greeted();
    stokes_error err;
    assert_true(send(session, "material", red, &err) && send(session, "material", red, &err));
    assert_int_equal(tally_sum(session->outside), 1);
    assert_true(send(session, "material", grey, &err));
    assert_int_equal(tally_sum(session->outside), 0);
    assert_true(send(session, "material", red, &err));
    assert_true(send(session, "remove", "{\"kind\": \"material\", \"name\": \"m\"}", &err));
    assert_int_equal(tally_sum(session->outside), 0);
    stokes_session_destroy(session);
}

/* --- Images ------------------------------------------------------------------------------------------------ */

static const struct image *sent_image(stokes_session *session, const char *colorspace, bool expected)
{
    static const float texels[6] = {0.5f, 0.25f, 0, 1, 1, 0.04f};
    char json[256];
    stokes_error err;
    snprintf(json, sizeof json,
             "{\"name\": \"Photo\", \"width\": 2, \"height\": 1, \"channels\": 3, \"format\": \"f32\","
             "\"colorspace\": \"%s\", \"pixels\": {\"at\": 0, \"bytes\": 24}}",
             colorspace);
    assert_int_equal(send_with(session, "image", json, texels, sizeof texels, &err), expected);
    if (!expected)
        assert_string_equal(err.property, "image.colorspace");
    return scene_find_image(session->scene, "Photo");
}

static void an_image_arrives_in_the_working_space(void **state)
{
    (void)state;
    stokes_session *session = greeted();
    assert_null(sent_image(session, "Filmic Log", false)); /* needs a config */
    const struct image *image = sent_image(session, "data", true);
    assert_float_equal(image->rgba[0], 0.5, 0);
    image = sent_image(session, "sRGB", true);
    assert_float_equal(image->rgba[0], 0.214041, 1e-5); /* IEC 61966-2-1 */
    assert_float_equal(image->rgba[1], 0.050876, 1e-5);
    assert_float_equal(image->rgba[3], 1, 0);
    assert_float_equal(image->rgba[6], 0.04 / 12.92, 1e-5);
    assert_float_equal(image->mean[0], (0.214041 + 1) / 2, 1e-5);
    stokes_session_destroy(session);
}

static void an_image_keeps_its_colour_in_another_working_space(void **state)
{
    (void)state;
    stokes_session *session = greeted();
    struct working_space rec709;
    stokes_error err;
    assert_true(send(session, "color",
                     "{\"rgb_to_xyz\": [0.6624542, 0.1340042, 0.1561877, 0.2722287, 0.6740818, 0.0536895,"
                     "-0.0055746, 0.0040607, 1.0103391]}",
                     &err));
    const float *p = sent_image(session, "Linear Rec.709", true)->rgba;
    const double *m = session->color.working_space.rgb_to_xyz, rgb[3] = {0.5, 0.25, 0};
    working_space_rec709(&rec709);
    for (int r = 0; r < 3; r++) {
        double expected = 0, found = 0;
        for (int c = 0; c < 3; c++) {
            expected += rec709.rgb_to_xyz[3 * r + c] * rgb[c];
            found += m[3 * r + c] * (double)p[c];
        }
        assert_float_equal(found, expected, 1e-5);
    }
    stokes_session_destroy(session);
}

/* --- Fingerprints ------------------------------------------------------------------------------------------ */

static void print_of(const char *settings, uint32_t last_index, char text[SESSION_FINGERPRINT_BYTES])
{
    stokes_session *session = greeted();
    stokes_error err;
    assert_true(send(session, "settings", settings, &err));
    send_mesh(session, last_index, true);
    session_fingerprint(session, &session->settings, text);
    stokes_session_destroy(session);
}

static void a_fingerprint_sees_what_changes_the_image_and_nothing_else(void **state)
{
    (void)state;
    static const char *const same[] = {"{\"threads\": 3}", "{\"time_limit\": 9}", "{\"seed\": 0}"};
    static const char *const other[] = {"{\"integrator\": \"pt\"}",
                                        "{\"seed\": 1}",
                                        "{\"d0\": 51}",
                                        "{\"shrink\": 0.3}",
                                        "{\"mollify_side\": \"camera\"}",
                                        "{\"max_path\": 8}",
                                        "{\"max_camera\": 8}",
                                        "{\"max_light\": 8}",
                                        "{\"max_diffuse\": 8}",
                                        "{\"max_glossy\": 8}",
                                        "{\"max_transmission\": 8}",
                                        "{\"max_transparent\": 8}",
                                        "{\"roulette_start\": 8}",
                                        "{\"lambda_min\": 310}",
                                        "{\"lambda_max\": 820}",
                                        "{\"uv_rule\": \"zero\"}",
                                        "{\"filter_width\": 2}",
                                        "{\"film_transparent\": true}",
                                        "{\"techniques\": [[2, 2]]}",
                                        "{\"techniques\": [[2, 3]]}",
                                        "{\"spectral_bins\": {\"count\": 4, \"min\": 400, \"max\": 700}}"};
    char plain[SESSION_FINGERPRINT_BYTES], print[SESSION_FINGERPRINT_BYTES];
    print_of("{}", 3, plain);
    for (size_t i = 0; i < sizeof same / sizeof *same; i++) {
        print_of(same[i], 3, print);
        assert_string_equal(print, plain);
    }
    for (size_t i = 0; i < sizeof other / sizeof *other; i++) {
        print_of(other[i], 3, print);
        assert_string_not_equal(print, plain);
    }
    print_of("{}", 1, print); /* another triangle */
    assert_string_not_equal(print, plain);
}

static void overrides_are_checked_like_settings(void **state)
{
    (void)state;
    stokes_session *session = greeted();
    stokes_error err;
    struct session_settings s = session->settings;
    stokes_overrides o = stokes_overrides_default();
    assert_true(session_settings_override(&s, &o, &err));
    assert_memory_equal(&s, &session->settings, sizeof s);
    o.integrator = "pt", o.seed = 9, o.techniques = " 2,2  3,1 ", o.spectral_bins = 4;
    assert_true(session_settings_override(&s, &o, &err));
    assert_string_equal(s.integrator.name, "pt");
    assert_true(s.integrator.technique[2][2] && s.integrator.technique[3][1] && !s.integrator.all_techniques);
    assert_true(s.integrator.bins_min < s.integrator.bins_max);
    static const char *const wrong[] = {"2", "2,", "2,2,2", "2;2", "x", "-1,2", "99,1", "2,2x", "2,123,4"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        o.techniques = wrong[i];
        assert_false(session_settings_override(&s, &o, &err));
        assert_string_equal(err.property, "techniques");
    }
    o = stokes_overrides_default();
    o.max_path = 1000;
    assert_false(session_settings_override(&s, &o, &err));
    stokes_session_destroy(session);
}

static void bins_are_overridden_number_by_number(void **state)
{
    (void)state;
    stokes_session *session = greeted();
    stokes_error err;
    stokes_overrides count = stokes_overrides_default(), range = stokes_overrides_default();
    struct session_settings s = session->settings;
    count.spectral_bins = 4;
    range.bins_min_nm = 450;
    range.bins_max_nm = 650;
    assert_true(session_settings_override(&s, &count, &err)); /* the scene has none: the visible part */
    assert_float_equal(s.integrator.bins_min, 360, 0);
    assert_float_equal(s.integrator.bins_max, 830, 0);
    assert_true(
        send(session, "settings", "{\"spectral_bins\": {\"count\": 8, \"min\": 400, \"max\": 700}}", &err));
    s = session->settings;
    assert_true(session_settings_override(&s, &count, &err));
    assert_int_equal(s.integrator.spectral_bins, 4);
    assert_float_equal(s.integrator.bins_min, 400, 0);
    s = session->settings;
    assert_true(session_settings_override(&s, &range, &err));
    assert_int_equal(s.integrator.spectral_bins, 8);
    assert_float_equal(s.integrator.bins_max, 650, 0);
    stokes_session_destroy(session);
}

/* --- Inbox ------------------------------------------------------------------------------------------------- */

static void post(int fd, const char *name)
{
    size_t bytes;
    unsigned char *frame = frame_build(name, true, "{}", 2, &bytes);
    assert_true(os_write_all(fd, frame, bytes));
    free(frame);
}

static void wait_until_stopped(struct inbox *inbox, uint64_t number)
{
    double end = os_seconds() + 10;
    while (!inbox_stops(inbox, number))
        assert_true(os_seconds() < end);
}

static void a_cancel_stops_what_came_before_it(void **state)
{
    (void)state;
    int ends[2];
    uint64_t number;
    struct stream_frame frame;
    stokes_error err;
    assert_int_equal(pipe(ends), 0);
    struct inbox *inbox = inbox_open(ends[0]);
    post(ends[1], "render");
    post(ends[1], "cancel");
    post(ends[1], "render");
    wait_until_stopped(inbox, 0);
    assert_false(inbox_stops(inbox, 2));
    for (uint64_t i = 0; i < 3; i++) {
        assert_int_equal(inbox_take(inbox, &frame, &number, &err), FRAME_READ);
        assert_int_equal(number, i);
        assert_string_equal(frame.name, i == 1 ? "cancel" : "render");
        frame_free(&frame);
    }
    assert_false(inbox_stops(inbox, 2)); /* nor once all has come */
    close(ends[1]);
    wait_until_stopped(inbox, 2);
    assert_int_equal(inbox_take(inbox, &frame, &number, &err), FRAME_END);
    inbox_close(inbox);
    close(ends[0]);
}

static void a_broken_stream_is_told_once_after_what_was_whole(void **state)
{
    (void)state;
    int ends[2];
    uint64_t number;
    struct stream_frame frame;
    stokes_error err;
    assert_int_equal(pipe(ends), 0);
    struct inbox *inbox = inbox_open(ends[0]);
    post(ends[1], "settings");
    assert_true(os_write_all(ends[1], "garbage garbage garbage garbage garbage garbage.", 48));
    assert_int_equal(inbox_take(inbox, &frame, &number, &err), FRAME_READ);
    frame_free(&frame);
    assert_int_equal(inbox_take(inbox, &frame, &number, &err), FRAME_BROKEN);
    assert_string_equal(err.property, "magic");
    assert_int_equal(inbox_take(inbox, &frame, &number, &err), FRAME_END);
    inbox_close(inbox);
    close(ends[0]);
    close(ends[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_is_read_as_it_was_built),
        cmocka_unit_test(a_frame_cut_anywhere_is_broken),
        cmocka_unit_test(a_strange_head_is_broken),
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
        cmocka_unit_test(a_failed_frame_changes_nothing),
        cmocka_unit_test(settings_that_are_not_named_stay),
        cmocka_unit_test(defaults_are_those_of_the_page),
        cmocka_unit_test(what_colours_rest_on_cannot_change_under_them),
        cmocka_unit_test(colours_out_of_reach_are_counted_once_for_each_object),
        cmocka_unit_test(an_image_arrives_in_the_working_space),
        cmocka_unit_test(an_image_keeps_its_colour_in_another_working_space),
        cmocka_unit_test(a_fingerprint_sees_what_changes_the_image_and_nothing_else),
        cmocka_unit_test(overrides_are_checked_like_settings),
        cmocka_unit_test(bins_are_overridden_number_by_number),
        cmocka_unit_test(a_cancel_stops_what_came_before_it),
        cmocka_unit_test(a_broken_stream_is_told_once_after_what_was_whole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
