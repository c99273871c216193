/* Measured reradiation matrices: the instruments' formats, missing bands, noise, grids, and files that lie. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/random.h"
#include "image/exr.h"
#include "material/bispectral.h"
#include "spectrum/measured.h"

#include <cmocka.h>

/* What was told, one after another. */
struct told {
    int count;
    char text[2000];
};

static void listen(void *user, const stokes_error *what)
{
    struct told *told = user;
    size_t used = strlen(told->text);
    told->count++;
    snprintf(told->text + used, sizeof told->text - used, "%s: %s\n", what->property, what->text);
}

static stokes_matrix *try_read(const char *text, struct told *told, stokes_error *err)
{
    char *copy = strdup(text);
    *told = (struct told){0};
    stokes_matrix *m = reradiation_from_text(copy, "test", listen, told, err);
    free(copy);
    return m;
}

static stokes_matrix *must_read(const char *text, struct told *told)
{
    stokes_error err = {0};
    stokes_matrix *m = try_read(text, told, &err);
    if (!m)
        fail_msg("%s: %s", err.property, err.text);
    return m;
}

static void must_fail(const char *text, const char *why)
{
    stokes_error err = {0};
    struct told told;
    assert_null(try_read(text, &told, &err));
    if (!strstr(err.text, why))
        fail_msg("'%s' does not say '%s'", err.text, why);
    assert_string_equal(err.object, "test");
}

static float share(const stokes_matrix *m, int out, int in)
{
    return m->share[out * m->count_in + in];
}

#define BODY "r:c: 380 390 400\n380\t0.5\t0\t0\n\n390 0.1 0.6 0\n400 0.02 0.1 0.7\n410 0.01 0.03 0.2\nEOD 4\n"
#define CSV                                                                                                  \
    "outgoing\\incident,380,390,400\n380,0.5,0,0\n390,0.1,0.6,0\n400,0.02,0.1,0.7\n410,0.01,0.03,0.2\n"

static void a_bfc_matrix_is_read_whatever_its_head(void **state)
{
    (void)state;
    static const char *const heads[] = {
        "VEC_01 4\nBFC-450 Matrix File\n380 410 10 3 380 10\n",
        "VEC_01 4\r\nBFC-450 Matrix File\r\nsample 1 2 3\r\n\r\n1 2 3 4 "
        "5\r\noperator: me\r\nx\r\ny\r\nz\r\n380 410 10 3 380 10\r\n",
        "BFC-450 Matrix File\n   380   410   10   3   380   10   \n\n",
        "\xef\xbb\xbfVEC_01\t5167\nBFC-450 Matrix File\n; sample, 3; of 5\n;\n"
        "1 2 3 4 5 6\n380\t410\t10\t3\t380\t10\n"};
    for (size_t i = 0; i < sizeof heads / sizeof *heads; i++) {
        char text[1000];
        struct told told;
        snprintf(text, sizeof text, "%s%s", heads[i], BODY);
        stokes_matrix *m = must_read(text, &told), *csv = must_read(CSV, &told);
        assert_int_equal(m->count_in, 3);
        assert_int_equal(m->count_out, 4);
        assert_true(m->step_nm == 10 && m->first_in_nm == 380 && m->first_out_nm == 380);
        assert_memory_equal(m->share, csv->share, 12 * sizeof *m->share);
        assert_float_equal(share(m, 3, 1), 0.03, 1e-7);
        reradiation_destroy(m);
        reradiation_destroy(csv);
    }
}

