/* Claims about messages as they are applied: what a failed one leaves, settings, images, fingerprints, overrides. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "stream_kit.h"

/* --- Sessions ---------------------------------------------------------------------------------------------- */

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
    stokes_session *session = stream_greeted();
    stokes_error err;
    stream_send_mesh(session, 3, true);
    assert_true(stream_send(session, "material", "{\"name\": \"m\", \"surface\": null}", &err));
    struct session_settings settings = session->settings;
    struct scene_statistics scene = scene_statistics(session->scene);
    uint64_t hash = session->scene_hash;
    stream_send_mesh(session, 4, false);
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        assert_false(stream_send(session, faults[i].name, faults[i].json, &err));
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
    stokes_session *session = stream_greeted();
    stokes_error err;
    assert_true(stream_send(session, "settings",
                            "{\"seed\": 7, \"techniques\": [[2, 1]], \"mollify_side\": \"camera\"}", &err));
    assert_true(stream_send(session, "settings",
                            "{\"spectral_bins\": {\"count\": 8, \"min\": 400, \"max\": 700}}", &err));
    assert_true(stream_send(session, "settings", "{}", &err));
    const struct integrator_settings *s = &session->settings.integrator;
    assert_int_equal(s->seed, 7);
    assert_int_equal(s->mollify_side, SIDE_CAMERA);
    assert_int_equal(s->spectral_bins, 8);
    assert_true(!s->all_techniques && s->technique[2][1] && !s->technique[1][2]);
    assert_true(stream_send(session, "settings", "{\"techniques\": [], \"spectral_bins\": null}", &err));
    assert_true(s->all_techniques && s->spectral_bins == 0);
    stokes_session_destroy(session);
}

static void defaults_are_those_of_the_page(void **state)
{
    (void)state;
    stokes_session *session = stream_greeted();
    struct session_settings before = session->settings;
    stokes_error err;
    assert_true(stream_send(
        session, "settings",
        "{\"integrator\": \"bdpt\", \"seed\": 0, \"d0\": 50, \"shrink\": 0.2, \"kernel\": \"constant\","
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
    stokes_session *session = stream_greeted();
    stokes_error err;
    assert_true(stream_send(session, "settings", "{\"lambda_min\": 320}", &err));
    assert_true(
        stream_send(session, "material", "{\"name\": \"m\", \"surface\": {\"bsdf\": \"diffuse\"}}", &err));
    assert_true(stream_send(session, "settings", "{\"lambda_min\": 320, \"seed\": 3}", &err));
    assert_false(stream_send(session, "settings", "{\"lambda_min\": 300}", &err));
    assert_false(stream_send(session, "settings", "{\"uv_rule\": \"zero\"}", &err));
    assert_false(stream_send(session, "color", "{\"rgb_to_xyz\": [1, 0, 0, 0, 1, 0, 0, 0, 1]}", &err));
    assert_true(stream_send(session, "color", "{\"exposure\": 1}", &err));
    stokes_session_destroy(session);
}

static void colours_out_of_reach_are_counted_once_for_each_object(void **state)
{
    (void)state;
    static const char red[] =
        "{\"name\": \"m\", \"surface\": {\"bsdf\": \"diffuse\", \"reflectance\": {\"rgb\": [1.5, 0, 0]}}}";
    static const char grey[] = "{\"name\": \"m\", \"surface\": {\"bsdf\": \"diffuse\", \"reflectance\": "
                               "{\"rgb\": [0.5, 0.5, 0.5]}}}";
    stokes_session *session = stream_greeted();
    stokes_error err;
    assert_true(stream_send(session, "material", red, &err) && stream_send(session, "material", red, &err));
    assert_int_equal(tally_sum(session->outside), 1);
    assert_true(stream_send(session, "material", grey, &err));
    assert_int_equal(tally_sum(session->outside), 0);
    assert_true(stream_send(session, "material", red, &err));
    assert_true(stream_send(session, "remove", "{\"kind\": \"material\", \"name\": \"m\"}", &err));
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
    assert_int_equal(stream_send_with(session, "image", json, texels, sizeof texels, &err), expected);
    if (!expected)
        assert_string_equal(err.property, "image.colorspace");
    return scene_find_image(session->scene, "Photo");
}

static void an_image_arrives_in_the_working_space(void **state)
{
    (void)state;
    stokes_session *session = stream_greeted();
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
    stokes_session *session = stream_greeted();
    struct working_space rec709;
    stokes_error err;
    assert_true(
        stream_send(session, "color",
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
    stokes_session *session = stream_greeted();
    stokes_error err;
    assert_true(stream_send(session, "settings", settings, &err));
    stream_send_mesh(session, last_index, true);
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
    stokes_session *session = stream_greeted();
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
    stokes_session *session = stream_greeted();
    stokes_error err;
    stokes_overrides count = stokes_overrides_default(), range = stokes_overrides_default();
    struct session_settings s = session->settings;
    count.spectral_bins = 4;
    range.bins_min_nm = 450;
    range.bins_max_nm = 650;
    assert_true(session_settings_override(&s, &count, &err)); /* the scene has none: the visible part */
    assert_float_equal(s.integrator.bins_min, 360, 0);
    assert_float_equal(s.integrator.bins_max, 830, 0);
    assert_true(stream_send(session, "settings",
                            "{\"spectral_bins\": {\"count\": 8, \"min\": 400, \"max\": 700}}", &err));
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

int main(void)
{
    const struct CMUnitTest tests[] = {
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
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
