/* Multiple importance sampling, plainly: the balance heuristic over all cuts of one labelled path, from the product of all densities of
   each (algorithm.md §6, §7). For subsets of techniques, and to hold tally.h's recursion against. */
#ifndef INTEGRATOR_MIS_H
#define INTEGRATOR_MIS_H

#include "integrator/path.h"

#define FULL_PATH_VERTICES (2 * PATH_VERTICES)

struct joint;

/* All that the weight is a function of: one lane. Indices run from the light (0) to the camera (edges); step[i].geometry, along, against and
   lambda belong to edge i, between vertices i − 1 and i. */
struct full_path {
    int edges;     /* K */
    int cut;       /* s: the technique that made it */
    double weight; /* what the integrator gave it; for observers */
    double pdf_point;
    double reach_nm; /* 1/k(λ|λ) of the mollified method */
    const struct light_point *light;
    struct full_step {
        double fwd; /* density of the light sub-path's step from here to i + 1 */
        double rev; /* of the camera sub-path's step from here to i − 1 */
        double geometry;
        double along,
            against; /* densities of the edge's length in volumes, for the light's and the camera's step over it */
        float lambda;
        enum label label;
        bool in_volume; /* it scatters inside of volumes */
        bool begins;    /* vertex_begins_light_paths */
        bool disperses; /* passed by a refraction whose direction depends on the wavelength */
        int dye; /* scene-wide index of the fluorophore, where label is FLUORESCENT and this is a surface */
    } step[FULL_PATH_VERTICES];
};

/* One lane of a connection whose ends are evaluated. */
void full_path_of_joint(const struct integrator *, const struct worker *, const struct joint *, int lane,
                        struct full_path *);
/* One lane of the camera sub-path with `edges` edges, the last of which ends on a light: all but step[0], edge 1 and the light itself. */
struct strand;
void full_path_of_camera(const struct worker *, const struct subpath *, int edges, const struct strand *,
                         int lane, struct full_path *);

/* Weight of cut path->cut among all techniques that the integrator may use. */
double mis_weight(const struct integrator *, const struct full_path *);
void mis_weigh_plainly(const struct integrator *, const struct worker *, const struct joint *,
                       double weight[LANES_MAX]);

/* How much of the sum of all densities each kind of technique has. False if there is none, or no end of it. */
bool mis_shares(const struct integrator *, const struct full_path *, double share[TECHNIQUE_KINDS]);

/* Density of one cut over a factor common to all of them. */
double mis_cut_density(const struct integrator *, const struct full_path *, int cut);

#endif
