/* The CIE 1931 observer and illuminant D65, from the tables in cie.inc. */
#include <math.h>

#include "color/color.h"

#include "color/cie.inc"

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))
#define D65_MIN_NM 300.0f
#define D65_STEP_NM 5.0f

void cmf_eval(float lambda_nm, float xyz[3])
{
    float at = lambda_nm - CMF_MIN_NM;
    if (!(at >= 0 && at <= CMF_MAX_NM - CMF_MIN_NM)) {
        xyz[0] = xyz[1] = xyz[2] = 0;
        return;
    }
    int i = at < COUNT(cie_cmf) - 1 ? (int)at : COUNT(cie_cmf) - 2;
    float t = at - (float)i;
    for (int c = 0; c < 3; c++)
        xyz[c] = cie_cmf[i][c] + t * (cie_cmf[i + 1][c] - cie_cmf[i][c]);
}

float illuminant_d65(float lambda_nm)
{
    float at = (lambda_nm - D65_MIN_NM) / D65_STEP_NM;
    if (!(at >= 0 && at <= (float)(COUNT(cie_d65) - 1)))
        return 0;
    int i = at < COUNT(cie_d65) - 1 ? (int)at : COUNT(cie_d65) - 2;
    return cie_d65[i] + (at - (float)i) * (cie_d65[i + 1] - cie_d65[i]);
}

static double luminous(double lambda_nm)
{
    float xyz[3];
    cmf_eval((float)lambda_nm, xyz);
    return illuminant_d65((float)lambda_nm) * xyz[1];
}

double cmf_normalization(double lambda_min, double lambda_max)
{
    double power = 0, luminance = 0;
    double low = fmax(lambda_min, 0), high = fmin(lambda_max, 2000);
    while (low <
           high) { /* between whole nanometres D65·ȳ is a quadratic, for which Simpson's rule is exact */
        double next = fmin(floor(low) + 1, high), middle = (low + next) / 2;
        power += (next - low) * illuminant_d65((float)middle);
        luminance += (next - low) / 6 * (luminous(low) + 4 * luminous(middle) + luminous(next));
        low = next;
    }
    return luminance > 0 ? power / luminance : 0;
}
