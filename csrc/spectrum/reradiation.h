/* Reradiation matrices: of the energy that arrives in a band of wavelengths, the shares that leave in each band.
   The diagonal is what stays in its own band: reflected, and re-emitted nearby. */
#ifndef SPECTRUM_RERADIATION_H
#define SPECTRUM_RERADIATION_H

#include "spectrum/spectrum.h"

#define RERADIATION_BANDS_MAX 640
#define RERADIATION_STEP_MIN_NM 0.5

/* stokes_matrix itself is public (stokes.h). Here both sides' bands lie on one grid, and no share is negative. */

/* Zeroed; yours (reradiation_destroy). NULL with *err if the bands make no sense. */
stokes_matrix *reradiation_create(double first_in, int count_in, double first_out, int count_out,
                                       double step, const char *name, stokes_error *err);
void reradiation_destroy(stokes_matrix *);
stokes_matrix *reradiation_copy(const stokes_matrix *); /* NULL without memory */
/* False with *err unless every share is finite and not negative. */
bool reradiation_check(const stokes_matrix *, const char *name, stokes_error *err);

/* Incident band 0 is outgoing band `shift` (any whole number). */
static inline int reradiation_shift(const stokes_matrix *m)
{
    return (int)lround((m->first_in_nm - m->first_out_nm) / m->step_nm);
}

/* What was found of a measurement, a line each. */
typedef void (*reradiation_note)(void *user, const stokes_error *what);

/* A measured matrix of the library by name; NULL with *err if there is none. */
stokes_matrix *reradiation_library(const char *entry, const char *name, reradiation_note, void *user,
                                        stokes_error *err);

/* Reads CSV (bands of the incident light across, a line an outgoing band) or the BFC-450 matrix text; `text` ends with NUL. */
stokes_matrix *reradiation_from_text(char *text, const char *name, reradiation_note, void *user,
                                          stokes_error *err);
/* Written under a temporary name, then renamed. */
bool reradiation_write_csv(const stokes_matrix *, const char *path, stokes_error *err);

#endif
