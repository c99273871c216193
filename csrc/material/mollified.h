/* Elastic reflection under a mollification kernel (algorithm.md §3): values and densities when λo and λi need not be equal.

   Written level × kernel: the level is a reflectance, the kernel k(λo|λi) an area of 1 per nm. With g = (1 − c a) r:

   | kernel               | level                        | k, of half-width d                  |
   |----------------------|------------------------------|-------------------------------------|
   | CONSTANT (f_mo)      | g(λi)                        | 1/(2d) for |λo − λi| < d            |
   | INCIDENT_REFLECTANCE | (1 − c a(λi)) r(λo)          | the same; f_mi of r alone           |
   | INCIDENT             | g(λo)                        | the same; f_mi of the whole diagonal|
   | BOX (f_mb)           | mean of g between the two    | tent: (d − |λo − λi|)/d²            |
   | ASYMMETRIC           | g(λi)                        | 1/(2d) for 0 ≤ λo − λi < 2d         |

   f_mb is a box filter of half-width d/2 in each of the two wavelengths; its mean runs from max(λi, λo) − d/2 to min(λi, λo) + d/2.
   INCIDENT can make energy (eq. 6), ASYMMETRIC photons (§2.2 of the supplemental). Nothing is renormalised at the ends of Λ, beyond which
   nothing is reflected. Where a lobe's wavelengths are tables all is exact and takes constant time, by the spectra's cumulative tables and,
   for f_mb, the tables of those; else Gauss–Legendre quadrature (4 points for each 50 nm at most). */
#ifndef MATERIAL_MOLLIFIED_H
#define MATERIAL_MOLLIFIED_H

#include "material/material.h"

enum kernel {
    KERNEL_CONSTANT,
    KERNEL_INCIDENT_REFLECTANCE,
    KERNEL_INCIDENT,
    KERNEL_BOX,
    KERNEL_ASYMMETRIC,
    KERNEL_COUNT
};
const char *kernel_name(enum kernel); /* "constant", … as the stream says them */

/* k(λo|λi), nm⁻¹; 0 outside of its support. */
float kernel_density(enum kernel, float lambda_in, float lambda_out, float half_width_nm);

/* Value of all elastic lobes of finite density *without* k, sr⁻¹: times kernel_density it is the mollified BBRRDF's elastic term (eq. 16).
   Meant inside the kernel's support. */
float surface_mollified(const struct surface *, enum kernel, struct vec3 to_light, struct vec3 to_camera,
                        float lambda_in, float lambda_out, float half_width_nm);
/* surface_pdf_mollified for any kernel: (1 − P_F) p^moll/k × the direction's density; 0 outside of the support. */
float surface_pdf_mollified_by(const struct surface *, enum kernel, enum side, struct vec3 arriving,
                               struct vec3 leaving, float lambda_arriving, float lambda_leaving,
                               float half_width_nm);

/* The spectral parts alone, for a sub-path from `side` that arrives from a direction with a wavelength (λi from the light, λo from the
   camera); of diffuse surfaces they do not depend on the direction. */

/* ∫ of the elastic term over the other wavelength: eqs. 18 and 20 without their fluorescent part. */
double mollified_strength(const struct surface *, enum kernel, enum side, struct vec3 arriving, float lambda,
                          float half_width_nm);
/* p^moll (eqs. 25, 26) of the other wavelength, nm⁻¹; and its integral over what of it lies below `lambda_leaving` and in Λ: over all of Λ it
   is 1 less what is lost at Λ's ends. */
float mollified_pdf(const struct surface *, enum kernel, enum side, struct vec3 arriving,
                    float lambda_arriving, float lambda_leaving, float half_width_nm);
double mollified_cdf(const struct surface *, enum kernel, enum side, struct vec3 arriving,
                     float lambda_arriving, float lambda_leaving, float half_width_nm);
/* Draws from it by a uniform number; false if the wavelength falls outside of Λ, or there is nothing to draw from. */
bool mollified_sample(const struct surface *, enum kernel, enum side, struct vec3 arriving,
                      float lambda_arriving, float half_width_nm, float u, float *lambda, float *pdf);
/* p_c(λi|λo) and p_l(λo|λi) of eqs. 17, 19 and 27: all labels together. */
float mollified_pdf_of_all(const struct surface *, enum kernel, enum side, struct vec3 arriving,
                           float lambda_arriving, float lambda_leaving, float half_width_nm);

#endif
