/* Claims about csrc/base: errors in one line, threads that do each unit once, memory that cannot shrink, whole files. */
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>
#undef fail /* cmocka's; ours fills an error */

#include "base/error.h"
#include "base/os.h"
#include "base/random.h"
#include "base/thread.h"

/* --- Errors ------------------------------------------------------------------------------------------------ */

static void an_error_is_one_line(void **state)
{
    (void)state;
    stokes_error err;
    assert_false(fail(&err, "a\nb", "c\td", "%s", "e\r\nf\x1b[2J"));
    assert_string_equal(err.object, "a b");
    assert_string_equal(err.property, "c d");
    assert_string_equal(err.text, "e  f [2J");
}

static bool is_utf8(const char *text)
{
    for (const unsigned char *c = (const unsigned char *)text; *c;) {
        int more = *c < 0x80 ? 0 : *c >= 0xf0 ? 3 : *c >= 0xe0 ? 2 : *c >= 0xc0 ? 1 : -1;
        if (more < 0)
            return false;
        for (c++; more > 0; more--, c++)
            if ((*c & 0xc0) != 0x80)
                return false;
    }
    return true;
}

static void a_cut_error_stays_utf8(void **state)
{
    (void)state;
    static const char *const characters[] = {"x", "é", "☀", "🌈"};
    for (size_t c = 0; c < 4; c++)
        for (size_t shift = 0; shift < 5; shift++) {
            char name[512] = "";
            stokes_error err;
            for (size_t i = 0; i < shift; i++)
                strcat(name, "-");
            while (strlen(name) < 400)
                strcat(name, characters[c]);
            fail(&err, name, name, "%s%s", name, name);
            assert_true(is_utf8(err.object) && is_utf8(err.property) && is_utf8(err.text));
            assert_true(strlen(err.object) + 4 >= sizeof err.object - 1);
        }
}

static void an_error_of_other_bytes_becomes_utf8(void **state)
{
    (void)state;
    stokes_error err;
    for (int lead = 0x80; lead < 0x100; lead++)
        for (int next = 0; next < 0x100; next++) {
            const char bytes[] = {'a', (char)lead, (char)next, 'b', (char)lead, 0};
            fail(&err, bytes, "", "%s", "");
            json_t *text = json_string(err.object); /* refuses what is no UTF-8 */
            assert_non_null(text);
            json_decref(text);
        }
}

static void an_error_may_be_built_of_itself(void **state)
{
    (void)state;
    stokes_error err;
    fail(&err, "mesh", "index", "is wrong");
    fail(&err, "file", err.object, "%s: %s", err.property, err.text);
    assert_string_equal(err.property, "mesh");
    assert_string_equal(err.text, "index: is wrong");
    assert_false(fail(NULL, "nobody", "listens", "x"));
}

/* --- Threads ----------------------------------------------------------------------------------------------- */

struct count {
    atomic_int done[1000];
    atomic_int total, worst_worker;
    int stop_after;
};

static void count_unit(void *context, size_t index, int worker)
{
    struct count *count = context;
    atomic_fetch_add(&count->done[index], 1);
    atomic_fetch_add(&count->total, 1);
    if (worker > atomic_load(&count->worst_worker))
        atomic_store(&count->worst_worker, worker);
}

static bool counted_enough(void *context)
{
    struct count *count = context;
    return atomic_load(&count->total) >= count->stop_after;
}

static void every_unit_is_done_once(void **state)
{
    (void)state;
    for (int threads = 0; threads <= 9; threads += 3) {
        struct count *count = calloc(1, sizeof *count);
        thread_run(threads, 1000, count_unit, NULL, count);
        for (int i = 0; i < 1000; i++)
            assert_int_equal(count->done[i], 1);
        assert_true(count->worst_worker < (threads > 1 ? threads : 1));
        free(count);
    }
}

static void stopping_skips_the_rest(void **state)
{
    (void)state;
    struct count *count = calloc(1, sizeof *count);
    count->stop_after = 100;
    thread_run(4, 1000, count_unit, counted_enough, count);
    /* Each of the four may have been about to begin one. */
    assert_in_range(count->total, 100, 103);
    free(count);
    thread_run(4, 0, count_unit, NULL, NULL);
    assert_true(thread_processors() >= 1);
}

/* --- Shared memory ----------------------------------------------------------------------------------------- */

static void mapped_memory_cannot_shrink(void **state)
{
    (void)state;
    stokes_error err;
    struct os_memory memory = {.fd = -1};
    int fd = memfd_create("test", MFD_ALLOW_SEALING);
    assert_int_equal(ftruncate(fd, 8192), 0);
    assert_true(os_memory_map(&memory, fd, false, &err));
    assert_int_equal(memory.bytes, 8192);
    assert_int_not_equal(ftruncate(fd, 100), 0);
    os_memory_unmap(&memory);
    os_memory_unmap(&memory);
    close(fd);
}

static void memory_that_grew_is_mapped_again(void **state)
{
    (void)state;
    stokes_error err;
    struct os_memory memory = {.fd = -1};
    int fd = memfd_create("test", MFD_ALLOW_SEALING);
    assert_true(os_memory_map(&memory, fd, true, &err));
    assert_null(memory.data);
    assert_int_equal(ftruncate(fd, 4096), 0);
    assert_true(os_memory_map(&memory, fd, true, &err));
    assert_int_equal(memory.bytes, 4096);
    assert_int_equal(ftruncate(fd, 1 << 20), 0);
    assert_int_equal(pwrite(fd, "Z", 1, (1 << 20) - 1), 1);
    assert_true(os_memory_map(&memory, fd, true, &err));
    assert_int_equal(memory.data[(1 << 20) - 1], 'Z');
    os_memory_unmap(&memory);
    close(fd);
}

