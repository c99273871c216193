/* The off-diagonal part of a reradiation matrix over Λ: constant within a pair of bands, which makes its sums, its draws and their densities
   exact, and one step of noise in a measurement stay where it was measured. */
#ifndef MATERIAL_BANDS_H
#define MATERIAL_BANDS_H

#include "material/lobe.h"

/* One direction of drawing: for each band of the given wavelength the cdf over bands of the drawn one. */
struct band_cdf {
    float *sum; /* ∫ of the value over all drawn wavelengths, by given band */
    float *cdf; /* [given * (drawn bands + 1) + drawn], 0 … 1 */
};

struct band_table {
    int count_in, count_out;
    float *edge_in, *edge_out; /* count + 1 each, inside Λ, ascending */
    float bands_per_nm;
    float *value;                            /* [out * count_in + in], nm⁻¹ */
    struct band_cdf from_light, from_camera; /* λo given λi; λi given λo */
};

/* Shares of a matrix (on its diagonal: what is re-emitted into its own band) over the part of it that lies in Λ. NULL without memory. */
struct band_table *band_table_create(const stokes_matrix *, struct range);
void band_table_destroy(struct band_table *);

float band_table_value(const struct band_table *, float lambda_in, float lambda_out);
float band_table_strength(const struct band_table *, enum side, float lambda);
float band_table_pdf(const struct band_table *, enum side, float lambda_arriving, float lambda_leaving);
float band_table_sample(const struct band_table *, enum side, float lambda_arriving, float u, float *pdf);

#endif
