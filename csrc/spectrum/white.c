/* The working space's white as a light: D65, or for another white the mixture of daylight's components that has
   exactly its chromaticity. */
#include <math.h>

#include "base/error.h"
#include "spectrum/knots.h"
#include "spectrum/library/library.h"
#include "spectrum/white.h"

#define SAME_XY 1e-3 /* whites nearer to D65 than this are D65, rounded by somebody */

struct white_light {
    bool d65;
    double weight[3]; /* of daylight's components, unless it is D65 */
};

static void white_xyz(const struct working_space *space, double xyz[3])
{
    const double *m = space->rgb_to_xyz;
    for (int row = 0; row < 3; row++)
        xyz[row] = m[3 * row] + m[3 * row + 1] + m[3 * row + 2];
}

static float component_at(int component, float lambda_nm)
{
    float at = (lambda_nm - DAYLIGHT_MIN_NM) / DAYLIGHT_STEP_NM;
    if (!(at >= 0 && at <= DAYLIGHT_COUNT - 1))
        return 0;
    int i = at < DAYLIGHT_COUNT - 1 ? (int)at : DAYLIGHT_COUNT - 2;
    float v0 = library_daylight(i)[component], v1 = library_daylight(i + 1)[component];
    return v0 + (at - (float)i) * (v1 - v0);
}

static double power_at(const struct white_light *light, float lambda_nm)
{
    if (light->d65)
        return illuminant_d65(lambda_nm);
    double power = 0;
    for (int c = 0; c < 3; c++)
        power += light->weight[c] * component_at(c, lambda_nm);
    return fmax(power, 0);
}

static void component_xyz(int component, double xyz[3])
{
    xyz[0] = xyz[1] = xyz[2] = 0;
    for (float l = CMF_MIN_NM; l <= CMF_MAX_NM; l += 1) {
        float cmf[3];
        cmf_eval(l, cmf);
        for (int c = 0; c < 3; c++)
            xyz[c] += (double)cmf[c] * component_at(component, l);
    }
}

/* The weights w of S0 + w1·S1 + w2·S2 whose X/Y and Z/Y are the white's: two linear equations. */
static struct white_light white_light(const struct working_space *space)
{
    static const double d65_xy[2] = {0.31272, 0.32903};
    double white[3], part[3][3];
    white_xyz(space, white);
    double sum = white[0] + white[1] + white[2];
    if (fabs(white[0] / sum - d65_xy[0]) < SAME_XY && fabs(white[1] / sum - d65_xy[1]) < SAME_XY)
        return (struct white_light){.d65 = true};
    for (int i = 0; i < 3; i++)
        component_xyz(i, part[i]);
    double x = white[0] / white[1], z = white[2] / white[1], e[2][3];
    for (int i = 0; i < 3; i++) {
        e[0][i] = part[i][0] - x * part[i][1];
        e[1][i] = part[i][2] - z * part[i][1];
    }
    double determinant = e[0][1] * e[1][2] - e[0][2] * e[1][1];
    return (struct white_light){.weight = {1, (e[0][2] * e[1][0] - e[0][0] * e[1][2]) / determinant,
                                           (e[0][0] * e[1][1] - e[0][1] * e[1][0]) / determinant}};
}

struct spectrum *spectrum_white(struct range range, const struct working_space *space)
{
    struct white_light light = white_light(space);
    float lambda[DAYLIGHT_COUNT], value[DAYLIGHT_COUNT];
    for (int i = 0; i < DAYLIGHT_COUNT; i++) {
        lambda[i] = DAYLIGHT_MIN_NM + DAYLIGHT_STEP_NM * (float)i;
        value[i] = (float)(power_at(&light, lambda[i]) / 100);
    }
    return spectrum_table(range, lambda, value, DAYLIGHT_COUNT, BEYOND_ZERO, "white", NULL);
}

/* Adds ∫ light·cmf·hat over [from, from + 1] nm to the weights of the two nodes whose hats stand there. The integrand
   is a cubic, for which Simpson's rule is exact. */
static void add_nanometre(struct observer *o, const struct white_light *light, int from, int step)
{
    static const double simpson[3] = {1.0 / 6, 4.0 / 6, 1.0 / 6};
    int node = from / step;
    for (int i = 0; i < 3; i++) {
        double at = from + 0.5 * i, t = at / step - node;
        float lambda = CMF_MIN_NM + (float)at, cmf[3];
        cmf_eval(lambda, cmf);
        double power = simpson[i] * power_at(light, lambda);
        for (int c = 0; c < 3; c++) {
            o->weight[node][c] += (1 - t) * power * cmf[c];
            o->weight[node + 1][c] += t * power * cmf[c];
        }
    }
}

void observer_set(struct observer *o, const struct working_space *space, int step_nm)
{
    const int length = (int)(CMF_MAX_NM - CMF_MIN_NM);
    struct white_light light = white_light(space);
    *o = (struct observer){.count = length / step_nm + 1};
    white_xyz(space, o->white);
    for (int from = 0; from < length; from++)
        add_nanometre(o, &light, from, step_nm);
    for (int c = 0; c < 3; c++) {
        double sum = 0;
        for (int i = 0; i < o->count; i++)
            sum += o->weight[i][c];
        for (int i = 0; i < o->count; i++)
            o->weight[i][c] *= o->white[c] / sum;
    }
}