static void separators_and_marks_of_csv_do_not_matter(void **state)
{
    (void)state;
    static const char *const same[] = {
        "\xef\xbb\xbfoutgoing;380;390;400\r\n380;0.5;0;0\r\n390;0.1;0.6;0\r\n400;0.02;0.1;0.7\r\n410;0.01;0."
        "03;0.2",
        "# a note\nx 380 390 400\n380 0.5 0 0\n390 0.1 0.6 0\n400 0.02 0.1 0.7\n\n410 0.01 0.03 0.2\n",
        "x, 380, 390, 400\n380, 0.5, 0, 0\n390, 0.1, 0.6, 0\n400, 0.02, 0.1, 0.7\n410, 0.01, 0.03, 0.2\n",
        "x;380;390;400\n380;0,5;0;0\n390;0,1;0,6;0\n400;0,02;0,1;0,7\n410;0,01;0,03;0,2\n",
        "\"\",\"380\",\"390\",\"400\"\n\"380\",\"0.5\",0,0\n390,\"0.1\",\"0.6\",\"0\"\n400,0.02,0.1,0.7\n"
        "410,0.01,0.03,\"0.2\"\n",
        "# a BFC-450 Matrix of VEC_01, r:c:\n" CSV};
    struct told told;
    stokes_matrix *wanted = must_read(CSV, &told);
    for (size_t i = 0; i < sizeof same / sizeof *same; i++) {
        stokes_matrix *m = must_read(same[i], &told);
        assert_memory_equal(m->share, wanted->share, 12 * sizeof *m->share);
        assert_int_equal(told.count, 0);
        reradiation_destroy(m);
    }
    reradiation_destroy(wanted);
}

static void missing_bands_lie_between_their_neighbours(void **state)
{
    (void)state;
    struct told told;
    stokes_matrix *m = must_read("o,400,410,420,430\n400,0.5,0,0,0\n410,,0.6,0,0\n420,nan,0.1,n/a,0\n"
                                 "430,0.2,0.1,0.2,0.9\n440,0.1,0.1,-,0.3\n",
                                 &told);
    assert_int_equal(told.count, 2); /* its last column holds more than 1 */
    assert_non_null(
        strstr(told.text, "missing: 4 of 20 bands were not measured (1 of them on the diagonal)"));
    assert_float_equal(share(m, 1, 0), 0, 1e-6); /* nothing was measured below it */
    assert_float_equal(share(m, 2, 2), (0.6 + 0.9) / 2, 1e-6);
    assert_float_equal(share(m, 4, 2), 0, 1e-6);
    reradiation_destroy(m);

    m = must_read(
        "o,400,410,420,430\n400,0.5,0.04,0,0\n410,0.1,0.6,0,0\n420,nan,0.1,0.7,0\n430,0.4,nan,0.2,0.9\n"
        "440,0.1,0.2,0.1,0.3\n",
        &told);
    assert_float_equal(share(m, 2, 0), 0.25, 1e-6);
    assert_float_equal(share(m, 3, 1), 0.15, 1e-6);
    reradiation_destroy(m);
}

/* Noise of σ = 0.001 over a peak whose sum is known, and over nothing. */
static void noise_is_taken_out_and_sums_stay(void **state)
{
    (void)state;
    enum { COUNT = 40 };
    struct random_path path = random_path(41, 0, 0);
    stokes_error err;
    struct told told = {0};
    struct measured *raw = measured_create(COUNT, COUNT, "test", &err);
    double wanted = 0;
    for (int in = 0; in < COUNT; in++) {
        raw->in[in] = raw->out[in] = 380 + 10 * in;
        for (int out = 0; out < COUNT; out++) {
            uint32_t at = 2 * (uint32_t)(in * COUNT + out);
            double u = random_at(path, at), v = random_at(path, at + 1);
            double value = 0.001 * sqrt(-2 * log(1 - u)) * cos(2 * M_PI * v);
            if (in < 10 && out > 12 && out < 22)
                value += 0.03;
            raw->share[out * COUNT + in] = (float)(out == in ? 0.5 : value);
            if (in < 10 && out > 12 && out < 22)
                wanted += raw->share[out * COUNT + in];
        }
    }
    stokes_matrix *m = measured_finish(raw, "test", listen, &told, &err);
    assert_non_null(m);
    assert_int_equal(told.count, 1);
    assert_non_null(strstr(told.text, "30 of 40 incident bands only reflect"));
    double found = 0;
    for (int in = 0; in < COUNT; in++)
        for (int out = 0; out < COUNT; out++) {
            assert_true(share(m, out, in) >= 0);
            if (in != out)
                found += share(m, out, in);
            if (in >= 10 && in != out)
                assert_true(share(m, out, in) == 0);
        }
    /* Bands beside the peak may keep up to the noise. */
    assert_float_equal(found, wanted, 0.01 * wanted);
    reradiation_destroy(m);
}

