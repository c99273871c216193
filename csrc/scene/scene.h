/* The scene that integrators see: rays against meshes and lamps, lights, camera. Immutable once scene_commit has run. */
#ifndef SCENE_SCENE_H
#define SCENE_SCENE_H

#include "material/material.h"

struct scene;

/* --- Rays ------------------------------------------------------------------------------------------------ */

enum ray_kind { RAY_CAMERA = 1, RAY_DIFFUSE = 2, RAY_GLOSSY = 4, RAY_TRANSMISSION = 8, RAY_SHADOW = 16, RAY_VOLUME = 32 };
/* Beside the kinds of ray that see an object: some do, but not all of those that fly from one surface or volume to another. */
#define SEEN_BY_SOME 64

struct ray {
    struct vec3 origin, direction; /* unit */
    float near, far;
    uint32_t kind; /* enum ray_kind: which visibility flags count */
};

/* Nearest surface; false if none. Lamps (`light` messages) are not surfaces: they neither block nor reflect. */
bool scene_intersect(const struct scene *, const struct ray *, struct hit *, const struct material **);

/* Transmittance at a wavelength of the open segment between two points that were offset from their surfaces: 0 if blocked, the
   product over `transparent` materials otherwise. What this kind of ray does not see lets it pass. */
float scene_visibility(const struct scene *, struct vec3 from, struct vec3 to, float lambda, uint32_t kind);
/* The same to infinity along a unit direction. */
float scene_visibility_distant(const struct scene *, struct vec3 from, struct vec3 direction, float lambda,
                               uint32_t kind);

/* Whether anything is SEEN_BY_SOME, and whether it lies on that segment: a ray that is not worth tracing where nothing is. */
bool scene_has_barriers(const struct scene *);
bool scene_is_barred(const struct scene *, struct vec3 from, struct vec3 to);

/* Which kinds of ray (enum ray_kind, and SEEN_BY_SOME) see what was hit. An edge of a path is a ray that leaves its end on the camera's side, whoever traced it. */
uint32_t scene_hit_kinds(const struct scene *, const struct hit *);

/* True of an object that is a hole in the picture: camera rays end there, black and with alpha 0. All other rays see it as it is. */
bool scene_hit_is_holdout(const struct scene *, const struct hit *);

/* A ray's origin moved off the surface, to the side that `direction` leaves to. */
struct vec3 scene_offset(const struct hit *, struct vec3 direction);

/* Radius and centre of a sphere about all geometry (and the camera). */
void scene_bounds(const struct scene *, struct vec3 *center, float *radius);

/* --- Lights ---------------------------------------------------------------------------------------------- */
/* Mesh emitters, lamps and the world are one list. A light vertex is a point on it (or, for sun and world, a direction). */

struct light_point {
    int light;
    struct vec3 position;
    struct vec3 normal;   /* of an emitting surface; for distant lights the direction *from the scene to the light* */
    struct hit hit;       /* of a mesh emitter, for textures */
    float uv[2];
    bool distant;         /* position is meaningless; pdf_point is per solid angle of `normal` */
    bool delta;           /* a point or a single direction: no ray can hit it */
    bool on_mesh;         /* a mesh emitter: `hit` is set */
    bool has_normal;      /* false for points: their directions have densities per solid angle, and no cosine in G */
};

int scene_light_count(const struct scene *);
const char *scene_light_name(const struct scene *, int light);
/* True if no camera sub-path can hit it (`pt` names such lights). */
bool scene_light_is_delta(const struct scene *, int light);

/* The same of a light. */
uint32_t scene_light_kinds(const struct scene *, int light);

/* Draws a light by power and a point on it; u: light, point, point. pdf: the choice × density per area (per solid angle if
   distant; 1 × choice for δ). False if the scene has no light. */
bool scene_sample_light(const struct scene *, const float u[3], struct light_point *, float *pdf);
float scene_pdf_light(const struct scene *, const struct light_point *);

