/* Connections of the mollified method: each pair of labels is one labelled path with its own wavelength on the edge, its own value
   and its own weight; they share geometry and shadow ray. Lanes pair up by number; where both ends are elastic, each with each. */
#include "integrator/connect.h"

#include <string.h>

#include "integrator/joint.h"
#include "integrator/tally.h"

/* Two sub-paths to be joined, and where a contribution goes. */
struct meeting {
    struct joint joint;
    const int *splat; /* NULL: the camera's pixel */
};

/* --- Both ends elastic ----------------------------------------------------------------------------------------- */

/* The end of an E–E connection that takes the kernel, with the densities of eqs. 25–26 in labelled space (algorithm.md §6). The kernel
   itself multiplies elsewhere. */
static void mollified_end(const struct integrator *it, struct joint *joint, enum side side,
                          float half_width_nm)
{
    enum side other = side == SIDE_LIGHT ? SIDE_CAMERA : SIDE_LIGHT;
    enum kernel kernel = it->settings.kernel;
    struct joint_end *end = &joint->end[side];
    const struct vertex *v = end->vertex;
    struct vec3 to_other = side == SIDE_LIGHT ? joint->y_to_x : negate(joint->y_to_x);
    struct vec3 to_light = side == SIDE_LIGHT ? v->to_prev : to_other;
    struct vec3 to_camera = side == SIDE_LIGHT ? to_other : v->to_prev;
    for (int i = 0; i < joint->lanes; i++) {
        float own = end->at->lambda[i], edge = joint->lambda[i];
        float in = side == SIDE_LIGHT ? own : edge, out = side == SIDE_LIGHT ? edge : own;
        end->steps.value[i] =
            surface_mollified(&v->surface, kernel, to_light, to_camera, in, out, half_width_nm);
        end->steps.pdf[i] = surface_pdf_mollified_by(&v->surface, kernel, side, v->to_prev, to_other, own,
                                                     edge, half_width_nm);
        end->steps.pdf_other[i] = surface_pdf_mollified_by(&v->surface, kernel, other, to_other, v->to_prev,
                                                           edge, own, half_width_nm);
        end->draw[i] = end->at->draw[i];
    }
}

/* Lanes of the two sides that the kernel lets meet. */
struct pairs {
    int count;
    uint8_t lane[SIDES][LANES_MAX];
    double density[LANES_MAX];
};

/* What arrives at a vertex, lane by lane as the pairs have it. */
static void pick(const struct arrival *from, const struct pairs *pairs, enum side side, struct arrival *to)
{
    *to = *from;
    for (int i = 0; i < pairs->count; i++) {
        int k = pairs->lane[side][i];
        to->lambda[i] = from->lambda[k];
        to->draw[i] = from->draw[k];
        to->throughput[i] = from->throughput[k];
        to->seam[i] = from->seam[k];
        to->tally.closed[i] = from->tally.closed[k];
    }
}

static void join_pairs(const struct integrator *it, struct worker *w, struct meeting *m,
                       const struct pairs *pairs)
{
    struct joint *joint = &m->joint;
    struct joint_end *y = &joint->end[SIDE_LIGHT], *x = &joint->end[SIDE_CAMERA];
    const struct arrival *of_y = y->at, *of_x = x->at;
    struct arrival at_y, at_x;
    float film[LANES_MAX];
    pick(of_y, pairs, SIDE_LIGHT, &at_y);
    pick(of_x, pairs, SIDE_CAMERA, &at_x);
    for (int i = 0; i < pairs->count; i++)
        film[i] = x->vertex->lambda_film[pairs->lane[SIDE_CAMERA][i]];
    y->at = &at_y;
    x->at = &at_x;
    joint->lanes = pairs->count;
    memcpy(joint->lane, pairs->lane, sizeof joint->lane);
    enum side blurred = it->settings.mollify_side, sharp = blurred == SIDE_LIGHT ? SIDE_CAMERA : SIDE_LIGHT;
    memcpy(joint->lambda, joint->end[sharp].at->lambda, sizeof joint->lambda);
    joint->owed = 1;
    if (joint_survives(it, w, joint, pairs->density, film)) {
        mollified_end(it, joint, blurred, w->half_width_nm);
        joint_evaluate_end(it, joint, sharp);
        joint_contribute(it, w, joint, pairs->density, film, m->splat);
    }
    y->at = of_y;
    x->at = of_x;
    memcpy(joint->lane, joint_straight, sizeof joint->lane);
}

