/* Volumes by themselves: phase functions, how coefficients add up, the rates of distances, and what the stream says of them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "material/surface.h"
#include "statistics.h"
#include "stream_kit.h"

#include <cmocka.h>

static const struct range range = {300, 830};
static const float anisotropies[] = {-0.95f, -0.5f, 0, 1e-4f, 0.3f, 0.8f, 0.99f};
enum { ANISOTROPIES = sizeof anisotropies / sizeof *anisotropies, BINS = 20, DRAWS = 20000 };

/* --- Phase functions ------------------------------------------------------------------------------------------- */

static struct vec3 at_cosine(double cosine)
{
    return vec3((float)sqrt(fmax(0, 1 - cosine * cosine)), 0, (float)cosine);
}

/* P(cos of the deflection < x), the textbook's integral of Henyey and Greenstein's function. */
static double cdf(double g, double x)
{
    if (fabs(g) < 1e-3)
        return (1 + x) / 2 + g * 3 * (x * x - 1) / 4;
    return (1 - g * g) / (2 * g) * (1 / sqrt(1 + g * g - 2 * g * x) - 1 / (1 + g));
}

static void phase_functions_are_normalised_and_have_mean_cosine_g(void **state)
{
    (void)state;
    const struct vec3 arriving = vec3(0, 0, -1); /* light comes from below and goes on upward */
    for (int i = 0; i < ANISOTROPIES; i++) {
        double g = anisotropies[i], sum = 0, mean = 0;
        enum { STEPS = 400000 };
        for (int k = 0; k < STEPS; k++) {
            double cosine = -1 + 2 * (k + 0.5) / STEPS;
            double share =
                4 * (double)PI_F / STEPS * (double)phase_value(anisotropies[i], arriving, at_cosine(cosine));
            sum += share;
            mean += share * cosine;
        }
        assert_float_equal(sum, 1, 1e-3);
        assert_float_equal(mean, g, 1e-3);
    }
    /* Forward if positive. */
    assert_true(phase_value(0.5f, arriving, vec3(0, 0, 1)) > phase_value(0.5f, arriving, vec3(0, 0, -1)));
}

static void phase_functions_are_drawn_as_their_values_say(void **state)
{
    (void)state;
    const struct vec3 arriving = normalize(vec3(0.3f, -0.7f, 0.2f));
    for (int i = 0; i < ANISOTROPIES; i++) {
        double observed[BINS] = {0}, expected[BINS], g = anisotropies[i];
        for (int k = 0; k < DRAWS; k++) {
            const float u[2] = {(float)independent(11, 2 * (uint64_t)k),
                                (float)independent(11, 2 * (uint64_t)k + 1)};
            struct vec3 leaving = phase_sample(anisotropies[i], arriving, u);
            assert_float_equal(length(leaving), 1, 1e-5);
            /* Equal shares by the exact cdf. */
            double share = cdf(g, -(double)dot(arriving, leaving));
            int bin = (int)(share * BINS);
            observed[bin < 0 ? 0 : bin >= BINS ? BINS - 1 : bin]++;
        }
        for (int bin = 0; bin < BINS; bin++)
            expected[bin] = (double)DRAWS / BINS;
        assert_distributed(observed, expected, BINS, (struct power){.sees_error = 0.1});
    }
}

/* --- As a vertex ------------------------------------------------------------------------------------------------ */

static struct volume *finished(struct volume *v)
{
    assert_true(v && volume_finish(v));
    return v;
}

static struct spectrum *ramp(float first, float last)
{
    struct spectrum *s = spectrum_table(range, (float[2]){range.min, range.max}, (float[2]){first, last}, 2,
                                        BEYOND_HOLD, "ramp", NULL);
    assert_non_null(s);
    return s;
}

/* Three lobes of two volumes, one of them twice: the sampled density is the evaluated one, values are the sum, both directions agree. */
static void a_vertex_in_overlapping_volumes_scatters_their_sum(void **state)
{
    (void)state;
    struct volume *two = finished(volume_blend(volume_create(ramp(1, 3), NULL, 0.6f), 1,
                                               volume_create(ramp(2, 0), NULL, -0.3f), 1, NULL)),
                  *one = finished(volume_create(ramp(0.5f, 0.5f), ramp(1, 1), 0.1f));
    struct surface s;
    volume_shade((const struct volume *[]){two, one}, (int[]){1, 2}, 2, NULL, &s);
    assert_true(s.has_elastic && s.connects && !s.is_matte && s.lobe_count == 3);
    const struct vec3 arriving = normalize(vec3(1, 2, -0.5f));
    const float lambda = 700, t = (700 - 300) / 530.0f;
    for (int k = 0; k < 1000; k++) {
        float u[4];
        struct scatter drawn;
        for (int i = 0; i < 4; i++)
            u[i] = (float)independent(5, 4 * (uint64_t)k + (uint64_t)i);
        assert_true(surface_sample(&s, SIDE_CAMERA, arriving, lambda, u, &drawn));
        struct vec3 w = drawn.direction;
        float value = (1 + 2 * t) * phase_value(0.6f, arriving, w) +
                      2 * (1 - t) * phase_value(-0.3f, arriving, w) +
                      2 * 0.5f * phase_value(0.1f, arriving, w);
        assert_true(fabsf(drawn.value / value - 1) < 1e-4f);
        assert_float_equal(surface_elastic(&s, w, arriving, lambda), value, 1e-4f * value);
        assert_float_equal(surface_elastic(&s, arriving, w, lambda), value, 1e-4f * value);
        float pdf = surface_pdf_elastic(&s, SIDE_CAMERA, arriving, w, lambda);
        assert_float_equal(drawn.pdf, pdf, 1e-4f * pdf);
        assert_float_equal(drawn.pdf_other, pdf, 1e-4f * pdf); /* nothing tells the sides apart */
        assert_int_equal(drawn.depth_class, SCATTER_VOLUME);
    }
    volume_destroy(two);
    volume_destroy(one);
}

