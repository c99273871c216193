/* Lamps that have a place: rectangles, ellipses, spheres, points and spots. They are seen by rays and drawn
   as emitters, and block nothing. Surfaces emit on one side: rectangles and ellipses along their normal,
   spheres outwards. */
#include "scene/state.h"

static double power_surface(const struct scene *scene, const struct light *light)
{
    (void)scene;
    return light->total * light->lamp->area * PI_F;
}

static float pdf_area(const struct scene *scene, const struct light *light, const struct light_point *point)
{
    (void)scene;
    (void)point;
    return 1 / light->lamp->area;
}

/* Directions of a Lambertian side: density 1/π per projected solid angle. */
static float sample_lambert(const struct scene *scene, const struct light *light,
                            const struct light_point *point, const float u[2], struct vec3 *direction)
{
    (void)scene;
    (void)light;
    struct frame frame = frame_about(point->normal);
    *direction = normalize(to_world(&frame, cosine_hemisphere(u[0], u[1])));
    return dot(*direction, point->normal) > 0 ? 1 / PI_F : 0;
}

static float pdf_lambert(const struct scene *scene, const struct light *light,
                         const struct light_point *point, struct vec3 direction)
{
    (void)scene;
    (void)light;
    return dot(direction, point->normal) > 0 ? 1 / PI_F : 0;
}

static float emission_surface(const struct scene *scene, const struct light *light,
                              const struct light_point *point, struct vec3 direction, float lambda)
{
    (void)scene;
    if (!(dot(direction, point->normal) > 0))
        return 0;
    return emission_at(&light->lamp->emission, vec3(point->uv[0], point->uv[1], 0), lambda);
}

/* --- Rectangles and ellipses ------------------------------------------------------------------------- */

static void flat_point(const struct lamp *lamp, float u, float v, struct light_point *point)
{
    point->position = along(along(lamp->center, lamp->axis_u, u - 0.5f), lamp->axis_v, v - 0.5f);
    point->normal = lamp->normal;
    point->uv[0] = u;
    point->uv[1] = v;
}

static float sample_rectangle(const struct scene *scene, const struct light *light, double choice,
                              const float u[2], struct light_point *point)
{
    (void)choice;
    flat_point(light->lamp, u[0], u[1], point);
    return pdf_area(scene, light, point);
}

static float sample_ellipse(const struct scene *scene, const struct light *light, double choice,
                            const float u[2], struct light_point *point)
{
    (void)choice;
    float radius = 0.5f * sqrtf(u[0]), phi = 2 * PI_F * u[1];
    flat_point(light->lamp, 0.5f + radius * cosf(phi), 0.5f + radius * sinf(phi), point);
    return pdf_area(scene, light, point);
}

static bool hit_plane(const struct lamp *lamp, const struct ray *ray, struct light_point *point, float *t)
{
    float cosine = dot(ray->direction, lamp->normal);
    if (!(cosine < 0)) /* the dark side */
        return false;
    struct vec3 to_center = sub(lamp->center, ray->origin);
    *t = dot(to_center, lamp->normal) / cosine;
    struct vec3 inside = sub(scale(ray->direction, *t), to_center);
    flat_point(lamp, 0.5f + dot(inside, lamp->dual_u), 0.5f + dot(inside, lamp->dual_v), point);
    return true;
}

static bool hit_rectangle(const struct scene *scene, const struct light *light, const struct ray *ray,
                          struct light_point *point, float *t)
{
    (void)scene;
    return hit_plane(light->lamp, ray, point, t) && point->uv[0] >= 0 && point->uv[0] <= 1 &&
           point->uv[1] >= 0 && point->uv[1] <= 1;
}

static bool hit_ellipse(const struct scene *scene, const struct light *light, const struct ray *ray,
                        struct light_point *point, float *t)
{
    (void)scene;
    if (!hit_plane(light->lamp, ray, point, t))
        return false;
    float x = point->uv[0] - 0.5f, y = point->uv[1] - 0.5f;
    return x * x + y * y <= 0.25f;
}

const struct light_kind light_rectangle = {.has_normal = true,
                                           .power = power_surface,
                                           .sample_point = sample_rectangle,
                                           .pdf_point = pdf_area,
                                           .sample_direction = sample_lambert,
                                           .pdf_direction = pdf_lambert,
                                           .emission = emission_surface,
                                           .hit = hit_rectangle};
