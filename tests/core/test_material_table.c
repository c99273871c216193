/* What holds for every kind of BSDF, over the table of kinds: densities, and draws by them. A kind that is added is tested the
   day it is added; reciprocity and balances are in test_material_balance.c. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "material_kit.h"
#include "statistics.h"

#include <cmocka.h>

#define UP vec3(0, 0, 1)

static struct kit_random seeded(uint32_t seed)
{
    return (struct kit_random){random_path(seed, 0, 0), 0};
}

static struct vec3 tilted(struct kit_random *r, struct vec3 n)
{
    return normalize(along(n, kit_direction(r), 0.4f));
}

/* As under a normal map: the lobes' normal leans far over, and soft terminators and bent frames come in. */
static void map_normals(struct surface *s, struct kit_random *r)
{
    struct vec3 n = normalize(along(s->ng, kit_direction(r), 0.85f));
    for (int i = 0; i < s->lobe_count; i++)
        if (s->lobe[i].kind->nature != LOBE_DELTA) {
            s->lobe[i].frame = frame_about(n);
            s->lobe[i].mapped = true;
            s->is_matte = false; /* material_shade would have seen the map */
        }
}

static enum side other_side(enum side side)
{
    return side == SIDE_LIGHT ? SIDE_CAMERA : SIDE_LIGHT;
}

/* --- Densities are normalised and are what is drawn -------------------------------------------------------- */

enum { Z_BINS = 12, PHI_BINS = 12, LAMBDA_BINS = 12, DELTA_BINS = 2 * SURFACE_LOBES };
enum { E_BINS = Z_BINS * PHI_BINS, F_BINS = 4 * LAMBDA_BINS };
enum { BINS = E_BINS + F_BINS + DELTA_BINS + 1 };

/* Probability that a bin may hold where the quadrature finds nothing: slivers along the horizon of a tilted normal. */
#define HORIZON_SLACK 1e-6

static int direction_bin(const struct frame *f, struct vec3 w)
{
    struct vec3 l = to_local(f, w);
    float phi = atan2f(l.y, l.x) / (2 * PI_F) + 0.5f;
    int z = (int)fminf(Z_BINS - 1, (l.z + 1) / 2 * Z_BINS), p = (int)fminf(PHI_BINS - 1, phi * PHI_BINS);
    return z * PHI_BINS + p;
}

static size_t kit_below(struct kit_random *r, size_t count)
{
    return (size_t)(kit_uniform(r) * (float)count);
}

/* ∫ pdf |cos_g| dω over a bin of elastic directions, by Gauss–Legendre in z and φ about any axis: quartered twice, and on while it
   varies. */
static double bin_integral(const struct surface *s, enum side side, struct vec3 arriving, float lambda,
                           const struct frame *f, double z0, double z1, double p0, double p1, int level,
                           int last)
{
    static const double node[] = {0.046910077030668, 0.230765344947158, 0.5, 0.769234655052842,
                                  0.953089922969332};
    static const double weight[] = {0.118463442528095, 0.239314335249683, 0.284444444444444,
                                    0.239314335249683, 0.118463442528095};
    double sum = 0, most = 0, least = INFINITY;
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 5; j++) {
            double z = z0 + (z1 - z0) * node[i], phi = p0 + (p1 - p0) * node[j], r = sqrt(fmax(0, 1 - z * z));
            struct vec3 w = to_world(f, vec3((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z));
            double density = surface_pdf_elastic(s, side, arriving, w, lambda) * (double)fabsf(dot(w, s->ng));
            sum += weight[i] * weight[j] * density;
            most = fmax(most, density);
            least = fmin(least, density);
        }
    bool settled = level >= 2 && (most - least < 0.3 * most || most * (z1 - z0) * (p1 - p0) < 1e-7);
    if (level == last || settled)
        return sum * (z1 - z0) * (p1 - p0);
    double zm = (z0 + z1) / 2, pm = (p0 + p1) / 2;
    return bin_integral(s, side, arriving, lambda, f, z0, zm, p0, pm, level + 1, last) +
           bin_integral(s, side, arriving, lambda, f, zm, z1, p0, pm, level + 1, last) +
           bin_integral(s, side, arriving, lambda, f, z0, zm, pm, p1, level + 1, last) +
           bin_integral(s, side, arriving, lambda, f, zm, z1, pm, p1, level + 1, last);
}

