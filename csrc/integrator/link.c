/* Link factors of the mollified table (algorithm.md §5) and of the exact one (§9). */
#include "integrator/link.h"

#include <math.h>

/* The light counts as fluorescent (its spectrum is an emission), and so does the camera (p_cam is an absorption). */
static bool is_fluorescent(const struct full_path *path, int i)
{
    return i == 0 || i == path->edges || path->step[i].label == LABEL_FLUORESCENT;
}

static bool is_specular(const struct full_path *path, int i)
{
    return i > 0 && i < path->edges && path->step[i].label == LABEL_SPECULAR;
}

void chart_runs(const struct full_path *path, struct chart *chart)
{
    struct chart_end at = {0, false};
    for (int y = 0; y < path->edges; y++) {
        if (is_fluorescent(path, y))
            at = (struct chart_end){y, false};
        chart->from_light[y] = at;
        at.disperses |= y > at.start && path->step[y].disperses;
    }
    at = (struct chart_end){path->edges, false};
    for (int x = path->edges; x > 0; x--) {
        if (is_fluorescent(path, x))
            at = (struct chart_end){x, false};
        chart->from_camera[x] = at;
        at.disperses |= x < at.start && path->step[x].disperses;
    }
}

/* --- Densities of wavelengths ------------------------------------------------------------------------------ */

/* Density of the wavelength of edge c from the product of what vertex y emits and x takes. */
static double product_density(const struct integrator *it, const struct full_path *path, int source, int x,
                              int c)
{
    const struct wavelengths *w = &it->wavelengths;
    int sink = x == path->edges ? wavelengths_sink_camera(w) : path->step[x].dye;
    const struct spectral_histogram *product = wavelengths_product(w, source, sink);
    return product ? spectral_histogram_pdf(product, path->step[c].lambda) : 0;
}

static int source_at(const struct integrator *it, const struct full_path *path, int y)
{
    return y == 0 ? scene_light_shape(it->scene, path->light->light)
                  : wavelengths_source_dye(&it->wavelengths, path->step[y].dye);
}

/* What F vertex y's light-side step had as density of its wavelength, that of edge y + 1. */
static double emitted_density(const struct integrator *it, const struct full_path *path, int y)
{
    float lambda = path->step[y + 1].lambda;
    return y == 0 ? scene_pdf_light_lambda(it->scene, path->light, lambda)
                  : scene_fluorophore_pdf_emitted(it->scene, path->step[y].dye, path->step[y].lambda, lambda);
}

/* The same of F vertex x's camera-side step, edge x. */
static double absorbed_density(const struct integrator *it, const struct full_path *path, int x)
{
    float lambda = path->step[x].lambda;
    return x == path->edges ? spectrum_pdf(it->wavelengths.camera, lambda)
                            : scene_fluorophore_pdf_absorbed(it->scene, path->step[x].dye, lambda,
                                                             path->step[x + 1].lambda);
}

/* --- The two tables ------------------------------------------------------------------------------------------ */

static double mollified_wavelength(const struct integrator *it, const struct full_path *path, int c)
{
    if (it->settings
            .shared_wavelength) /* drawn once, by the camera, whose density a sub-path of its own holds already */
        return c == path->edges ? spectrum_pdf(it->wavelengths.camera, path->step[c].lambda) : 1;
    switch (is_fluorescent(path, c - 1) + is_fluorescent(path, c)) {
    case 2: return product_density(it, path, source_at(it, path, c - 1), c, c);
    case 1: return 1;
    default: return path->reach_nm;
    }
}

double copy_own_chance(const struct integrator *it)
{
    return it->wavelengths.fluorophores ? 0.5 : 0;
}

double copy_run_chance(const struct integrator *it, int run)
{
    return it->wavelengths.fluorophores ? ldexp(0.5, -run - 1) : run == 0;
}

static int fluorescent_between(const struct full_path *path, int first, int last)
{
    int count = 0;
    for (int i = first; i <= last; i++)
        count += path->step[i].label == LABEL_FLUORESCENT;
    return count;
}

/* The four rows of §9, as a factor on the two sub-paths' own densities: those hold the draw of y's side if its run began before y,
   and of x's if it began before x. */
static double exact_wavelength(const struct integrator *it, const struct full_path *path,
                               const struct chart *chart, int c)
{
    struct chart_end x = chart->from_camera[c > 0 ? c : 1];
    struct chart_end y = c > 0 ? chart->from_light[c - 1] : (struct chart_end){0, false};
    if (c == 0) {
        /* The camera's part is the whole run: it includes x_1. */
        if (x.disperses || (x.start > 1 && path->step[1].disperses))
            return 1;
        double drawn = absorbed_density(it, path, x.start);
        return drawn > 0 ? product_density(it, path, source_at(it, path, 0), x.start, 1) / drawn : 0;
    }
    double drawn_by_light = y.start < c - 1 ? emitted_density(it, path, y.start) : 1;
    double drawn_by_camera = x.start > c ? absorbed_density(it, path, x.start) : 1;
    if (!(drawn_by_light > 0) || !(drawn_by_camera > 0))
        return 0;
    if (y.disperses && x.disperses)
        return pow(copy_own_chance(it), fluorescent_between(path, 1, y.start)) *
               copy_run_chance(it, fluorescent_between(path, x.start, path->edges - 1)) / drawn_by_light;
    if (x.disperses)
        return 1 / drawn_by_light;
    if (y.disperses)
        return 1 / drawn_by_camera;
    return product_density(it, path, source_at(it, path, y.start), x.start, c) /
           (drawn_by_light * drawn_by_camera);
}

double link_factor(const struct integrator *it, const struct full_path *path, const struct chart *chart,
                   int c)
{
    if (!it->settings.technique[c][path->edges + 1 - c])
        return 0;
    if (c == 0)
        return path->light->delta ? 0 : it->exact ? exact_wavelength(it, path, chart, 0) : 1;
    if (is_specular(path, c - 1) || is_specular(path, c) || (c >= 2 && !path->step[1].begins))
        return 0;
    /* The light seen by the camera itself: joint_camera_vertex makes no such path to a distant one. */
    if (path->edges == 1 && (path->light->distant || !scene_light_seen_by_camera(it->scene, path->light)))
        return 0;
    return (it->exact ? exact_wavelength(it, path, chart, c) : mollified_wavelength(it, path, c)) *
           technique_trust(it, c, path->edges + 1 - c) / path->step[c].geometry;
}
