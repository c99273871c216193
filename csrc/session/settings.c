/* Settings as a whole: limits, cross-checks, and the overrides of `stokes render`. */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/thread.h"
#include "session/session.h"

#define LAMBDA_LOWEST_NM 100.0f
#define LAMBDA_HIGHEST_NM 4000.0f
#define LAMBDA_NARROWEST_NM 1.0f
#define BINS_MAX 1024
#define THREADS_MAX 1024

const char *session_integrator_name(const char *name)
{
    const char *known;
    for (size_t i = 0; (known = integrator_name_at(i)); i++)
        if (strcmp(known, name) == 0)
            return known;
    return NULL;
}

static bool check_range(const char *property, double value, double low, double high, stokes_error *err)
{
    if (value >= low && value <= high)
        return true;
    return fail(err, "settings", property, "%g is not within %g and %g", value, low, high);
}

static bool check_edges(const struct integrator_settings *s, stokes_error *err)
{
    return check_range("max_path", s->max_path, 1, PATH_EDGES_MAX, err) &&
           check_range("max_camera", s->max_camera, 1, PATH_EDGES_MAX, err) &&
           check_range("max_light", s->max_light, 0, PATH_EDGES_MAX, err) &&
           check_range("max_diffuse", s->max_diffuse, 0, INT_MAX, err) &&
           check_range("max_glossy", s->max_glossy, 0, INT_MAX, err) &&
           check_range("max_transmission", s->max_transmission, 0, INT_MAX, err) &&
           check_range("max_volume", s->max_volume, 0, INT_MAX, err) &&
           check_range("max_transparent", s->max_transparent, 0, INT_MAX, err) &&
           check_range("roulette_start", s->roulette_start, 0, INT_MAX, err);
}

static bool check_bins(const struct integrator_settings *s, stokes_error *err)
{
    if (s->spectral_bins == 0)
        return true;
    return check_range("spectral_bins.count", s->spectral_bins, 1, BINS_MAX, err) &&
           check_range("spectral_bins.min", s->bins_min, s->lambda_min, s->lambda_max, err) &&
           check_range("spectral_bins.max", s->bins_max, (double)s->bins_min + 1e-3, s->lambda_max, err);
}

bool session_settings_check(const struct session_settings *settings, stokes_error *err)
{
    const struct integrator_settings *s = &settings->integrator;
    if (s->lanes != 1 && s->lanes != 4 && s->lanes != 8)
        return fail(err, "settings", "lanes", "%d is not 1, 4 or 8", s->lanes);
    return check_range("lambda_min", s->lambda_min, LAMBDA_LOWEST_NM, LAMBDA_HIGHEST_NM, err) &&
           check_range("lambda_max", s->lambda_max, s->lambda_min + LAMBDA_NARROWEST_NM, LAMBDA_HIGHEST_NM,
                       err) &&
           check_range("d0", s->d0_nm, 1e-3, 1e4, err) && check_range("shrink", s->shrink, 0, 1, err) &&
           check_range("light_paths", s->light_paths, 0, LIGHT_PATHS_MAX, err) &&
           check_range("filter_width", s->filter_width, 0.01, 100, err) && check_edges(s, err) &&
           check_bins(s, err) && check_range("threads", settings->threads, 0, THREADS_MAX, err) &&
           check_range("time_limit", settings->time_limit_s, 0, 1e9, err);
}

/* "2,2 3,1": the (s,t) that are left on. */
static bool read_techniques(const char *text, struct integrator_settings *settings, stokes_error *err)
{
    memset(settings->technique, 0, sizeof settings->technique);
    settings->all_techniques = strspn(text, " ") == strlen(text);
    while (*(text += strspn(text, " "))) {
        int s, t, used = 0;
        if (sscanf(text, "%2d,%2d%n", &s, &t, &used) < 2 || !used || (text[used] && text[used] != ' '))
            return fail(err, "settings", "techniques", "'%s' is not a pair like 2,1", text);
        if (s < 0 || t < 0 || s >= TECHNIQUES_MAX || t >= TECHNIQUES_MAX)
            return fail(err, "settings", "techniques", "%d,%d is beyond %d vertices", s, t,
                        TECHNIQUES_MAX - 1);
        settings->technique[s][t] = true;
        text += used;
    }
    return true;
}

/* Bins where the scene has none lie over the visible part of Λ, unless told otherwise. */
static void override_bins(struct integrator_settings *s, const stokes_overrides *o)
{
    if (o->spectral_bins > 0 && s->spectral_bins == 0) {
        s->bins_min = fmaxf(s->lambda_min, CMF_MIN_NM);
        s->bins_max = fminf(s->lambda_max, CMF_MAX_NM);
    }
    if (o->spectral_bins >= 0)
        s->spectral_bins = o->spectral_bins;
    if (o->bins_min_nm >= 0)
        s->bins_min = (float)o->bins_min_nm;
    if (o->bins_max_nm >= 0)
        s->bins_max = (float)o->bins_max_nm;
}

static bool read_kernel(const char *name, struct integrator_settings *s, stokes_error *err)
{
    for (int i = 0; i < KERNEL_COUNT; i++)
        if (strcmp(name, kernel_name((enum kernel)i)) == 0) {
            s->kernel = (enum kernel)i;
            return true;
        }
    return fail(err, "settings", "kernel", "'%s' is unknown", name);
}

bool session_settings_override(struct session_settings *settings, const stokes_overrides *o,
                               stokes_error *err)
{
    struct integrator_settings *s = &settings->integrator;
    if (o->integrator) {
        const char *name = session_integrator_name(o->integrator);
        if (!name)
            return fail(err, "settings", "integrator", "'%s' is unknown", o->integrator);
        s->name = name;
    }
    if (o->seed > UINT32_MAX)
        return fail(err, "settings", "seed", "%lld does not fit 32 bits", (long long)o->seed);
    if (o->seed >= 0)
        s->seed = (uint32_t)o->seed;
    if (o->shared_wavelength)
        s->shared_wavelength = true;
    if (o->connectable_only)
        s->connectable_only = true;
    if (o->lanes >= 0)
        s->lanes = o->lanes;
    if (o->threads >= 0)
        settings->threads = o->threads;
    if (o->d0_nm >= 0)
        s->d0_nm = o->d0_nm;
    if (o->kernel && !read_kernel(o->kernel, s, err))
        return false;
    if (o->shrink >= 0)
        s->shrink = o->shrink;
    if (o->light_paths >= 0)
        s->light_paths = o->light_paths;
    override_bins(s, o);
    if (o->max_path >= 0)
        s->max_path = o->max_path;
    if (o->time_limit_s >= 0)
        settings->time_limit_s = o->time_limit_s;
    return (!o->techniques || read_techniques(o->techniques, s, err)) &&
           session_settings_check(settings, err);
}

stokes_overrides stokes_overrides_default(void)
{
    return (stokes_overrides){.seed = -1,
                              .first_sample = -1,
                              .end_sample = -1,
                              .lanes = -1,
                              .threads = -1,
                              .d0_nm = -1,
                              .shrink = -1,
                              .light_paths = -1,
                              .spectral_bins = -1,
                              .bins_min_nm = -1,
                              .bins_max_nm = -1,
                              .max_path = -1,
                              .time_limit_s = -1};
}

int session_threads(const struct session_settings *settings)
{
    return settings->threads > 0 ? settings->threads : thread_processors();
}
