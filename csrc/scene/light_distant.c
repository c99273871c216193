/* Lights at infinity: suns and the world. A point of theirs is a direction from the scene; their rays start
   on a disk outside of the scene, with a density per area perpendicular to the direction (lights.c). */
#include "scene/state.h"

static double cross_section(const struct scene *scene)
{
    return (double)PI_F * scene->radius * scene->radius;
}

/* --- Suns -------------------------------------------------------------------------------------------- */

static double power_sun(const struct scene *scene, const struct light *light)
{
    return light->total * cross_section(scene);
}

/* 1 − cos without cancellation. */
static float versine(float angle)
{
    float s = sinf(0.5f * angle);
    return 2 * s * s;
}

static float sun_pdf(const struct lamp *lamp)
{
    return 1 / (2 * PI_F * versine(lamp->half_angle));
}

static float sample_sun(const struct scene *scene, const struct light *light, double choice, const float u[2],
                        struct light_point *point)
{
    (void)scene;
    (void)choice;
    const struct lamp *lamp = light->lamp;
    float below = u[0] * versine(lamp->half_angle), r = sqrtf(below * (2 - below)), phi = 2 * PI_F * u[1];
    struct frame frame = frame_about(lamp->normal);
    point->normal = normalize(to_world(&frame, vec3(r * cosf(phi), r * sinf(phi), 1 - below)));
    return sun_pdf(lamp);
}

static float pdf_sun(const struct scene *scene, const struct light *light, const struct light_point *point)
{
    (void)scene;
    (void)point;
    return sun_pdf(light->lamp);
}

/* Radiance whose integral over the disk, times the cosine to its middle, is the lamp's irradiance: E / (π
   sin²). */
static float emission_sun(const struct scene *scene, const struct light *light,
                          const struct light_point *point, struct vec3 direction, float lambda)
{
    (void)scene;
    (void)point;
    (void)direction;
    float s = sinf(light->lamp->half_angle);
    return emission_at(&light->lamp->emission, vec3(0, 0, 0), lambda) / (PI_F * s * s);
}

/* By the chord, because cosines of small angles round to 1. */
static bool hit_sun(const struct scene *scene, const struct light *light, const struct ray *ray,
                    struct light_point *point, float *t)
{
    (void)scene;
    point->normal = ray->direction;
    *t = INFINITY;
    return length_squared(sub(ray->direction, light->lamp->normal)) <= 2 * versine(light->lamp->half_angle);
}

const struct light_kind light_sun = {.distant = true,
                                     .has_normal = true,
                                     .power = power_sun,
                                     .sample_point = sample_sun,
                                     .pdf_point = pdf_sun,
                                     .emission = emission_sun,
                                     .hit = hit_sun};

static float sample_sun_delta(const struct scene *scene, const struct light *light, double choice,
                              const float u[2], struct light_point *point)
{
    (void)scene;
    (void)choice;
    (void)u;
    point->normal = light->lamp->normal;
    return 1;
}

static float pdf_sun_delta(const struct scene *scene, const struct light *light,
                           const struct light_point *point)
{
    (void)scene;
    (void)light;
    (void)point;
    return 1;
}

static float emission_sun_delta(const struct scene *scene, const struct light *light,
                                const struct light_point *point, struct vec3 direction, float lambda)
{
    (void)scene;
    (void)point;
    (void)direction;
    return emission_at(&light->lamp->emission, vec3(0, 0, 0), lambda);
}

const struct light_kind light_sun_delta = {.delta = true,
                                           .distant = true,
                                           .has_normal = true,
                                           .power = power_sun,
                                           .sample_point = sample_sun_delta,
                                           .pdf_point = pdf_sun_delta,
                                           .emission = emission_sun_delta};

/* --- The world --------------------------------------------------------------------------------------- */

static double power_world(const struct scene *scene, const struct light *light)
{
    (void)light;
    return light->total * 4 * PI_F * cross_section(scene);
}

static float pdf_world(const struct scene *scene, const struct light *light, const struct light_point *point)
{
    (void)light;
    return world_pdf(scene->world, point->normal);
}

static float sample_world(const struct scene *scene, const struct light *light, double choice,
                          const float u[2], struct light_point *point)
{
    (void)choice;
    point->normal = world_sample(scene->world, u);
    return pdf_world(scene, light, point);
}

static float emission_world(const struct scene *scene, const struct light *light,
                            const struct light_point *point, struct vec3 direction, float lambda)
{
    (void)light;
    (void)direction;
    return world_radiance(scene->world, point->normal, lambda);
}

static bool hit_world(const struct scene *scene, const struct light *light, const struct ray *ray,
                      struct light_point *point, float *t)
{
    (void)scene;
    (void)light;
    point->normal = ray->direction;
    *t = INFINITY;
    return true;
}

const struct light_kind light_world = {.distant = true,
                                       .has_normal = true,
                                       .power = power_world,
                                       .sample_point = sample_world,
                                       .pdf_point = pdf_world,
                                       .emission = emission_world,
                                       .hit = hit_world};
