/* Films for the tests of csrc/film. */
#include "film_kit.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

const int kit_whole[4] = {0, 0, 40, 30}, kit_corner[4] = {8, 10, 37, 28};
const struct range kit_range = {380, 780};

struct film *kit_film(const int border[4], int bins)
{
    stokes_error err;
    struct film *film = film_create(40, 30, border, bins, kit_range, &err);
    assert_non_null(film);
    return film;
}

bool kit_same(const struct film *a, const struct film *b)
{
    size_t count = (size_t)a->width * (size_t)a->height * (size_t)a->channels;
    return a->width == b->width && a->height == b->height && a->channels == b->channels &&
           memcmp(a->sum, b->sum, count * sizeof *a->sum) == 0 && a->first_sample == b->first_sample &&
           a->end_sample == b->end_sample && a->saturated == b->saturated && a->rejected == b->rejected;
}
