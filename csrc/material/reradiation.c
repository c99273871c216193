/* A measured diffuse surface: f = 1/π [δ(λi − λo) r(λi) + M(λi→λo)], from its reradiation matrix. Both are constant within a band (bands.h).
   A measured diagonal holds what is reflected and what is re-emitted into its own band: they are told apart by the diagonal's neighbours. */
#include <math.h>
#include <stdlib.h>

#include "material/bands.h"

enum { DIAGONAL_BOTH, DIAGONAL_ELASTIC };

/* A cut is worth a warning if it takes away more than this share of what would be re-emitted, or reflected. */
#define CUT_NOTICED 1e-3

/* The matrix while it is taken apart. Incident band `in` shows itself in outgoing band in + shift. */
struct parts {
    struct compiler *compiler;
    stokes_matrix *fluorescent; /* its diagonal: re-emitted */
    float *reflected;           /* by incident band */
    int first, end;             /* incident bands whose reflection is known */
    int shift;
};

static float share_at(const stokes_matrix *m, int out, int in)
{
    return out >= 0 && out < m->count_out && in >= 0 && in < m->count_in ? m->share[out * m->count_in + in]
                                                                         : -1;
}

/* What incident band `in` re-emits into its own: the mean of the neighbours off the diagonal. For a smooth ã(λi) e(λo) that is right to
   second order in the bands' width. */
static float own_light(const stokes_matrix *m, int out, int in)
{
    const float beside[4] = {share_at(m, out - 1, in), share_at(m, out + 1, in), share_at(m, out, in - 1),
                             share_at(m, out, in + 1)};
    float sum = 0;
    int count = 0;
    for (int i = 0; i < 4; i++)
        if (beside[i] >= 0) {
            sum += beside[i];
            count++;
        }
    return count > 0 ? sum / (float)count : 0;
}

static void split_diagonal(struct parts *p, const stokes_matrix *whole, bool elastic)
{
    double most = 0;
    for (int in = p->first; in < p->end; in++) {
        int out = in + p->shift;
        float all = share_at(whole, out, in), own = elastic ? 0 : fminf(own_light(whole, out, in), all);
        p->fluorescent->share[out * whole->count_in + in] = own;
        most = fmax(most, all - own);
        p->reflected[in] = fminf(all - own, 1);
    }
    if (most > 1 + CUT_NOTICED)
        compiler_warn(p->compiler, "matrix", "reflects up to %.3g of what arrives; cut to 1", most);
    for (int in = 0; in < whole->count_in; in++)
        if (p->first < p->end && (in < p->first || in >= p->end))
            p->reflected[in] = p->reflected[in < p->first ? p->first : p->end - 1];
}

/* The factor on what band `in` re-emits that keeps energy, r + ΣM ≤ 1, and photons, r + ΣM λo/λi ≤ 1 for the band's shortest λi. */
static float conserving(const struct parts *p, int in, double *energy)
{
    const stokes_matrix *m = p->fluorescent;
    double photons = 0, room = 1 - p->reflected[in];
    double shortest = m->first_in_nm + (in - 0.5) * m->step_nm;
    *energy = 0;
    for (int out = 0; out < m->count_out; out++) {
        double share = m->share[out * m->count_in + in];
        *energy += share;
        photons += share * (m->first_out_nm + out * m->step_nm) / shortest;
    }
    double most = fmax(*energy, photons);
    return most > room ? (float)(room / most) : 1;
}

static void conserve(struct parts *p)
{
    stokes_matrix *m = p->fluorescent;
    double all = 0, kept = 0, energy;
    int cut = 0;
    for (int in = 0; in < m->count_in; in++) {
        float factor = conserving(p, in, &energy);
        for (int out = 0; factor < 1 && out < m->count_out; out++)
            m->share[out * m->count_in + in] *= factor;
        all += energy;
        kept += energy * factor;
        cut += factor < 1;
    }
    if (kept < all * (1 - CUT_NOTICED))
        compiler_warn(p->compiler, "matrix",
                      "gives more energy or photons than arrive in %d of %d incident bands; %.3g %% of the "
                      "emission is cut",
                      cut, m->count_in, 100 * (1 - kept / all));
}

/* --- Spectra that are constant within bands ------------------------------------------------------------------ */

static struct spectrum *banded(struct range range, const float *edge, const float *value, int count,
                               double scale, enum beyond beyond)
{
    float *lambda = malloc(4 * (size_t)count * sizeof *lambda), *knot = lambda + 2 * (size_t)count;
    size_t n = 0;
    if (!lambda)
        return NULL;
    for (int i = 0; i < count; i++)
        for (int side = 0; edge[i + 1] > edge[i] && side < 2; side++) {
            lambda[n] = edge[i + side];
            knot[n++] = (float)(value[i] * scale);
        }
    struct spectrum *s =
        n ? spectrum_table(range, lambda, knot, n, beyond, "matrix", NULL) : spectrum_constant(range, 0);
    free(lambda);
    return s;
}

