/* Reradiation matrices as OpenEXR pictures: the bispectral layout of Fichet, Pacanowski and Wilkie 2021 ("An OpenEXR Layout for Spectral
   Images", JCGT 10(3)), channels T.λ for the diagonal and T.λi.λo beside it. */
#ifndef MATERIAL_BISPECTRAL_H
#define MATERIAL_BISPECTRAL_H

#include "spectrum/reradiation.h"

/* One pixel (x, y from the top left), or the mean of all where `pixel` is NULL. */
stokes_matrix *bispectral_read(const char *path, const int *pixel, reradiation_note, void *user,
                                    stokes_error *err);
/* A picture of one pixel. Channels above the diagonal, and below it where anything is. */
bool bispectral_write(const stokes_matrix *, const char *path, stokes_error *err);

#endif
