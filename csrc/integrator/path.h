/* Paths: vertices, sub-paths, and what one worker needs to trace them.

   A path is x_0 (light) … x_K (camera); edge i lies between x_{i-1} and x_i (algorithm.md §7). The camera sub-path holds
   x_K, x_{K-1}, … and the light sub-path x_0, x_1, …, each in the order in which it was traced: `prev` and `next` are meant
   that way. Densities are per projected solid angle, so a step's density over area is pdf × the edge's geometry term. */
#ifndef INTEGRATOR_PATH_H
#define INTEGRATOR_PATH_H

#include "base/random.h"
#include "integrator/integrator.h"
#include "integrator/wavelengths.h"

#define PATH_VERTICES TECHNIQUES_MAX
#define SCATTER_CLASSES 4

enum vertex_kind { VERTEX_LIGHT, VERTEX_CAMERA, VERTEX_SURFACE };

struct vertex {
    enum vertex_kind kind;
    enum label label; /* of a vertex that was passed; the last one of a sub-path has none yet */
    int lobe;         /* fluorescent or specular lobe of that label */
    struct vec3 position;
    struct vec3 to_prev, to_next; /* unit, away from the vertex */
    float lambda_in, lambda_out;  /* nm, of the edges to prev and next */
    double throughput;            /* on arrival: everything before this vertex */
    float pdf_own;                /* label × wavelength × direction of the step to next */
    float pdf_other; /* with which the other side's sub-path, coming from next, would step to prev */
    float survival;  /* of roulette; in a copying sub-path also the chance of an own wavelength */
    float geometry;  /* of the edge to prev */
    /* A distant light, an orthographic camera: a direction instead of a point, so that edges to it have no
       length, and its steps have densities per area perpendicular to them. */
    bool unbounded;
    /* Transparent surfaces on the edge to prev: whether there were any, and 1/(chance to stop at this vertex). */
    bool passed;
    float passage;
    bool disperses;     /* passed by a refraction whose direction depends on the wavelength */
    bool run_disperses; /* some vertex of this run before this one did (algorithm.md §9) */
    uint8_t bounces[SCATTER_CLASSES];
    uint32_t kinds;           /* of rays that see this vertex (enum ray_kind) */
    float pdf_point;          /* VERTEX_LIGHT: of choosing light and point */
    struct light_point light; /* VERTEX_LIGHT */
    struct camera_point lens; /* VERTEX_CAMERA */
    struct hit hit;           /* VERTEX_SURFACE */
    struct surface surface;   /* VERTEX_SURFACE: evaluates again at any wavelength */
};

/* Sets what says nothing yet; hit and surface, which are two kilobytes, are left as they are. */
static inline void vertex_begin(struct vertex *v, enum vertex_kind kind)
{
    v->kind = kind;
    v->label = kind == VERTEX_SURFACE ? LABEL_ELASTIC : LABEL_FLUORESCENT;
    v->lobe = 0;
    v->lambda_in = v->lambda_out = 0;
    v->throughput = 1;
    v->pdf_own = v->pdf_other = 0;
    v->survival = v->passage = 1;
    v->geometry = 0;
    v->unbounded = v->passed = v->disperses = false;
}

struct subpath {
    int count;
    struct vertex *vertex; /* PATH_VERTICES of them */
};

