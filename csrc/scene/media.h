/* Volumes in space: which ones a point is in, what of them a straight edge crosses, and what that does to light and to the density of
   distances (algorithm.md §13). */
#ifndef SCENE_MEDIA_H
#define SCENE_MEDIA_H

#include "material/volume.h"
#include "scene/scene.h"

/* A set of volumes, each so many times over: where bodies of one volume overlap, it counts twice. What would not fit is left out. */
#define MEDIA_MAX 8
struct media {
    int count;
    struct {
        int16_t volume, times;
    } in[MEDIA_MAX];
};

/* How much of each volume an edge crosses, m; infinite where it never ends. */
#define CROSSING_MAX 12
struct crossing {
    int count; /* more than CROSSING_MAX: so many volumes that nothing gets through */
    struct {
        int16_t volume;
        float length;
    } at[CROSSING_MAX];
};

/* Whether there are volumes at all, and whether some that do not fill all of space. */
bool scene_has_volumes(const struct scene *);
bool scene_has_bounded_volumes(const struct scene *);

/* The world's volume alone. */
struct media scene_open_media(const struct scene *);
/* The volumes at a point, seen along a unit direction: what a ray that starts there will leave. Takes a ray through the whole scene. */
struct media scene_media_at(const struct scene *, struct vec3 point, struct vec3 direction);
/* The same for a camera's ray, which takes one only where the camera may be inside of something. */
struct media scene_camera_media(const struct scene *, struct vec3 point, struct vec3 direction);

/* A ray passes the boundary of a volume. */
void media_pass(struct media *, int volume, bool enters);

/* `length` more metres in these media. */
void crossing_add(struct crossing *, const struct media *, float length);
double crossing_transmittance(const struct scene *, const struct crossing *, float lambda);
/* Optical depth for one of the rates that distances are drawn from, and the rate at a place. */
double crossing_depth(const struct scene *, const struct crossing *, int rate);
double media_rate(const struct scene *, const struct media *, int rate);
/* For each rate the density of crossing all of it and being stopped there: by these media (per metre), or by a surface (end = NULL: a probability). */
void crossing_densities(const struct scene *, const struct crossing *, const struct media *end,
                        double density[VOLUME_RATES]);

/* The surface of a scattering vertex. False where nothing scatters. */
bool scene_shade_media(const struct scene *, const struct media *, struct surface *);

/* As scene_visibility and scene_visibility_distant, without what volumes extinguish; fills what of them the segment crosses, from the media at
   its beginning on. */
float scene_visibility_through(const struct scene *, struct vec3 from, struct vec3 to, float lambda,
                               uint32_t kind, const struct media *, struct crossing *);
float scene_visibility_distant_through(const struct scene *, struct vec3 from, struct vec3 direction,
                                       float lambda, uint32_t kind, const struct media *, struct crossing *);

#endif