static struct spectrum *reflectance_of(const struct parts *p, struct range range)
{
    const stokes_matrix *m = p->fluorescent;
    int count = p->end - p->first;
    float *edge = malloc(((size_t)count + 1) * sizeof *edge);
    struct spectrum *s = NULL;
    for (int i = 0; edge && i <= count; i++)
        edge[i] = (float)(m->first_in_nm + (p->first + i - 0.5) * m->step_nm);
    if (edge)
        s = count ? banded(range, edge, p->reflected + p->first, count, 1, BEYOND_HOLD)
                  : spectrum_constant(range, 0);
    free(edge);
    return s;
}

/* The marginals, by which other tables may draw (algorithm.md §5): all that is re-emitted at λo under even light, and ã(λi). */
static bool make_marginals(struct fluorophore *f, struct range range)
{
    const struct band_table *t = f->bands;
    f->reradiation = banded(range, t->edge_in, t->from_light.sum, t->count_in, 1, BEYOND_ZERO);
    f->strength = f->reradiation ? spectrum_integral(f->reradiation) : 0;
    f->emission = banded(range, t->edge_out, t->from_camera.sum, t->count_out,
                         f->strength > 0 ? 1 / f->strength : 0, BEYOND_ZERO);
    return f->reradiation && f->emission;
}

/* --- Compiling ----------------------------------------------------------------------------------------------- */

static void free_spectrum(void *spectrum)
{
    spectrum_destroy(spectrum);
}

static bool shade_reflected(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    (void)in;
    lobe->color[0] = spectral_of(plan->data);
    lobe->kind = &lobe_diffuse;
    return true;
}

static bool shade_reradiated(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    (void)plan, (void)in;
    lobe->kind = &lobe_fluorescent;
    return true;
}

static bool add_reflected(struct compiler *compiler, const struct closure *closure, const struct parts *p)
{
    struct spectrum *r = reflectance_of(p, compiler_range(compiler));
    if (!r)
        return compiler_fail(compiler, "matrix", "out of memory");
    if (spectrum_max(r) > 0)
        return compiler_add(compiler, closure, shade_reflected, r, free_spectrum);
    spectrum_destroy(r);
    return true;
}

static bool add_reradiated(struct compiler *compiler, const struct closure *closure, const struct parts *p)
{
    struct range range = compiler_range(compiler);
    struct fluorophore *f = calloc(1, sizeof *f);
    if (!f)
        return compiler_fail(compiler, "matrix", "out of memory");
    f->index = -1;
    f->bands = band_table_create(p->fluorescent, range);
    if (!f->bands || !make_marginals(f, range)) {
        fluorophore_destroy(f);
        return compiler_fail(compiler, "matrix", "out of memory");
    }
    if (!(f->strength > 0)) {
        fluorophore_destroy(f);
        return true;
    }
    struct lobe_plan *plan = compiler_add(compiler, closure, shade_reradiated, f, fluorophore_destroy);
    if (plan)
        plan->fluorophore = f;
    return plan != NULL;
}

static bool compile(struct compiler *compiler, const struct closure *closure)
{
    const stokes_matrix *whole = closure->matrix;
    struct parts p = {.compiler = compiler, .shift = reradiation_shift(whole)};
    p.first = p.shift < 0 ? -p.shift : 0;
    p.end = whole->count_out - p.shift < whole->count_in ? whole->count_out - p.shift : whole->count_in;
    if (p.end < p.first)
        p.end = p.first;
    p.fluorescent = reradiation_copy(whole);
    p.reflected = calloc((size_t)whole->count_in, sizeof *p.reflected);
    bool good = p.fluorescent && p.reflected;
    if (good) {
        split_diagonal(&p, whole, closure->option[0] == DIAGONAL_ELASTIC);
        conserve(&p);
        good = add_reradiated(compiler, closure, &p) && add_reflected(compiler, closure, &p);
    } else {
        compiler_fail(compiler, "matrix", "out of memory");
    }
    reradiation_destroy(p.fluorescent);
    free(p.reflected);
    return good;
}

const struct bsdf_kind bsdf_reradiation_matrix = {
    .signature = {.name = "reradiation_matrix",
                  .option_names = {"diagonal"},
                  .option_choices = {{"both", "elastic"}},
                  .takes_matrix = true},
    .compile = compile,
};
