/* A table of curves over the RGB cube, for textures. As Jakob & Hanika do, it has one cube per largest component: axes
   are that component's value and the ratios of the other two to it.

   What is interpolated is not the coefficients but g = asinh x - ½ ln(value) at three wavelengths: where the curve
   saturates, asinh grows as a logarithm and not without bound; and as a colour darkens, x tends to -1/(2√S) with S in
   proportion to its value, so that g tends to a constant. Both make it nearly linear between the nodes. */
#include <math.h>
#include <stdlib.h>

#include "base/thread.h"
#include "spectrum/rgb_fit.h"

#define NODES 32
#define WHITEST 0.9998 /* what the table takes for white: x stays finite */
#define FIT_STEP_NM 5
#define RIDGE 1e-4 /* for colours out of reach */

/* The three wavelengths, as t of struct fit: about 442, 548 and 642 nm. */
static const double anchor[3] = {-0.65, -0.2, 0.2};

struct rgb_table {
    float value_node[NODES], ratio_node[NODES];
    float g[3][NODES][NODES][NODES][3]; /* [largest][first ratio][second ratio][value][anchor] */
};

struct build {
    struct rgb_table *table;
    struct fitter fitter;
};

static double smoothstep(double u)
{
    return u * u * (3 - 2 * u);
}

/* Dense where curves change most: near black and white, near pure colours and greys. */
static void set_nodes(struct rgb_table *table)
{
    for (int i = 0; i < NODES; i++) {
        double u = (double)i / (NODES - 1);
        table->value_node[i] = (float)smoothstep(u * sqrt(u));
        table->ratio_node[i] = (float)smoothstep(u);
    }
}

static void set_node(float g[3], const struct fit *fit, double value)
{
    for (int a = 0; a < 3; a++)
        g[a] = (float)(asinh((fit->p[0] * anchor[a] + fit->p[1]) * anchor[a] + fit->p[2]) - 0.5 * log(value));
}

/* The next brighter colour of a column. What reflectances can be is convex and holds black, so that the colours of a
   column are in reach up to some value, and out of it from there on. */
static struct fit climb(const struct fitter *fitter, const double rgb[3], double value, struct fit below,
                        bool *reach)
{
    if (*reach) {
        struct fit fit = fitter_improve(fitter, rgb, below, 0, 30);
        if (!fit_reaches(&fit))
            fit = fitter_improve(fitter, rgb, fit_grey(RGB_SIGMOID, 0.3 * value), 0, 40);
        *reach = fit_reaches(&fit);
        if (*reach)
            return fit;
    }
    return fitter_improve(fitter, rgb, below, RIDGE, 30);
}

static void build_column(struct build *build, int largest, int i, int j)
{
    struct rgb_table *table = build->table;
    float(*column)[3] = table->g[largest][i][j];
    bool reach = true, grey = i == NODES - 1 && j == NODES - 1;
    struct fit fit = fit_grey(RGB_SIGMOID, 0.3 * table->value_node[1]);
    for (int k = 1; k < NODES; k++) {
        double rgb[3], value = table->value_node[k];
        rgb[largest] = value;
        rgb[(largest + 1) % 3] = value * table->ratio_node[i];
        rgb[(largest + 2) % 3] = value * table->ratio_node[j];
        fit = grey ? fit_grey(RGB_SIGMOID, fmin(value, WHITEST)) : climb(&build->fitter, rgb, value, fit, &reach);
        set_node(column[k], &fit, value);
    }
    for (int a = 0; a < 3; a++) /* the limit towards black */
        column[0][a] = column[1][a];
}

static void build_slab(void *context, size_t index, int worker)
{
    (void)worker;
    for (int j = 0; j < NODES; j++)
        build_column(context, (int)index / NODES, (int)index % NODES, j);
}

struct rgb_table *rgb_table_create(const struct working_space *space, int threads)
{
    struct build *build = malloc(sizeof *build);
    struct rgb_table *table = build ? malloc(sizeof *table) : NULL;
    if (table) {
        set_nodes(table);
        fitter_set(&build->fitter, RGB_SIGMOID, space, FIT_STEP_NM);
        build->table = table;
        thread_run(threads, 3 * NODES, build_slab, NULL, build);
    }
    free(build);
    return table;
}

void rgb_table_destroy(struct rgb_table *table)
{
    free(table);
}

/* The cell of ascending nodes that holds `at` in [0, 1], and how far in it lies. */
static int cell(const float node[NODES], float at, float *t)
{
    int low = 0;
    for (int step = NODES / 2; step > 0; step /= 2)
        if (low + step < NODES - 1 && node[low + step] <= at)
            low += step;
    *t = (at - node[low]) / (node[low + 1] - node[low]);
    return low;
}

static float unit(float value)
{
    return value > 0 ? value < 1 ? value : 1 : 0;
}

static struct rgb_curve grey_curve(float value)
{
    struct fit fit = fit_grey(RGB_SIGMOID, value);
    return fit_curve(&fit);
}

/* The coefficients of the parabola through x at the three anchors, by divided differences. */
static struct rgb_curve through_anchors(const float x[3])
{
    double first = (x[1] - x[0]) / (anchor[1] - anchor[0]), second = (x[2] - x[1]) / (anchor[2] - anchor[1]);
    double a = (second - first) / (anchor[2] - anchor[0]), b = first - a * (anchor[0] + anchor[1]);
    struct fit fit = {.p = {a, b, x[0] - (a * anchor[0] + b) * anchor[0]}};
    return fit_curve(&fit);
}

struct rgb_curve rgb_table_lookup(const struct rgb_table *table, const float rgb[3])
{
    float color[3] = {unit(rgb[0]), unit(rgb[1]), unit(rgb[2])};
    int largest = color[0] >= color[1] ? (color[0] >= color[2] ? 0 : 2) : (color[1] >= color[2] ? 1 : 2);
    float value = color[largest], first = color[(largest + 1) % 3], second = color[(largest + 2) % 3];
    if ((first == value && second == value) || value < 1e-6f)
        return grey_curve(value);
    float ti, tj, tk, x[3];
    int i = cell(table->ratio_node, first / value, &ti), j = cell(table->ratio_node, second / value, &tj);
    int k = cell(table->value_node, value, &tk);
    float root = sqrtf(value);
    for (int a = 0; a < 3; a++) {
        float g[4];
        for (int c = 0; c < 4; c++) {
            const float(*column)[3] = table->g[largest][i + (c >> 1)][j + (c & 1)];
            g[c] = column[k][a] + tk * (column[k + 1][a] - column[k][a]);
        }
        float low = g[0] + tj * (g[1] - g[0]), high = g[2] + tj * (g[3] - g[2]);
        float grown = expf(low + ti * (high - low)) * root; /* sinh(g + ½ ln value) */
        x[a] = 0.5f * (grown - 1 / grown);
    }
    return through_anchors(x);
}