/* Each light lane with each camera lane: those that the kernel accepts, as full bundles of pairs. A pair's density is 1/k(λc|λl) for the two
   wavelengths' one (algorithm.md §5). */
static void join_elastic(const struct integrator *it, struct worker *w, struct meeting *m)
{
    const struct arrival *y = m->joint.end[SIDE_LIGHT].at, *x = m->joint.end[SIDE_CAMERA].at;
    int all = y->lanes * x->lanes;
    struct pairs pairs = {.count = 0};
    for (int i = 0; i < all; i++) {
        int of_y = i % y->lanes, of_x = i / y->lanes;
        float k = kernel_density(it->settings.kernel, y->lambda[of_y], x->lambda[of_x], w->half_width_nm);
        if (k > 0) {
            pairs.lane[SIDE_LIGHT][pairs.count] = (uint8_t)of_y;
            pairs.lane[SIDE_CAMERA][pairs.count] = (uint8_t)of_x;
            pairs.density[pairs.count++] = all / (double)k;
        }
        if (pairs.count == it->lanes || (i + 1 == all && pairs.count > 0)) {
            /* joint_contribute takes the mean of a bundle. */
            for (int j = 0; j < pairs.count; j++)
                pairs.density[j] /= pairs.count;
            join_pairs(it, w, m, &pairs);
            pairs.count = 0;
        }
    }
}

/* --- The table of algorithm.md §5 ------------------------------------------------------------------------------- */

/* The one wavelength of both sub-paths, and its density, where the camera's sub-path has not paid it. */
static void share_lambda(const struct integrator *it, struct joint *joint, double density[LANES_MAX])
{
    const struct joint_end *y = &joint->end[SIDE_LIGHT], *x = &joint->end[SIDE_CAMERA];
    bool paid = x->vertex->kind != VERTEX_CAMERA;
    joint->lanes = 1;
    joint->lambda[0] = paid                              ? x->at->lambda[0]
                       : y->vertex->kind == VERTEX_LIGHT ? y->vertex->lambda_out[0]
                                                         : y->at->lambda[0];
    density[0] = paid ? 1 : spectrum_pdf(it->wavelengths.camera, joint->lambda[0]);
}

/* One end at least fluoresces: the other says what the wavelength is, or the product of both does. */
static void join_fluorescent(const struct integrator *it, struct worker *w, struct meeting *m, int pair)
{
    struct joint *joint = &m->joint;
    const struct joint_end *y = &joint->end[SIDE_LIGHT], *x = &joint->end[SIDE_CAMERA];
    double product[LANES_MAX], *density = NULL;
    if (it->settings.shared_wavelength) {
        share_lambda(it, joint, product);
        density = product;
    } else if (y->as.label == LABEL_ELASTIC) {
        memcpy(joint->lambda, y->at->lambda, sizeof joint->lambda);
    } else if (x->as.label == LABEL_ELASTIC) {
        memcpy(joint->lambda, x->at->lambda, sizeof joint->lambda);
    } else {
        uint32_t dimension =
            DIM_CONNECT + (uint32_t)((joint->s * PATH_VERTICES + joint->t) * PAIRS_MAX + pair);
        joint_name_run(it, joint);
        joint->lanes = it->lanes;
        if (!draw_product(it, w, joint->source, joint->sink, dimension, joint->lanes, joint->lambda, product))
            return;
        density = product;
    }
    const float *film = joint->t == 1 ? joint->lambda : x->vertex->lambda_film;
    joint->owed = 1;
    if (joint_evaluate(it, w, joint, density, film))
        joint_contribute(it, w, joint, density, film, m->splat);
}