/* Dimensions of the sample point (random.h). A new one goes to the end of its block: the map has a version. */
enum dimension {
    DIM_FILM = 0,   /* 2 */
    DIM_LENS = 2,   /* 2 */
    DIM_LAMBDA = 4, /* 1 */
    DIM_LIGHT = 8,  /* 3: light, point */
    DIM_LIGHT_LAMBDA = 11,
    DIM_LIGHT_DIRECTION = 12, /* 2 */
    /* DIMS_PER_STEP for each surface that a segment meets, PASSES_MAX of them a step. */
    DIM_CAMERA_STEP = 1 << 8,
    DIM_LIGHT_STEP = 1 << 16,
    DIM_NEE = 2 << 16,     /* DIMS_PER_NEE a camera vertex */
    DIM_SPLAT = 3 << 16,   /* DIMS_PER_SPLAT a light vertex */
    DIM_CONNECT = 4 << 16, /* per (s, t, pair of labels), or per pair of runs */
    DIM_GATHER = 8 << 16,  /* per emitter met */
    DIM_COPY =
        9 << 16, /* the second light sub-path of exact.c: the light's dimensions, and one for each copy */
    DIM_COPY_STEP = 10 << 16,
};
enum { DIMS_PER_STEP = 8, DIMS_PER_NEE = 16, DIMS_PER_SPLAT = 16 };
/* Surfaces that one step may pass without scattering. */
enum { PASSES_MAX = 64 };

/* A light sub-path that takes over wavelengths of the camera's runs where both sides disperse (algorithm.md §9). */
struct copying {
    int runs;                                     /* dispersive runs of the camera sub-path */
    int run[PATH_VERTICES], first[PATH_VERTICES]; /* their numbers from the camera, and where they start */
    float lambda[PATH_VERTICES];
    double own, chance[PATH_VERTICES]; /* actual chances of an own wavelength, and of each run's */
    int taken;                         /* index of the run whose wavelength the last run has; −1: its own */
    int start;                         /* vertex where that run starts */
};

/* One worker's memory and the state of the path that it traces. */
struct worker {
    struct subpath camera, light, copy;
    uint32_t sightings;      /* emitters met by this camera sub-path */
    struct copying *copying; /* while `copy` is traced */
    struct random_path random;
    struct film_sample gathered;
    float half_width_nm; /* d_n */
};

struct full_path; /* mis.h */

struct integrator {
    struct integrator_settings settings;
    const struct scene *scene;
    struct film *film;
    struct wavelengths wavelengths;
    double kappa;
    int full[2], border[4];
    bool traces_camera, traces_light, connects, splats;
    bool exact;                    /* connections by exact.c instead of the mollified table */
    bool limits_bounces;           /* some limit on a class of bounces is tighter than max_path */
    int camera_edges, light_edges; /* of the longest sub-paths that some technique can use */
    int worker_count;
    struct worker *worker;
    /* For tests: told of every contribution (density tests, algorithm.md §8). NULL otherwise. */
    void (*observe)(void *observer, const struct full_path *, double value);
    void *observer;
};

/* Grows the camera sub-path from film point (x, y), and adds what its rays see of emitters (s = 0) to worker->gathered. */
void path_trace_camera(const struct integrator *, struct worker *, float x, float y);
/* Grows the light sub-path. */
void path_trace_light(const struct integrator *, struct worker *);
/* Grows worker->copy; sets copying->taken and start. */
void path_trace_copy(const struct integrator *, struct worker *, struct copying *);

/* Cosine of a direction with the surface's geometric normal, absolute. */
static inline float vertex_cosine(const struct vertex *v, struct vec3 direction)
{
    switch (v->kind) {
    case VERTEX_LIGHT:
        return v->unbounded || !v->light.has_normal ? 1 : fabsf(dot(v->light.normal, direction));
    case VERTEX_CAMERA: return v->unbounded ? 1 : fabsf(dot(v->lens.axis, direction));
    case VERTEX_SURFACE: return fabsf(dot(v->hit.ng, direction));
    }
    return 0;
}

/* The kind of ray that leaves a vertex after scattering there, towards the light. */
uint32_t path_ray_kind(enum scatter_class);

/* Whether a whole path with so many bounces of each class is within the limits. */
bool path_keeps_bounces(const struct integrator_settings *, const uint8_t bounces[SCATTER_CLASSES]);

/* Where a shadow ray from this vertex starts. */
struct vec3 vertex_offset(const struct vertex *, struct vec3 direction);

#endif
