/* A material's reradiation matrix, as a bispectral photometer would measure it. */
#ifndef MATERIAL_PHOTOMETER_H
#define MATERIAL_PHOTOMETER_H

#include "material/material.h"
#include "spectrum/reradiation.h"

/* Lit at 45° and seen at 0°, π times the value; both sides have `count` bands of `step` nm from `first` on. NULL with *err. */
stokes_matrix *material_measure(const struct material *, const char *name, double first, int count,
                                double step, stokes_error *err);

#endif
