/* The film's files: the same bits come back, parts merge in any order, a full disk leaves what was there, and a
   file that lies is an error. */
#include "film_kit.h"

#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "image/exr.h"
#include "statistics.h"

#include <cmocka.h>

#define UNITS ((double)((int64_t)1 << FILM_FRACTION_BITS))

static char directory[64];

static const char *in_directory(const char *name)
{
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", directory, name);
    return path;
}

static int make_directory(void **state)
{
    (void)state;
    snprintf(directory, sizeof directory, "/tmp/stokes-test-film-XXXXXX");
    return mkdtemp(directory) ? 0 : -1;
}

static int files_left(void)
{
    char command[128];
    snprintf(command, sizeof command, "ls -A %s | wc -l", directory);
    FILE *list = popen(command, "r");
    int count = -1;
    if (!list || fscanf(list, "%d", &count) != 1)
        count = -1;
    if (list)
        pclose(list);
    return count;
}

static int remove_directory(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", directory);
    return system(command);
}

static void fill(struct film *film, uint32_t seed, int first, int end)
{
    for (int i = 0; i < film->width * film->height * film->channels; i++) {
        uint64_t at = 2 * (uint64_t)i;
        film->sum[i] = (int64_t)(independent(seed, at) * exp2(60 * independent(seed, at + 1)));
    }
    film->sum[5] = FILM_SUM_MAX;
    film->saturated = 1;
    film->rejected = seed;
    film->first_sample = first;
    film->end_sample = end;
}

static const struct film_note notes[] = {{"fingerprint", "a1b2c3"}, {"integrator", "mbdpt"}, {"report", ""}};

static void write_film(const struct film *film, const char *path)
{
    stokes_error err = {0};
    struct working_space space;
    working_space_rec709(&space);
    if (!film_write_exr(film, &space, notes, 3, path, &err))
        fail_msg("%s: %s: %s", err.object, err.property, err.text);
}

static struct film *read_film(const char *path)
{
    stokes_error err = {0};
    char fingerprint[16];
    struct film *film = film_read_exr(path, fingerprint, sizeof fingerprint, &err);
    if (!film)
        fail_msg("%s: %s: %s", err.object, err.property, err.text);
    assert_string_equal(fingerprint, "a1b2c3");
    return film;
}

static void an_exr_gives_back_the_same_bits(void **state)
{
    (void)state;
    const int bins[3] = {0, 1, 53};
    for (int i = 0; i < 3; i++)
        for (int cropped = 0; cropped < 2; cropped++) {
            struct film *film = kit_film(cropped ? kit_corner : kit_whole, bins[i]);
            fill(film, 77, 32, 96);
            write_film(film, in_directory("film.exr"));
            struct film *back = read_film(in_directory("film.exr"));
            assert_true(kit_same(film, back));
            assert_true(back->x0 == film->x0 && back->y0 == film->y0 && back->full_width == 40 &&
                        back->bins == bins[i]);
            assert_true(!bins[i] || (back->bin_range.min == 380 && back->bin_range.max == 780));
            film_destroy(film);
            film_destroy(back);
        }
    assert_int_equal(files_left(), 1);
}

struct heard {
    char text[256];
};

static void hear(void *user, const char *key, const char *value)
{
    struct heard *heard = user;
    size_t length = strlen(heard->text);
    snprintf(heard->text + length, sizeof heard->text - length, "%s=%s;", key, value);
}

static void an_exr_gives_back_its_notes_and_working_space(void **state)
{
    (void)state;
    struct film *film = kit_film(kit_whole, 0);
    struct working_space wanted, found;
    working_space_rec709(&wanted);
    fill(film, 1, 0, 1);
    write_film(film, in_directory("film.exr"));
    struct heard heard = {""};
    stokes_error err;
    assert_true(film_read_notes(in_directory("film.exr"), &found, hear, &heard, &err));
    assert_string_equal(heard.text, "fingerprint=a1b2c3;integrator=mbdpt;report=;");
    assert_memory_equal(wanted.rgb_to_xyz, found.rgb_to_xyz, sizeof wanted.rgb_to_xyz);
    film_destroy(film);
}

struct bin_row {
    float value[40];
};

static bool keep_row(void *user, size_t channel, int y, const void *values, stokes_error *err)
{
    (void)channel, (void)err;
    if (y == 4)
        memcpy(user, values, sizeof(struct bin_row));
    return true;
}

