/* The recursion of algorithm.md §12. With Q_i the sum over the cuts 0 … i of their densities over that of the sub-path's own first i + 1
   vertices, Q_i = (link(i) + other_i Q_{i-1})/own_{i-1}; arrivals keep Q_{i-1}/own_{i-1} and 1/(own_{i-1} G_i). */
#include "integrator/tally.h"

#include <math.h>

#include "integrator/joint.h"

void arrival_begin(struct arrival *at, int lanes, double throughput, int origin)
{
    at->lanes = 1;
    at->start = 0;
    at->first = at->disperses = at->disperses_early = false;
    at->dyes = 0;
    at->origin = origin;
    for (int i = 0; i < lanes; i++) {
        at->lambda[i] = at->draw[i] = 0;
        at->throughput[i] = throughput;
        at->seam[i] = 0;
    }
}

void arrival_fill(struct arrival *at, float lambda_film[LANES_MAX], int lanes)
{
    for (int i = at->lanes; i < lanes; i++) {
        at->lambda[i] = at->lambda[0];
        at->draw[i] = at->draw[0];
        at->throughput[i] = at->throughput[0];
        at->seam[i] = at->seam[0];
        at->tally.closed[i] = at->tally.closed[0];
        at->tally.open[i] = at->tally.open[0];
        at->tally.near[i] = at->tally.near[0];
        at->tally.bent[i] = at->tally.bent[0];
        at->tally.both[i] = at->tally.both[0];
        if (lambda_film)
            lambda_film[i] = lambda_film[0];
    }
}

void product_densities(const struct integrator *it, int source, int sink, int lanes, const float lambda[],
                       double out[LANES_MAX])
{
    const struct spectral_histogram *product = wavelengths_product(&it->wavelengths, source, sink);
    for (int i = 0; i < lanes; i++)
        out[i] = product ? spectral_histogram_pdf(product, lambda[i]) : 0;
}

bool draw_product(const struct integrator *it, const struct worker *w, int source, int sink,
                  uint32_t dimension, int lanes, float lambda[LANES_MAX], double density[LANES_MAX])
{
    const struct spectral_histogram *product = wavelengths_product(&it->wavelengths, source, sink);
    float u[LANES_MAX], pdf;
    if (!product)
        return false;
    lanes_stratify(random_at(w->random, dimension), lanes, u);
    for (int i = 0; i < lanes; i++) {
        lambda[i] = spectral_histogram_sample(product, u[i], &pdf);
        density[i] = pdf;
        if (!(pdf > 0))
            return false;
    }
    return true;
}

static double over(double a, double b)
{
    return b > 0 ? a / b : 0;
}

/* --- Through one vertex ------------------------------------------------------------------------------------------ */

/* How a vertex is passed, or ended at. */
struct passing {
    enum side side;
    enum label label;
    int partner; /* F: the sink (light side) or source (camera side) that it is for the run that ends here */
    bool disperses;
    int lanes, first; /* of those that arrived, so many from the first on */
};

LANES_INLINE void tally_clear(int lanes, struct tally *t)
{
    for (int i = 0; i < lanes; i++)
        t->closed[i] = t->open[i] = t->near[i] = t->bent[i] = t->both[i] = 0;
}

/* The light itself: the cut s = 0, where the camera sub-path meets it. */
static void through_light(const struct integrator *it, const struct vertex *light, int lanes, struct tally *q)
{
    tally_clear(lanes, q);
    double *sum = it->exact ? q->open : q->closed;
    if (!light->light.delta)
        for (int i = 0; i < lanes; i++)
            sum[i] = 1 / (double)light->pdf_point;
}

/* The mollified table (algorithm.md §5). */
LANES_INLINE void through_mollified(int lanes, const struct integrator *it, const struct worker *w,
                                    const struct passing *p, const struct arrival *here, const float other[],
                                    struct tally *restrict q)
{
    const double *seam = here->seam + p->first, *closed = here->tally.closed + p->first;
    bool dye_before = here->first, dye_here = p->label == LABEL_FLUORESCENT;
    double link[LANES_MAX];
    if (it->settings.shared_wavelength)
        link[0] = p->side == SIDE_CAMERA && here->first ? here->draw[0] : 1;
    else if (dye_before && dye_here)
        product_densities(it, p->side == SIDE_LIGHT ? here->origin : p->partner,
                          p->side == SIDE_LIGHT ? p->partner : here->origin, it->lanes, here->lambda, link);
    else
        for (int i = 0; i < it->lanes; i++)
            link[i] = dye_before || dye_here ? 1 : w->reach_nm;
    double linked = p->label == LABEL_SPECULAR ? 0 : 1;
    for (int i = 0; i < lanes; i++)
        q->closed[i] = (double)other[i] * closed[i] + linked * (seam[i] * link[p->first + i]);
}

