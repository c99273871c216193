/* Tables of wavelengths and values as text: CSV, SPD, or whatever parts numbers by commas, semicolons or blanks. */
#ifndef SPECTRUM_SPECTRUM_TEXT_H
#define SPECTRUM_SPECTRUM_TEXT_H

#include "spectrum/spectrum.h"

/* Below it there is no light that a scene may carry: a table that ends there is in µm. */
#define TABLE_SHORTEST_NM 50.0
/* A matrix that begins there is in Å: no instrument shines infrared alone to see what glows. */
#define MATRIX_FURTHEST_NM 2000.0

/* Rows of a wavelength and the value in a column (from 1 on: the wavelengths are column 0), by ascending wavelength in nm. Lines that do not begin
   with a number are titles; one before the rows may say that wavelengths are in Å. `text` is UTF-8, ends with NUL and is changed. What was
   taken for granted is told to `note` (may be NULL), a line each. NULL with *err; yours to free, with the table's arrays in it. */
stokes_spectrum *spectrum_from_text(char *text, int column, const char *name,
                                    void (*note)(void *user, const stokes_error *what), void *user,
                                    stokes_error *err);

#endif
