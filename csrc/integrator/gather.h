/* Emitters that a camera sub-path meets by itself: the techniques with s = 0. */
#ifndef INTEGRATOR_GATHER_H
#define INTEGRATOR_GATHER_H

#include "integrator/path.h"

/* x̄+ȳ+z̄, in which shares of the light are reckoned. */
static inline double gather_cmf_sum(float lambda)
{
    float cmf[3];
    cmf_eval(lambda, cmf);
    return (double)cmf[0] + (double)cmf[1] + (double)cmf[2];
}

/* `passed`: the ray went through transparent surfaces since the last vertex. */

/* `media`: where the scene has volumes, what the segment lies in; the next vertex's crossing is that of the edge before it. */

/* Lamps along the segment `ray` of worker->camera's next edge and, if it goes to infinity, the world and suns. */
void gather_lamps(const struct integrator *, struct worker *, const struct ray *, bool passed,
                  bool to_infinity, const struct media *);
/* An emitting surface at the end of that edge. */
void gather_surface(const struct integrator *, struct worker *, const struct hit *, struct vec3 direction,
                    bool passed);

#endif