static void expect_elastic(const struct surface *s, enum side side, struct vec3 arriving, float lambda,
                           const struct frame *f, double expected[])
{
    for (int z = 0; z < Z_BINS; z++)
        for (int p = 0; p < PHI_BINS; p++)
            expected[z * PHI_BINS + p] = bin_integral(
                s, side, arriving, lambda, f, 2.0 * z / Z_BINS - 1, 2.0 * (z + 1) / Z_BINS - 1,
                2 * M_PI * ((double)p / PHI_BINS - 0.5), 2 * M_PI * ((double)(p + 1) / PHI_BINS - 0.5), 0, 5);
}

/* Fluorescent draws: z of the direction on either side in four bins, wavelength in twelve. */
static int fluorescent_bin(const struct frame *f, const struct scatter *drawn)
{
    float z = dot(f->n, drawn->direction);
    int i = (int)fminf(3, (z + 1) * 2),
        l = (int)fminf(LAMBDA_BINS - 1, (drawn->lambda - 300) / 530 * LAMBDA_BINS);
    return E_BINS + i * LAMBDA_BINS + l;
}

/* Where the density of the new wavelength is highest. */
static float likeliest(const struct surface *s, enum side side, int f, float lambda)
{
    float best = 300, most = 0;
    for (float at = 300.5f; at < 830; at += 1) {
        float pdf = side == SIDE_CAMERA ? surface_pdf_absorbed(s, f, at, lambda)
                                        : surface_pdf_emitted(s, f, lambda, at);
        if (pdf > most) {
            most = pdf;
            best = at;
        }
    }
    return best;
}

/* Wavelength and direction are independent: the density along all directions at one wavelength, times that over all wavelengths
   along one direction. */
