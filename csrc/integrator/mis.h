/* Multiple importance sampling: the balance heuristic over all cuts of one labelled path (algorithm.md §6, algorithm.md §7). */
#ifndef INTEGRATOR_MIS_H
#define INTEGRATOR_MIS_H

#include "integrator/path.h"

#define FULL_PATH_VERTICES (2 * PATH_VERTICES)

/* All that the weight is a function of. Indices run from the light (0) to the camera (edges); step[i].geometry and step[i].lambda
   belong to edge i, between vertices i − 1 and i. */
struct full_path {
    int edges; /* K */
    int cut;   /* s: the technique that made it */
    double pdf_point;
    float half_width_nm;
    const struct light_point *light;
    struct full_step {
        double fwd; /* density of the light sub-path's step from here to i + 1 */
        double rev; /* of the camera sub-path's step from here to i − 1 */
        double geometry;
        float lambda;
        enum label label;
        bool disperses; /* passed by a refraction whose direction depends on the wavelength */
        int dye; /* scene-wide index of the fluorophore, where label is FLUORESCENT and this is a surface */
    } step[FULL_PATH_VERTICES];
};

/* Copies what the two sub-paths know of their first s and t vertices into a path of `edges` edges (s + t − 1, or s + t where a vertex
   between them is still to come). What a connection changes — the end vertices y and x, and the edges between — is for the caller. */
void full_path_copy(struct full_path *, const struct subpath *light, int s, const struct subpath *camera,
                    int t, int edges);

/* Weight of cut path->cut among all techniques that the integrator may use. Sums to 1 over them on a path of one wavelength per run. */
double mis_weight(const struct integrator *, const struct full_path *);

/* Density of one cut over a factor common to all of them, in the plain product form: for tests, slow. */
double mis_cut_density(const struct integrator *, const struct full_path *, int cut);

#endif
