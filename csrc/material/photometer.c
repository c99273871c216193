/* A material's reradiation matrix: means of its value over pairs of bands, by midpoints. */
#include "material/photometer.h"

#include "material/lobe.h"

/* Points in a band: one a nanometre, but for narrow bands. */
#define POINTS_MIN 4
#define POINTS_MAX 40

struct bench {
    struct surface surface;
    struct vec3 to_light, to_camera;
    int points; /* in a band */
};

static float point_of(const stokes_matrix *m, const struct bench *b, int band, int point)
{
    return (float)(m->first_in_nm + (band - 0.5 + (point + 0.5) / b->points) * m->step_nm);
}

/* Light outside of Λ does not exist: means are over the incident points inside. */
static bool is_inside(const struct bench *b, float lambda)
{
    struct range range = b->surface.material->context.range;
    return lambda >= range.min && lambda <= range.max;
}

static double reradiated(const stokes_matrix *m, const struct bench *b, int out, float in)
{
    double sum = 0;
    for (int f = 0; f < b->surface.fluorescent_count; f++)
        for (int o = 0; o < b->points; o++)
            sum += surface_fluorescent(&b->surface, f, b->to_light, b->to_camera, in, point_of(m, b, out, o));
    return sum * m->step_nm / b->points;
}

static double share_of(const stokes_matrix *m, const struct bench *b, int out, int in)
{
    double sum = 0;
    int inside = 0;
    for (int i = 0; i < b->points; i++) {
        float lambda = point_of(m, b, in, i);
        if (!is_inside(b, lambda))
            continue;
        inside++;
        sum += reradiated(m, b, out, lambda);
        if (out == in)
            sum += surface_elastic(&b->surface, b->to_light, b->to_camera, lambda);
    }
    return inside > 0 ? M_PI * sum / inside : 0;
}

stokes_matrix *material_measure(const struct material *material, const char *name, double first, int count,
                                double step, stokes_error *err)
{
    const struct vec3 up = vec3(0, 0, 1);
    const struct hit hit = {.ng = up, .ns = up, .tangent = vec3(1, 0, 0), .light = -1};
    struct bench b = {.to_light = normalize(vec3(1, 0, 1)), .to_camera = up};
    stokes_matrix *m = reradiation_create(first, count, first, count, step, name, err);
    if (!m)
        return NULL;
    b.points = step < POINTS_MIN ? POINTS_MIN : step > POINTS_MAX ? POINTS_MAX : (int)step;
    material_shade(material, &hit, up, &b.surface);
    for (int out = 0; out < count; out++)
        for (int in = 0; in < count; in++)
            m->share[out * count + in] = (float)share_of(m, &b, out, in);
    return m;
}