/* An elastic or δ vertex of a run that goes on (algorithm.md §9). What lay open before a dispersive vertex now has a part on the other
   side that disperses. */
LANES_INLINE void through_run(int lanes, const struct passing *p, const struct arrival *here,
                              const float other[], struct tally *restrict q)
{
    const struct tally *t = &here->tally;
    const double *seam = here->seam + p->first, *closed = t->closed + p->first, *open = t->open + p->first,
                 *near = t->near + p->first, *bent = t->bent + p->first, *both = t->both + p->first;
    const float *draw = here->draw + p->first;
    for (int i = 0; i < lanes; i++) {
        q->closed[i] = other[i] * (closed[i] + (p->disperses ? open[i] : 0));
        q->open[i] = p->disperses ? 0 : other[i] * open[i];
        q->near[i] = p->disperses ? 0 : other[i] * near[i];
        q->bent[i] = other[i] * bent[i];
        q->both[i] = other[i] * both[i];
    }
    if (p->disperses && p->side == SIDE_LIGHT)
        for (int i = 0; i < lanes; i++)
            q->both[i] += over(other[i] * near[i], draw[i]);
    if (p->disperses && p->side == SIDE_CAMERA)
        for (int i = 0; i < lanes; i++)
            q->bent[i] += other[i] * near[i];
    if (p->label == LABEL_SPECULAR)
        return;
    if (here->disperses_early)
        for (int i = 0; i < lanes; i++)
            q->near[i] += seam[i];
    else
        for (int i = 0; i < lanes; i++)
            q->open[i] += here->first ? seam[i] : over(seam[i], draw[i]);
}

/* The F vertex (or, from the camera, the light) where a run ends: all of it is known now. `far` is the density with which this vertex would
   have drawn the run's wavelength from its own side. */
LANES_INLINE void through_dye(int lanes, const struct integrator *it, const struct passing *p,
                              const struct arrival *here, const float other[], const float far[],
                              struct tally *restrict q)
{
    const struct tally *t = &here->tally;
    const double *seam = here->seam + p->first, *closed = t->closed + p->first, *open = t->open + p->first,
                 *near = t->near + p->first, *bent = t->bent + p->first, *both = t->both + p->first;
    const float *draw = here->draw + p->first;
    double product[LANES_MAX];
    product_densities(it, p->side == SIDE_LIGHT ? here->origin : p->partner,
                      p->side == SIDE_LIGHT ? p->partner : here->origin, lanes, here->lambda + p->first,
                      product);
    tally_clear(lanes, q);
    for (int i = 0; i < lanes; i++) {
        q->closed[i] = other[i] * (closed[i] + over(open[i] * product[i] + near[i], far[i]));
        q->both[i] = other[i] * (both[i] + over(bent[i], far[i]));
    }
    if (here->disperses_early)
        for (int i = 0; i < lanes; i++)
            q->closed[i] += seam[i];
    else
        for (int i = 0; i < lanes; i++)
            q->closed[i] += over(seam[i] * product[i], here->first ? 1 : draw[i]);
}

/* Q at vertex v with a label. `lobe` is the fluorescent one, if it is. */
static void through(const struct integrator *it, const struct worker *w, enum side side,
                    const struct vertex *v, const struct arrival *here, struct passing p, int lobe,
                    const struct surface_steps *steps, struct tally *q)
{
    enum side across = side == SIDE_LIGHT ? SIDE_CAMERA : SIDE_LIGHT;
    p.side = side;
    if (v->kind == VERTEX_LIGHT) {
        through_light(it, v, p.lanes, q);
        return;
    }
    if (v->kind == VERTEX_CAMERA || it->cuts != CUTS_ALL) {
        LANES_CALL(tally_clear, p.lanes, q);
        return;
    }
    if (p.label == LABEL_FLUORESCENT)
        p.partner = wavelengths_dye(&it->wavelengths, across, surface_fluorophore(&v->surface, lobe));
    if (!it->exact)
        LANES_CALL(through_mollified, p.lanes, it, w, &p, here, steps->pdf_other, q);
    else if (p.label != LABEL_FLUORESCENT)
        LANES_CALL(through_run, p.lanes, &p, here, steps->pdf_other, q);
    else
        LANES_CALL(through_dye, p.lanes, it, &p, here, steps->pdf_other, steps->draw_other, q);
}

/* Over the density of the step that was made. `rate` is of the next edge as a cut. */
LANES_INLINE void depart(int lanes, const float pdf[], double rate, const struct tally *restrict q,
                         struct arrival *restrict there)
{
    for (int i = 0; i < lanes; i++) {
        double inverse = over(1, pdf[i]);
        there->seam[i] = rate * inverse;
        there->tally.closed[i] = q->closed[i] * inverse;
        there->tally.open[i] = q->open[i] * inverse;
        there->tally.near[i] = q->near[i] * inverse;
        there->tally.bent[i] = q->bent[i] * inverse;
        there->tally.both[i] = q->both[i] * inverse;
    }
}

