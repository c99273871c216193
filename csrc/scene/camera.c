/* The camera: a frame, a thin lens (disk or polygon), and the density of its rays, forwards and for
   connections. A film point is a direction (perspective) or a position (orthographic); see scene.h for the
   measures. */
#include <float.h>
#include <stdlib.h>

#include "base/error.h"
#include "scene/state.h"

void camera_destroy(struct camera *camera)
{
    free(camera);
}

static bool check_frame(const struct camera_input *in, stokes_error *err)
{
    const float *f = in->frame;
    const int *b = in->border, *size = in->resolution;
    if (!(f[1] > f[0] && f[3] > f[2]) || !isfinite((f[1] - f[0]) * (f[3] - f[2])) ||
        !((f[1] - f[0]) * (f[3] - f[2]) > 0))
        return fail(err, "camera", "frame", "[%g, %g, %g, %g] is empty", (double)f[0], (double)f[1],
                    (double)f[2], (double)f[3]);
    if (size[0] < 1 || size[1] < 1)
        return fail(err, "camera", "resolution", "%d × %d has no pixels", size[0], size[1]);
    if (b[0] < 0 || b[1] < 0 || b[2] > size[0] || b[3] > size[1] || b[0] >= b[2] || b[1] >= b[3])
        return fail(err, "camera", "border", "[%d, %d, %d, %d] is not within %d × %d pixels", b[0], b[1],
                    b[2], b[3], size[0], size[1]);
    return true;
}

static bool check_lens(const struct camera_input *in, stokes_error *err)
{
    if (!(in->clip[0] < in->clip[1]) || (!in->orthographic && in->clip[0] < 0))
        return fail(err, "camera", "clip", "[%g, %g] is empty", (double)in->clip[0], (double)in->clip[1]);
    if (!(in->lens_radius >= 0 && isfinite(in->lens_radius)))
        return fail(err, "camera", "lens_radius", "is %g m", (double)in->lens_radius);
    if (in->lens_radius > 0 && !(in->focus_distance > 0 && isfinite(in->focus_distance)))
        return fail(err, "camera", "focus_distance", "is %g m", (double)in->focus_distance);
    if (in->lens_radius > 0 && !(in->aspect > 0 && isfinite(in->aspect)))
        return fail(err, "camera", "aspect", "is %g", (double)in->aspect);
    return true;
}

/* The transform's axes without their scale; the viewing direction counts most, then up. */
static bool derive_axes(struct camera *camera, stokes_error *err)
{
    const float *m = camera->input.transform.m;
    struct vec3 y = vec3(m[1], m[5], m[9]);
    camera->axis = normalize(vec3(-m[2], -m[6], -m[10]));
    camera->y = normalize(along(y, camera->axis, -dot(y, camera->axis)));
    camera->x = cross(camera->axis, camera->y);
    if (dot(camera->x, vec3(m[0], m[4], m[8])) < 0) /* a mirrored camera keeps its mirror image */
        camera->x = negate(camera->x);
    camera->position = vec3(m[3], m[7], m[11]);
    if (!transform_is_finite(&camera->input.transform) || !(length_squared(camera->axis) > 0) ||
        !(length_squared(camera->y) > 0))
        return fail(err, "camera", "transform", "has no viewing direction");
    return true;
}

static void derive_window(struct camera *camera)
{
    struct vec3 x = camera->x, y = camera->y, z = negate(camera->axis), o = camera->position;
    const float *frame = camera->input.frame;
    camera->width = frame[1] - frame[0];
    camera->height = frame[3] - frame[2];
    camera->window = (struct hit_window){
        .to_camera = {{x.x, x.y, x.z, -dot(x, o), y.x, y.y, y.z, -dot(y, o), z.x, z.y, z.z, -dot(z, o)}},
        .left = frame[0],
        .bottom = frame[2],
        .inverse_width = 1 / camera->width,
        .inverse_height = 1 / camera->height,
        .orthographic = camera->input.orthographic};
}