static void bins_are_radiance_per_nanometre_named_by_their_centre(void **state)
{
    (void)state;
    struct film *film = kit_film(kit_whole, 20); /* 20 nm each */
    film->end_sample = 8;
    film->sum[(4 * 40 + 3) * film->channels + 4 + 7] =
        (int64_t)(UNITS * 8 * 3); /* radiance 3 in the bin 520–540 nm */
    write_film(film, in_directory("film.exr"));
    struct exr_file *file = exr_open(in_directory("film.exr"), NULL);
    struct bin_row row = {{0}};
    const struct exr_channel bin = {.name = "S0.530,000000nm"}, none = {.name = "S0.530nm"};
    assert_true(exr_read(file, &bin, 1, keep_row, &row, NULL));
    assert_true(row.value[3] == 3.0f / 20 && row.value[2] == 0);
    assert_false(exr_read(file, &none, 1, keep_row, &row, NULL));
    assert_string_equal(exr_text_named(file, "spectralLayoutVersion"), "1.0");
    assert_string_equal(exr_text_named(file, "emissiveUnits"), "W.m^-2.sr^-1.nm^-1");
    exr_close(file);
    film_destroy(film);
}

/* Every order and grouping of four touching parts, through files. */
static void merging_in_any_order_gives_the_same_bits(void **state)
{
    (void)state;
    const int orders[4][4] = {{0, 1, 2, 3}, {3, 2, 1, 0}, {1, 2, 0, 3}, {2, 1, 3, 0}};
    struct film *part[4], *result[5];
    for (int i = 0; i < 4; i++) {
        part[i] = kit_film(kit_corner, 3);
        fill(part[i], 10 + (uint32_t)i, 16 * i, 16 * i + 16);
        part[i]->sum[9] = FILM_SUM_MAX / 4 * (i + 1); /* passes the limit on the way, in most orders */
    }
    for (int o = 0; o < 4; o++) {
        write_film(part[orders[o][0]], in_directory("part.exr"));
        result[o] = read_film(in_directory("part.exr"));
        for (int i = 1; i < 4; i++)
            assert_true(film_merge(result[o], part[orders[o][i]], NULL));
        assert_true(kit_same(result[0], result[o]));
    }
    assert_true(film_merge(part[0], part[1], NULL) && film_merge(part[2], part[3], NULL));
    assert_true(film_merge(part[0], part[2], NULL)); /* pairs first */
    result[4] = part[0];
    part[0] = NULL;
    assert_true(kit_same(result[0], result[4]));
    assert_true(result[0]->first_sample == 0 && result[0]->end_sample == 64 && result[0]->rejected == 46);
    assert_true(result[0]->sum[9] == FILM_SUM_MAX && result[0]->saturated == 2);
    for (int i = 0; i < 5; i++)
        film_destroy(result[i]);
    for (int i = 1; i < 4; i++)
        film_destroy(part[i]);
}

static void parts_that_do_not_fit_are_refused_by_name(void **state)
{
    (void)state;
    struct film *a = kit_film(kit_whole, 3), *b = kit_film(kit_whole, 3), *small = kit_film(kit_corner, 3),
                *plain = kit_film(kit_whole, 0);
    stokes_error err;
    a->end_sample = 10;
    b->first_sample = small->first_sample = plain->first_sample = 10;
    b->end_sample = small->end_sample = plain->end_sample = 20;
    assert_false(film_merge(a, small, &err));
    assert_string_equal(err.property, "border");
    assert_false(film_merge(a, plain, &err));
    assert_string_equal(err.property, "spectral_bins");
    b->first_sample = 9;
    assert_false(film_merge(a, b, &err));
    assert_non_null(strstr(err.text, "[0, 10) and [9, 20) overlap"));
    b->first_sample = 11;
    assert_false(film_merge(a, b, &err));
    assert_non_null(strstr(err.text, "do not touch"));
    assert_int_equal(a->end_sample, 10);
    film_destroy(a);
    film_destroy(b);
    film_destroy(small);
    film_destroy(plain);
}

static long file_size(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 ? (long)status.st_size : -1;
}