void tally_pass(const struct integrator *it, const struct worker *w, enum side side, const struct vertex *v,
                const struct arrival *here, int first, const struct surface_steps *steps,
                struct arrival *there)
{
    struct passing p = {.label = v->label, .disperses = v->disperses, .lanes = there->lanes, .first = first};
    struct tally q;
    /* The next edge as a cut, s or t = 1 if this is its side's end, of a path that goes on beyond it. */
    double rate = technique_rate(it, side == SIDE_LIGHT && v->kind == VERTEX_LIGHT ? 1 : 2,
                                 side == SIDE_CAMERA && v->kind == VERTEX_CAMERA ? 1 : 2);
    if (v->kind == VERTEX_SURFACE && v->label == LABEL_SPECULAR)
        rate = 0;
    through(it, w, side, v, here, p, v->lobe, steps, &q);
    LANES_CALL(depart, there->lanes, steps->pdf, rate, &q, there);
}

void tally_cross(struct arrival *at, double ahead, double back, int lanes)
{
    double ratio = back / ahead;
    for (int i = 0; i < lanes; i++) {
        at->seam[i] /= ahead;
        at->tally.closed[i] *= ratio;
        at->tally.open[i] *= ratio;
        at->tally.near[i] *= ratio;
        at->tally.bent[i] *= ratio;
        at->tally.both[i] *= ratio;
    }
}

/* --- Closing a sum ----------------------------------------------------------------------------------------------- */

/* Nominal chance of copying in a path with so many F vertices, whichever of its runs it is (copy_run_chance). */
static double copy_chance(const struct integrator *it, int dyes)
{
    return it->wavelengths.fluorophores ? ldexp(1, -(dyes + 2)) : 1;
}

/* What an end brings to the connecting run. */
struct part {
    bool is_start;  /* the run begins at this end */
    bool disperses; /* between its start and the end */
    bool bends;     /* the end itself disperses */
    struct tally q;
};

static void part_of(const struct integrator *it, const struct worker *w, const struct joint *j,
                    enum side side, struct part *part)
{
    const struct joint_end *end = &j->end[side];
    struct passing p = {.label = end->as.label, .disperses = end->disperses, .lanes = j->lanes};
    part->is_start = end->as.label == LABEL_FLUORESCENT;
    part->bends = end->disperses;
    part->disperses = !part->is_start && end->at->disperses;
    through(it, w, side, end->vertex, end->at, p, end->as.lobe, &end->steps, &part->q);
    if (j->s == 1 && !vertex_begins_light_paths(end->vertex))
        LANES_CALL(tally_clear, j->lanes, &part->q);
}

/* Density of the connecting run's wavelength for the cut at hand (§9's four rows). */
LANES_INLINE void exact_link(int lanes, const struct part *y, const struct part *x, const double product[],
                             const float draw_y[], const float draw_x[], double copy, double link[restrict])
{
    bool starts_y = y->is_start, starts_x = x->is_start;
    if (y->disperses && x->disperses)
        for (int i = 0; i < lanes; i++)
            link[i] = over(copy, draw_y[i]);
    else if (x->disperses)
        for (int i = 0; i < lanes; i++)
            link[i] = over(1, starts_y ? 1 : draw_y[i]);
    else if (y->disperses)
        for (int i = 0; i < lanes; i++)
            link[i] = over(1, starts_x ? 1 : draw_x[i]);
    else
        for (int i = 0; i < lanes; i++)
            link[i] = over(product[i], (starts_y ? 1 : (double)draw_y[i]) * (starts_x ? 1 : draw_x[i]));
}

/* The sum over the cuts of one side, now that the other part of the run is known; `draw` is that part's, `draw_y` the light's. */
LANES_INLINE void close(int lanes, const struct part *own, const struct part *far, const double product[],
                        const float draw[], const float draw_y[], double copy, double sum[restrict])
{
    const struct tally *q = &own->q;
    if (far->disperses || far->bends)
        for (int i = 0; i < lanes; i++)
            sum[i] = q->closed[i] + q->open[i] + q->near[i] * over(copy, draw_y[i]);
    else
        for (int i = 0; i < lanes; i++)
            sum[i] = q->closed[i] + over(q->open[i] * product[i], draw[i]) + over(q->near[i], draw[i]);
    for (int i = 0; i < lanes; i++)
        sum[i] = sum[i] + over(q->bent[i] * copy, draw[i]) + q->both[i] * copy;
}

