/* Weights by walking the cuts outward from the one that was drawn: each step exchanges one light-side density for one
   camera-side density. mis_cut_density is the plain product beside it, which the tests hold it against. */
#include "integrator/link.h"

static void copy_step(struct full_step *step, const struct vertex *v, enum side side)
{
    step->fwd = side == SIDE_LIGHT ? v->pdf_own : v->pdf_other;
    step->rev = side == SIDE_LIGHT ? v->pdf_other : v->pdf_own;
    step->label = v->label;
    step->disperses = v->disperses;
    step->dye = v->kind == VERTEX_SURFACE && v->label == LABEL_FLUORESCENT
                    ? surface_fluorophore(&v->surface, v->lobe)
                    : -1;
}

void full_path_copy(struct full_path *path, const struct subpath *light, int s, const struct subpath *camera,
                    int t, int edges)
{
    path->edges = edges;
    path->cut = s;
    for (int i = 0; i < s; i++) {
        const struct vertex *v = &light->vertex[i];
        copy_step(&path->step[i], v, SIDE_LIGHT);
        path->step[i].geometry = v->geometry;
        path->step[i + 1].lambda = v->lambda_out;
    }
    for (int j = 0; j < t; j++) {
        const struct vertex *v = &camera->vertex[j];
        struct full_step *step = &path->step[edges - j];
        copy_step(step, v, SIDE_CAMERA);
        step->lambda = v->lambda_out;
        if (j > 0)
            step[1].geometry = v->geometry;
    }
    if (s > 0) {
        path->pdf_point = light->vertex[0].pdf_point;
        path->light = &light->vertex[0].light;
    }
}

double mis_weight(const struct integrator *it, const struct full_path *path)
{
    const struct full_step *step = path->step;
    struct chart chart;
    int s = path->cut;
    if (it->exact)
        chart_runs(path, &chart);
    double own = link_factor(it, path, &chart, s), sum = own;
    double sub_paths = 1; /* densities of the two sub-paths of a cut over those of cut s */
    for (int c = s; c < path->edges; c++) {
        /* Cut c + 1: vertex c joins the light sub-path, vertex c + 1 leaves the camera's. */
        sub_paths *= (c == 0 ? path->pdf_point : step[c - 1].fwd) / step[c + 1].rev;
        if (!(sub_paths > 0))
            break;
        sum += sub_paths * link_factor(it, path, &chart, c + 1);
    }
    sub_paths = 1;
    for (int c = s; c > 0; c--) {
        sub_paths *= step[c].rev / (c == 1 ? path->pdf_point : step[c - 2].fwd);
        if (!(sub_paths > 0))
            break;
        sum += sub_paths * link_factor(it, path, &chart, c - 1);
    }
    return sum > 0 ? own / sum : 0;
}

double mis_cut_density(const struct integrator *it, const struct full_path *path, int cut)
{
    struct chart chart;
    chart_runs(path, &chart);
    double density = link_factor(it, path, &chart, cut);
    for (int i = 0; i <= cut - 2; i++)
        density *= path->step[i].fwd;
    for (int i = cut + 1; i <= path->edges; i++)
        density *= path->step[i].rev;
    return cut > 0 ? density * path->pdf_point : density;
}
