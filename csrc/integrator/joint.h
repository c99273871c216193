/* A joint: the edge that connects a light sub-path's vertex y to a camera sub-path's vertex x, what the two ends add to the path's
   value and densities, and the shadow ray. Which wavelengths the edge has is for connect.c (mollified) or exact.c to say. */
#ifndef INTEGRATOR_JOINT_H
#define INTEGRATOR_JOINT_H

#include "integrator/mis.h"

/* A label that a vertex may take as the end of a connection. The light and the camera have the one label FLUORESCENT. */
struct choice {
    enum label label;
    int lobe;
};
enum { CHOICES_MAX = SURFACE_LOBES + 1, PAIRS_MAX = CHOICES_MAX * CHOICES_MAX };

int joint_choices(const struct vertex *, struct choice out[CHOICES_MAX]);

/* What an edge crosses of volumes, and the nominal densities of its length for either side's step over it (algorithm.md §13). */
struct haze {
    struct crossing crossing;
    double across[SIDES];
};

/* An edge once looked at: all connections of its two vertices share its shadow ray. */
struct sight {
    uint32_t stamp; /* of the sample that it was made in */
    enum { SIGHT_NOTHING, SIGHT_OPEN, SIGHT_TRACED } state;
    struct vec3 y_to_x;
    float geometry;
    double
        visibility; /* SIGHT_TRACED: at one wavelength; neither 0 nor 1 where it is transparent to some of the light */
    bool barred;       /* SIGHT_TRACED: to light sub-paths, which might fly there (SEEN_BY_SOME) */
    struct haze *haze; /* where the scene has volumes */
};

struct joint_end {
    const struct vertex *vertex;
    const struct subpath *path;
    const struct strand *strand; /* of the connecting run, evaluated again; NULL: as traced */
    const struct arrival *at;    /* the vertex's, or the strand's */
    struct choice as;
    bool disperses;
    double across; /* density of the edge's length for this side's step over it; 1 without volumes */
    float
        draw[LANES_MAX]; /* density with which the start of its part of the run draws the edge's wavelength */
    struct surface_steps
        steps; /* ρ (or emitted radiance, or the camera's density); densities of own and other side */
};

struct joint {
    int s, t;
    struct sight *sight;
    struct vec3 y_to_x;
    float geometry;
    double owed;                /* 1/(chance that roulette left it) */
    float pdf_camera_direction; /* t = 1 */
    struct joint_end end[SIDES];
    /* Of the labels and wavelengths at hand: */
    int lanes;
    uint8_t lane[SIDES][LANES_MAX]; /* which lane of either sub-path each is */
    float lambda[LANES_MAX];
    int source, sink; /* of the connecting run */
    int dyes;         /* F vertices of the path */
};

/* Lanes meet by number. */
extern const uint8_t joint_straight[SIDES][LANES_MAX];

/* Direction and geometry of an edge. False if it has no length, is at infinity at both ends, leaves a matte surface on the side that the sub-path did
   not come from, or is known to be blocked. */
bool joint_open(struct joint *, const struct vertex *y, const struct vertex *x, uint32_t stamp,
                struct sight *);

/* True if the path with these labels keeps the limits on bounces, and every edge's near end is seen by the kind of ray that leaves its
   far end. */
bool joint_is_allowed(const struct integrator *, const struct joint *);

/* Sets an end as the vertex was traced, or as a strand says, with a label. */
void joint_set_end(struct joint *, enum side, const struct subpath *, int at, const struct strand *,
                   struct choice);

/* Sets source, sink and dyes. */
void joint_name_run(const struct integrator *, struct joint *);

/* Evaluates one end at joint->lambda. False where every lane of it is dark. */
bool joint_evaluate_end(const struct integrator *, struct joint *, enum side);

/* Roulette, before surfaces are evaluated, but a light is: both ends are set, and so are the lanes; the arguments are joint_contribute's. False: given up. */
bool joint_survives(const struct integrator *, struct worker *, struct joint *,
                    const double density[LANES_MAX], const float lambda_film[LANES_MAX]);

/* Both, end by end. */
bool joint_evaluate(const struct integrator *, struct worker *, struct joint *,
                    const double density[LANES_MAX], const float lambda_film[LANES_MAX]);

/* Value × weight of each lane, over `density` of the lanes' wavelengths; what is above 0 is added to the camera's pixel or splatted. */
void joint_contribute(const struct integrator *, struct worker *, struct joint *,
                      const double density[LANES_MAX], const float lambda_film[LANES_MAX],
                      const int splat[2]);

/* t = 1: a lens point that sees y, and the pixel that a splat falls into. False if there is none inside the border. */
bool joint_camera_vertex(const struct integrator *, const struct vertex *y, struct vertex *x,
                         const float u[4], int pixel[2], float *pdf_direction);

#endif
