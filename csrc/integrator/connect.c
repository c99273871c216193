/* Connections of the mollified method: each pair of labels is one labelled path with its own wavelength on the edge, its own value
   and its own weight; they share geometry and shadow ray. */
#include "integrator/connect.h"

#include "integrator/joint.h"

/* The end of an E–E connection that takes the kernel: evaluated at the incident wavelength (f_mo, eq. 16), with the densities of
   eqs. 25–26 in labelled space (algorithm.md §6). The kernel itself multiplies elsewhere. */
static struct end mollified_end(const struct vertex *v, enum side own, struct vec3 to_other,
                                float lambda_edge, float half_width_nm)
{
    enum side other = own == SIDE_LIGHT ? SIDE_CAMERA : SIDE_LIGHT;
    struct vec3 to_light = own == SIDE_LIGHT ? v->to_prev : to_other;
    struct vec3 to_camera = own == SIDE_LIGHT ? to_other : v->to_prev;
    float lambda_in = own == SIDE_LIGHT ? v->lambda_in : lambda_edge;
    struct end end = {.value = surface_elastic(&v->surface, to_light, to_camera, lambda_in), .dye = -1};
    if (!(end.value > 0))
        return end;
    double pdf_own = surface_pdf_mollified(&v->surface, own, v->to_prev, to_other, v->lambda_in, lambda_edge,
                                           half_width_nm);
    double pdf_other = surface_pdf_mollified(&v->surface, other, to_other, v->to_prev, lambda_edge,
                                             v->lambda_in, half_width_nm);
    end.fwd = own == SIDE_LIGHT ? pdf_own : pdf_other;
    end.rev = own == SIDE_LIGHT ? pdf_other : pdf_own;
    return end;
}

static double pair_value(const struct integrator *it, struct joint *joint, struct choice as_y,
                         struct choice as_x, float lambda_edge)
{
    struct end y = joint_end(it, joint, SIDE_LIGHT, as_y, lambda_edge);
    if (!(y.value > 0))
        return 0;
    struct end x = joint_end(it, joint, SIDE_CAMERA, as_x, lambda_edge);
    return joint_value(it, joint, &y, as_y, &x, as_x, lambda_edge);
}

/* Both ends elastic: accepted through the kernel k(λc|λl) = 1/(2d) at one of them (algorithm.md §5). */
static double mollified_value(const struct integrator *it, struct joint *joint, struct choice elastic,
                              float *lambda_edge)
{
    float lambda_light = joint->y->lambda_in, lambda_camera = joint->x->lambda_in;
    float d = joint->path.half_width_nm;
    bool light_side = it->settings.mollify_side == SIDE_LIGHT;
    if (!(fabsf(lambda_light - lambda_camera) < d))
        return 0;
    *lambda_edge = light_side ? lambda_camera : lambda_light;
    struct end y = light_side ? mollified_end(joint->y, SIDE_LIGHT, joint->y_to_x, *lambda_edge, d)
                              : joint_end(it, joint, SIDE_LIGHT, elastic, *lambda_edge);
    if (!(y.value > 0))
        return 0;
    struct end x = light_side ? joint_end(it, joint, SIDE_CAMERA, elastic, *lambda_edge)
                              : mollified_end(joint->x, SIDE_CAMERA, negate(joint->y_to_x), *lambda_edge, d);
    return joint_value(it, joint, &y, elastic, &x, elastic, *lambda_edge) / (2 * (double)d);
}

static int source_of(const struct integrator *it, const struct vertex *y, int lobe)
{
    return y->kind == VERTEX_LIGHT
               ? scene_light_shape(it->scene, y->light.light)
               : wavelengths_source_dye(&it->wavelengths, surface_fluorophore(&y->surface, lobe));
}

static int sink_of(const struct wavelengths *table, const struct vertex *x, int lobe)
{
    return x->kind == VERTEX_CAMERA ? wavelengths_sink_camera(table) : surface_fluorophore(&x->surface, lobe);
}

