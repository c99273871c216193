/* Paths: vertices, sub-paths, and what one worker needs to trace them.

   A path is x_0 (light) … x_K (camera); edge i lies between x_{i-1} and x_i (algorithm.md §7). The camera sub-path holds
   x_K, x_{K-1}, … and the light sub-path x_0, x_1, …, each in the order in which it was traced: `prev` and `next` are meant
   that way. Densities are per projected solid angle, so a step's density over area is pdf × the edge's geometry term.

   A sub-path carries a bundle of wavelengths (algorithm.md §11). One lane leads: it draws labels and directions. All share the
   geometry, until a refraction disperses and leaves the leader alone. */
#ifndef INTEGRATOR_PATH_H
#define INTEGRATOR_PATH_H

#include "base/random.h"
#include "integrator/integrator.h"
#include "integrator/wavelengths.h"
#include "scene/media.h"

#define PATH_VERTICES TECHNIQUES_MAX
#define SCATTER_CLASSES 5

enum vertex_kind { VERTEX_LIGHT, VERTEX_CAMERA, VERTEX_SURFACE };

/* The weights of all cuts before a vertex, relative to the sub-path that arrives there (algorithm.md §6 and §9). What the part of the
   run that is still to come has to say about them is not known yet, so they are kept apart by the factor that it brings. */
struct tally {
    double closed[LANES_MAX]; /* nothing */
    double open[LANES_MAX];   /* the own part does not disperse: P/far, or 1 if the other part does */
    double near[LANES_MAX];   /* the own part does: 1/far, or a copy's chance */
    double bent[LANES_MAX];   /* both do, camera side: a copy's chance/far */
    double both[LANES_MAX];   /* a copy's chance */
};

/* What arrives at a vertex, lane by lane; as traced, or evaluated again at other wavelengths (relight.h). */
struct arrival {
    int lanes;
    float lambda[LANES_MAX];      /* nm, of the edge to prev */
    float draw[LANES_MAX];        /* density with which the run's start draws that, nm⁻¹ */
    double throughput[LANES_MAX]; /* of everything before this vertex */
    double seam[LANES_MAX]; /* 1/(density over area of the step that made this vertex); 0 behind a δ vertex */
    struct tally tally;     /* of the cuts before, over the density of that step's direction */
    int start;              /* vertex where the run starts (an F vertex, the light, the camera) */
    bool first;             /* that is the vertex before */
    int origin;             /* the source (light side) or sink (camera side) of wavelengths.h that it is */
    int dyes;               /* F vertices passed */
    bool behind_specular;   /* the vertex before is specular */
    bool connectable;       /* some two neighbours before this vertex are not */
    bool disperses;         /* some vertex of the run before this one does */
    bool disperses_early;   /* and some vertex before the previous one */
};

/* What volumes have to do with a vertex, where the scene has any (algorithm.md §13). */
struct vertex_media {
    struct media media;       /* on the side that the edge to prev arrives at */
    int boundary;             /* the volume behind the surface; −1: none */
    struct crossing crossing; /* of the edge to prev */
    double ahead,
        back;     /* nominal densities of that edge's length for a step from prev, and for one back to it. 1 without volumes; but 0 if the
                     edge is barred to light sub-paths (SEEN_BY_SOME) */
    double flown; /* density with which it was really drawn */
    float odds[VOLUME_RATES]; /* of each rate to have drawn this run so far */
    float toll;               /* what of the lanes' sum is left at its end, over `flown` */
};

struct vertex {
    enum vertex_kind kind;
    enum label label; /* of a vertex that was passed; the last one of a sub-path has none yet */
    int lobe;         /* fluorescent or specular lobe of that label */
    struct vec3 position;
    struct vec3 to_prev, to_next; /* unit, away from the vertex */
    struct arrival arrival;
    float lead
        [LANES_MAX]; /* how likely each lane would have led here, relative to all that live: their mean is 1 */
    int leader, leaders;          /* the lane that leads, of how many that live */
    float lambda_film[LANES_MAX]; /* camera side: nm, of the first run */
    /* Of the step to next, when passed: its lanes, and each one's place among those of arrival. */
    int lanes_out;
    uint8_t from[LANES_MAX];
    float lambda_out[LANES_MAX];
    float own[LANES_MAX];   /* nominal density: label × wavelength × direction */
    float other[LANES_MAX]; /* with which the other side's sub-path, coming from next, would step to prev */
    double
        drawn; /* density with which the step was really drawn, all leaders together: label × direction × roulette */
    float geometry; /* of the edge to prev */
    /* A distant light, an orthographic camera: a direction instead of a point, so that edges to it have no
       length, and its steps have densities per area perpendicular to them. */
    bool unbounded;
    bool in_volume; /* VERTEX_SURFACE: it scatters inside of volumes, and has no normal */
    /* Transparent surfaces on the edge to prev: whether there were any, and 1/(chance to stop at this vertex). */
    bool passed;
    float passage;
    bool disperses; /* passed by a refraction whose direction depends on the wavelength */
    uint8_t bounces[SCATTER_CLASSES];
    uint32_t kinds;            /* of rays that see this vertex (enum ray_kind) */
    float pdf_point;           /* VERTEX_LIGHT: of choosing light and point */
    struct light_point light;  /* VERTEX_LIGHT */
    struct camera_point lens;  /* VERTEX_CAMERA */
    struct hit hit;            /* VERTEX_SURFACE */
    struct surface surface;    /* VERTEX_SURFACE: evaluates again at any wavelength */
    struct surface_memo *memo; /* VERTEX_SURFACE: MEMOS of them, the worker's */
    struct vertex_media inside;
};