/* A file may not grow beyond `bytes`, as on a full disk. */
static void limit_files(rlim_t bytes)
{
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit limit;
    getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = bytes;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

static void a_full_disk_gives_one_error_and_leaves_what_was_there(void **state)
{
    (void)state;
    struct film *film = kit_film(kit_whole, 5);
    struct working_space space;
    working_space_rec709(&space);
    fill(film, 6, 0, 4);
    write_film(film, in_directory("film.exr"));
    long size = file_size(in_directory("film.exr")); /* what the second film takes */
    assert_true(size > 10000);
    fill(film, 5, 0, 4);
    write_film(film, in_directory("film.exr"));
    fill(film, 6, 0, 4);
    const long limits[5] = {0, 100, 3000, size / 2, size - 1};
    for (int i = 0; i < 5; i++) {
        stokes_error err = {0};
        limit_files((rlim_t)limits[i]);
        bool good = film_write_exr(film, &space, notes, 3, in_directory("film.exr"), &err);
        limit_files(RLIM_INFINITY);
        assert_false(good);
        assert_string_equal(err.object, in_directory("film.exr"));
        assert_string_equal(err.text, "File too large");
        assert_int_equal(files_left(), 1);
        struct film *old = read_film(in_directory("film.exr"));
        assert_int_equal(old->rejected, 5);
        film_destroy(old);
    }
    stokes_error err = {0};
    assert_false(film_write_exr(film, &space, notes, 3, in_directory("missing/film.exr"), &err));
    assert_string_equal(err.text, "No such file or directory");
    film_destroy(film);
}

static void a_file_cut_anywhere_is_an_error(void **state)
{
    (void)state;
    struct film *film = kit_film(kit_corner, 2);
    fill(film, 8, 0, 4);
    write_film(film, in_directory("film.exr"));
    long size = file_size(in_directory("film.exr"));
    char *data = malloc((size_t)size);
    FILE *in = fopen(in_directory("film.exr"), "rb");
    assert_int_equal(fread(data, 1, (size_t)size, in), size);
    fclose(in);
    for (int i = 0; i < 60; i++) {
        long cut = i < 30 ? i * 70 : size - 1 - (i - 30) * 501;
        FILE *out = fopen(in_directory("cut.exr"), "wb");
        fwrite(data, 1, (size_t)cut, out);
        fclose(out);
        stokes_error err = {0};
        assert_null(film_read_exr(in_directory("cut.exr"), NULL, 0, &err));
        assert_string_equal(err.object, in_directory("cut.exr"));
        assert_true(err.text[0]);
    }
    free(data);
    film_destroy(film);
}

/* Any byte of the file may be wrong: reading ends in a film or in an error, never in a crash (run it with
   sanitizers). */
static void a_file_with_wrong_bytes_is_survived(void **state)
{
    (void)state;
    struct film *film = kit_film(kit_corner, 2);
    fill(film, 8, 0, 4);
    write_film(film, in_directory("film.exr"));
    long size = file_size(in_directory("film.exr"));
    char *data = malloc((size_t)size);
    FILE *in = fopen(in_directory("film.exr"), "rb");
    assert_int_equal(fread(data, 1, (size_t)size, in), size);
    fclose(in);
    int survived = 0;
    for (uint32_t i = 0; i < 1500; i++) {
        /* Most damage where it hurts: in the header. */
        size_t at = (size_t)(independent(4, 2 * i) * (i % 3 ? 2400 : (double)size));
        char old = data[at];
        data[at] ^= (char)(1 + (int)(independent(4, 2 * i + 1) * 127));
        FILE *out = fopen(in_directory("wrong.exr"), "wb");
        fwrite(data, 1, (size_t)size, out);
        fclose(out);
        struct film *back = film_read_exr(in_directory("wrong.exr"), NULL, 0, NULL);
        survived += back != NULL;
        film_destroy(back);
        data[at] = old;
    }
    assert_in_range(survived, 1, 1499);
    free(data);
    film_destroy(film);
}

static void a_sum_out_of_range_in_a_file_is_an_error(void **state)
{
    (void)state;
    struct film *film = kit_film(kit_corner, 2);
    fill(film, 8, 0, 4);
    film->sum[7] = -1;
    write_film(film, in_directory("film.exr"));
    stokes_error err = {0};
    assert_null(film_read_exr(in_directory("film.exr"), NULL, 0, &err));
    assert_string_equal(err.property, "sums");
    film_destroy(film);
}

static void a_png_is_written_whole_or_not_at_all(void **state)
{
    (void)state;
    float rgba[3 * 2 * 4] = {0, 0.5f, 1, 1, 2, -1, NAN, 0.25f};
    const char *path = in_directory("picture.png");
    stokes_error err = {0};
    limit_files(20);
    bool good = film_write_png(3, 2, rgba, path, &err);
    limit_files(RLIM_INFINITY);
    assert_false(good);
    assert_string_equal(err.object, path);
    assert_int_equal(file_size(path), -1);
    assert_true(film_write_png(3, 2, rgba, path, &err));
    unsigned char head[8] = {0};
    FILE *in = fopen(path, "rb");
    assert_int_equal(fread(head, 1, 8, in), 8);
    fclose(in);
    assert_memory_equal(head, "\x89PNG\r\n\x1a\n", 8);
}

int main(void)
{
#define FILE_TEST(name) cmocka_unit_test_setup_teardown(name, make_directory, remove_directory)
    const struct CMUnitTest tests[] = {
        FILE_TEST(an_exr_gives_back_the_same_bits),
        FILE_TEST(an_exr_gives_back_its_notes_and_working_space),
        FILE_TEST(bins_are_radiance_per_nanometre_named_by_their_centre),
        FILE_TEST(merging_in_any_order_gives_the_same_bits),
        FILE_TEST(parts_that_do_not_fit_are_refused_by_name),
        FILE_TEST(a_full_disk_gives_one_error_and_leaves_what_was_there),
        FILE_TEST(a_file_cut_anywhere_is_an_error),
        FILE_TEST(a_file_with_wrong_bytes_is_survived),
        FILE_TEST(a_sum_out_of_range_in_a_file_is_an_error),
        FILE_TEST(a_png_is_written_whole_or_not_at_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
