/* Directional albedo of GGX by stratified quadrature over the visible normals. */
#include "material/albedo.h"

#include <stdlib.h>

#include "material/microfacet.h"

#define COSINES 24
#define ROUGHNESSES 16
#define POINTS 256 /* of the quadrature; the error of E stays below 0.002 */

struct albedo_table {
    int rows;
    float low, per_roughness; /* roughness → row */
    float mean[ROUGHNESSES];
    float value[ROUGHNESSES][COSINES];
};

/* Cosines of the columns crowd at grazing angles, where albedos bend. */
static float cosine_of_column(int i)
{
    return square((float)i / (COSINES - 1));
}

static float reflected_weight(struct vec3 w, struct vec3 h, float alpha)
{
    struct vec3 l = reflect(w, h);
    float lambda_w = ggx_lambda(w, alpha);
    return l.z > 0 ? (1 + lambda_w) * ggx_g2(lambda_w, ggx_lambda(l, alpha), false) : 0;
}

static float refracted_weight(struct vec3 w, struct vec3 h, float alpha, float ior)
{
    struct vec3 l;
    float lambda_w = ggx_lambda(w, alpha);
    if (!refract(w, h, ior, &l) || l.z >= 0)
        return 0;
    return (1 + lambda_w) * ggx_g2(lambda_w, ggx_lambda(l, alpha), false);
}

static float quadrature(enum albedo_of of, float ior, float alpha, float cosine)
{
    struct vec3 w = vec3(sqrtf(fmaxf(0, 1 - cosine * cosine)), 0, cosine);
    float f0 = fresnel_f0(ior), sum = 0, white = 0;
    for (int i = 0; i < POINTS; i++) {
        float v = (float)i * 0.618034f; /* Kronecker's sequence: each coordinate is even by itself, too */
        struct vec3 h = ggx_sample(w, alpha, ((float)i + 0.5f) / POINTS, v - floorf(v));
        float weight = reflected_weight(w, h, alpha), f = fresnel_dielectric(fminf(1, dot(w, h)), ior);
        white += weight;
        if (of == ALBEDO_FRESNEL_SHARE)
            sum += weight * clampf((f - f0) / (1 - f0), 0, 1);
        else if (of == ALBEDO_GLASS)
            sum += f * weight + (1 - f) * refracted_weight(w, h, alpha, ior);
    }
    switch (of) {
    case ALBEDO_WHITE: return white / POINTS;
    case ALBEDO_FRESNEL_SHARE: return white > 0 ? sum / white : 1;
    case ALBEDO_GLASS: return sum / POINTS;
    }
    return 0;
}

static void fill_row(struct albedo_table *t, int row, enum albedo_of of, float ior, float alpha)
{
    float *value = t->value[row];
    double sum = 0;
    for (int i = 0; i < COSINES; i++)
        value[i] = quadrature(of, ior, alpha, fmaxf(cosine_of_column(i), 1e-3f));
    for (int i = 1; i < COSINES; i++) { /* cos² is the measure, E linear in it within a column's width */
        float a = cosine_of_column(i - 1), b = cosine_of_column(i);
        sum += 0.5 * (value[i - 1] + value[i]) * (b * b - a * a);
    }
    t->mean[row] = (float)sum;
}

struct albedo_table *albedo_table_create(enum albedo_of of, float ior, const struct closure *closure,
                                         int input)
{
    struct albedo_table *t = calloc(1, sizeof *t);
    float low, high;
    if (!t)
        return NULL;
    if (closure_value_is_constant(closure, input, &low))
        low = high = clampf(low, 0, 1);
    else {
        low = 0;
        high = 1;
    }
    t->low = low;
    t->rows = high > low ? ROUGHNESSES : 1;
    t->per_roughness = t->rows > 1 ? (t->rows - 1) / (high - low) : 0;
    for (int r = 0; r < t->rows; r++) {
        float roughness = t->rows > 1 ? low + (high - low) * r / (t->rows - 1) : low;
        fill_row(t, r, of, ior, alpha_of_roughness(roughness));
    }
    return t;
}

void albedo_table_destroy(struct albedo_table *t)
{
    free(t);
}

/* The row below a roughness, and how far it lies toward the next. */
static int row_of(const struct albedo_table *t, float roughness, float *fraction)
{
    float x = clampf((roughness - t->low) * t->per_roughness, 0, (float)(t->rows - 1));
    int row = (int)x;
    if (row > t->rows - 2)
        row = t->rows > 1 ? t->rows - 2 : 0;
    *fraction = x - (float)row;
    return row;
}

float albedo_at(const struct albedo_table *t, float roughness, float cosine)
{
    float fraction, x = sqrtf(clampf(cosine, 0, 1)) * (COSINES - 1);
    int row = row_of(t, roughness, &fraction), column = (int)fminf(x, COSINES - 2);
    float along_row = x - (float)column;
    float a = lerpf(t->value[row][column], t->value[row][column + 1], along_row);
    if (t->rows == 1)
        return a;
    return lerpf(a, lerpf(t->value[row + 1][column], t->value[row + 1][column + 1], along_row), fraction);
}

float albedo_mean(const struct albedo_table *t, float roughness)
{
    float fraction;
    int row = row_of(t, roughness, &fraction);
    return t->rows == 1 ? t->mean[0] : lerpf(t->mean[row], t->mean[row + 1], fraction);
}

float albedo_compensation(const struct albedo_table *t, float roughness, float cosine, float facets)
{
    if (!t)
        return 1;
    float e = albedo_at(t, roughness, fabsf(cosine)), mean = albedo_mean(t, roughness);
    return 1 + facets * mean / (1 - facets * (1 - mean)) * (1 - e) / e;
}
