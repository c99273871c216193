/* Weights in constant time per connection: each vertex keeps what all cuts before it weigh (struct tally), and a connection closes the sum
   from both sides (algorithm.md §12). mis.h has the plain products that the tests hold this against. */
#ifndef INTEGRATOR_TALLY_H
#define INTEGRATOR_TALLY_H

#include "integrator/path.h"

struct joint; /* joint.h */

/* Vertex 0 of a sub-path: nothing came before. */
void arrival_begin(struct arrival *, int lanes, double throughput, int origin);

/* Where fewer lanes than `lanes` are in use, the others repeat the first. */
void arrival_fill(struct arrival *, float lambda_film[LANES_MAX], int lanes);

/* Sets `there->tally` and `seam`, but for the edge's geometry, behind vertex v, which was passed by v->label: here->… [first + i] arrived, and the
   steps hold the nominal densities. Reads there->lanes. */
void tally_pass(const struct integrator *, const struct worker *, enum side, const struct vertex *v,
                const struct arrival *here, int first, const struct surface_steps *,
                struct arrival *there);

/* The edge that arrives has a length in volumes, with densities for the own step over it and for the other side's back (algorithm.md §13). */
void tally_cross(struct arrival *, double ahead, double back, int lanes);

/* The weight of each lane of a connection. */
void tally_weigh(const struct integrator *, const struct worker *, const struct joint *,
                 double weight[LANES_MAX]);

/* The weight of each lane of a path that the camera sub-path made alone: `at` is what arrives at the light point that it met, over an edge with
   this geometry and, in volumes, the densities of its length for the own step (`ahead`) and for the light's (`behind`); `back` and `draw` are the light's
   densities of the step and of its wavelength. */
void tally_weigh_sighting(const struct integrator *, const struct worker *, const struct arrival *at,
                          const struct light_point *, double pdf_point, int edges, double geometry,
                          double ahead, double behind, const float back[], const float draw[],
                          double weight[LANES_MAX]);

/* Stratified wavelengths from the product of a source and a sink, and their densities. False if they have no wavelength in common. */
bool draw_product(const struct integrator *, const struct worker *, int source, int sink, uint32_t dimension,
                  int lanes, float lambda[LANES_MAX], double density[LANES_MAX]);
/* Density of a wavelength from the table of products; 0 where source and sink have none in common. */
void product_densities(const struct integrator *, int source, int sink, int lanes, const float lambda[],
                       double out[LANES_MAX]);

#endif
