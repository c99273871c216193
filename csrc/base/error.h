/* Filling a stokes_error: one line that names the object, the property and what is wrong. */
#ifndef BASE_ERROR_H
#define BASE_ERROR_H

#include "stokes.h"

/* Fills *err (which may be NULL) and returns false, so that a check reads `return fail(…)`. */
bool fail(stokes_error *err, const char *object, const char *property, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

#endif
