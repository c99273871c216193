/* Claims about csrc/stream as bytes: frames whole, cut and strange; the inbox, cancels and broken streams. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/os.h"
#include "stream/frame.h"
#include "stream/inbox.h"

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
        cmocka_unit_test(a_cancel_stops_what_came_before_it),
        cmocka_unit_test(a_broken_stream_is_told_once_after_what_was_whole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
