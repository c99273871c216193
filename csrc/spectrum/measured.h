/* A reradiation matrix as an instrument writes it: any wavelengths, noise below zero, bands that it could not measure. */
#ifndef SPECTRUM_MEASURED_H
#define SPECTRUM_MEASURED_H

#include "spectrum/reradiation.h"

struct measured {
    int count_in, count_out;
    double *in, *out; /* nm, ascending */
    float *share;     /* [out * count_in + in]; NaN: not measured */
};

struct measured *measured_create(int count_in, int count_out, const char *name, stokes_error *err);
void measured_destroy(struct measured *);

/* Takes the measurement. Fills what is missing from its neighbours, takes the noise out, puts both sides on one grid; says what it did
   by notes. NULL with *err if it cannot be read as a matrix. */
stokes_matrix *measured_finish(struct measured *, const char *name, reradiation_note, void *user,
                                    stokes_error *err);

#endif