/* Sets what says nothing yet; hit and surface, which are two kilobytes, are left as they are. */
static inline void vertex_begin(struct vertex *v, enum vertex_kind kind)
{
    v->kind = kind;
    v->label = LABEL_FLUORESCENT;
    v->lobe = 0;
    v->passage = 1;
    v->geometry = 0;
    v->drawn = 1;
    v->unbounded = v->in_volume = v->passed = v->disperses = false;
}

struct subpath {
    int count;
    struct vertex *vertex; /* PATH_VERTICES of them */
    struct surface_memo *memo;
};

/* Dimensions of the sample point (random.h). A new one goes to the end of its block: the map has a version. */
enum dimension {
    DIM_FILM = 0,   /* 2 */
    DIM_LENS = 2,   /* 2 */
    DIM_LAMBDA = 4, /* 1 */
    DIM_LIGHT = 8,  /* 3: light, point */
    DIM_LIGHT_LAMBDA = 11,
    DIM_LIGHT_DIRECTION = 12, /* 2 */
    DIM_LIGHT_LEADER = 14,
    DIM_LIGHT_PATHS = 15,
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
    DIM_ROULETTE = 11 << 16, /* per turn (roulette.h) */
};
enum { SIDES = 2 };
/* Within a step: 0–3 the surface's, then */
enum { STEP_ROULETTE = 4, STEP_PASS = 5, STEP_COPY = 6, STEP_LEADER = 7 };
/* Within the step's last pass: the distance in volumes. */
enum { STEP_RATE = 0, STEP_DEPTH = 1 };
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

struct strand; /* relight.h */
struct sight;  /* joint.h */
struct haze;   /* joint.h */

/* Who makes a path: s ≤ 1 with t ≥ 2 takes no light sub-path, the others take one, connected or seen (algorithm.md §15). */
enum technique_kind { BY_CAMERA, BY_CONNECTIONS, BY_SPLATS, TECHNIQUE_KINDS };

struct trial; /* trial.h */

/* One worker's memory and the state of the path that it traces. */
struct worker {
    struct subpath camera, light, copy;
    int light_paths;                   /* of this sample */
    uint32_t sightings;                /* emitters met by this camera sub-path */
    uint32_t spins;                    /* of roulette on connections, in this sample */
    double taken;                      /* what the sample has gathered so far, in all its bins alike */
    float power[SIDES][PATH_VERTICES]; /* of the two sub-paths' vertices, for that (roulette.h) */
    double all, unconnected; /* gathered light, X+Y+Z, since the integrator was made; for the report */
    float veil;              /* of the void behind the scene, what volumes hide from the camera's ray */
    float hole;              /* how much of what the camera's ray met first is a hole in the picture */
    struct copying *copying; /* while `copy` is traced */
    struct random_path random;
    struct film_sample gathered;
    float half_width_nm; /* d_n */
    double reach_nm;     /* 1/k(λ|λ): what an E–E connection counts for on a path of one wavelength */
    struct strand *strand[SIDES]; /* runs that are being connected, evaluated again */
    struct sight *sight;          /* PATH_VERTICES²: edges between the two sub-paths, once looked at */
    struct haze *haze;            /* of those edges; NULL without volumes */
    uint32_t stamp;               /* of the sights that belong to this sample */
    double work[TECHNIQUE_KINDS]; /* so far, in edges traced */
    struct trial *trial;          /* during a look (pilot.c), which learns what the film is not told; NULL otherwise */
};

struct full_path; /* mis.h */

/* Which cuts of a path are techniques, and so how weights are summed. */
enum cuts {
    CUTS_ONE,    /* one of each path: it has weight 1 */
    CUTS_LIGHTS, /* s ≤ 1 */
    CUTS_ALL,
    CUTS_CHOSEN, /* any subset: by plain products (mis.h) */
};

