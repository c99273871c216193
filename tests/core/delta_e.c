/* CIE 15:2018, section 8.2.1 (L*a*b*) and ISO/CIE 11664-6 (CIEDE2000). */
#include "delta_e.h"

#include <math.h>

#define DEGREE (3.14159265358979323846 / 180)

static double root_of(double q)
{
    return q > 216.0 / 24389 ? cbrt(q) : 841.0 / 108 * q + 4.0 / 29;
}

void lab_of_xyz(const double xyz[3], const double white[3], double lab[3])
{
    double x = root_of(xyz[0] / white[0]), y = root_of(xyz[1] / white[1]), z = root_of(xyz[2] / white[2]);
    lab[0] = 116 * y - 16;
    lab[1] = 500 * (x - y);
    lab[2] = 200 * (y - z);
}

static double seventh_power_share(double chroma) /* √(C⁷/(C⁷ + 25⁷)) */
{
    double c7 = pow(chroma, 7);
    return sqrt(c7 / (c7 + 6103515625.0));
}

static double hue(double a, double b)
{
    double h = a == 0 && b == 0 ? 0 : atan2(b, a) / DEGREE;
    return h < 0 ? h + 360 : h;
}

static double mean_hue(double h1, double h2, double c1, double c2)
{
    if (c1 * c2 == 0)
        return h1 + h2;
    double mean = (h1 + h2) / 2;
    return fabs(h1 - h2) <= 180 ? mean : mean < 180 ? mean + 180 : mean - 180;
}

static double hue_step(double h1, double h2, double c1, double c2)
{
    if (c1 * c2 == 0)
        return 0;
    double step = h2 - h1;
    return step > 180 ? step - 360 : step < -180 ? step + 360 : step;
}

double delta_e_2000(const double lab1[3], const double lab2[3])
{
    double g = 1 + 0.5 * (1 - seventh_power_share((hypot(lab1[1], lab1[2]) + hypot(lab2[1], lab2[2])) / 2));
    double c1 = hypot(g * lab1[1], lab1[2]), c2 = hypot(g * lab2[1], lab2[2]), c = (c1 + c2) / 2;
    double h1 = hue(g * lab1[1], lab1[2]), h2 = hue(g * lab2[1], lab2[2]), h = mean_hue(h1, h2, c1, c2);
    double t = 1 - 0.17 * cos((h - 30) * DEGREE) + 0.24 * cos(2 * h * DEGREE) +
               0.32 * cos((3 * h + 6) * DEGREE) - 0.20 * cos((4 * h - 63) * DEGREE);
    double l50 = ((lab1[0] + lab2[0]) / 2 - 50) * ((lab1[0] + lab2[0]) / 2 - 50);
    double dl = (lab2[0] - lab1[0]) / (1 + 0.015 * l50 / sqrt(20 + l50));
    double dc = (c2 - c1) / (1 + 0.045 * c);
    double dh = 2 * sqrt(c1 * c2) * sin(hue_step(h1, h2, c1, c2) / 2 * DEGREE) / (1 + 0.015 * c * t);
    double turn = -2 * seventh_power_share(c) * sin(60 * exp(-((h - 275) / 25) * ((h - 275) / 25)) * DEGREE);
    return sqrt(dl * dl + dc * dc + dh * dh + turn * dc * dh);
}
