/* Tables of wavelengths and values as text: whatever bytes come, a table comes of them or one line that says why none does. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "spectrum/spectrum_text.h"
#include "spectrum/text_cells.h"
#include "spectrum/text_unit.h"

#define SEED 5u
#define TRIALS 4000

static const char *const seeds[] = {
    "nm,share\n400,0.25\n500.5,0.75\n",
    "\"nm\";\"a; b\"\r\n\"400\";\"0,25\";\"x\"\"y\"\r\n\"500,5\";\"0,75\"\r\n",
    "\xef\xbb\xbf# Wavelength (A)\tflux\n3800\t0,25\n7800\t-1e-3\n",
    "\xc3\x85 cm\xe2\x81\xbb\xc2\xb9 1/cm\n 400, 0,5 # remark\n\n,,\n500 1\n",
};

static void count_note(void *user, const stokes_error *what)
{
    (*(int *)user)++;
    assert_null(strpbrk(what->text, "\r\n"));
}

/* Bytes that mean something to the reader, and others. */
static char byte_of(uint32_t draw)
{
    static const char marks[] = ",;\t \"\r\n.#-+eE0123456789A(\xc3\x85\x01\xff";
    return marks[draw % (sizeof marks - 1)];
}

static void assert_is_table(const stokes_spectrum *s)
{
    assert_in_range(s->count, 2, 65534);
    for (size_t i = 0; i < s->count; i++) {
        assert_true(s->lambda_nm[i] > 0 && s->lambda_nm[i] < 1e6 && isfinite(s->value[i]));
        assert_true(i == 0 || s->lambda_nm[i] > s->lambda_nm[i - 1]);
    }
}

/* An exact allocation, so that a sanitizer sees a byte read beyond the text. */
static bool reads(const char *text, int column, int *notes)
{
    char *copy = strdup(text);
    stokes_error err = {.text = "untold"};
    assert_non_null(copy);
    stokes_spectrum *s = spectrum_from_text(copy, column, "test", count_note, notes, &err);
    bool good = s != NULL;
    if (good)
        assert_is_table(s);
    else
        assert_true(strcmp(err.text, "untold") != 0 && !strpbrk(err.text, "\r\n\x01\x1b"));
    free(s);
    free(copy);
    return good;
}

static void broken_bytes_give_a_table_or_one_line(void **state)
{
    (void)state;
    int notes = 0, tables = 0;
    for (uint32_t trial = 0; trial < TRIALS; trial++) {
        char text[128];
        uint32_t draw = trial * 2654435761u + SEED;
        strcpy(text, seeds[trial % 4]);
        for (int changes = 1 + (int)(draw >> 28) % 4; changes > 0; changes--) {
            draw = draw * 1664525u + 1013904223u;
            text[(draw >> 8) % strlen(seeds[trial % 4])] = byte_of(draw >> 16);
        }
        tables += reads(text, 1 + (int)(trial / 4 % 2), &notes);
    }
    assert_in_range(tables, TRIALS / 20, TRIALS * 19 / 20);
    assert_true(notes > TRIALS / 100);
}

static void every_beginning_of_a_text_is_a_text(void **state)
{
    (void)state;
    int notes = 0;
    for (int seed = 0; seed < 4; seed++)
        for (size_t length = strlen(seeds[seed]); length-- > 0;) {
            char text[128] = "";
            memcpy(text, seeds[seed], length);
            reads(text, 1, &notes);
            text_unit_of(text);
            char *copy = strdup(text);
            assert_non_null(copy);
            text_drop_quotes(copy);
            assert_true(strlen(copy) <= length);
            free(copy);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(broken_bytes_give_a_table_or_one_line),
        cmocka_unit_test(every_beginning_of_a_text_is_a_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
