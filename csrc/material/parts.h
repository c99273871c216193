/* Values and integrals of what an elastic lobe's wavelengths are made of; zero outside of Λ. */
#ifndef MATERIAL_PARTS_H
#define MATERIAL_PARTS_H

#include "material/lobe.h"

double part_at(const struct lobe *, enum part, struct range, float z, float lambda);
/* ∫ from a to b. */
double part_integral(const struct lobe *, enum part, struct range, float z, double a, double b);
/* ∫ from a to b of ∫ from a to there. */
double part_second(const struct lobe *, enum part, struct range, float z, double a, double b);
/* ∫ f from a to b, by 4 points of Gauss and Legendre on pieces of at most 50 nm. */
double part_quadrature(double (*f)(const void *, double x), const void *of, double a, double b);

#endif
