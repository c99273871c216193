/* A connection is certain if it is likely to bring a good share of what the sample has gathered already. What survives otherwise counts
   for that share, so that it stands out from its sample no more than the rest does. */
#include "integrator/roulette.h"

/* Estimates take surfaces for white and weights for 1: what comes in the end is some ten times less. */
static const double share = 0.6;
static const double share_of_typical = 0.3; /* of a pixel as they are on average, for a sample that has gathered little */
static const double chance_min = 0.1;

double roulette(const struct integrator *it, struct worker *w, double estimate)
{
    const double *xyz = w->gathered.xyz, bins = it->film->bins ? it->kappa * w->taken : 0;
    double enough = fmax(share * (xyz[0] + xyz[1] + xyz[2] + bins), share_of_typical * it->typical);
    if (!(estimate < enough))
        return 1;
    double chance = fmax(chance_min, estimate / enough);
    if (w->trial) /* a look counts the work that is saved, but no noise */
        return 1 / chance;
    return (double)random_at(w->random, DIM_ROULETTE + w->spins++) < chance ? 1 / chance : 0;
}

double roulette_color(const struct integrator *it, float lambda)
{
    float cmf[3];
    cmf_eval(lambda, cmf);
    return it->kappa * (double)(cmf[0] + cmf[1] + cmf[2] + (it->film->bins ? 1 : 0));
}

double roulette_white(const struct integrator *it)
{
    const double visible_nm = 320.6; /* ∫(x̄+ȳ+z̄)dλ */
    double bins_nm = (double)(it->settings.lambda_max - it->settings.lambda_min);
    return it->kappa * (visible_nm + (it->film->bins ? bins_nm : 0));
}

float roulette_value(const struct vertex *v, enum label label)
{
    static const float dye_per_nm = 0.01f;
    if (v->in_volume) { /* four times what an even phase function sends everywhere */
        float sigma = 0;
        for (int i = 0; i < v->surface.lobe_count; i++)
            sigma += v->surface.lobe[i].weight;
        return sigma / PI_F;
    }
    return (v->surface.is_matte ? 1 : 10) / PI_F * (label == LABEL_FLUORESCENT ? dye_per_nm : 1);
}

/* What arrives at a vertex, on the camera's side as a share of what the pixel takes. */
static double power_at(const struct integrator *it, const struct vertex *v, enum side side)
{
    double sum = 0;
    for (int k = 0; k < v->arrival.lanes; k++)
        sum += v->arrival.throughput[k] *
               (side == SIDE_CAMERA ? (double)spectrum_pdf(it->wavelengths.camera, v->lambda_film[k]) : 1);
    return sum / v->arrival.lanes;
}

void roulette_weigh(const struct integrator *it, struct worker *w)
{
    static const double least_albedo = 0.25;
    const struct subpath *paths[SIDES] = {[SIDE_LIGHT] = &w->light, [SIDE_CAMERA] = &w->camera};
    for (int side = 0; side < SIDES; side++) {
        double power = 0;
        for (int i = 1; i < paths[side]->count; i++) {
            const struct vertex *v = &paths[side]->vertex[i];
            if (!it->exact || v[-1].label == LABEL_FLUORESCENT)
                power = 0;
            else if (v[-1].label == LABEL_ELASTIC && v[-1].surface.is_matte)
                power *= least_albedo / ((double)PI_F * v[-1].drawn);
            power = fmax(power, power_at(it, v, (enum side)side));
            w->power[side][i] = (float)power * roulette_value(v, LABEL_ELASTIC);
        }
    }
}
