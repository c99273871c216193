/* The recursion of algorithm.md §12. With Q_i the sum over the cuts 0 … i of their densities over that of the sub-path's own first i + 1
   vertices, Q_i = (link(i) + other_i Q_{i-1})/own_{i-1}; arrivals keep Q_{i-1}/own_{i-1} and 1/(own_{i-1} G_i). */
#include "integrator/tally.h"

#include <math.h>
#include <string.h>

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
    int lanes;
};

static void tally_clear(struct tally *t, int lanes)
{
    for (int i = 0; i < lanes; i++)
        t->closed[i] = t->open[i] = t->near[i] = t->bent[i] = t->both[i] = 0;
}

/* The light itself: the cut s = 0, where the camera sub-path meets it. */
static void through_light(const struct integrator *it, const struct vertex *light, int lanes, struct tally *q)
{
    tally_clear(q, lanes);
    double *sum = it->exact ? q->open : q->closed;
    if (!light->light.delta)
        for (int i = 0; i < lanes; i++)
            sum[i] = 1 / (double)light->pdf_point;
}

/* The mollified table (algorithm.md §5). */
static void through_mollified(const struct integrator *it, const struct worker *w, const struct passing *p,
                              const struct arrival *here, const uint8_t from[], const float other[],
                              struct tally *q)
{
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
    for (int i = 0; i < p->lanes; i++) {
        int k = from[i];
        double seam = p->label == LABEL_SPECULAR ? 0 : here->seam[k] * link[k];
        q->closed[i] = (double)other[i] * here->tally.closed[k] + seam;
    }
}

/* An elastic or δ vertex of a run that goes on (algorithm.md §9). What lay open before a dispersive vertex now has a part on the other
   side that disperses. */
static void through_run(const struct passing *p, const struct arrival *here, const uint8_t from[],
                        const float other[], struct tally *q)
{
    const struct tally *t = &here->tally;
    for (int i = 0; i < p->lanes; i++) {
        int k = from[i];
        double b = other[i], seam = p->label == LABEL_SPECULAR ? 0 : here->seam[k];
        q->closed[i] = b * (t->closed[k] + (p->disperses ? t->open[k] : 0));
        q->open[i] = p->disperses ? 0 : b * t->open[k];
        q->near[i] = p->disperses ? 0 : b * t->near[k];
        q->bent[i] = b * t->bent[k];
        q->both[i] = b * t->both[k];
        if (p->disperses && p->side == SIDE_LIGHT)
            q->both[i] += over(b * t->near[k], here->draw[k]);
        if (p->disperses && p->side == SIDE_CAMERA)
            q->bent[i] += b * t->near[k];
        if (here->disperses_early)
            q->near[i] += seam;
        else
            q->open[i] += here->first ? seam : over(seam, here->draw[k]);
    }
}

/* The F vertex (or, from the camera, the light) where a run ends: all of it is known now. `far` is the density with which this vertex would
   have drawn the run's wavelength from its own side. */
static void through_dye(const struct integrator *it, const struct passing *p, const struct arrival *here,
                        const uint8_t from[], const float other[], const float far[], struct tally *q)
{
    const struct tally *t = &here->tally;
    double product[LANES_MAX];
    product_densities(it, p->side == SIDE_LIGHT ? here->origin : p->partner,
                      p->side == SIDE_LIGHT ? p->partner : here->origin, it->lanes, here->lambda, product);
    tally_clear(q, p->lanes);
    for (int i = 0; i < p->lanes; i++) {
        int k = from[i];
        double b = other[i], seam = here->seam[k];
        q->closed[i] = b * (t->closed[k] + over(t->open[k] * product[k] + t->near[k], far[i]));
        q->both[i] = b * (t->both[k] + over(t->bent[k], far[i]));
        q->closed[i] += here->disperses_early ? seam
                        : here->first         ? seam * product[k]
                                              : over(seam * product[k], here->draw[k]);
    }
}