bool scene_set_camera(struct scene *scene, const struct camera_input *in, stokes_error *err)
{
    struct camera *camera = malloc(sizeof *camera);
    if (!camera)
        return fail(err, "camera", "camera", "no memory");
    *camera = (struct camera){.input = *in};
    if (!check_frame(in, err) || !check_lens(in, err) || !derive_axes(camera, err)) {
        camera_destroy(camera);
        return false;
    }
    derive_window(camera);
    camera_destroy(scene->camera);
    scene->camera = camera;
    scene->camera_dirty = true;
    scene->committed = false;
    return true;
}

/* --- Rays -------------------------------------------------------------------------------------------- */

/* Uniform in the regular polygon with corners at distance 1, one of them half a sector below the rotation. */
static void sample_polygon(int blades, float rotation, const float u[2], float point[2])
{
    float sector = floorf(u[0] * (float)blades), within = u[0] * (float)blades - sector;
    float root = sqrtf(within), a = root * (1 - u[1]),
          b = root * u[1]; /* weights of the sector's two outer corners */
    float half = PI_F / (float)blades, middle = rotation + 2 * half * sector;
    point[0] = a * cosf(middle - half) + b * cosf(middle + half);
    point[1] = a * sinf(middle - half) + b * sinf(middle + half);
}

static void sample_lens(const struct camera_input *in, const float u[2], float point[2])
{
    point[0] = point[1] = 0;
    if (!(in->lens_radius > 0))
        return;
    if (in->blades >= 3) {
        sample_polygon(in->blades, in->blade_rotation, u, point);
    } else {
        float r = sqrtf(u[0]), phi = 2 * PI_F * u[1];
        point[0] = r * cosf(phi);
        point[1] = r * sinf(phi);
    }
    point[0] *= in->lens_radius / in->aspect;
    point[1] *= in->lens_radius;
}

static struct vec3 in_world(const struct camera *camera, float x, float y, float depth)
{
    return along(along(scale(camera->axis, depth), camera->x, x), camera->y, y);
}

/* Points uniform over the frame at distance 1 have the density 1/A per area; dA cos³θ is the solid angle, and
   projecting it about the axis takes another cosine. A lens shifts what a film point looks at (thin lens),
   with the Jacobian 1. */
static float perspective_pdf(const struct camera *camera, struct vec3 direction)
{
    float cosine = dot(direction, camera->axis), squared = cosine * cosine;
    return 1 / (camera->width * camera->height * squared * squared);
}

static struct ray perspective_ray(const struct camera *camera, float x, float y, const float u[2],
                                  struct camera_point *point, float *pdf)
{
    const struct camera_input *in = &camera->input;
    float lens[2];
    sample_lens(in, u, lens);
    if (in->lens_radius > 0) {
        x -= lens[0] / in->focus_distance;
        y -= lens[1] / in->focus_distance;
    }
    struct vec3 direction = in_world(camera, x, y, 1);
    float stretch = length(direction);
    direction = scale(direction, 1 / stretch);
    point->position = add(camera->position, in_world(camera, lens[0], lens[1], 0));
    point->near = in->clip[0];
    *pdf = perspective_pdf(camera, direction);
    return (struct ray){point->position, direction, in->clip[0] * stretch,
                        fminf(in->clip[1] * stretch, FLT_MAX), RAY_CAMERA};
}

/* A point of an orthographic camera's lens looks in one direction, whatever the film point: as in Cycles the ray of a film point
   starts that far beside it and meets the plane of focus where it would without a lens. So it is another orthographic camera, whose
   positions lie on the same plane and are that much denser across the direction. */
struct slant {
    float lens[2];
    struct vec3 axis;
    float cosine, pdf;
};

static struct slant slant_of(const struct camera *camera, const float u[2])
{
    const struct camera_input *in = &camera->input;
    struct slant s = {.axis = camera->axis, .cosine = 1};
    sample_lens(in, u, s.lens);
    if (in->lens_radius > 0) {
        s.axis = normalize(in_world(camera, -s.lens[0], -s.lens[1], in->focus_distance));
        s.cosine = dot(s.axis, camera->axis);
    }
    s.pdf = 1 / (camera->width * camera->height * s.cosine);
    return s;
}

