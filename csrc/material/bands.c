/* Tables over pairs of bands: values, densities and draws. */
#include "material/bands.h"

#include <stdlib.h>

/* --- Making ------------------------------------------------------------------------------------------------ */

/* The bands that lie in Λ, at least in part; *first is the first of them. Returns how many. */
static int bands_within(struct range range, double first_nm, double step, int count, int *first)
{
    int low = 0, high = count;
    while (low < high && !(first_nm + (low + 0.5) * step > range.min))
        low++;
    while (high > low && !(first_nm + (high - 1.5) * step < range.max))
        high--;
    *first = low;
    return high - low;
}

static float *edges_of(struct range range, double first_nm, double step, int first, int count)
{
    float *edge = malloc(((size_t)count + 1) * sizeof *edge);
    for (int i = 0; edge && i <= count; i++)
        edge[i] = fminf(fmaxf((float)(first_nm + (first + i - 0.5) * step), range.min), range.max);
    return edge;
}

static float value_at(const struct band_table *t, enum side side, int given, int drawn)
{
    return side == SIDE_LIGHT ? t->value[drawn * t->count_in + given] : t->value[given * t->count_in + drawn];
}

static bool make_cdf(struct band_table *t, enum side side)
{
    struct band_cdf *c = side == SIDE_LIGHT ? &t->from_light : &t->from_camera;
    int given = side == SIDE_LIGHT ? t->count_in : t->count_out;
    int drawn = side == SIDE_LIGHT ? t->count_out : t->count_in;
    const float *edge = side == SIDE_LIGHT ? t->edge_out : t->edge_in;
    c->sum = calloc((size_t)given, sizeof *c->sum);
    c->cdf = calloc((size_t)given * ((size_t)drawn + 1), sizeof *c->cdf);
    if (!c->sum || !c->cdf)
        return false;
    for (int g = 0; g < given; g++) {
        float *cdf = c->cdf + g * (drawn + 1);
        double sum = 0;
        for (int d = 0; d < drawn; d++)
            sum += (double)value_at(t, side, g, d) * (edge[d + 1] - edge[d]);
        c->sum[g] = (float)sum;
        for (int d = 0; sum > 0 && d < drawn; d++)
            cdf[d + 1] = (float)(cdf[d] + (double)value_at(t, side, g, d) * (edge[d + 1] - edge[d]) / sum);
    }
    return true;
}

struct band_table *band_table_create(const stokes_matrix *m, struct range range)
{
    int first_in, first_out;
    struct band_table *t = calloc(1, sizeof *t);
    if (!t)
        return NULL;
    t->count_in = bands_within(range, m->first_in_nm, m->step_nm, m->count_in, &first_in);
    t->count_out = bands_within(range, m->first_out_nm, m->step_nm, m->count_out, &first_out);
    t->bands_per_nm = (float)(1 / m->step_nm);
    t->edge_in = edges_of(range, m->first_in_nm, m->step_nm, first_in, t->count_in);
    t->edge_out = edges_of(range, m->first_out_nm, m->step_nm, first_out, t->count_out);
    t->value = calloc((size_t)t->count_in * (size_t)t->count_out + 1, sizeof *t->value);
    if (!t->edge_in || !t->edge_out || !t->value) {
        band_table_destroy(t);
        return NULL;
    }
    for (int out = 0; out < t->count_out; out++)
        for (int in = 0; in < t->count_in; in++)
            t->value[out * t->count_in + in] =
                (float)(m->share[(first_out + out) * m->count_in + first_in + in] / m->step_nm);
    if (!make_cdf(t, SIDE_LIGHT) || !make_cdf(t, SIDE_CAMERA)) {
        band_table_destroy(t);
        return NULL;
    }
    return t;
}

void band_table_destroy(struct band_table *t)
{
    if (!t)
        return;
    free(t->edge_in);
    free(t->edge_out);
    free(t->value);
    free(t->from_light.sum);
    free(t->from_light.cdf);
    free(t->from_camera.sum);
    free(t->from_camera.cdf);
    free(t);
}

/* --- Asking ------------------------------------------------------------------------------------------------ */

/* The band that holds the wavelength, by its edges as they were rounded; −1 outside. A band that Λ cuts is narrower than the rest, so the
   guess may be off by one. */
static int band_of(const float *edge, int count, float bands_per_nm, float lambda)
{
    if (count == 0 || !(lambda >= edge[0] && lambda < edge[count]))
        return -1;
    int i = (int)((lambda - edge[count > 1]) * bands_per_nm + (count > 1));
    i = i < 0 ? 0 : i >= count ? count - 1 : i;
    while (lambda < edge[i])
        i--;
    while (lambda >= edge[i + 1])
        i++;
    return i;
}

static int band_in(const struct band_table *t, float lambda)
{
    return band_of(t->edge_in, t->count_in, t->bands_per_nm, lambda);
}

static int band_out(const struct band_table *t, float lambda)
{
    return band_of(t->edge_out, t->count_out, t->bands_per_nm, lambda);
}

float band_table_value(const struct band_table *t, float lambda_in, float lambda_out)
{
    int in = band_in(t, lambda_in), out = band_out(t, lambda_out);
    return in >= 0 && out >= 0 ? t->value[out * t->count_in + in] : 0;
}

float band_table_strength(const struct band_table *t, enum side side, float lambda)
{
    int given = side == SIDE_LIGHT ? band_in(t, lambda) : band_out(t, lambda);
    return given < 0 ? 0 : (side == SIDE_LIGHT ? &t->from_light : &t->from_camera)->sum[given];
}

float band_table_pdf(const struct band_table *t, enum side side, float lambda_arriving, float lambda_leaving)
{
    float strength = band_table_strength(t, side, lambda_arriving);
    if (!(strength > 0))
        return 0;
    return (side == SIDE_LIGHT ? band_table_value(t, lambda_arriving, lambda_leaving)
                               : band_table_value(t, lambda_leaving, lambda_arriving)) /
           strength;
}

/* The last band whose cdf begins at or below u and that is not empty. */
static int find(const float *cdf, int count, float u)
{
    int low = 0, high = count;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (cdf[middle] <= u)
            low = middle;
        else
            high = middle;
    }
    while (low > 0 && !(cdf[low + 1] > cdf[low]))
        low--;
    return low;
}

float band_table_sample(const struct band_table *t, enum side side, float lambda_arriving, float u,
                        float *pdf)
{
    bool light = side == SIDE_LIGHT;
    const struct band_cdf *c = light ? &t->from_light : &t->from_camera;
    int given = light ? band_in(t, lambda_arriving) : band_out(t, lambda_arriving);
    int count = light ? t->count_out : t->count_in;
    const float *edge = light ? t->edge_out : t->edge_in;
    *pdf = 0;
    if (given < 0 || !(c->sum[given] > 0))
        return lambda_arriving;
    const float *cdf = c->cdf + given * (count + 1);
    u = fminf(u * cdf[count], nextafterf(cdf[count], 0)); /* rounding left the last a hair off 1 */
    int drawn = find(cdf, count, u);
    float s = (u - cdf[drawn]) / (cdf[drawn + 1] - cdf[drawn]);
    float lambda = edge[drawn] + s * (edge[drawn + 1] - edge[drawn]);
    *pdf = value_at(t, side, given, drawn) / c->sum[given];
    return fminf(fmaxf(lambda, edge[drawn]), nextafterf(edge[drawn + 1], 0));
}
