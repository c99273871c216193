/* Films for the tests of csrc/film: 40 × 30 pixels, whole or cropped, and whether two hold the same bits. */
#ifndef FILM_KIT_H
#define FILM_KIT_H

#include "film/film.h"

extern const int kit_whole[4], kit_corner[4]; /* borders */
extern const struct range kit_range;          /* of the bins, nm */

struct film *kit_film(const int border[4], int bins); /* fails the test on an error */
bool kit_same(const struct film *, const struct film *);

#endif
