/* Tables of wavelengths and values as text: CSV, SPD, or whatever parts numbers by commas, semicolons or blanks. */
#ifndef SPECTRUM_SPECTRUM_TEXT_H
#define SPECTRUM_SPECTRUM_TEXT_H

#include "spectrum/spectrum.h"

/* Below it there is no light that a scene may carry: a table that ends there is in µm. */
#define TABLE_SHORTEST_NM 50.0

/* Where semicolons part the columns of a line a comma is a decimal mark, as spreadsheets of half of Europe write it: it becomes the point that
   strtod knows. False if there is no semicolon. */
bool text_settle_commas(char *line);

/* Rows of a wavelength (nm) and the value in a column (from 1 on), by ascending wavelength. Lines that do not begin with a number are titles.
   `text` ends with NUL and is changed. NULL with *err; yours to free, with the table's arrays in it. */
stokes_spectrum *spectrum_from_text(char *text, int column, const char *name, stokes_error *err);

#endif