/* The weight of one cut beside the others of both sides. */
LANES_INLINE void weigh(int lanes, const struct joint *j, double rate, const double link[],
                        const double of_y[], const double of_x[], double weight[restrict])
{
    const struct joint_end *y = &j->end[SIDE_LIGHT], *x = &j->end[SIDE_CAMERA];
    for (int i = 0; i < lanes; i++) {
        double own = link[i] * rate / (double)j->geometry;
        double others =
            x->across * (double)x->steps.pdf[i] * of_y[i] + y->across * (double)y->steps.pdf[i] * of_x[i];
        weight[i] = over(own, own + others);
    }
}

LANES_INLINE void weigh_exact(int lanes, const struct integrator *it, const struct joint *j,
                              const struct part *y, const struct part *x, double weight[])
{
    const float *draw_y = j->end[SIDE_LIGHT].draw, *draw_x = j->end[SIDE_CAMERA].draw;
    double product[LANES_MAX], link[LANES_MAX], of_y[LANES_MAX], of_x[LANES_MAX];
    double copy = copy_chance(it, j->dyes);
    product_densities(it, j->source, j->sink, lanes, j->lambda, product);
    exact_link(lanes, y, x, product, draw_y, draw_x, copy, link);
    close(lanes, y, x, product, draw_x, draw_y, copy, of_y);
    close(lanes, x, y, product, draw_y, draw_y, copy, of_x);
    weigh(lanes, j, technique_trust(it, j->s, j->t), link, of_y, of_x, weight);
}

LANES_INLINE void weigh_mollified(int lanes, const struct integrator *it, const struct worker *w,
                                  const struct joint *j, const struct part *y, const struct part *x,
                                  double weight[])
{
    double link[LANES_MAX];
    if (it->settings.shared_wavelength)
        link[0] = x->is_start ? j->end[SIDE_CAMERA].draw[0] : 1;
    else if (y->is_start && x->is_start)
        product_densities(it, j->source, j->sink, lanes, j->lambda, link);
    else
        for (int i = 0; i < lanes; i++)
            link[i] = y->is_start || x->is_start ? 1 : w->reach_nm;
    weigh(lanes, j, technique_trust(it, j->s, j->t), link, y->q.closed, x->q.closed, weight);
}

void tally_weigh(const struct integrator *it, const struct worker *w, const struct joint *j,
                 double weight[LANES_MAX])
{
    if (it->cuts == CUTS_ONE) {
        for (int i = 0; i < j->lanes; i++)
            weight[i] = 1;
        return;
    }
    struct part y, x;
    part_of(it, w, j, SIDE_LIGHT, &y);
    part_of(it, w, j, SIDE_CAMERA, &x);
    if (it->exact)
        LANES_CALL(weigh_exact, j->lanes, it, j, &y, &x, weight);
    else
        LANES_CALL(weigh_mollified, j->lanes, it, w, j, &y, &x, weight);
}

void tally_weigh_sighting(const struct integrator *it, const struct worker *w, const struct arrival *at,
                          const struct light_point *light, double pdf_point, int edges, double geometry,
                          double ahead, double behind, const float back[], const float draw[],
                          double weight[LANES_MAX])
{
    struct passing p = {.side = SIDE_CAMERA,
                        .label = LABEL_FLUORESCENT,
                        .partner = scene_light_shape(it->scene, light->light),
                        .lanes = at->lanes};
    struct tally q;
    /* The light seen by the camera itself: no connection makes such a path to a distant one, and `pt_nee` none at all. */
    bool connects = it->cuts != CUTS_ONE && (edges > 1 || (it->cuts == CUTS_ALL && !light->distant &&
                                                           scene_light_seen_by_camera(it->scene, light)));
    struct arrival here = *at;
    double rate =
        technique_trust(it, 1, edges) / technique_trust(it, 2, edges); /* tally_pass took it for s = 2 */
    if (!vertex_begins_light_paths(&w->camera.vertex[edges - 1]))
        LANES_CALL(tally_clear, it->lanes, &here.tally);
    for (int i = 0; i < it->lanes; i++)
        here.seam[i] = connects ? at->seam[i] * rate / geometry : 0;
    if (it->has_volumes)
        tally_cross(&here, ahead, behind, it->lanes);
    if (it->exact)
        through_dye(at->lanes, it, &p, &here, back, draw, &q);
    else
        through_mollified(at->lanes, it, w, &p, &here, back, &q);
    double product[LANES_MAX], copy = copy_chance(it, at->dyes);
    product_densities(it, p.partner, at->origin, at->lanes, at->lambda, product);
    for (int i = 0; i < at->lanes; i++) {
        double own = !it->exact || at->disperses ? 1 : over(product[i], at->draw[i]);
        double others = pdf_point * (q.closed[i] + (it->exact ? copy * q.both[i] : 0));
        weight[i] = it->cuts == CUTS_ONE ? 1 : over(own, own + others);
    }
}