static void rates_lie_between_the_least_and_the_largest_extinction(void **state)
{
    (void)state;
    struct volume *v = finished(volume_create(ramp(0.1f, 4), ramp(0.2f, 0.2f), 0));
    assert_float_equal(v->rate[0], 0.3, 1e-5);
    assert_float_equal(v->rate[VOLUME_RATES - 1], 4.2, 1e-5);
    for (int k = 0; k < VOLUME_RATES; k++)
        assert_true(v->rate[k] >= v->rate[0] && v->rate[k] <= v->rate[VOLUME_RATES - 1]);
    volume_destroy(v);
    v = finished(volume_create(NULL, ramp(1, 2), 0)); /* what does not scatter takes no distances */
    assert_false(volume_scatters(v));
    assert_false(volume_is_empty(v));
    volume_destroy(v);
    v = finished(volume_create(ramp(0, 0), NULL, 0));
    assert_true(volume_is_empty(v));
    volume_destroy(v);
}

/* --- The stream --------------------------------------------------------------------------------------------------- */

#define HALF "\"color\": 0.25, \"density\": 8"

static void every_form_of_a_volume_has_its_coefficients(void **state)
{
    (void)state;
    static const struct {
        const char *json;
        double scattering, absorption, g; /* at 550 nm; of the first phase function */
    } cases[] = {
        {"{\"volume\": \"scatter\"}", 0.8, 0, 0},
        {"{\"volume\": \"scatter\", " HALF ", \"anisotropy\": -0.5}", 2, 0, -0.5},
        {"{\"volume\": \"absorption\"}", 0, 0.2, 0},
        {"{\"volume\": \"absorption\", " HALF "}", 0, 6, 0},
        {"{\"volume\": \"absorption\", \"color\": 2}", 0, 0, 0},
        {"{\"volume\": \"principled\"}", 0.5, 0.5, 0},
        {"{\"volume\": \"principled\", " HALF ", \"absorption_color\": 0.5, \"anisotropy\": 0.25}", 2, 3,
         0.25},
        {"{\"volume\": \"coefficients\", \"scattering\": 3, \"absorption\": 5, \"anisotropy\": 0.1}", 3, 5,
         0.1},
        {"{\"volume\": \"coefficients\"}", 0, 0, 0},
        {"{\"add\": [{\"volume\": \"scatter\", " HALF "}, {\"volume\": \"absorption\", " HALF "}]}", 2, 6, 0},
        {"{\"add\": [{\"volume\": \"scatter\", " HALF "}, {\"volume\": \"scatter\", " HALF "}]}", 4, 0, 0},
        {"{\"mix\": [{\"volume\": \"scatter\", " HALF "}, {\"volume\": \"absorption\", " HALF
         "}], \"factor\": 0.25}",
         1.5, 1.5, 0},
        {"{\"mix\": [{\"volume\": \"scatter\"}, null], \"factor\": 1}", 0, 0, 0},
        {"null", 0, 0, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct reading reading = {0};
        struct place place = reading_start(&reading, cases[i].json);
        struct volume *v = read_volume(&place);
        assert_non_null(v);
        double scattering = v->phase_count ? (double)spectrum_eval(v->phase[0].scattering, 550) : 0;
        double absorption = v->absorption ? (double)spectrum_eval(v->absorption, 550) : 0;
        assert_float_equal(scattering, cases[i].scattering, 1e-5);
        assert_float_equal(absorption, cases[i].absorption, 1e-5);
        assert_float_equal(v->phase_count ? v->phase[0].g : 0, cases[i].g, 1e-6);
        volume_destroy(v);
        reading_end(&reading);
    }
}

static void a_faulty_volume_is_named(void **state)
{
    (void)state;
    static const struct {
        const char *json, *property, *why;
    } cases[] = {
        {"7", "", ""},
        {"{}", "", "is no volume"},
        {"{\"volume\": \"smoke\"}", "volume", "smoke"},
        {"{\"volume\": \"scatter\", \"density\": -1}", "density", "is not within"},
        {"{\"volume\": \"scatter\", \"density\": 1e30}", "density", "is not within"},
        {"{\"volume\": \"scatter\", \"density\": \"thick\"}", "density", ""},
        {"{\"volume\": \"scatter\", \"color\": -0.1}", "color", "must not be negative"},
        {"{\"volume\": \"scatter\", \"color\": 1e30}", "", "per metre"},
        {"{\"volume\": \"scatter\", \"color\": {\"texture\": {\"image\": \"i\"}}}", "color", "cannot vary"},
        {"{\"volume\": \"scatter\", \"anisotropy\": 1}", "anisotropy", "between -1 and 1"},
        {"{\"volume\": \"principled\", \"anisotropy\": -1}", "anisotropy", "between -1 and 1"},
        {"{\"volume\": \"principled\", \"anisotropy\": 0.999999999999}", "anisotropy", "between -1 and 1"},
        {"{\"volume\": \"coefficients\", \"absorption\": -2}", "absorption", "must not be negative"},
        {"{\"volume\": \"coefficients\", \"scattering\": {\"gaussian\": {\"mean\": 500, \"sigma\": 20, "
         "\"peak\": -1}}}",
         "scattering", "must not be negative"},
        {"{\"add\": [null]}", "add", "2 are wanted"},
        {"{\"add\": [null, {\"volume\": 3}]}", "add[1].volume", ""},
        {"{\"mix\": [null, null]}", "factor", ""},
        {"{\"mix\": [null, null], \"factor\": 2}", "factor", "is not within"},
        {"{\"mix\": [null, null], \"factor\": {\"facing\": 0.5}}", "factor", ""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct reading reading = {0};
        struct place place = reading_start(&reading, cases[i].json);
        assert_null(read_volume(&place));
        assert_string_equal(reading.err.object, "thing");
        assert_non_null(strstr(reading.err.property, cases[i].property));
        assert_true(*reading.err.text && strstr(reading.err.text, cases[i].why));
        reading_end(&reading);
    }
}

static void nesting_and_phase_functions_have_their_limits(void **state)
{
    (void)state;
    char deep[4096] = "null", wrapped[sizeof deep];
    for (int i = 0; i < EXPRESSION_DEPTH; i++) {
        snprintf(wrapped, sizeof wrapped, "{\"add\": [%.4000s, null]}", deep);
        strcpy(deep, wrapped);
    }
    struct reading reading = {0};
    struct place place = reading_start(&reading, deep);
    assert_null(read_volume(&place));
    assert_non_null(strstr(reading.err.text, "nested"));
    reading_end(&reading);

    char many[sizeof wrapped] = "null";
    for (int i = 0; i <= VOLUME_PHASES; i++) {
        snprintf(wrapped, sizeof wrapped,
                 "{\"add\": [%.4000s, {\"volume\": \"scatter\", \"anisotropy\": 0.%d}]}", many, i);
        strcpy(many, wrapped);
    }
    memset(&reading, 0, sizeof reading);
    place = reading_start(&reading, many);
    assert_null(read_volume(&place));
    assert_non_null(strstr(reading.err.text, "more than 4 different"));
    reading_end(&reading);
}

static void a_material_with_a_faulty_volume_changes_nothing(void **state)
{
    (void)state;
    stokes_session *session = stream_greeted();
    stokes_error err;
    assert_false(stream_send(
        session, "material",
        "{\"name\": \"m\", \"surface\": null, \"volume\": {\"volume\": \"scatter\", \"density\": -1}}",
        &err));
    assert_string_equal(err.object, "m");
    assert_string_equal(err.property, "material.volume.density");
    assert_int_equal(scene_statistics(session->scene).materials, 0);
    assert_false(stream_send(session, "world",
                             "{\"kind\": \"constant\", \"emission\": {\"rgb\": [1, 1, 1]}, \"volume\": []}",
                             &err));
    assert_true(stream_send(
        session, "world",
        "{\"kind\": \"constant\", \"emission\": {\"rgb\": [1, 1, 1]}, \"volume\": {\"volume\": \"scatter\"}}",
        &err));
    stokes_session_destroy(session);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(phase_functions_are_normalised_and_have_mean_cosine_g),
        cmocka_unit_test(phase_functions_are_drawn_as_their_values_say),
        cmocka_unit_test(a_vertex_in_overlapping_volumes_scatters_their_sum),
        cmocka_unit_test(rates_lie_between_the_least_and_the_largest_extinction),
        cmocka_unit_test(every_form_of_a_volume_has_its_coefficients),
        cmocka_unit_test(a_faulty_volume_is_named),
        cmocka_unit_test(nesting_and_phase_functions_have_their_limits),
        cmocka_unit_test(a_material_with_a_faulty_volume_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