/* All pairs of labels of one connection. */
static void join(const struct integrator *it, struct worker *w, struct meeting *m,
                 const struct subpath *light, int s, const struct subpath *camera, int t, struct sight *sight)
{
    struct choice of_y[CHOICES_MAX], of_x[CHOICES_MAX];
    const struct vertex *y = &light->vertex[s - 1], *x = &camera->vertex[t - 1];
    int y_count = joint_choices(y, of_y), x_count = joint_choices(x, of_x);
    if (!joint_open(&m->joint, y, x, w->stamp, sight))
        return;
    for (int i = 0; i < y_count; i++)
        for (int j = 0; j < x_count; j++) {
            joint_set_end(&m->joint, SIDE_LIGHT, light, s - 1, NULL, of_y[i]);
            joint_set_end(&m->joint, SIDE_CAMERA, camera, t - 1, NULL, of_x[j]);
            m->joint.lanes = y->arrival.lanes > x->arrival.lanes ? y->arrival.lanes : x->arrival.lanes;
            if (!joint_is_allowed(it, &m->joint))
                continue;
            if (of_y[i].label == LABEL_ELASTIC && of_x[j].label == LABEL_ELASTIC &&
                !it->settings.shared_wavelength)
                join_elastic(it, w, m);
            else
                join_fluorescent(it, w, m, i * CHOICES_MAX + j);
        }
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
    struct subpath light = {1, &y, NULL};
    struct haze haze;
    struct sight sight = {.haze = &haze};
    struct meeting m;
    m.splat = NULL;
    float u[3];
    draw(w, DIM_NEE + (uint32_t)t * DIMS_PER_NEE, 3, u);
    if (path_light_vertex(it, u, &y))
        join(it, w, &m, &light, 1, &w->camera, t, &sight);
}

/* t = 1: a lens point drawn anew for each light vertex. */
static void connect_camera(const struct integrator *it, struct worker *w, int s)
{
    struct vertex x;
    struct subpath camera = {1, &x, NULL};
    struct haze haze;
    struct sight sight = {.haze = &haze};
    int pixel[2];
    struct meeting m; /* a kilobyte that is not worth clearing */
    m.splat = pixel;
    float u[4];
    draw(w, DIM_SPLAT + (uint32_t)s * DIMS_PER_SPLAT, 4, u);
    if (joint_camera_vertex(it, &w->light.vertex[s - 1], &x, u, pixel, &m.joint.pdf_camera_direction))
        join(it, w, &m, &w->light, s, &camera, 1, &sight);
}

void connect_lenses(const struct integrator *it, struct worker *w)
{
    for (int s = 1; s <= w->light.count; s++)
        if (it->settings.technique[s][1] && (s == 1 || w->light.vertex[s - 1].surface.connects))
            connect_camera(it, w, s);
}

void connect_all(const struct integrator *it, struct worker *w)
{
    const struct integrator_settings *settings = &it->settings;
    struct meeting m;
    m.splat = NULL;
    for (int t = 2; t <= w->camera.count; t++)
        if (settings->technique[1][t] && w->camera.vertex[t - 1].surface.connects)
            connect_light(it, w, t);
    for (int t = 2; t <= w->camera.count; t++)
        for (int s = 2; s <= w->light.count; s++)
            if (settings->technique[s][t] && w->camera.vertex[t - 1].surface.connects &&
                w->light.vertex[s - 1].surface.connects)
                join(it, w, &m, &w->light, s, &w->camera, t, &w->sight[(s - 1) * PATH_VERTICES + t - 1]);
    connect_lenses(it, w);
}