const struct light_kind light_ellipse = {.has_normal = true,
                                         .power = power_surface,
                                         .sample_point = sample_ellipse,
                                         .pdf_point = pdf_area,
                                         .sample_direction = sample_lambert,
                                         .pdf_direction = pdf_lambert,
                                         .emission = emission_surface,
                                         .hit = hit_ellipse};

/* --- Spheres ----------------------------------------------------------------------------------------- */

static float sample_sphere(const struct scene *scene, const struct light *light, double choice,
                           const float u[2], struct light_point *point)
{
    (void)choice;
    float z = 1 - 2 * u[0], phi = 2 * PI_F * u[1], r = sqrtf(fmaxf(0, 1 - z * z));
    point->normal = vec3(r * cosf(phi), r * sinf(phi), z);
    point->position = along(light->lamp->center, point->normal, light->lamp->input.radius);
    return pdf_area(scene, light, point);
}

/* The nearer intersection: the other one is seen from inside, where nothing is emitted. In doubles, for small
   distant spheres. */
static bool hit_sphere(const struct scene *scene, const struct light *light, const struct ray *ray,
                       struct light_point *point, float *t)
{
    (void)scene;
    struct vec3 d = ray->direction, o = sub(ray->origin, light->lamp->center);
    double radius = light->lamp->input.radius, b = (double)o.x * d.x + (double)o.y * d.y + (double)o.z * d.z;
    double px = o.x - b * d.x, py = o.y - b * d.y,
           pz = o.z - b * d.z; /* the ray's nearest point to the centre */
    double discriminant = radius * radius - (px * px + py * py + pz * pz);
    if (!(discriminant > 0))
        return false;
    double root = sqrt(discriminant);
    *t = (float)(-b - root);
    point->normal =
        normalize(vec3((float)(px - root * d.x), (float)(py - root * d.y), (float)(pz - root * d.z)));
    point->position = along(light->lamp->center, point->normal, light->lamp->input.radius);
    return true;
}

const struct light_kind light_sphere = {.has_normal = true,
                                        .power = power_surface,
                                        .sample_point = sample_sphere,
                                        .pdf_point = pdf_area,
                                        .sample_direction = sample_lambert,
                                        .pdf_direction = pdf_lambert,
                                        .emission = emission_surface,
                                        .hit = hit_sphere};

/* --- Points ------------------------------------------------------------------------------------------ */

static double power_point(const struct scene *scene, const struct light *light)
{
    (void)scene;
    return light->total * 4 * PI_F;
}

static float sample_point(const struct scene *scene, const struct light *light, double choice,
                          const float u[2], struct light_point *point)
{
    (void)scene;
    (void)choice;
    (void)u;
    point->position = light->lamp->center;
    return 1;
}

static float pdf_one(const struct scene *scene, const struct light *light, const struct light_point *point)
{
    (void)scene;
    (void)light;
    (void)point;
    return 1;
}

static float sample_all_directions(const struct scene *scene, const struct light *light,
                                   const struct light_point *point, const float u[2], struct vec3 *direction)
{
    (void)scene;
    (void)light;
    (void)point;
    float z = 1 - 2 * u[0], phi = 2 * PI_F * u[1], r = sqrtf(fmaxf(0, 1 - z * z));
    *direction = vec3(r * cosf(phi), r * sinf(phi), z);
    return 1 / (4 * PI_F);
}

static float pdf_all_directions(const struct scene *scene, const struct light *light,
                                const struct light_point *point, struct vec3 direction)
{
    (void)scene;
    (void)light;
    (void)point;
    (void)direction;
    return 1 / (4 * PI_F);
}

static float emission_point(const struct scene *scene, const struct light *light,
                            const struct light_point *point, struct vec3 direction, float lambda)
{
    (void)scene;
    (void)point;
    (void)direction;
    return emission_at(&light->lamp->emission, vec3(0, 0, 0), lambda);
}

const struct light_kind light_point_lamp = {.delta = true,
                                            .power = power_point,
                                            .sample_point = sample_point,
                                            .pdf_point = pdf_one,
                                            .sample_direction = sample_all_directions,
                                            .pdf_direction = pdf_all_directions,
                                            .emission = emission_point};

/* --- Spots ------------------------------------------------------------------------------------------- */

/* Cosine to the spot's axis, in its own space, where the cone is round. */
static float spot_cosine(const struct lamp *lamp, struct vec3 direction, float *stretch)
{
    struct vec3 local = transform_vector(&lamp->to_local, direction);
    *stretch = length(local);
    return *stretch > 0 ? -local.z / *stretch : 0;
}

