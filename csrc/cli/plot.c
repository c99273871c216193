/* Spectra drawn as SVG. */
#include <math.h>
#include <string.h>

#include "cli.h"

#define WIDTH 800
#define HEIGHT 450
#define LEFT 70
#define RIGHT 20
#define TOP 20
#define BOTTOM 50
#define LINE 16 /* of the legend */

struct axes {
    double from, to, low, high; /* nm; values */
};

static double x_of(const struct axes *a, double nm)
{
    return LEFT + (nm - a->from) / (a->to - a->from) * (WIDTH - LEFT - RIGHT);
}

static double y_of(const struct axes *a, double value)
{
    return HEIGHT - BOTTOM - (value - a->low) / (a->high - a->low) * (HEIGHT - TOP - BOTTOM);
}

/* 1, 2 or 5 times a power of ten, at most `parts` of them in the span. */
static double step_of(double span, double parts)
{
    double least = span / parts, power = pow(10, floor(log10(least)));
    return least <= power       ? power
           : least <= 2 * power ? 2 * power
           : least <= 5 * power ? 5 * power
                                : 10 * power;
}

/* Color Universal Design (Okabe & Ito 2008), so that no eye confuses two curves. */
static const char *color_of(int i)
{
    static const char *const colors[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                         "#E69F00", "#56B4E9", "#000000"};
    return colors[i % (int)(sizeof colors / sizeof *colors)];
}

static void put_text(FILE *out, const char *text)
{
    for (; *text; text++)
        switch (*text) {
        case '<': fputs("&lt;", out); break;
        case '>': fputs("&gt;", out); break;
        case '&': fputs("&amp;", out); break;
        case '"': fputs("&quot;", out); break;
        default: fputc((unsigned char)*text < ' ' ? ' ' : *text, out);
        }
}

static void grid(FILE *out, const struct axes *a)
{
    double step = step_of(a->to - a->from, 10);
    for (double nm = ceil(a->from / step) * step; nm <= a->to * (1 + 1e-9); nm += step)
        fprintf(out,
                "<line x1=\"%.1f\" x2=\"%.1f\" y1=\"%d\" y2=\"%d\" stroke=\"#ddd\"/>"
                "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%g</text>\n",
                x_of(a, nm), x_of(a, nm), TOP, HEIGHT - BOTTOM, x_of(a, nm), HEIGHT - BOTTOM + 18, nm);
    step = step_of(a->high - a->low, 6);
    for (double v = ceil(a->low / step) * step; v <= a->high * (1 + 1e-9); v += step)
        fprintf(out,
                "<line x1=\"%d\" x2=\"%d\" y1=\"%.1f\" y2=\"%.1f\" stroke=\"#ddd\"/>"
                "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%.4g</text>\n",
                LEFT, WIDTH - RIGHT, y_of(a, v), y_of(a, v), LEFT - 6, y_of(a, v) + 4,
                fabs(v) < 1e-9 * step ? 0 : v);
    fprintf(out, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">wavelength (nm)</text>\n",
            (LEFT + WIDTH - RIGHT) / 2, HEIGHT - 10);
    fprintf(out,
            "<text x=\"16\" y=\"%d\" text-anchor=\"middle\" transform=\"rotate(-90 16 %d)\">value</text>\n",
            (TOP + HEIGHT - BOTTOM) / 2, (TOP + HEIGHT - BOTTOM) / 2);
}

static void curve(FILE *out, const struct axes *a, const stokes_spectrum *s, const char *color)
{
    fprintf(out, "<polyline fill=\"none\" stroke=\"%s\" stroke-width=\"2\" points=\"", color);
    double from = fmax(a->from, s->holds ? a->from : s->lambda_nm[0]),
           to = fmin(a->to, s->holds ? a->to : s->lambda_nm[s->count - 1]);
    if (from <= to)
        fprintf(out, "%.2f,%.2f ", x_of(a, from), y_of(a, stokes_spectrum_value(s, from)));
    for (size_t i = 0; i < s->count; i++)
        if (s->lambda_nm[i] > from && s->lambda_nm[i] < to)
            fprintf(out, "%.2f,%.2f ", x_of(a, s->lambda_nm[i]), y_of(a, s->value[i]));
    if (from < to)
        fprintf(out, "%.2f,%.2f", x_of(a, to), y_of(a, stokes_spectrum_value(s, to)));
    fputs("\"/>\n", out);
}

/* Zero is on the sheet, and a little air above. */
static struct axes axes_of(stokes_spectrum *const *spectra, int count, double from, double to)
{
    struct axes a = {from, to, 0, 0};
    for (int k = 0; k < count; k++)
        for (size_t i = 0; i < spectra[k]->count; i++)
            if (spectra[k]->lambda_nm[i] >= from && spectra[k]->lambda_nm[i] <= to) {
                a.low = fmin(a.low, spectra[k]->value[i]);
                a.high = fmax(a.high, spectra[k]->value[i]);
            }
    a.high = a.high > a.low ? a.high + 0.05 * (a.high - a.low) : a.low + 1;
    return a;
}

void cli_plot(FILE *out, stokes_spectrum *const *spectra, const char *const *names, int count, double from_nm,
              double to_nm)
{
    struct axes a = axes_of(spectra, count, from_nm, to_nm);
    fprintf(out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" font-family=\"sans-serif\" "
            "font-size=\"13\">\n<rect width=\"%d\" height=\"%d\" fill=\"#fff\"/>\n",
            WIDTH, HEIGHT + LINE * count, WIDTH, HEIGHT + LINE * count);
    grid(out, &a);
    fprintf(out, "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"none\" stroke=\"#000\"/>\n", LEFT,
            TOP, WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM);
    for (int i = 0; i < count; i++) {
        int y = HEIGHT + LINE * i;
        curve(out, &a, spectra[i], color_of(i));
        fprintf(out,
                "<line x1=\"%d\" x2=\"%d\" y1=\"%d\" y2=\"%d\" stroke=\"%s\" stroke-width=\"2\"/><text "
                "x=\"%d\" y=\"%d\">",
                LEFT, LEFT + 24, y, y, color_of(i), LEFT + 32, y + 4);
        put_text(out, names[i]);
        fputs("</text>\n", out);
    }
    fputs("</svg>\n", out);
}