static void a_matrix_without_noise_stays_as_it_is(void **state)
{
    (void)state;
    struct told told;
    stokes_matrix *m = must_read("o,400,410,420\n400,0.5,0,0\n410,0.0001,0.6,0\n420,0.3,0,0.7\n", &told);
    assert_int_equal(told.count, 0);
    assert_float_equal(share(m, 1, 0), 0.0001, 1e-9);
    assert_true(share(m, 2, 1) == 0);
    reradiation_destroy(m);
}

/* In a noisy file an exact zero was not measured: bands near the diagonal that an instrument leaves out. */
static void zeros_of_a_noisy_file_are_missing(void **state)
{
    (void)state;
    struct told told;
    stokes_matrix *m =
        must_read("o,400,410,420,430,440\n400,0.5,0.001,-0.001,0.002,-0.001\n410,0,0.5,0.001,-0.001,0.001\n"
                  "420,0.2,0.1,0.5,-0.001,0.001\n430,0.2,0.2,0,0.5,0.001\n440,0.2,0.2,0.2,0.1,0.5\n",
                  &told);
    assert_non_null(strstr(told.text, "missing: 2 of 25"));
    assert_true(share(m, 3, 2) > 0.05);
    reradiation_destroy(m);
}

static void grids_that_differ_are_joined_and_energy_is_kept(void **state)
{
    (void)state;
    struct told told;
    /* Incident by 10, outgoing by 5: what arrives in a band leaves in the bands that it covers. */
    stokes_matrix *m =
        must_read("o,400,410,420\n395,0.1,0,0\n400,0.3,0,0\n405,0.1,0.1,0\n410,0,0.3,0\n415,0,0.1,0.1\n"
                  "420,0.05,0,0.3\n425,0.05,0,0.1\n430,0.2,0.1,0\n435,0.1,0.2,0\n",
                  &told);
    assert_non_null(strstr(told.text, "bands: of incident and outgoing light do not match"));
    assert_true(m->step_nm == 10);
    for (int in = 0; in < 3; in++) {
        static const double sums[3] = {0.9, 0.8, 0.5};
        double sum = 0;
        for (int out = 0; out < m->count_out; out++)
            sum += share(m, out, in);
        assert_float_equal(sum, sums[in], 1e-5);
    }
    reradiation_destroy(m);
    /* Uneven steps. */
    m = must_read("o,400,410,430\n400,0.5,0,0\n410,0,0.5,0\n430,0.1,0.1,0.5\n", &told);
    assert_true(m->step_nm == 20);
    reradiation_destroy(m);
}

static void more_light_than_arrives_is_told(void **state)
{
    (void)state;
    struct told told;
    reradiation_destroy(must_read("o,400,410\n400,50,0\n410,20,80\n", &told));
    assert_string_equal(
        told.text,
        "energy: up to 80 of what arrives leaves; a material gives 1 at most (are these percent?)\n");
    reradiation_destroy(must_read("o,400,410\n400,0.5,0\n410,0.6,0.8\n", &told));
    assert_string_equal(told.text, "energy: up to 1.1 of what arrives leaves; a material gives 1 at most\n");
    reradiation_destroy(must_read("o,400,410\n400,0.5,0\n410,0.5,1\n", &told));
    assert_int_equal(told.count, 0);
}

#define HEAD "VEC_01\n380 410 10 3 380 10\nr:c:"