/* Wavelength of the first edge of a light path: the light's own spectrum. */
float scene_sample_light_lambda(const struct scene *, const struct light_point *, float u, float *pdf);
float scene_pdf_light_lambda(const struct scene *, const struct light_point *, float lambda);
/* The spectrum that those draw from (not normalised); borrowed. */
const struct spectrum *scene_light_spectrum(const struct scene *, int light);
/* Lights of one spectral shape share their spectrum: how many shapes there are, and which one a light has. */
int scene_light_shape_count(const struct scene *);
int scene_light_shape(const struct scene *, int light);

/* Draws the first ray of a light path. pdf: per projected solid angle about the light point's normal (per solid angle where it has none);
   for distant lights the density per area perpendicular to the direction, and *origin is on a disk outside of the scene. */
bool scene_sample_light_direction(const struct scene *, const struct light_point *, const float u[2], struct vec3 *origin,
                                  struct vec3 *direction, float *pdf);
float scene_pdf_light_direction(const struct scene *, const struct light_point *, struct vec3 direction);

/* Spectral radiance (intensity for points without area; irradiance perpendicular for δ suns) that leaves the light point along a direction. */
float scene_light_emission(const struct scene *, const struct light_point *, struct vec3 direction, float lambda);

/* Lamps that the open segment passes, nearest first, at most `most` (and 64); ray->far bounds it. */
int scene_lamps_along(const struct scene *, const struct ray *, struct light_point *, int most);
/* What the ray sees at infinity: the world and suns of finite angle; at most `most`. */
int scene_distant_along(const struct scene *, const struct ray *, struct light_point *, int most);
/* The light point of a mesh emitter that was hit (hit->light ≥ 0). */
void scene_light_point_at(const struct scene *, const struct hit *, struct light_point *);

/* True if a camera ray can meet this point of a light directly, so that a connection of the two counts: mesh emitters that the camera
   sees, lamps with camera visibility that have an area. */
bool scene_light_seen_by_camera(const struct scene *, const struct light_point *);

/* Power-weighted spectrum of all lights, for p_cam (algorithm.md §1); borrowed; NULL without lights. */
const struct spectrum *scene_lamp_spectrum(const struct scene *);

/* --- Camera ---------------------------------------------------------------------------------------------- */

struct camera_point {
    struct vec3 position; /* on the lens, or on the near plane of an orthographic camera */
    struct vec3 axis;     /* viewing direction of the camera; of an orthographic one, of this point of its lens */
    float near;           /* rays begin at this depth along the axis */
};

/* A ray through film point (x, y), in pixels of the full frame from its lower left corner; u: on the lens. The density of
   directions per projected solid angle about the axis, for points uniform over the whole frame; for an orthographic camera see
   scene_camera_is_orthographic. */
struct ray scene_camera_ray(const struct scene *, float x, float y, const float u[2], struct camera_point *, float *pdf);
/* A point on the lens for a connection from `from`; where it falls on the film, and the density with which scene_camera_ray
   would make that direction. False outside the frame by more than `margin` pixels (a pixel filter reaches over the edge), or
   outside the clip range. */
bool scene_camera_connect(const struct scene *, struct vec3 from, float margin, const float u[2], struct camera_point *,
                          float film[2], float *pdf);
/* An orthographic camera is the dual of a distant light: its position on the film plane is what the pixel draws, its direction is
   a δ that the point on the lens decides. `pdf` is then per area perpendicular to the axis. */
bool scene_camera_is_orthographic(const struct scene *);
bool scene_camera_blurs(const struct scene *); /* has a lens, not a pinhole */
void scene_camera_size(const struct scene *, int full[2], int border[4]);

/* --- Fluorophores, for the product tables ------------------------------------------------------------------ */
int scene_fluorophore_count(const struct scene *);
const struct spectrum *scene_fluorophore_emission(const struct scene *, int index);
const struct spectrum *scene_fluorophore_absorption(const struct scene *, int index);
/* As surface_pdf_emitted and surface_pdf_absorbed: what is drawn at a fluorophore given the other wavelength. */
float scene_fluorophore_pdf_emitted(const struct scene *, int index, float lambda_in, float lambda_out);
float scene_fluorophore_pdf_absorbed(const struct scene *, int index, float lambda_in, float lambda_out);

#endif
