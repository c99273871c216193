/* Volumes put together: coefficients add, phase functions of one anisotropy become one. */
#include "material/volume.h"

#include <float.h>
#include <stdlib.h>

#include "base/error.h"

/* A rate is at least this share of the largest: what no rate's wavelength sees must not be drawn next to never. */
#define RATE_FLOOR 0.01

struct volume *volume_create(struct spectrum *scattering, struct spectrum *absorption, float g)
{
    struct volume *v = calloc(1, sizeof *v);
    if (!v) {
        spectrum_destroy(scattering);
        spectrum_destroy(absorption);
        return NULL;
    }
    v->absorption = absorption;
    v->phase_count = scattering != NULL;
    v->phase[0] = (struct volume_phase){.scattering = scattering, .g = g};
    return v;
}

void volume_destroy(struct volume *v)
{
    if (!v)
        return;
    for (int i = 0; i < v->phase_count; i++)
        spectrum_destroy(v->phase[i].scattering);
    spectrum_destroy(v->absorption);
    spectrum_destroy(v->extinction);
    free(v);
}

/* *sum += factor × more. False without memory, or beyond floats. */
static bool accumulate(struct spectrum **sum, const struct spectrum *more, double factor)
{
    struct spectrum *scaled = spectrum_scaled(more, (float)factor), *old = *sum;
    if (!old || !scaled) {
        *sum = old ? old : scaled;
        spectrum_destroy(old ? scaled : NULL);
        return scaled;
    }
    *sum = spectrum_sum(old, scaled);
    spectrum_destroy(old);
    spectrum_destroy(scaled);
    return *sum;
}

static bool add_phase(struct volume *to, const struct volume_phase *phase, double factor, stokes_error *why)
{
    int i = 0;
    while (i < to->phase_count && to->phase[i].g != phase->g)
        i++;
    if (i == VOLUME_PHASES)
        return fail(why, "volume", "anisotropy", "more than %d different ones in one volume", VOLUME_PHASES);
    if (i == to->phase_count)
        to->phase[to->phase_count++] = (struct volume_phase){.g = phase->g};
    return accumulate(&to->phase[i].scattering, phase->scattering, factor) ||
           fail(why, "volume", "density", "no memory, or coefficients that floats cannot hold");
}

static bool add_volume(struct volume *to, const struct volume *from, double factor, stokes_error *why)
{
    if (factor == 0)
        return true;
    for (int i = 0; i < from->phase_count; i++)
        if (!add_phase(to, &from->phase[i], factor, why))
            return false;
    return !from->absorption || accumulate(&to->absorption, from->absorption, factor) ||
           fail(why, "volume", "density", "no memory, or coefficients that floats cannot hold");
}

struct volume *volume_blend(struct volume *first, double a, struct volume *second, double b,
                            stokes_error *why)
{
    struct volume *sum = volume_create(NULL, NULL, 0);
    bool good = sum ? add_volume(sum, first, a, why) && add_volume(sum, second, b, why)
                    : fail(why, "volume", "volume", "no memory");
    volume_destroy(first);
    volume_destroy(second);
    if (good)
        return sum;
    volume_destroy(sum);
    return NULL;
}

bool volume_is_empty(const struct volume *v)
{
    for (int i = 0; i < v->phase_count; i++)
        if (spectrum_max(v->phase[i].scattering) >= FLT_MIN)
            return false;
    return !v->absorption || !(spectrum_max(v->absorption) > 0);
}

bool volume_scatters(const struct volume *v)
{
    return v->rate[VOLUME_RATES - 1] > 0;
}

/* The least and the largest extinction, and those of wavelengths between (algorithm.md §13): with the least no wavelength gets through that
   the density believes stopped, with the largest none scatters where it believes it passing. */
static void set_rates(struct volume *v)
{
    const struct spectrum *s = v->extinction;
    double most = spectrum_max(s), floor = RATE_FLOOR * most;
    v->rate[0] = fmax(0, spectrum_min(s));
    v->rate[VOLUME_RATES - 1] = most;
    for (int i = 1; i < VOLUME_RATES - 1; i++) {
        float lambda = 400 + 300 * ((float)i - 0.5f) / (VOLUME_RATES - 2);
        v->rate[i] = fmax(floor, spectrum_eval(s, fminf(fmaxf(lambda, s->min), s->max)));
    }
}

bool volume_finish(struct volume *v)
{
    bool scatters = false;
    int kept = 0;
    for (int i = 0; i < v->phase_count; i++) {
        struct volume_phase phase = v->phase[i];
        phase.most = spectrum_max(phase.scattering);
        if (phase.most >= FLT_MIN)
            v->phase[kept++] = phase;
        else
            spectrum_destroy(phase.scattering);
    }
    v->phase_count = kept;
    for (int i = 0; i < kept; i++) {
        scatters = true;
        if (!accumulate(&v->extinction, v->phase[i].scattering, 1))
            return false;
    }
    if (v->absorption && !accumulate(&v->extinction, v->absorption, 1))
        return false;
    if (scatters)
        set_rates(v);
    return true;
}