static void what_is_wrong_is_named(void **state)
{
    (void)state;
    must_fail("", "holds no matrix");
    must_fail("\n\n# only this\n", "holds no matrix");
    must_fail("x,400\n400,1\n", "names 1 incident wavelengths");
    must_fail("x,400,abc\n", "place 3 is no incident wavelength");
    must_fail("x,400,410\n400,1\n", "line 2 has 1 values for 2 incident bands");
    must_fail("x,400,410\nabc,1,0\n", "line 2 begins with no wavelength");
    must_fail("x,400,410\n400,1,0\n", "1 outgoing");
    must_fail("x,400,410\n410,1,0\n400,0,1\n", "400 nm comes after 410 nm");
    must_fail("x,0.4,0.41\n0.4,1,0\n0.41,0,1\n", "end at 0.41: they are wanted in nm, not in µm");
    must_fail("x,4000,4100\n4000,1,0\n4100,0,1\n", "begin at 4000: they are wanted in nm, not in Å");
    must_fail("x,400,400.1\n400,1,0\n410,0,1\n", "steps of at least");
    must_fail("x,400,410\n400,1e30,0\n410,0,1\n", "is no share");
    must_fail("x,400,410\n500,1,0\n510,0,1\n", "no band was measured that holds its own light");
    must_fail("VEC_01 3\nnothing\n", "six whole numbers");
    must_fail("VEC_01\n380 410 10 3 380 10\n380 1 2 3\n", "r:c:");
    must_fail(HEAD "\n380 1 0 0\nEOD\n", "1 outgoing bands follow a head of 4");
    must_fail(HEAD "\n380 1 0 0\n", "and no EOD");
    must_fail(HEAD " 380 390\n380 1 0 0\n", "line 3 names 2 incident wavelengths, the line of bands 3");
    must_fail(HEAD " 380 400 410\n380 1 0 0\n", "line 3: place 2 is 400 nm, by the line of bands 390");
    must_fail(HEAD "\n380 1 0 0\n395 1 0 0\n", "line 5 is of 395 nm, by the line of bands of 390");
    must_fail("VEC_01\n380 410 10 100000 380 10\nr:c: 380\n", "100000 incident");
}

static void the_note_of_the_library_is_what_was_published(void **state)
{
    (void)state;
    stokes_error err;
    struct told told = {0};
    stokes_matrix *m = reradiation_library("matrix/yellow_note", "note", listen, &told, &err);
    assert_non_null(m);
    assert_int_equal(told.count, 2);
    assert_true(m->count_in == 49 && m->count_out == 41 && m->first_in_nm == 300 && m->first_out_nm == 380);
    assert_float_equal(share(m, 0, 8), 0.251802, 1e-6);
    for (int in = 0; in < 17; in++) { /* up to 460 nm it glows most at 520, band 14 */
        assert_true(share(m, 14, in) > share(m, 10, in) && share(m, 14, in) > share(m, 20, in));
        assert_true(share(m, 14, in) > 0.005f);
    }
    assert_null(reradiation_library("matrix/none", "note", NULL, NULL, &err));
    reradiation_destroy(m);
}

/* --- Bispectral pictures ------------------------------------------------------------------------------------- */

static char path[64];

static int make_file(void **state)
{
    (void)state;
    snprintf(path, sizeof path, "/tmp/stokes-test-matrix-XXXXXX");
    int fd = mkstemp(path);
    return fd < 0 ? -1 : close(fd);
}

static int remove_file(void **state)
{
    (void)state;
    return remove(path);
}

static void a_picture_holds_the_matrix(void **state)
{
    (void)state;
    stokes_error err;
    struct told told;
    stokes_matrix *m = must_read(CSV, &told);
    assert_true(bispectral_write(m, path, &err));
    stokes_matrix *again = bispectral_read(path, NULL, listen, &told, &err);
    assert_non_null(again);
    assert_true(again->count_in == 3 && again->count_out == 4 && again->step_nm == 10);
    assert_memory_equal(again->share, m->share, 12 * sizeof *m->share);
    const int outside[2] = {0, 1};
    assert_null(bispectral_read(path, outside, NULL, NULL, &err));
    assert_string_equal(err.property, "pixel");
    reradiation_destroy(again);
    reradiation_destroy(m);
}

static void give_share(const void *user, size_t channel, int y, void *values)
{
    (void)y;
    *(float *)values = ((const float *)user)[channel];
}