static void memory_that_cannot_be_sealed_is_an_error(void **state)
{
    (void)state;
    stokes_error err = {0};
    struct os_memory memory = {.fd = -1};
    int sealed = memfd_create("test", 0); /* sealing is not allowed */
    assert_int_equal(ftruncate(sealed, 8192), 0);
    assert_false(os_memory_map(&memory, sealed, false, &err));
    assert_non_null(strstr(err.text, "MFD_ALLOW_SEALING"));
    close(sealed);
    assert_false(os_memory_map(&memory, 999, false, &err));
    assert_string_equal(err.property, "descriptor");
}

/* --- Descriptors and files --------------------------------------------------------------------------------- */

static void reading_tells_a_short_end(void **state)
{
    (void)state;
    int ends[2];
    char data[8] = "";
    assert_int_equal(pipe(ends), 0);
    assert_false(os_readable(ends[0], 0.01));
    assert_true(os_write_all(ends[1], "abcde", 5));
    assert_true(os_readable(ends[0], 0));
    close(ends[1]);
    assert_true(os_read_all(ends[0], data, 3));
    assert_memory_equal(data, "abc", 3);
    assert_false(os_read_all(ends[0], data, 3));
    assert_true(os_readable(ends[0], 0)); /* the end is news, too */
    close(ends[0]);
}

static void write_much(void *context, size_t index, int worker)
{
    (void)worker;
    const int *ends = context;
    unsigned char *data = calloc(1, 1 << 20);
    assert_non_null(data);
    if (index == 0)
        assert_true(os_write_all(ends[1], data, 1 << 20));
    else
        assert_true(os_read_all(ends[0], data, 1 << 20));
    free(data);
}

static void descriptors_that_do_not_block_are_waited_for(void **state)
{
    (void)state;
    int ends[2];
    assert_int_equal(pipe2(ends, O_NONBLOCK), 0);
    thread_run(2, 2, write_much, NULL, ends);
    assert_false(os_readable(ends[0], 0)); /* all of it has come */
    close(ends[0]);
    close(ends[1]);
}

static void a_file_is_whole_or_not_there(void **state)
{
    (void)state;
    char folder[] = "/tmp/stokes-test-XXXXXX", path[64], missing[64];
    stokes_error err;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/file", folder);
    snprintf(missing, sizeof missing, "%s/missing/file", folder);
    assert_true(os_write_file(path, "old", 3, &err));
    assert_true(os_write_file(path, "newer", 5, &err));
    struct stat status;
    assert_int_equal(stat(path, &status), 0);
    assert_int_equal(status.st_size, 5);
    assert_false(os_write_file(missing, "x", 1, &err));
    assert_string_equal(err.object, missing);
    /* A folder in the file's place: the temporary file must go. */
    assert_int_equal(unlink(path), 0);
    assert_int_equal(mkdir(path, 0700), 0);
    assert_false(os_write_file(path, "x", 1, &err));
    assert_int_equal(rmdir(path), 0);
    assert_int_equal(rmdir(folder), 0); /* nothing else was in it */
}

/* --- Random numbers ---------------------------------------------------------------------------------------- */

static void neighbouring_addresses_are_unrelated(void **state)
{
    (void)state;
    /* Correlation of u(seed, pixel, sample, dimension) with a neighbouring seed, pixel or pair of dimensions over n = 10^5
       pixels: |r| < 5.3/√n fails by chance once in 10^7. Samples of one pixel are related, by design. */
    enum { COUNT = 100000 };
    for (int argument = 0; argument < 3; argument++) {
        double sum = 0;
        for (uint32_t i = 0; i < COUNT; i++) {
            struct random_path here = random_path(7, i, 3);
            struct random_path there = random_path(argument == 0 ? 8 : 7, i + (argument == 1), 3);
            sum += (random_at(here, 5) - 0.5) * (random_at(there, argument == 2 ? 6 : 5) - 0.5) * 12;
        }
        assert_true(sum * sum / COUNT < 5.3 * 5.3);
    }
    assert_true(random_at(random_path(1, 2, 3), 4) == random_at(random_path(1, 2, 3), 4));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_error_is_one_line),
        cmocka_unit_test(a_cut_error_stays_utf8),
        cmocka_unit_test(an_error_of_other_bytes_becomes_utf8),
        cmocka_unit_test(an_error_may_be_built_of_itself),
        cmocka_unit_test(every_unit_is_done_once),
        cmocka_unit_test(stopping_skips_the_rest),
        cmocka_unit_test(mapped_memory_cannot_shrink),
        cmocka_unit_test(memory_that_grew_is_mapped_again),
        cmocka_unit_test(memory_that_cannot_be_sealed_is_an_error),
        cmocka_unit_test(reading_tells_a_short_end),
        cmocka_unit_test(descriptors_that_do_not_block_are_waited_for),
        cmocka_unit_test(a_file_is_whole_or_not_there),
        cmocka_unit_test(neighbouring_addresses_are_unrelated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
