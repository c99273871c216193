/* Plain weights: every cut's density is multiplied out. */
#include "integrator/mis.h"

#include "integrator/joint.h"
#include "integrator/link.h"
#include "integrator/relight.h"

/* One side of a path, walked from its end to its beginning; i counts its own vertices. */
static void put_step(struct full_path *path, enum side side, int i, float own, float other, float lambda)
{
    int at = side == SIDE_LIGHT ? i : path->edges - i;
    path->step[at].fwd = side == SIDE_LIGHT ? own : other;
    path->step[at].rev = side == SIDE_LIGHT ? other : own;
    path->step[side == SIDE_LIGHT ? at + 1 : at].lambda = lambda;
}

static void put_vertex(struct full_path *path, enum side side, int i, const struct vertex *v)
{
    struct full_step *step = &path->step[side == SIDE_LIGHT ? i : path->edges - i];
    step->label = v->label;
    step->disperses = v->disperses;
    step->in_volume = v->in_volume;
    step->begins = vertex_begins_light_paths(v);
    step->dye = v->kind == VERTEX_SURFACE && v->label == LABEL_FLUORESCENT
                    ? surface_fluorophore(&v->surface, v->lobe)
                    : -1;
}

/* The edge that ends at own vertex i. */
static void put_edge(struct full_path *path, enum side side, int i, const struct vertex *v)
{
    struct full_step *edge = &path->step[side == SIDE_LIGHT ? i : path->edges - i + 1];
    edge->geometry = v->geometry;
    edge->along = side == SIDE_LIGHT ? v->inside.ahead : v->inside.back;
    edge->against = side == SIDE_LIGHT ? v->inside.back : v->inside.ahead;
}

/* The first `count` own vertices, all passed, with the lane that has this place among those that arrive at vertex `count`. */
static void put_side(struct full_path *path, enum side side, const struct subpath *own, int count,
                     const struct strand *strand, int lane)
{
    for (int i = count - 1; i >= 0; i--) {
        const struct vertex *v = &own->vertex[i];
        put_vertex(path, side, i, v);
        if (i > 0)
            put_edge(path, side, i, v);
        if (strand && i >= strand->start) {
            put_step(path, side, i, strand->own[i][lane], strand->other[i][lane],
                     strand->at[i + 1].lambda[lane]);
            continue;
        }
        int out = lane < v->lanes_out ? lane : 0;
        put_step(path, side, i, v->own[out], v->other[out], v->lambda_out[out]);
        lane = v->from[out];
    }
}

static void put_end(struct full_path *path, const struct joint_end *end, enum side side, int i, int lane)
{
    struct full_step *step = &path->step[side == SIDE_LIGHT ? i : path->edges - i];
    double own = end->steps.pdf[lane], other = end->steps.pdf_other[lane];
    step->fwd = side == SIDE_LIGHT ? own : other;
    step->rev = side == SIDE_LIGHT ? other : own;
    step->label = end->as.label;
    step->disperses = end->disperses;
    step->in_volume = end->vertex->in_volume;
    step->begins = vertex_begins_light_paths(end->vertex);
    step->dye = end->vertex->kind == VERTEX_SURFACE && end->as.label == LABEL_FLUORESCENT
                    ? surface_fluorophore(&end->vertex->surface, end->as.lobe)
                    : -1;
    if (i > 0)
        put_edge(path, side, i, end->vertex);
}

void full_path_of_joint(const struct integrator *it, const struct worker *w, const struct joint *joint,
                        int lane, struct full_path *path)
{
    const struct joint_end *y = &joint->end[SIDE_LIGHT], *x = &joint->end[SIDE_CAMERA];
    (void)it;
    path->edges = joint->s + joint->t - 1;
    path->cut = joint->s;
    path->reach_nm = w->reach_nm;
    path->light = &y->path->vertex[0].light;
    path->pdf_point = y->path->vertex[0].pdf_point;
    put_side(path, SIDE_LIGHT, y->path, joint->s - 1, y->strand, joint->lane[SIDE_LIGHT][lane]);
    put_side(path, SIDE_CAMERA, x->path, joint->t - 1, x->strand, joint->lane[SIDE_CAMERA][lane]);
    put_end(path, y, SIDE_LIGHT, joint->s - 1, lane);
    put_end(path, x, SIDE_CAMERA, joint->t - 1, lane);
    path->step[joint->s].geometry = joint->geometry;
    path->step[joint->s].along = y->across;
    path->step[joint->s].against = x->across;
    path->step[joint->s].lambda = joint->lambda[lane];
}

void full_path_of_camera(const struct worker *w, const struct subpath *camera, int edges,
                         const struct strand *strand, int lane, struct full_path *path)
{
    path->edges = edges;
    path->cut = 0;
    path->reach_nm = w->reach_nm;
    put_side(path, SIDE_CAMERA, camera, edges, strand, lane);
}

double mis_weight(const struct integrator *it, const struct full_path *path)
{
    double own = mis_cut_density(it, path, path->cut), sum = 0;
    for (int cut = 0; cut <= path->edges; cut++)
        sum += mis_cut_density(it, path, cut);
    return sum > 0 ? own / sum : 0;
}

void mis_weigh_plainly(const struct integrator *it, const struct worker *w, const struct joint *joint,
                       double weight[LANES_MAX])
{
    struct full_path path;
    for (int i = 0; i < joint->lanes; i++) {
        full_path_of_joint(it, w, joint, i, &path);
        weight[i] = mis_weight(it, &path);
    }
}

static double cut_density(const struct integrator *it, const struct full_path *path,
                          const struct chart *chart, int cut)
{
    double density = link_factor(it, path, chart, cut);
    for (int i = 0; i <= cut - 2; i++)
        density *= path->step[i].fwd * path->step[i + 1].along;
    for (int i = cut + 1; i <= path->edges; i++)
        density *= path->step[i].rev * path->step[i].against;
    return cut > 0 ? density * path->pdf_point : density;
}

double mis_cut_density(const struct integrator *it, const struct full_path *path, int cut)
{
    struct chart chart;
    chart_runs(path, &chart);
    return cut_density(it, path, &chart, cut);
}

bool mis_shares(const struct integrator *it, const struct full_path *path, double share[TECHNIQUE_KINDS])
{
    struct chart chart;
    double sum = 0;
    chart_runs(path, &chart);
    for (int kind = 0; kind < TECHNIQUE_KINDS; kind++)
        share[kind] = 0;
    for (int cut = 0; cut <= path->edges; cut++) {
        double density = cut_density(it, path, &chart, cut);
        share[technique_kind(cut, path->edges + 1 - cut)] += density;
        sum += density;
    }
    for (int kind = 0; kind < TECHNIQUE_KINDS; kind++)
        share[kind] /= sum;
    return sum > 0 && isfinite(sum);
}
