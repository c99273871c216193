/* What evaluation (surface.c) and drawing (draw.c) of surfaces share. */
#ifndef MATERIAL_SURFACE_H
#define MATERIAL_SURFACE_H

#include "material/lobe.h"

/* Light sub-paths do not know how a camera's direction will bend a mapped frame: this share of theirs goes anywhere above ng. */
#define BENT_ANYWHERE 0.1f

static inline const struct fluorophore *lobe_fluorophore(const struct lobe *lobe)
{
    return lobe->data;
}

static inline bool surface_crosses(const struct surface *s, struct vec3 a, struct vec3 b)
{
    return dot(a, s->ng) * dot(b, s->ng) < 0;
}

/* Cosine with the geometric normal, absolute. */
static inline float surface_cosine(const struct surface *s, struct vec3 w)
{
    return s->in_volume ? 1 : fabsf(dot(w, s->ng));
}

/* A lobe whose frame bends toward the camera: rough reflection under a normal map. */
bool lobe_is_bent(const struct lobe *);

/* The direction in a frame. False on the horizon, or where geometric and shading sides disagree. */
bool surface_in_frame(const struct surface *, const struct frame *, struct vec3 w, struct vec3 *local);

/* The frame in which a sub-path draws, and how it sees `arriving`. */
bool surface_drawing_frame(const struct surface *, const struct lobe *, enum side, struct vec3 arriving,
                           struct frame *, struct vec3 *local);

/* How a lobe of finite density sees both directions, and its weight there. False where it has no value. */
bool surface_lobe_at(const struct surface *, const struct lobe *, struct vec3 to_light, struct vec3 to_camera,
                     struct vec3 *light, struct vec3 *camera, float *weight);

/* Product of the mix factors that depend on the view, toward a direction. */
float surface_view_weight(const struct surface *, const struct lobe *, struct vec3 direction);

/* The chance of each lobe for a sub-path from `side` that came in from `arriving`. They sum to 1, if there are lobes. */
void surface_chances(const struct surface *, enum side, struct vec3 arriving, float lambda, float chance[]);

/* matte.c: whether a surface of such lobes alone is matte, and surface_steps for one that is. */
bool surface_lobe_is_matte(const struct lobe *);
void surface_matte_steps(const struct surface *, enum side, enum label, int f, struct vec3 arriving,
                         struct vec3 leaving, int lanes, const float lambda_arriving[],
                         const float lambda_leaving[], struct surface_memo memo[MEMOS],
                         struct surface_steps *out);

/* phase.c: surface_steps for a scattering vertex with one phase function. */
void surface_phase_steps(const struct surface *, struct vec3 arriving, struct vec3 leaving, int lanes,
                         const float lambda[], struct surface_steps *out);

#endif
