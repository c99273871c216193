/* Weights by walking the cuts outward from the one that was drawn: each step exchanges one light-side density for one
   camera-side density. mis_cut_density is the plain product beside it, which the tests hold it against. */
#include "integrator/mis.h"

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

/* The light counts as fluorescent (its spectrum is an emission), and so does the camera (p_cam is an absorption). */
static bool is_fluorescent(const struct full_path *path, int i)
{
    return i == 0 || i == path->edges || path->step[i].label == LABEL_FLUORESCENT;
}

static bool is_specular(const struct full_path *path, int i)
{
    return i > 0 && i < path->edges && path->step[i].label == LABEL_SPECULAR;
}

/* Density of the wavelength of edge c where both ends are fluorescent: drawn from the product e_Y ã_X / O. */
static double product_density(const struct integrator *it, const struct full_path *path, int c)
{
    const struct wavelengths *w = &it->wavelengths;
    int source = c == 1 ? path->light->light : wavelengths_source_dye(w, path->step[c - 1].dye);
    int sink = c == path->edges ? wavelengths_sink_camera(w) : path->step[c].dye;
    const struct spectral_histogram *product = wavelengths_product(w, source, sink);
    return product ? spectral_histogram_pdf(product, path->step[c].lambda) : 0;
}

/* What cut c has beside the densities of its two sub-paths: how the connecting edge got its wavelength (algorithm.md §5, table),
   and 1/G of the edge that no sub-path made. 0 where the cut is impossible. */
static double link_factor(const struct integrator *it, const struct full_path *path, int c)
{
    int t = path->edges + 1 - c;
    if (!it->settings.technique[c][t])
        return 0;
    if (c == 0)
        return path->light->delta ? 0 : 1;
    if (is_specular(path, c - 1) || is_specular(path, c))
        return 0;
    if (path->edges == 1 && !scene_light_seen_by_camera(it->scene, path->light))
        return 0;
    int fluorescent_ends = is_fluorescent(path, c - 1) + is_fluorescent(path, c);
    double wavelength = fluorescent_ends == 2   ? product_density(it, path, c)
                        : fluorescent_ends == 1 ? 1
                                                : 2 * (double)path->half_width_nm;
    return wavelength / path->step[c].geometry;
}

double mis_weight(const struct integrator *it, const struct full_path *path)
{
    const struct full_step *step = path->step;
    int s = path->cut;
    double own = link_factor(it, path, s), sum = own;
    double sub_paths = 1; /* densities of the two sub-paths of a cut over those of cut s */
    for (int c = s; c < path->edges; c++) {
        /* Cut c + 1: vertex c joins the light sub-path, vertex c + 1 leaves the camera's. */
        sub_paths *= (c == 0 ? path->pdf_point : step[c - 1].fwd) / step[c + 1].rev;
        if (!(sub_paths > 0))
            break;
        sum += sub_paths * link_factor(it, path, c + 1);
    }
    sub_paths = 1;
    for (int c = s; c > 0; c--) {
        sub_paths *= step[c].rev / (c == 1 ? path->pdf_point : step[c - 2].fwd);
        if (!(sub_paths > 0))
            break;
        sum += sub_paths * link_factor(it, path, c - 1);
    }
    return sum > 0 ? own / sum : 0;
}

double mis_cut_density(const struct integrator *it, const struct full_path *path, int cut)
{
    double density = link_factor(it, path, cut);
    for (int i = 0; i <= cut - 2; i++)
        density *= path->step[i].fwd;
    for (int i = cut + 1; i <= path->edges; i++)
        density *= path->step[i].rev;
    return cut > 0 ? density * path->pdf_point : density;
}