/* How far beside its film point a ray is at a depth, as a multiple of the lens point. */
static float aside(const struct camera *camera, float depth)
{
    return camera->input.lens_radius > 0 ? 1 - depth / camera->input.focus_distance : 0;
}

/* On the near plane. */
static struct camera_point slanted_point(const struct camera *camera, const struct slant *s, float x, float y)
{
    float near = camera->input.clip[0], k = aside(camera, near);
    struct vec3 offset = in_world(camera, x + k * s->lens[0], y + k * s->lens[1], near);
    return (struct camera_point){add(camera->position, offset), s->axis, 0};
}

struct ray scene_camera_ray(const struct scene *scene, float x, float y, const float u[2],
                            struct camera_point *point, float *pdf)
{
    const struct camera *camera = scene->camera;
    const struct camera_input *in = &camera->input;
    x = in->frame[0] + camera->width * x / (float)in->resolution[0];
    y = in->frame[2] + camera->height * y / (float)in->resolution[1];
    point->axis = camera->axis;
    if (!in->orthographic)
        return perspective_ray(camera, x, y, u, point, pdf);
    struct slant slant = slant_of(camera, u);
    *point = slanted_point(camera, &slant, x, y);
    *pdf = slant.pdf;
    return (struct ray){point->position, slant.axis, 0,
                        fminf((in->clip[1] - in->clip[0]) / slant.cosine, FLT_MAX), RAY_CAMERA};
}

static bool within_frame(const struct camera *camera, float x, float y, float margin, float film[2])
{
    const struct camera_input *in = &camera->input;
    film[0] = (x - in->frame[0]) / camera->width * (float)in->resolution[0];
    film[1] = (y - in->frame[2]) / camera->height * (float)in->resolution[1];
    return film[0] >= -margin && film[0] < (float)in->resolution[0] + margin && film[1] >= -margin &&
           film[1] < (float)in->resolution[1] + margin;
}

bool scene_camera_connect(const struct scene *scene, struct vec3 from, float margin, const float u[2],
                          struct camera_point *point, float film[2], float *pdf)
{
    const struct camera *camera = scene->camera;
    const struct camera_input *in = &camera->input;
    struct vec3 offset = sub(from, camera->position);
    float x = dot(offset, camera->x), y = dot(offset, camera->y), depth = dot(offset, camera->axis);
    if (!(depth > in->clip[0] && depth < in->clip[1]))
        return false;
    point->axis = camera->axis;
    if (in->orthographic) {
        struct slant slant = slant_of(camera, u);
        x -= aside(camera, depth) * slant.lens[0];
        y -= aside(camera, depth) * slant.lens[1];
        *point = slanted_point(camera, &slant, x, y);
        *pdf = slant.pdf;
        return within_frame(camera, x, y, margin, film);
    }
    float lens[2];
    sample_lens(in, u, lens);
    x = (x - lens[0]) / depth;
    y = (y - lens[1]) / depth;
    point->position = add(camera->position, in_world(camera, lens[0], lens[1], 0));
    point->near = in->clip[0];
    *pdf = perspective_pdf(camera, normalize(in_world(camera, x, y, 1)));
    if (in->lens_radius > 0) {
        x += lens[0] / in->focus_distance;
        y += lens[1] / in->focus_distance;
    }
    return within_frame(camera, x, y, margin, film);
}

bool scene_camera_is_orthographic(const struct scene *scene)
{
    return scene->camera->input.orthographic;
}

bool scene_camera_blurs(const struct scene *scene)
{
    return scene->camera->input.lens_radius > 0;
}

void scene_camera_size(const struct scene *scene, int full[2], int border[4])
{
    for (int i = 0; i < 2; i++)
        full[i] = scene->camera->input.resolution[i];
    for (int i = 0; i < 4; i++)
        border[i] = scene->camera->input.border[i];
}
