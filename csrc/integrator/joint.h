/* A joint: the edge that connects a light sub-path's vertex y to a camera sub-path's vertex x, what the two ends add to the path's
   value and densities, and the shadow ray. Which wavelength the edge has is for connect.c (mollified) or exact.c to say. */
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

struct joint {
    const struct vertex *y, *x;
    int s, t;
    double throughput_y, throughput_x; /* on arrival */
    struct vec3 y_to_x;
    float geometry;
    float pdf_camera_direction; /* t = 1 */
    struct full_path path;
};

/* Before joint_open; the rest is left as it is, for a full path is three kilobytes. */
static inline void joint_set(struct joint *joint, const struct vertex *y, const struct vertex *x, int s,
                             int t)
{
    joint->y = y;
    joint->x = x;
    joint->s = s;
    joint->t = t;
}

/* What one end adds: ρ (or emitted radiance, or the camera's density) and the densities of both sides' steps through it. */
struct end {
    double value, fwd, rev;
    int dye;
    bool disperses;
};

/* Direction, geometry term and the densities of the sub-paths. False if the edge has no length, or is at infinity at both ends. */
bool joint_open(const struct worker *, struct joint *, const struct subpath *light, const struct subpath *camera);

/* True if the path with these labels keeps the limits on bounces, and every edge's near end is seen by the kind of ray that leaves its
   far end. */
bool joint_is_allowed(const struct integrator *, const struct joint *, struct choice as_y,
                      struct choice as_x);

/* The end on one side with a label and the edge's wavelength, which an elastic end shares with its own sub-path. */
struct end joint_end(const struct integrator *, const struct joint *, enum side, struct choice as,
                     float lambda_edge);

/* Value × weight of the labelled path with these ends; 0 where either is 0. */
double joint_value(const struct integrator *, struct joint *, const struct end *y, struct choice as_y,
                   const struct end *x, struct choice as_x, float lambda_edge);

/* Transmittance of the edge. */
double joint_visibility(const struct integrator *, const struct joint *, float lambda);

/* Contributions of one joint that wait for its shadow ray. */
struct pending {
    double value;
    float lambda_edge, lambda_film;
};
struct pendings {
    int count;
    struct pending at[PAIRS_MAX];
};
void pendings_add(const struct integrator *, struct pendings *, const struct joint *, double value,
                  float lambda_edge, float lambda_film);
/* Traces the shadow ray, if anything waits for it; what is blocked is dropped. */
void pendings_resolve(const struct integrator *, struct pendings *, const struct joint *);
/* To the sample of the camera sub-path's pixel. */
void pendings_gather(const struct integrator *, struct worker *, const struct pendings *);

/* s = 1: a light point drawn from three numbers. False without lights. */
bool joint_light_vertex(const struct integrator *, const float u[3], struct vertex *);
/* t = 1: a lens point that sees y, and the pixel that a splat falls into. False if there is none inside the border. */
bool joint_camera_vertex(const struct integrator *, struct joint *, struct vertex *x, const float u[4],
                         int pixel[2]);
void pendings_splat(const struct integrator *, const struct pendings *, const int pixel[2]);

#endif