/* Any metre or hertz of the layout, and M00 as its draft and that draft's pictures have it. */
static void channels_are_known_by_any_name_of_the_layout(void **state)
{
    (void)state;
    static const char *const names[][3] = {
        {"M00.400,000000nm", "M00.410,000000nm", "M00.400,000000nm.410,000000nm"},
        {"T.4e-7m", "T.0,00041mm", "T.0,4um.0,00041mm"},
        {"T.749481145000000Hz", "T.731201117,073MHz", "T.749,481145THz.0,731201117PHz"},
    };
    const float shares[] = {0.5f, 0.4f, 0.3f};
    stokes_error err;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        struct exr_channel channel[3] = {0};
        for (int k = 0; k < 3; k++)
            snprintf(channel[k].name, sizeof channel[k].name, "%s", names[i][k]);
        const struct exr_layout one = {.full_width = 1,
                                       .full_height = 1,
                                       .width = 1,
                                       .height = 1,
                                       .channels = channel,
                                       .channel_count = 3};
        assert_true(exr_write(&one, give_share, shares, path, &err));
        stokes_matrix *m = bispectral_read(path, NULL, NULL, NULL, &err);
        assert_non_null(m);
        assert_true(m->count_in == 2 && m->count_out == 2);
        assert_float_equal(m->first_in_nm, 400, 1e-3);
        assert_float_equal(share(m, 0, 0), 0.5, 1e-7);
        assert_float_equal(share(m, 1, 0), 0.3, 1e-7);
        assert_float_equal(share(m, 1, 1), 0.4, 1e-7);
        reradiation_destroy(m);
    }
}

/* Every byte of a file may be wrong. What comes out is an error or a matrix, and never a crash. */
static void hostile_files_are_errors_or_matrices(void **state)
{
    (void)state;
    enum { TRIES = 3000 };
    struct random_path random = random_path(42, 0, 0);
    uint32_t next = 0;
    stokes_error err;
    struct told told;
    char texts[2][1000];
    snprintf(texts[0], sizeof texts[0], "%s", CSV);
    snprintf(texts[1], sizeof texts[1], "VEC_01 4\nBFC-450 Matrix File\n380 410 10 3 380 10\n%s", BODY);
    for (int i = 0; i < TRIES; i++) {
        char *text = strdup(texts[i & 1]);
        for (int k = 0; k < 1 + i % 4; k++) {
            size_t at = (size_t)(random_at(random, next++) * (float)strlen(texts[i & 1]));
            text[at] = "0123456789,;. \t\n-e#nr:cD"[(int)(random_at(random, next++) * 24)];
        }
        stokes_matrix *m = reradiation_from_text(text, "test", listen, &told, &err);
        assert_true(!m || reradiation_check(m, "test", &err));
        reradiation_destroy(m);
        free(text);
        told = (struct told){0};
    }
    stokes_matrix *m = must_read(CSV, &told);
    assert_true(bispectral_write(m, path, &err));
    reradiation_destroy(m);
    static unsigned char bytes[8192], changed[8192];
    FILE *file = fopen(path, "rb");
    size_t count = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    for (int i = 0; i < TRIES / 2; i++) {
        memcpy(changed, bytes, count);
        size_t at = (size_t)(random_at(random, next++) * (float)count);
        changed[at] = (unsigned char)(random_at(random, next++) * 256);
        size_t kept = i % 5 ? count : (size_t)(random_at(random, next++) * (float)count);
        file = fopen(path, "wb");
        fwrite(changed, 1, kept, file);
        fclose(file);
        m = bispectral_read(path, NULL, NULL, NULL, &err);
        assert_true(!m || reradiation_check(m, "test", &err));
        reradiation_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bfc_matrix_is_read_whatever_its_head),
        cmocka_unit_test(separators_and_marks_of_csv_do_not_matter),
        cmocka_unit_test(missing_bands_lie_between_their_neighbours),
        cmocka_unit_test(noise_is_taken_out_and_sums_stay),
        cmocka_unit_test(a_matrix_without_noise_stays_as_it_is),
        cmocka_unit_test(zeros_of_a_noisy_file_are_missing),
        cmocka_unit_test(grids_that_differ_are_joined_and_energy_is_kept),
        cmocka_unit_test(more_light_than_arrives_is_told),
        cmocka_unit_test(what_is_wrong_is_named),
        cmocka_unit_test(the_note_of_the_library_is_what_was_published),
        cmocka_unit_test_setup_teardown(a_picture_holds_the_matrix, make_file, remove_file),
        cmocka_unit_test_setup_teardown(channels_are_known_by_any_name_of_the_layout, make_file, remove_file),
        cmocka_unit_test_setup_teardown(hostile_files_are_errors_or_matrices, make_file, remove_file),
    };
    return cmocka_run_group_tests_name("measured matrices", tests, NULL, NULL);
}
