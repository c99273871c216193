/* The integrators by name: which techniques (s, t) each may use. */
#ifndef INTEGRATOR_KINDS_H
#define INTEGRATOR_KINDS_H

#include <stdbool.h>
#include <stddef.h>

struct integrator_kind {
    const char *name;
    /* Whether a path of s light and t camera vertices is one of its techniques. */
    bool (*uses)(int s, int t);
    bool exact; /* by exact.c, without mollification */
};

const struct integrator_kind *integrator_kind_at(size_t index);       /* NULL past the end */
const struct integrator_kind *integrator_kind_find(const char *name); /* NULL: unknown */

#endif