/* Cycles' spot: a smoothstep of the cosine from the cone's rim inwards; once also dimmed by the cosine. */
static float spot_attenuation(const struct lamp *lamp, struct vec3 direction)
{
    float stretch, cosine = spot_cosine(lamp, direction, &stretch), above = cosine - lamp->cos_half;
    float whole = lamp->input.dimmed ? fmaxf(cosine, 0) : 1;
    if (!(above > 0))
        return 0;
    if (!(above < lamp->smooth))
        return whole;
    float x = above / lamp->smooth;
    return whole * x * x * (3 - 2 * x);
}

/* Solid angle of the cone, each direction weighted by its attenuation: a smoothstep has the mean 1/2, and the first moment 7/20. */
static double spot_solid_angle(const struct lamp *lamp)
{
    if (lamp->input.dimmed && lamp->cos_half > 0) {
        double rim = lamp->cos_half, width = lamp->smooth, full = rim + width;
        return 2 * PI_F * (0.5 * (1 - full * full) + width * (0.5 * rim + 0.35 * width));
    }
    return 2 * PI_F * (1 - lamp->cos_half - 0.5 * lamp->smooth);
}

static double power_spot(const struct scene *scene, const struct light *light)
{
    (void)scene;
    return light->total * spot_solid_angle(light->lamp);
}

/* Uniform in the local cone. A linear map A of directions has the Jacobian |det A| / |A ω|³. */
static float pdf_cone(const struct scene *scene, const struct light *light, const struct light_point *point,
                      struct vec3 direction)
{
    (void)scene;
    (void)point;
    const struct lamp *lamp = light->lamp;
    float stretch, cosine = spot_cosine(lamp, direction, &stretch);
    if (!(cosine > lamp->cos_half))
        return 0;
    return 1 / (2 * PI_F * (1 - lamp->cos_half) * lamp->determinant * stretch * stretch * stretch);
}

static float sample_cone(const struct scene *scene, const struct light *light,
                         const struct light_point *point, const float u[2], struct vec3 *direction)
{
    const struct lamp *lamp = light->lamp;
    float z = 1 - u[0] * (1 - lamp->cos_half), phi = 2 * PI_F * u[1], r = sqrtf(fmaxf(0, 1 - z * z));
    *direction = normalize(transform_vector(&lamp->input.transform, vec3(r * cosf(phi), r * sinf(phi), -z)));
    return pdf_cone(scene, light, point, *direction);
}

static float emission_spot(const struct scene *scene, const struct light *light,
                           const struct light_point *point, struct vec3 direction, float lambda)
{
    float attenuation = spot_attenuation(light->lamp, direction);
    return attenuation > 0 ? attenuation * emission_point(scene, light, point, direction, lambda) : 0;
}

const struct light_kind light_spot = {.delta = true,
                                      .power = power_spot,
                                      .sample_point = sample_point,
                                      .pdf_point = pdf_one,
                                      .sample_direction = sample_cone,
                                      .pdf_direction = pdf_cone,
                                      .emission = emission_spot};

/* A spot with a radius is a sphere whose radiance falls off with direction as the spot's intensity does. Its
   directions come from the cone; over the cosine, to be per projected solid angle. */
static double power_spot_sphere(const struct scene *scene, const struct light *light)
{
    return power_spot(scene, light) * light->lamp->area / 4; /* a sphere's cross-section */
}

static float pdf_cone_projected(const struct scene *scene, const struct light *light,
                                const struct light_point *point, struct vec3 direction)
{
    float cosine = dot(direction, point->normal);
    return cosine > 0 ? pdf_cone(scene, light, point, direction) / cosine : 0;
}

static float sample_cone_projected(const struct scene *scene, const struct light *light,
                                   const struct light_point *point, const float u[2], struct vec3 *direction)
{
    sample_cone(scene, light, point, u, direction);
    return pdf_cone_projected(scene, light, point, *direction);
}

static float emission_spot_sphere(const struct scene *scene, const struct light *light,
                                  const struct light_point *point, struct vec3 direction, float lambda)
{
    return dot(direction, point->normal) > 0 ? emission_spot(scene, light, point, direction, lambda) : 0;
}

const struct light_kind light_spot_sphere = {.has_normal = true,
                                             .power = power_spot_sphere,
                                             .sample_point = sample_sphere,
                                             .pdf_point = pdf_area,
                                             .sample_direction = sample_cone_projected,
                                             .pdf_direction = pdf_cone_projected,
                                             .emission = emission_spot_sphere,
                                             .hit = hit_sphere};