static void expect_fluorescent(const struct surface *s, enum side side, struct vec3 arriving, float lambda,
                               const struct frame *f, double expected[])
{
    enum { ZS = 48, PHIS = 48, LAMBDAS = 240 };
    for (int k = 0; k < s->fluorescent_count; k++) {
        double direction[4] = {0}, wavelength[LAMBDA_BINS] = {0};
        struct vec3 across = dot(arriving, s->ng) > 0 ? s->ng : negate(s->ng);
        float middle = likeliest(s, side, k, lambda);
        double reference = surface_pdf_fluorescent(s, side, k, arriving, across, lambda, middle);
        for (int i = 0; i < 4 * ZS; i++)
            for (int j = 0; j < PHIS; j++) {
                double z = 2 * (i + 0.5) / (4 * ZS) - 1, phi = 2 * M_PI * (j + 0.5) / PHIS,
                       r = sqrt(1 - z * z);
                struct vec3 w = to_world(f, vec3((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z));
                direction[i / ZS] += surface_pdf_fluorescent(s, side, k, arriving, w, lambda, middle) *
                                     fabs(z) * 2 * M_PI / PHIS * 2 / (4 * ZS);
            }
        for (int l = 0; l < LAMBDA_BINS * LAMBDAS; l++) {
            float at = 300 + 530 * ((float)l + 0.5f) / (LAMBDA_BINS * LAMBDAS);
            wavelength[l / LAMBDAS] += surface_pdf_fluorescent(s, side, k, arriving, across, lambda, at) *
                                       530 / (LAMBDA_BINS * LAMBDAS);
        }
        for (int i = 0; i < 4 && reference > 0; i++)
            for (int l = 0; l < LAMBDA_BINS; l++)
                expected[E_BINS + i * LAMBDA_BINS + l] += direction[i] * wavelength[l] / reference;
    }
}

/* The chance of a δ draw: seen from the camera the density itself; from the light that without (n_c/n_l)², which Snell's law tells
   from the angles, and without the ratio of shading to geometric cosines (algorithm.md §7). */
static double delta_chance(const struct surface *s, enum side side, struct vec3 light,
                           const struct scatter *drawn)
{
    if (side == SIDE_CAMERA)
        return drawn->pdf;
    struct vec3 n = s->lobe[s->specular[drawn->lobe]].frame.n, camera = drawn->direction;
    double l = dot(light, n), c = dot(camera, n);
    double n_squared = drawn->refracts ? (1 - l * l) / (1 - c * c) : 1;
    return drawn->pdf / (n_squared * fabs(c * dot(light, s->ng) / (l * dot(camera, s->ng))));
}

/* Draws, and compares with the densities. What is lost is a bin, too: Σ∫pdf + lost = 1. */
static struct chi2 draws_against_densities(const struct surface *s, enum side side, struct vec3 arriving,
                                           float lambda, struct kit_random *r, int draws)
{
    double observed[BINS] = {0}, expected[BINS] = {0}, total = 0;
    struct frame f = frame_about(s->ng);
    expect_elastic(s, side, arriving, lambda, &f, expected);
    expect_fluorescent(s, side, arriving, lambda, &f, expected);
    for (int n = 0; n < draws; n++) {
        struct scatter drawn;
        const float u[4] = {kit_uniform(r), kit_uniform(r), kit_uniform(r), kit_uniform(r)};
        int bin = BINS - 1;
        if (surface_sample(s, side, arriving, lambda, u, &drawn)) {
            if (drawn.label == LABEL_ELASTIC)
                bin = direction_bin(&f, drawn.direction);
            else if (drawn.label == LABEL_FLUORESCENT)
                bin = fluorescent_bin(&f, &drawn);
            else {
                bin = E_BINS + F_BINS + 2 * drawn.lobe + drawn.refracts;
                expected[bin] = delta_chance(s, side, arriving, &drawn);
            }
        }
        observed[bin]++;
    }
    for (int i = 0; i < BINS - 1; i++)
        total += expected[i];
    assert_true(total < 1 + 2e-3);
    expected[BINS - 1] = fmax(0, 1 - total);
    for (int i = 0; i < BINS; i++)
        expected[i] = (expected[i] + HORIZON_SLACK) * draws;
    return chi2_test(observed, expected, BINS, 0);
}

static void draws_follow_densities_that_sum_to_one(void **state)
{
    (void)state;
    enum { CASES = 24, SMOOTH_FROM = 16, DRAWS = 20000 };
    int kinds = 0, failures = 0;
    while (bsdf_kind_at((size_t)kinds))
        kinds++;
    double threshold = 1 - pow(1 - C_FALSE_ALARM, 1.0 / (kinds * CASES * 2)); /* Šidák over one family */
    struct kit_random r = seeded(1);
    for (int k = 0; k < kinds; k++)
        for (int i = 0; i < CASES; i++) {
            char text[256];
            struct closure *closure = kit_random_bsdf(&r, bsdf_kind_at((size_t)k), 0.4f);
            if (i >= SMOOTH_FROM)
                kit_set_roughness(closure, 0);
            kit_describe(closure, text);
            if (i & 4) /* with another kind: labels and lobes compete */
                closure =
                    kit_mix(closure, kit_random_bsdf(&r, bsdf_kind_at(kit_below(&r, (size_t)kinds)), 0.4f),
                            kit_value(kit_between(&r, 0.2f, 0.8f)));
            struct material *m = kit_compile(closure);
            struct vec3 ng = kit_direction(&r);
            struct surface s = kit_surface(m, ng, i & 1 ? tilted(&r, ng) : ng);
            if (i & 8)
                map_normals(&s, &r);
            struct vec3 arriving = kit_direction_about(&r, s.ns, i & 2);
            for (int side = 0; side < 2; side++) {
                struct chi2 result = draws_against_densities(&s, (enum side)side, arriving,
                                                             kit_between(&r, 320, 800), &r, DRAWS);
                if (result.freedom > 0 && result.p < threshold) {
                    printf("%s, side %d, case %d: p = %g (χ² %g of %zu)\n", text, side, i, result.p,
                           result.statistic, result.freedom);
                    failures++;
                }
            }
            material_destroy(m);
        }
    assert_int_equal(failures, 0);
}

/* --- Peaks narrower than those bins ------------------------------------------------------------------------ */

enum { RINGS = 8, SECTORS = 8, PEAK_BINS = RINGS * SECTORS + 1 };

/* Rings of equal shares of what a branch draws, about its likeliest direction. */
struct peak {
    bool crosses; /* the surface: refraction */
    struct frame frame;
    double edge[RINGS + 1]; /* cosines, from 1 down */
};

static bool is_of_branch(const struct surface *s, bool crosses, struct vec3 arriving,
                         const struct scatter *drawn)
{
    return drawn->label == LABEL_ELASTIC &&
           (dot(arriving, s->ng) * dot(drawn->direction, s->ng) < 0) == crosses;
}

static bool draw_elastic(const struct surface *s, enum side side, struct vec3 arriving, float lambda,
                         struct kit_random *r, struct scatter *drawn)
{
    const float u[4] = {kit_uniform(r), kit_uniform(r), kit_uniform(r), kit_uniform(r)};
    return surface_sample(s, side, arriving, lambda, u, drawn);
}

/* Cosine with the peak's axis in doubles, for near the axis a float's own is too coarse; −1 behind. */
static double peak_cosine(const struct frame *f, struct vec3 w)
{
    double x = (double)dot(f->s, w), y = (double)dot(f->t, w);
    return dot(f->n, w) > 0 ? sqrt(fmax(0, 1 - x * x - y * y)) : -1;
}

static int descending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

/* False if the branch is too rare to be told apart. */
static bool find_peak(const struct surface *s, enum side side, struct vec3 arriving, float lambda,
                      bool crosses, struct kit_random *r, struct peak *peak)
{
    enum { LOOKS = 4000 };
    static struct vec3 seen[LOOKS];
    static double cosine[LOOKS];
    int count = 0;
    struct vec3 best = s->ng;
    float most = 0;
    for (int n = 0; n < LOOKS; n++) {
        struct scatter drawn;
        if (!draw_elastic(s, side, arriving, lambda, r, &drawn) ||
            !is_of_branch(s, crosses, arriving, &drawn))
            continue;
        seen[count++] = drawn.direction;
        if (drawn.pdf > most) {
            most = drawn.pdf;
            best = drawn.direction;
        }
    }
    if (count < LOOKS / 4)
        return false;
    peak->crosses = crosses;
    peak->frame = frame_about(best);
    for (int n = 0; n < count; n++)
        cosine[n] = peak_cosine(&peak->frame, seen[n]);
    qsort(cosine, (size_t)count, sizeof cosine[0], descending);
    peak->edge[0] = 1;
    for (int i = 1; i <= RINGS; i++)
        peak->edge[i] = fmin(peak->edge[i - 1], fmax(0, cosine[count * i / (RINGS + 1)]));
    return true;
}

static int peak_bin(const struct peak *peak, struct vec3 w)
{
    double z = peak_cosine(&peak->frame, w);
    int ring = 0;
    while (ring < RINGS && z < peak->edge[ring + 1])
        ring++;
    float phi = atan2f(dot(peak->frame.t, w), dot(peak->frame.s, w)) / (2 * PI_F) + 0.5f;
    return ring == RINGS ? PEAK_BINS - 1 : ring * SECTORS + (int)fminf(SECTORS - 1, phi * SECTORS);
}

/* All that is not in the rings is one bin. */
static struct chi2 draws_against_peak(const struct surface *s, enum side side, struct vec3 arriving,
                                      float lambda, const struct peak *peak, struct kit_random *r, int draws)
{
    double observed[PEAK_BINS] = {0}, expected[PEAK_BINS] = {0}, total = 0;
    for (int i = 0; i < PEAK_BINS - 1; i++) {
        int ring = i / SECTORS, sector = i % SECTORS;
        expected[i] = bin_integral(s, side, arriving, lambda, &peak->frame, peak->edge[ring + 1],
                                   peak->edge[ring], 2 * M_PI * ((double)sector / SECTORS - 0.5),
                                   2 * M_PI * ((double)(sector + 1) / SECTORS - 0.5), 0, 8);
        total += expected[i];
    }
    assert_true(total < 1 + 2e-3);
    expected[PEAK_BINS - 1] = fmax(0, 1 - total);
    for (int n = 0; n < draws; n++) {
        struct scatter drawn;
        bool elastic = draw_elastic(s, side, arriving, lambda, r, &drawn) && drawn.label == LABEL_ELASTIC;
        observed[elastic ? peak_bin(peak, drawn.direction) : PEAK_BINS - 1]++;
    }
    for (int i = 0; i < PEAK_BINS; i++)
        expected[i] = (expected[i] + HORIZON_SLACK) * draws;
    return chi2_test(observed, expected, PEAK_BINS, 0);
}

static bool has_roughness(const struct bsdf_kind *kind)
{
    const struct bsdf_signature *s = bsdf_kind_signature(kind);
    for (int i = 0; i < CLOSURE_VALUES && s->value_names[i]; i++)
        if (strcmp(s->value_names[i], "roughness") == 0)
            return true;
    return false;
}

/* Adds what reflection and refraction from both sides say of one surface. */
static void look_at_peaks(const struct surface *s, struct vec3 arriving, float lambda, struct kit_random *r,
                          struct chi2 *all)
{
    enum { DRAWS = 40000 };
    for (int j = 0; j < 4; j++) {
        enum side side = j & 1 ? SIDE_CAMERA : SIDE_LIGHT;
        struct peak peak;
        if (!find_peak(s, side, arriving, lambda, j & 2, r, &peak))
            continue;
        struct chi2 one = draws_against_peak(s, side, arriving, lambda, &peak, r, DRAWS);
        all->statistic += one.statistic;
        all->freedom += one.freedom;
    }
}

/* All cases of a kind together see a width that is 2 % off. */
static void sharp_draws_follow_their_densities(void **state)
{
    (void)state;
    enum { CASES = 12 };
    int failures = 0, kinds = 0;
    struct kit_random r = seeded(4);
    for (int k = 0; bsdf_kind_at((size_t)k); k++) {
        struct chi2 all = {0};
        for (int i = 0; i < CASES && has_roughness(bsdf_kind_at((size_t)k)); i++) {
            struct closure *closure = kit_random_bsdf(&r, bsdf_kind_at((size_t)k), 0);
            kit_set_roughness(closure, 0.05f * powf(8, kit_uniform(&r)));
            struct material *m = kit_compile(closure);
            struct vec3 ng = kit_direction(&r);
            struct surface s = kit_surface(m, ng, i & 1 ? tilted(&r, ng) : ng);
            look_at_peaks(&s, kit_direction_about(&r, s.ns, i & 2), kit_between(&r, 320, 800), &r, &all);
            material_destroy(m);
        }
        if (all.freedom == 0)
            continue;
        kinds++;
        double p = chi2_upper_tail(all.statistic, (double)all.freedom);
        printf("%s: p = %.2g (χ² %.0f of %zu)\n", bsdf_kind_signature(bsdf_kind_at((size_t)k))->name, p,
               all.statistic, all.freedom);
        failures += p < C_FALSE_ALARM / 8;
    }
    assert_true(kinds >= 4 && kinds <= 8);
    assert_int_equal(failures, 0);
}

/* --- A draw says what the functions say --------------------------------------------------------------------- */

/* Matte surfaces have formulae of their own (matte.c), which round otherwise. */
static void assert_near(float a, float b)
{
    assert_true(fabsf(a - b) <= 2e-5f * fabsf(b) + 1e-12f);
}

static void check_draw(const struct surface *s, enum side side, struct vec3 arriving, float lambda,
                       const struct scatter *d)
{
    bool camera = side == SIDE_CAMERA;
    struct vec3 light = camera ? d->direction : arriving, eye = camera ? arriving : d->direction;
    assert_true(isfinite(d->value) && d->value >= 0 && d->pdf > 0 && isfinite(d->pdf) && d->pdf_other >= 0);
    assert_float_equal(length(d->direction), 1, 1e-5);
    if (d->label == LABEL_ELASTIC) {
        assert_near(d->value, surface_elastic(s, light, eye, lambda));
        assert_near(d->pdf, surface_pdf_elastic(s, side, arriving, d->direction, lambda));
        assert_near(d->pdf_other, surface_pdf_elastic(s, other_side(side), d->direction, arriving, lambda));
        assert_true(d->lambda == lambda);
    } else if (d->label == LABEL_FLUORESCENT) {
        float in = camera ? d->lambda : lambda, out = camera ? lambda : d->lambda;
        assert_near(d->value, surface_fluorescent(s, d->lobe, light, eye, in, out));
        assert_near(d->pdf,
                    surface_pdf_fluorescent(s, side, d->lobe, arriving, d->direction, lambda, d->lambda));
        assert_near(d->pdf_other, surface_pdf_fluorescent(s, other_side(side), d->lobe, d->direction,
                                                          arriving, d->lambda, lambda));
        assert_near(d->draw, surface_pdf_lambda(s, side, d->lobe, lambda, d->lambda));
        assert_near(d->draw_other, surface_pdf_lambda(s, other_side(side), d->lobe, d->lambda, lambda));
        assert_true(d->lambda >= 300 && d->lambda <= 830);
    }
}

static void a_draw_has_the_value_and_densities_of_the_functions(void **state)
{
    (void)state;
    struct kit_random r = seeded(2);
    for (int k = 0; bsdf_kind_at((size_t)k); k++)
        for (int i = 0; i < 60; i++) {
            struct material *m = kit_compile(kit_random_bsdf(&r, bsdf_kind_at((size_t)k), i % 3 ? 0.01f : 0));
            struct vec3 ng = kit_direction(&r);
            struct surface s = kit_surface(m, ng, tilted(&r, ng));
            if (i & 4)
                map_normals(&s, &r);
            for (int n = 0; n < 40; n++) {
                enum side side = n & 1 ? SIDE_CAMERA : SIDE_LIGHT;
                struct vec3 arriving = kit_direction_about(&r, s.ns, n & 2);
                float lambda = kit_between(&r, 301, 829);
                const float u[4] = {kit_uniform(&r), kit_uniform(&r), kit_uniform(&r), kit_uniform(&r)};
                struct scatter drawn;
                if (surface_sample(&s, side, arriving, lambda, u, &drawn))
                    check_draw(&s, side, arriving, lambda, &drawn);
            }
            material_destroy(m);
        }
}

/* Where a value is, both sides can draw it: or else one technique alone would have to, which no other knows of. */
static void what_has_a_value_can_be_drawn_from_both_sides(void **state)
{
    (void)state;
    struct kit_random r = seeded(7);
    for (int k = 0; bsdf_kind_at((size_t)k); k++)
        for (int i = 0; i < 100; i++) {
            char text[256];
            struct closure *closure = kit_random_bsdf(&r, bsdf_kind_at((size_t)k), 0.1f);
            kit_describe(closure, text);
            struct material *m = kit_compile(closure);
            struct vec3 ng = kit_direction(&r);
            struct surface s = kit_surface(m, ng, tilted(&r, ng));
            if (i & 1)
                map_normals(&s, &r);
            for (int n = 0; n < 40; n++) {
                struct vec3 light = kit_direction(&r), camera = kit_direction(&r);
                float lambda = kit_between(&r, 301, 829);
                double value = surface_elastic(&s, light, camera, lambda);
                double from_light = surface_pdf_elastic(&s, SIDE_LIGHT, light, camera, lambda);
                double from_camera = surface_pdf_elastic(&s, SIDE_CAMERA, camera, light, lambda);
                if (value > 0 && !(from_light > 0 && from_camera > 0))
                    fail_msg("%s: value %g, densities %g and %g", text, value, from_light, from_camera);
            }
            material_destroy(m);
        }
}

/* A δ draw can be made backwards: the other side, arriving from where it left, leaves to where it came from, with the densities
   exchanged and the same value. */
static void a_specular_draw_can_be_made_from_the_other_side(void **state)
{
    (void)state;
    struct kit_random r = seeded(3);
    int checked = 0;
    for (int i = 0; i < 3000; i++) {
        struct closure *c = kit_random_bsdf(&r, bsdf_kind_find(i % 3 ? "dielectric" : "conductor"), 0);
        c->value[0]->constant = 0;
        struct material *m = kit_compile(c);
        struct vec3 ng = kit_direction(&r);
        struct surface s = kit_surface(m, ng, tilted(&r, ng));
        enum side side = i & 1 ? SIDE_CAMERA : SIDE_LIGHT;
        struct vec3 arriving = kit_direction_about(&r, s.ns, i & 2);
        float lambda = kit_between(&r, 301, 829);
        struct scatter there, back;
        const float u[4] = {kit_uniform(&r), kit_uniform(&r), 0, 0};
        if (surface_sample(&s, side, arriving, lambda, u, &there) &&
            fabsf(dot(there.direction, s.ns)) > 0.02f) {
            /* The branch is drawn by u[1] against the same Fresnel chance. */
            assert_true(surface_sample(&s, other_side(side), there.direction, lambda, u, &back));
            if (back.refracts == there.refracts) {
                assert_true(length(sub(back.direction, arriving)) < 3e-4f);
                assert_float_equal(back.value, there.value, 2e-3f * there.value);
                assert_float_equal(back.pdf, there.pdf_other, 5e-3f * there.pdf_other);
                assert_float_equal(back.pdf_other, there.pdf, 5e-3f * there.pdf);
                checked++;
            }
        }
        material_destroy(m);
    }
    assert_true(checked > 1500);
}

/* --- Mollified densities -------------------------------------------------------------------------------------- */

static void mollified_densities_tend_to_the_elastic_one_and_average_to_it(void **state)
{
    (void)state;
    struct kit_random r = seeded(6);
    for (int k = 0; bsdf_kind_at((size_t)k); k++)
        for (int i = 0; i < 40; i++) {
            char text[256];
            struct closure *closure = kit_random_bsdf(&r, bsdf_kind_at((size_t)k), 0.2f);
            kit_describe(closure, text);
            struct material *m = kit_compile(closure);
            struct vec3 ng = kit_direction(&r), a = kit_direction_about(&r, ng, false);
            struct vec3 b = kit_direction_about(&r, ng, i & 1);
            struct surface s = kit_surface(m, ng, ng);
            float lambda = kit_between(&r, 380, 750), d = kit_between(&r, 5, 70);
            float light = surface_pdf_elastic(&s, SIDE_LIGHT, a, b, lambda);
            float camera = surface_pdf_elastic(&s, SIDE_CAMERA, a, b, lambda);
            assert_true(surface_pdf_mollified(&s, SIDE_LIGHT, a, b, lambda, lambda + 0.5f * d, d) == light);
            assert_float_equal(surface_pdf_mollified(&s, SIDE_CAMERA, a, b, lambda, lambda, 0.01f), camera,
                               1e-3f * camera);
            assert_true(surface_pdf_mollified(&s, SIDE_CAMERA, a, b, lambda, lambda + 1.01f * d, d) == 0);
            /* Exact with cumulative tables. Quadrature meets the kinks of these random spectra, some 60 nm apart. */
            double mean = 0, tolerance = 1e-3;
            for (int n = 0; n < s.lobe_count; n++)
                if (s.lobe[n].kind->nature == LOBE_FINITE && !s.lobe[n].kind->albedo_integral)
                    tolerance = 0.03;
            enum { POINTS = 20000 }; /* a matrix steps at its bands' edges */
            for (int n = 0; n < POINTS; n++)
                mean += surface_pdf_mollified(&s, SIDE_CAMERA, a, b, lambda,
                                              lambda + d * (2 * (n + 0.5f) / POINTS - 1), d) /
                        POINTS;
            if (fabs(mean - camera) > tolerance * camera)
                fail_msg("%s: mean %g, elastic %g", text, mean, (double)camera);
            material_destroy(m);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(draws_follow_densities_that_sum_to_one),
        cmocka_unit_test(sharp_draws_follow_their_densities),
        cmocka_unit_test(a_draw_has_the_value_and_densities_of_the_functions),
        cmocka_unit_test(what_has_a_value_can_be_drawn_from_both_sides),
        cmocka_unit_test(a_specular_draw_can_be_made_from_the_other_side),
        cmocka_unit_test(mollified_densities_tend_to_the_elastic_one_and_average_to_it),
    };
    return cmocka_run_group_tests_name("material, over the kinds", tests, NULL, NULL);
}
