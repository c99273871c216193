/* Writing what was rendered: an EXR that holds all that merging needs, or a PNG as the display shows it; and merging. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/error.h"
#include "session/session.h"

/* Embree picks its kernels by what the processor has, so two kinds of processor may round differently. */
static const char *instruction_set(void)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f"))
        return "x86-64 avx512f";
    if (__builtin_cpu_supports("avx2"))
        return "x86-64 avx2";
    return "x86-64";
#else
    return "other";
#endif
}

static void describe_settings(const struct session_settings *settings, char *text, size_t bytes)
{
    const struct integrator_settings *s = &settings->integrator;
    snprintf(
        text, bytes,
        "integrator=%s lanes=%d kernel=%s d0=%g shrink=%g light_paths=%g max_path=%d max_camera=%d max_light=%d max_diffuse=%d max_glossy=%d "
        "max_transmission=%d max_volume=%d max_transparent=%d roulette_start=%d lambda=%g..%g filter_width=%g "
        "techniques=%s",
        s->name, s->lanes, kernel_name(s->kernel), s->d0_nm, s->shrink, s->light_paths, s->max_path, s->max_camera, s->max_light, s->max_diffuse, s->max_glossy,
        s->max_transmission, s->max_volume, s->max_transparent, s->roulette_start, (double)s->lambda_min,
        (double)s->lambda_max, (double)s->filter_width, s->all_techniques ? "all" : "some");
}

static bool write_exr(const stokes_session *session, const char *path, stokes_error *err)
{
    char settings[512], seed[16];
    describe_settings(&session->rendered, settings, sizeof settings);
    snprintf(seed, sizeof seed, "%" PRIu32, session->rendered.integrator.seed);
    const struct film_note notes[] = {
        {"version", STOKES_VERSION},
        {"instructionSet", instruction_set()},
        {"settings", settings},
        {"seed", seed},
        {"workingSpace", session->color.name},
        {"fingerprint", session->fingerprint},
    };
    return film_write_exr(session->film, &session->color.working_space, notes, sizeof notes / sizeof *notes,
                          path, err);
}

/* --- PNG --------------------------------------------------------------------------------------------------- */

/* XYZ to linear sRGB (IEC 61966-2-1). */
static const float srgb_from_xyz[9] = {3.2404542f, -1.5371385f, -0.4985314f, -0.9692660f, 1.8760108f,
                                       0.0415560f, 0.0556434f,  -0.2040259f, 1.0572252f};

static float srgb_curve(float v)
{
    v = clampf(v, 0, 1);
    return v <= 0.0031308f ? 12.92f * v : 1.055f * powf(v, 1 / 2.4f) - 0.055f;
}

static void display_without_config(const struct session_color *color, float *rgba, size_t count)
{
    float gain = (float)exp2(color->exposure), power = (float)(1 / color->gamma);
    const double *m = color->working_space.rgb_to_xyz;
    for (size_t i = 0; i < count; i++) {
        float *p = rgba + 4 * i, xyz[3], linear[3];
        for (int r = 0; r < 3; r++)
            xyz[r] = gain * (float)(m[3 * r] * p[0] + m[3 * r + 1] * p[1] + m[3 * r + 2] * p[2]);
        for (int r = 0; r < 3; r++)
            linear[r] = srgb_from_xyz[3 * r] * xyz[0] + srgb_from_xyz[3 * r + 1] * xyz[1] +
                        srgb_from_xyz[3 * r + 2] * xyz[2];
        for (int r = 0; r < 3; r++)
            p[r] = powf(srgb_curve(linear[r]), power);
    }
}

/* PNG's alpha is not associated, and a display curve is for the colour itself: divide first. */
static void divide_by_alpha(float *rgba, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        float *p = rgba + 4 * i, alpha = clampf(p[3], 0, 1);
        float k = alpha > 0 ? 1 / alpha : 1;
        for (int r = 0; r < 3; r++)
            p[r] *= k;
        p[3] = alpha;
    }
}

static bool to_display(stokes_session *session, float *rgba, size_t count, stokes_error *err)
{
    const struct session_color *color = &session->color;
    divide_by_alpha(rgba, count);
    if (color->config)
        return color_config_to_display(color->config, color->name, color->display, color->view, color->look,
                                       color->exposure, color->gamma, rgba, count, 4, err);
    stokes_error warning;
    fail(&warning, "color", "config",
         "no OpenColorIO config is open; the picture is written with the sRGB curve");
    session_warn(session, &warning);
    display_without_config(color, rgba, count);
    return true;
}

static bool write_png(stokes_session *session, const char *path, stokes_error *err)
{
    const struct film *film = session->film;
    size_t count = (size_t)film->width * (size_t)film->height;
    float *rgba = calloc(count, 4 * sizeof *rgba);
    if (!rgba)
        return fail(err, path, "write", "out of memory");
    film_resolve(film, &session->color.working_space, film_divisor(film), rgba);
    bool good =
        to_display(session, rgba, count, err) && film_write_png(film->width, film->height, rgba, path, err);
    free(rgba);
    return good;
}

static bool has_ending(const char *path, const char *ending)
{
    size_t length = strlen(path), wanted = strlen(ending);
    return length > wanted && strcasecmp(path + length - wanted, ending) == 0;
}

bool stokes_session_write(stokes_session *session, const char *path, stokes_error *err)
{
    if (stokes_session_samples(session) < 1 && !stokes_session_is_part(session))
        return fail(err, path, "write", "nothing has been rendered");
    if (has_ending(path, ".exr"))
        return write_exr(session, path, err);
    if (has_ending(path, ".png"))
        return write_png(session, path, err);
    return fail(err, path, "write", "the name must end in .exr or .png");
}
