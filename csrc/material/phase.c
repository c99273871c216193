/* Scattering inside volumes: a phase lobe for Henyey and Greenstein's function, so that a scattering vertex is evaluated, drawn from and connected
   like any other. Its directions are the world's, and all cosines are 1 (algorithm.md §13). */
#include "material/surface.h"
#include "material/volume.h"

float phase_value(float g, struct vec3 a, struct vec3 b)
{
    /* 1 + g² − 2g cos of the deflection, as a sum of squares: nothing cancels where it is small. */
    struct vec3 d = g > 0 ? add(a, b) : sub(a, b);
    float h = fabsf(g), rest = 1 - h, base = rest * rest + h * length_squared(d);
    return rest * (1 + h) / (4 * PI_F * base * sqrtf(base));
}

struct vec3 phase_sample(float g, struct vec3 arriving, const float u[2])
{
    float h = fabsf(g), rest = 1 - h;
    /* 1 − cos of the angle with the peak, by inversion of the cdf; its textbook form loses all digits as h → 1 or 0. */
    float q = rest / (rest + 2 * h * u[0]), fall = clampf(2 * (1 - u[0]) * (1 + h * u[0]) * q * q, 0, 2);
    float sine = sqrtf(fmaxf(0, fall * (2 - fall))), phi = 2 * PI_F * u[1];
    struct vec3 peak = g > 0 ? negate(arriving) : arriving;
    struct frame frame = frame_about(peak);
    return normalize(to_world(&frame, vec3(sine * cosf(phi), sine * sinf(phi), 1 - fall)));
}

/* σs over its maximum, which the lobe's weight holds. */
static float albedo(const struct lobe *lobe, float z, float lambda)
{
    (void)z;
    return spectral_value_eval(&lobe->color[0], lambda);
}

static bool albedo_integral(const struct lobe *lobe, float z, float a, float b, double *integral)
{
    (void)z;
    return spectral_value_integral(&lobe->color[0], a, b, integral);
}

static float evaluate(const struct lobe *lobe, struct vec3 to_light, struct vec3 to_camera, float lambda)
{
    return albedo(lobe, 1, lambda) * phase_value(lobe->parameter[0], to_light, to_camera);
}

static float pdf(const struct lobe *lobe, enum side side, struct vec3 arriving, struct vec3 leaving,
                 float lambda)
{
    (void)side, (void)lambda;
    return phase_value(lobe->parameter[0], arriving, leaving);
}

static bool sample(const struct lobe *lobe, enum side side, struct vec3 arriving, float lambda,
                   const float u[3], struct vec3 *leaving)
{
    (void)side, (void)lambda;
    *leaving = phase_sample(lobe->parameter[0], arriving, u);
    return true;
}

static const struct lobe_kind lobe_phase = {
    .name = "phase",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_VOLUME,
    .albedo = albedo,
    .albedo_integral = albedo_integral,
    .evaluate = evaluate,
    .pdf = pdf,
    .sample = sample,
};

static void add_lobe(const struct volume_phase *phase, int times, struct surface *s)
{
    struct lobe *lobe = &s->lobe[s->lobe_count++];
    lobe->kind = &lobe_phase;
    lobe->weight = phase->most * (float)times;
    lobe->view_count = 0;
    lobe->color[0] = spectral_of(phase->scattering);
    lobe->color[0].scale = 1 / phase->most;
    lobe->parameter[0] = phase->g;
    lobe->data = NULL;
    lobe->frame = (struct frame){vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)};
    lobe->mapped = false;
}

void volume_shade(const struct volume *const volume[], const int times[], int count,
                  const struct material *context, struct surface *s)
{
    s->ng = s->ns = vec3(0, 0, 0);
    s->lobe_count = s->fluorescent_count = s->specular_count = 0;
    s->is_matte = false;
    s->in_volume = true;
    s->material = context;
    for (int i = 0; i < count; i++)
        for (int k = 0; k < volume[i]->phase_count && s->lobe_count < SURFACE_LOBES; k++)
            add_lobe(&volume[i]->phase[k], times[i], s);
    s->has_elastic = s->connects = s->lobe_count > 0;
}

void surface_phase_steps(const struct surface *s, struct vec3 arriving, struct vec3 leaving, int lanes,
                         const float lambda[], struct surface_steps *out)
{
    const struct lobe *lobe = &s->lobe[0];
    float p = phase_value(lobe->parameter[0], arriving, leaving);
    for (int i = 0; i < lanes; i++) {
        out->value[i] = lobe->weight * albedo(lobe, 1, lambda[i]) * p;
        out->pdf[i] = out->pdf_other[i] = p;
    }
}