/* The table of algorithm.md §5: who says what the connecting edge's wavelength is. */
static double labelled_value(const struct integrator *it, const struct worker *w, struct joint *joint,
                             struct choice as_y, struct choice as_x, int pair, float *lambda_edge)
{
    bool y_fluorescent = as_y.label == LABEL_FLUORESCENT, x_fluorescent = as_x.label == LABEL_FLUORESCENT;
    if (!y_fluorescent && !x_fluorescent)
        return mollified_value(it, joint, as_y, lambda_edge);
    if (y_fluorescent != x_fluorescent) {
        *lambda_edge = y_fluorescent ? joint->x->lambda_in : joint->y->lambda_in;
        return pair_value(it, joint, as_y, as_x, *lambda_edge);
    }
    const struct wavelengths *table = &it->wavelengths;
    const struct spectral_histogram *product =
        wavelengths_product(table, source_of(it, joint->y, as_y.lobe), sink_of(table, joint->x, as_x.lobe));
    if (!product)
        return 0;
    uint32_t dimension = DIM_CONNECT + (uint32_t)((joint->s * PATH_VERTICES + joint->t) * PAIRS_MAX + pair);
    float pdf;
    *lambda_edge = spectral_histogram_sample(product, random_at(w->random, dimension), &pdf);
    return pdf > 0 ? pair_value(it, joint, as_y, as_x, *lambda_edge) / pdf : 0;
}

/* All pairs of labels of one connection; what survives weights and shadow ray stays in `out`. */
static void join(const struct integrator *it, struct worker *w, struct joint *joint,
                 const struct subpath *light, const struct subpath *camera, struct pendings *out)
{
    struct choice of_y[CHOICES_MAX], of_x[CHOICES_MAX];
    int y_count = joint_choices(joint->y, of_y), x_count = joint_choices(joint->x, of_x);
    out->count = 0;
    if (!joint_open(w, joint, light, camera))
        return;
    for (int i = 0; i < y_count; i++)
        for (int j = 0; j < x_count; j++) {
            float lambda_edge = 0;
            if (!joint_is_allowed(it, joint, of_y[i], of_x[j]))
                continue;
            double value = labelled_value(it, w, joint, of_y[i], of_x[j], i * CHOICES_MAX + j, &lambda_edge);
            if (value > 0)
                pendings_add(it, out, joint, value, lambda_edge,
                             joint->t == 1 ? lambda_edge : camera->vertex[0].lambda_out);
        }
    pendings_resolve(it, out, joint);
}

static void draw(const struct worker *w, uint32_t dimension, int count, float u[])
{
    for (int i = 0; i < count; i++)
        u[i] = random_at(w->random, dimension + (uint32_t)i);
}

/* s = 1: a light point drawn anew for each camera vertex. */
static void connect_light(const struct integrator *it, struct worker *w, int t)
{
    struct vertex y;
    struct subpath light = {1, &y};
    struct joint joint;
    joint_set(&joint, &y, &w->camera.vertex[t - 1], 1, t);
    struct pendings pendings;
    float u[3];
    draw(w, DIM_NEE + (uint32_t)t * DIMS_PER_NEE, 3, u);
    if (!joint_light_vertex(it, u, &y))
        return;
    join(it, w, &joint, &light, &w->camera, &pendings);
    pendings_gather(it, w, &pendings);
}

/* t = 1: a lens point drawn anew for each light vertex. */
static void connect_camera(const struct integrator *it, struct worker *w, int s)
{
    struct vertex x;
    struct subpath camera = {1, &x};
    struct joint joint;
    joint_set(&joint, &w->light.vertex[s - 1], &x, s, 1);
    struct pendings pendings;
    float u[4];
    int pixel[2];
    draw(w, DIM_SPLAT + (uint32_t)s * DIMS_PER_SPLAT, 4, u);
    if (!joint_camera_vertex(it, &joint, &x, u, pixel))
        return;
    join(it, w, &joint, &w->light, &camera, &pendings);
    pendings_splat(it, &pendings, pixel);
}

static void connect_inner(const struct integrator *it, struct worker *w, int s, int t)
{
    struct joint joint;
    joint_set(&joint, &w->light.vertex[s - 1], &w->camera.vertex[t - 1], s, t);
    struct pendings pendings;
    join(it, w, &joint, &w->light, &w->camera, &pendings);
    pendings_gather(it, w, &pendings);
}

void connect_all(const struct integrator *it, struct worker *w)
{
    const struct integrator_settings *settings = &it->settings;
    for (int t = 2; t <= w->camera.count; t++) {
        if (!w->camera.vertex[t - 1].surface.connects)
            continue;
        if (settings->technique[1][t])
            connect_light(it, w, t);
        for (int s = 2; s <= w->light.count; s++)
            if (settings->technique[s][t] && w->light.vertex[s - 1].surface.connects)
                connect_inner(it, w, s, t);
    }
    for (int s = 1; s <= w->light.count; s++)
        if (settings->technique[s][1] && (s == 1 || w->light.vertex[s - 1].surface.connects))
            connect_camera(it, w, s);
}