/* Q at vertex v with a label. `lobe` is the fluorescent one, if it is. */
static void through(const struct integrator *it, const struct worker *w, enum side side,
                    const struct vertex *v, const struct arrival *here, struct passing p, int lobe,
                    const uint8_t from[], const struct surface_steps *steps, struct tally *q)
{
    enum side across = side == SIDE_LIGHT ? SIDE_CAMERA : SIDE_LIGHT;
    p.side = side;
    if (v->kind == VERTEX_LIGHT) {
        through_light(it, v, p.lanes, q);
        return;
    }
    if (v->kind == VERTEX_CAMERA || it->cuts != CUTS_ALL) {
        tally_clear(q, p.lanes);
        return;
    }
    if (p.label == LABEL_FLUORESCENT)
        p.partner = wavelengths_dye(&it->wavelengths, across, surface_fluorophore(&v->surface, lobe));
    if (!it->exact) {
        through_mollified(it, w, &p, here, from, steps->pdf_other, q);
    } else if (p.label != LABEL_FLUORESCENT) {
        through_run(&p, here, from, steps->pdf_other, q);
    } else {
        through_dye(it, &p, here, from, steps->pdf_other, steps->draw_other, q);
    }
}

void tally_pass(const struct integrator *it, const struct worker *w, enum side side, const struct vertex *v,
                const struct arrival *here, const uint8_t from[], const struct surface_steps *steps,
                struct arrival *there)
{
    struct passing p = {.label = v->label, .disperses = v->disperses, .lanes = there->lanes};
    struct tally *q = &there->tally;
    /* The next edge as a cut, s or t = 1 if this is its side's end, of a path that goes on beyond it. */
    double rate = technique_rate(it, side == SIDE_LIGHT && v->kind == VERTEX_LIGHT ? 1 : 2,
                                 side == SIDE_CAMERA && v->kind == VERTEX_CAMERA ? 1 : 2);
    through(it, w, side, v, here, p, v->lobe, from, steps, q);
    for (int i = 0; i < there->lanes; i++) {
        double inverse = steps->pdf[i] > 0 ? 1 / (double)steps->pdf[i] : 0;
        there->seam[i] = v->kind == VERTEX_SURFACE && v->label == LABEL_SPECULAR ? 0 : rate * inverse;
        q->closed[i] *= inverse;
        q->open[i] *= inverse;
        q->near[i] *= inverse;
        q->bent[i] *= inverse;
        q->both[i] *= inverse;
    }
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

static const uint8_t straight[LANES_MAX] = {0, 1, 2, 3, 4, 5, 6, 7};

/* What an end brings to the connecting run. */
struct part {
    bool is_start;  /* the run begins at this end */
    bool disperses; /* between its start and the end */
    bool bends;     /* the end itself disperses */
    struct tally q;
};

static struct part part_of(const struct integrator *it, const struct worker *w, const struct joint *j,
                           enum side side)
{
    const struct joint_end *end = &j->end[side];
    struct part part = {.is_start = end->as.label == LABEL_FLUORESCENT, .bends = end->disperses};
    struct passing p = {.label = end->as.label, .disperses = end->disperses, .lanes = j->lanes};
    part.disperses = !part.is_start && end->at->disperses;
    through(it, w, side, end->vertex, end->at, p, end->as.lobe, straight, &end->steps, &part.q);
    return part;
}

/* Density of the connecting run's wavelength for the cut at hand (§9's four rows). */
static double exact_link(const struct part *y, const struct part *x, double product, double draw_y,
                         double draw_x, double copy)
{
    double by_light = y->is_start ? 1 : draw_y, by_camera = x->is_start ? 1 : draw_x;
    if (y->disperses && x->disperses)
        return over(copy, draw_y);
    if (x->disperses)
        return over(1, by_light);
    if (y->disperses)
        return over(1, by_camera);
    return over(product, by_light * by_camera);
}

/* The sum over the cuts of one side, now that the other part of the run is known; `far` is that part's draw. */
static double close(const struct part *own, const struct part *far, int i, double product, double draw_far,
                    double copied, double copy)
{
    bool bends = far->disperses || far->bends;
    return own->q.closed[i] + (bends ? own->q.open[i] : over(own->q.open[i] * product, draw_far)) +
           (bends ? own->q.near[i] * copied : over(own->q.near[i], draw_far)) +
           over(own->q.bent[i] * copy, draw_far) + own->q.both[i] * copy;
}

static void weigh_exact(const struct integrator *it, const struct joint *j, const struct part *y,
                        const struct part *x, double weight[LANES_MAX])
{
    const struct joint_end *end_y = &j->end[SIDE_LIGHT], *end_x = &j->end[SIDE_CAMERA];
    double product[LANES_MAX], copy = copy_chance(it, j->dyes), rate = technique_rate(it, j->s, j->t);
    product_densities(it, j->source, j->sink, j->lanes, j->lambda, product);
    for (int i = 0; i < j->lanes; i++) {
        double draw_y = end_y->draw[i], draw_x = end_x->draw[i], copied = over(copy, draw_y);
        double link = exact_link(y, x, product[i], draw_y, draw_x, copy) * rate / (double)j->geometry;
        double others =
            end_x->across * (double)end_x->steps.pdf[i] * close(y, x, i, product[i], draw_x, copied, copy) +
            end_y->across * (double)end_y->steps.pdf[i] * close(x, y, i, product[i], draw_y, copied, copy);
        weight[i] = over(link, link + others);
    }
}

static void weigh_mollified(const struct integrator *it, const struct worker *w, const struct joint *j,
                            const struct part *y, const struct part *x, double weight[LANES_MAX])
{
    const struct joint_end *end_y = &j->end[SIDE_LIGHT], *end_x = &j->end[SIDE_CAMERA];
    double link[LANES_MAX];
    if (it->settings.shared_wavelength)
        link[0] = x->is_start ? end_x->draw[0] : 1;
    else if (y->is_start && x->is_start)
        product_densities(it, j->source, j->sink, j->lanes, j->lambda, link);
    else
        for (int i = 0; i < j->lanes; i++)
            link[i] = y->is_start || x->is_start ? 1 : w->reach_nm;
    for (int i = 0; i < j->lanes; i++) {
        double own = link[i] * technique_rate(it, j->s, j->t) / (double)j->geometry;
        double others = end_x->across * (double)end_x->steps.pdf[i] * y->q.closed[i] +
                        end_y->across * (double)end_y->steps.pdf[i] * x->q.closed[i];
        weight[i] = over(own, own + others);
    }
}

void tally_weigh(const struct integrator *it, const struct worker *w, const struct joint *j,
                 double weight[LANES_MAX])
{
    if (it->cuts == CUTS_ONE) {
        for (int i = 0; i < j->lanes; i++)
            weight[i] = 1;
        return;
    }
    struct part y = part_of(it, w, j, SIDE_LIGHT), x = part_of(it, w, j, SIDE_CAMERA);
    if (it->exact)
        weigh_exact(it, j, &y, &x, weight);
    else
        weigh_mollified(it, w, j, &y, &x, weight);
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
        technique_rate(it, 1, edges) / technique_rate(it, 2, edges); /* tally_pass took it for s = 2 */
    for (int i = 0; i < it->lanes; i++)
        here.seam[i] = connects ? at->seam[i] * rate / geometry : 0;
    if (it->has_volumes)
        tally_cross(&here, ahead, behind, it->lanes);
    if (it->exact)
        through_dye(it, &p, &here, straight, back, draw, &q);
    else
        through_mollified(it, w, &p, &here, straight, back, &q);
    double product[LANES_MAX], copy = copy_chance(it, at->dyes);
    product_densities(it, p.partner, at->origin, at->lanes, at->lambda, product);
    for (int i = 0; i < at->lanes; i++) {
        double own = !it->exact || at->disperses ? 1 : over(product[i], at->draw[i]);
        double others = pdf_point * (q.closed[i] + (it->exact ? copy * q.both[i] : 0));
        weight[i] = it->cuts == CUTS_ONE ? 1 : over(own, own + others);
    }
}