struct integrator {
    struct integrator_settings settings;
    const struct scene *scene;
    struct film *film;
    struct wavelengths wavelengths;
    double kappa;
    int full[2], border[4];
    bool traces_camera, traces_light, connects, splats;
    bool meets;         /* some technique has s ≥ 2 and t ≥ 2 */
    bool exact;         /* connections by exact.c instead of the mollified table */
    double light_paths; /* light sub-paths of a sample, on average */
    double splat_trust; /* of s = t = 1, in the weights */
    double typical;     /* X+Y+Z (and bins) of a pixel, on average, but for lights that it shows; 0 until it is known */
    int looked;         /* stages of pilot.c that there were */
    enum cuts cuts;
    int lanes;                      /* 1, 4 or 8 */
    bool has_volumes, has_barriers; /* of the scene */
    bool limits_bounces;            /* some limit on a class of bounces is tighter than max_path */
    int camera_edges, light_edges;  /* of the longest sub-paths that some technique can use */
    int worker_count;
    struct worker *worker;
    /* For tests: told of every contribution (density tests, algorithm.md §8). NULL otherwise. */
    void (*observe)(void *observer, const struct full_path *, double value);
    void *observer;
};

/* All of a sample, but that what the camera gathered stays in worker->gathered. */
void integrator_trace(const struct integrator *, struct worker *, int x, int y, uint32_t seed, int sample);

/* Grows the camera sub-path from film point (x, y), and adds what its rays see of emitters (s = 0) to worker->gathered. */
void path_trace_camera(const struct integrator *, struct worker *, float x, float y);
/* Grows the light sub-path. */
void path_trace_light(const struct integrator *, struct worker *);
/* A light point drawn from three numbers. False without lights. */
bool path_light_vertex(const struct integrator *, const float u[3], struct vertex *);
/* Grows worker->copy; sets copying->taken and start. */
void path_trace_copy(const struct integrator *, struct worker *, struct copying *);

/* Cosine of a direction with the surface's geometric normal, absolute. */
static inline float vertex_cosine(const struct vertex *v, struct vec3 direction)
{
    switch (v->kind) {
    case VERTEX_LIGHT:
        return v->unbounded || !v->light.has_normal ? 1 : fabsf(dot(v->light.normal, direction));
    case VERTEX_CAMERA: return v->unbounded ? 1 : fabsf(dot(v->lens.axis, direction));
    case VERTEX_SURFACE: return v->in_volume ? 1 : fabsf(dot(v->hit.ng, direction));
    }
    return 0;
}

static inline enum technique_kind technique_kind(int s, int t)
{
    return t == 1 ? BY_SPLATS : s >= 2 ? BY_CONNECTIONS : BY_CAMERA;
}

/* How many of a technique a sample has on average: all light sub-paths are seen by the camera, but only the first is connected to its
   sub-path (algorithm.md §15). */
static inline double technique_rate(const struct integrator *it, int s, int t)
{
    return t == 1 ? it->light_paths : s >= 2 ? fmin(it->light_paths, 1) : 1;
}

/* The same in weights, which may take any factor: what a camera without a lens sees of a light at once has only the noise of its
   wavelengths (algorithm.md §6). */
static inline double technique_trust(const struct integrator *it, int s, int t)
{
    return technique_rate(it, s, t) * (s == 1 && t == 1 ? it->splat_trust : 1);
}

/* Density with which a light sub-path draws its first wavelength; 1 where it shares the camera's. */
static inline float path_light_draw(const struct integrator *it, const struct light_point *light,
                                    float lambda)
{
    return it->settings.shared_wavelength ? 1 : scene_pdf_light_lambda(it->scene, light, lambda);
}

/* What shadow rays do not see no light sub-path meets first: where it is next to the light, no cut s ≥ 2 is a technique. */
static inline bool vertex_begins_light_paths(const struct vertex *v)
{
    return v->kind != VERTEX_SURFACE || (v->kinds & RAY_SHADOW);
}

/* The kind of ray that leaves a vertex after scattering there, towards the light. */
uint32_t path_ray_kind(enum scatter_class);
/* The kind that a sub-path's own step from this vertex, which it has passed, is. */
uint32_t path_step_kind(enum side, const struct vertex *);

/* Whether a whole path with so many bounces of each class is within the limits. */
bool path_keeps_bounces(const struct integrator_settings *, const uint8_t bounces[SCATTER_CLASSES]);

/* Where a shadow ray from this vertex starts. */
struct vec3 vertex_offset(const struct vertex *, struct vec3 direction);

#endif
