/* Joins a light sub-path's vertex y and a camera sub-path's vertex x by an edge. Each pair of labels is one labelled path,
   with its own wavelength on the edge, its own value and its own weight; they share geometry and shadow ray. */
#include "integrator/connect.h"

#include "integrator/mis.h"

/* A label that a vertex may take as the end of a connection. The light and the camera have the one label FLUORESCENT. */
struct choice {
    enum label label;
    int lobe;
};
enum { CHOICES_MAX = SURFACE_LOBES + 1, PAIRS_MAX = CHOICES_MAX * CHOICES_MAX };

static int choices(const struct vertex *v, struct choice *out)
{
    int count = 0;
    if (v->kind != VERTEX_SURFACE) {
        out[count++] = (struct choice){LABEL_FLUORESCENT, 0};
        return count;
    }
    if (v->surface.has_elastic)
        out[count++] = (struct choice){LABEL_ELASTIC, 0};
    for (int f = 0; f < v->surface.fluorescent_count; f++)
        out[count++] = (struct choice){LABEL_FLUORESCENT, f};
    return count;
}

/* One connection, before labels: vertices, edge, and where a splat would fall. */
struct joint {
    const struct vertex *y, *x;
    int s, t;
    struct vec3 y_to_x;
    float geometry;
    float pdf_camera_direction; /* t = 1 */
    struct full_path path;
};

/* A contribution that waits for the shadow ray. */
struct pending {
    double value;
    float lambda_edge, lambda_film;
};

/* What one end adds: ρ (or emitted radiance, or the camera's density) and the densities of both sides' steps through it. */
struct end {
    double value, fwd, rev;
    int dye;
};

static struct end surface_end(const struct vertex *v, enum side own, struct choice as, struct vec3 to_other,
                              float lambda_edge)
{
    enum side other = own == SIDE_LIGHT ? SIDE_CAMERA : SIDE_LIGHT;
    struct vec3 to_light = own == SIDE_LIGHT ? v->to_prev : to_other;
    struct vec3 to_camera = own == SIDE_LIGHT ? to_other : v->to_prev;
    float lambda_in = own == SIDE_LIGHT ? v->lambda_in : lambda_edge;
    float lambda_out = own == SIDE_LIGHT ? lambda_edge : v->lambda_in;
    const struct surface *surface = &v->surface;
    struct end end = {.dye = -1};
    double pdf_own, pdf_other;
    if (as.label == LABEL_FLUORESCENT) {
        end.value = surface_fluorescent(surface, as.lobe, to_light, to_camera, lambda_in, lambda_out);
        end.dye = surface_fluorophore(surface, as.lobe);
        if (!(end.value > 0))
            return end;
        pdf_own =
            surface_pdf_fluorescent(surface, own, as.lobe, v->to_prev, to_other, v->lambda_in, lambda_edge);
        pdf_other =
            surface_pdf_fluorescent(surface, other, as.lobe, to_other, v->to_prev, lambda_edge, v->lambda_in);
    } else {
        end.value = surface_elastic(surface, to_light, to_camera, lambda_in);
        if (!(end.value > 0))
            return end;
        pdf_own = surface_pdf_elastic(surface, own, v->to_prev, to_other, v->lambda_in);
        pdf_other = surface_pdf_elastic(surface, other, to_other, v->to_prev, v->lambda_in);
    }
    end.fwd = own == SIDE_LIGHT ? pdf_own : pdf_other;
    end.rev = own == SIDE_LIGHT ? pdf_other : pdf_own;
    return end;
}

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

static struct end light_end(const struct integrator *it, const struct vertex *y, struct vec3 direction,
                            float lambda)
{
    return (struct end){.value = scene_light_emission(it->scene, &y->light, direction, lambda),
                        .fwd = scene_pdf_light_lambda(it->scene, &y->light, lambda) *
                               (double)scene_pdf_light_direction(it->scene, &y->light, direction),
                        .dye = -1};
}

static struct end camera_end(const struct integrator *it, const struct joint *joint, float lambda)
{
    return (struct end){.value = joint->pdf_camera_direction,
                        .rev = spectrum_pdf(it->wavelengths.camera, lambda) *
                               (double)joint->pdf_camera_direction,
                        .dye = -1};
}

static struct end make_end(const struct integrator *it, const struct joint *joint, enum side side,
                           struct choice as, float lambda_edge)
{
    const struct vertex *v = side == SIDE_LIGHT ? joint->y : joint->x;
    struct vec3 direction = side == SIDE_LIGHT ? joint->y_to_x : negate(joint->y_to_x);
    switch (v->kind) {
    case VERTEX_LIGHT:
        return light_end(it, v, direction, lambda_edge);
    case VERTEX_CAMERA:
        return camera_end(it, joint, lambda_edge);
    case VERTEX_SURFACE:
        break;
    }
    return surface_end(v, side, as, direction, lambda_edge);
}

static void put_end(struct full_step *step, const struct end *end, enum label label)
{
    step->fwd = end->fwd;
    step->rev = end->rev;
    step->label = label;
    step->dye = end->dye;
}

/* A labelled pair at wavelength lambda_edge, drawn with density 1/draw where it was drawn anew: value × weight. */
static double pair_contribution(const struct integrator *it, struct joint *joint, struct choice as_y,
                                struct choice as_x, float lambda_edge, double draw)
{
    struct end y = make_end(it, joint, SIDE_LIGHT, as_y, lambda_edge);
    if (!(y.value > 0))
        return 0;
    struct end x = make_end(it, joint, SIDE_CAMERA, as_x, lambda_edge);
    if (!(x.value > 0))
        return 0;
    put_end(&joint->path.step[joint->s - 1], &y, as_y.label);
    put_end(&joint->path.step[joint->s], &x, as_x.label);
    joint->path.step[joint->s].lambda = lambda_edge;
    return joint->y->throughput * y.value * joint->geometry * x.value * joint->x->throughput * draw *
           mis_weight(it, &joint->path);
}

/* Both ends elastic: accepted through the kernel k(λc|λl) = 1/(2d) at one of them (algorithm.md §5). */
static double mollified_contribution(const struct integrator *it, struct joint *joint, float *lambda_edge)
{
    float lambda_light = joint->y->lambda_in, lambda_camera = joint->x->lambda_in;
    float d = joint->path.half_width_nm;
    bool light_side = it->settings.mollify_side == SIDE_LIGHT;
    struct vec3 x_to_y = negate(joint->y_to_x);
    struct choice elastic = {LABEL_ELASTIC, 0};
    if (!(fabsf(lambda_light - lambda_camera) < d))
        return 0;
    *lambda_edge = light_side ? lambda_camera : lambda_light;
    struct end y = light_side ? mollified_end(joint->y, SIDE_LIGHT, joint->y_to_x, *lambda_edge, d)
                              : surface_end(joint->y, SIDE_LIGHT, elastic, joint->y_to_x, *lambda_edge);
    if (!(y.value > 0))
        return 0;
    struct end x = light_side ? surface_end(joint->x, SIDE_CAMERA, elastic, x_to_y, *lambda_edge)
                              : mollified_end(joint->x, SIDE_CAMERA, x_to_y, *lambda_edge, d);
    if (!(x.value > 0))
        return 0;
    put_end(&joint->path.step[joint->s - 1], &y, LABEL_ELASTIC);
    put_end(&joint->path.step[joint->s], &x, LABEL_ELASTIC);
    joint->path.step[joint->s].lambda = *lambda_edge;
    return joint->y->throughput * y.value * joint->geometry * x.value * joint->x->throughput /
           (2 * (double)d) * mis_weight(it, &joint->path);
}

/* The table of algorithm.md §5: who says what the connecting edge's wavelength is. */
static double contribution(const struct integrator *it, const struct worker *w, struct joint *joint,
                           struct choice as_y, struct choice as_x, int pair, float *lambda_edge)
{
    bool y_fluorescent = as_y.label == LABEL_FLUORESCENT, x_fluorescent = as_x.label == LABEL_FLUORESCENT;
    if (!y_fluorescent && !x_fluorescent)
        return mollified_contribution(it, joint, lambda_edge);
    if (y_fluorescent != x_fluorescent) {
        *lambda_edge = y_fluorescent ? joint->x->lambda_in : joint->y->lambda_in;
        return pair_contribution(it, joint, as_y, as_x, *lambda_edge, 1);
    }
    const struct wavelengths *table = &it->wavelengths;
    int source = joint->y->kind == VERTEX_LIGHT
                     ? joint->y->light.light
                     : wavelengths_source_dye(table, surface_fluorophore(&joint->y->surface, as_y.lobe));
    int sink = joint->x->kind == VERTEX_CAMERA ? wavelengths_sink_camera(table)
                                               : surface_fluorophore(&joint->x->surface, as_x.lobe);
    const struct spectral_histogram *product = wavelengths_product(table, source, sink);
    if (!product)
        return 0;
    uint32_t dimension = DIM_CONNECT + (uint32_t)((joint->s * PATH_VERTICES + joint->t) * PAIRS_MAX + pair);
    float pdf;
    *lambda_edge = spectral_histogram_sample(product, random_at(w->random, dimension), &pdf);
    return pdf > 0 ? pair_contribution(it, joint, as_y, as_x, *lambda_edge, 1 / (double)pdf) : 0;
}

static double visibility(const struct integrator *it, const struct joint *joint, float lambda)
{
    struct vec3 x_to_y = negate(joint->y_to_x);
    if (joint->y->unbounded)
        return scene_visibility_distant(it->scene, vertex_offset(joint->x, x_to_y), x_to_y, lambda);
    return scene_visibility(it->scene, vertex_offset(joint->x, x_to_y),
                            vertex_offset(joint->y, joint->y_to_x), lambda);
}

static bool set_edge(struct joint *joint)
{
    const struct vertex *y = joint->y, *x = joint->x;
    if (y->unbounded && x->unbounded)
        return false;
    float distance_squared = 1;
    if (y->unbounded) {
        joint->y_to_x = negate(y->light.normal);
    } else {
        struct vec3 edge = sub(x->position, y->position);
        distance_squared = length_squared(edge);
        if (!(distance_squared > 0))
            return false;
        joint->y_to_x = scale(edge, 1 / sqrtf(distance_squared));
        if (x->unbounded)
            distance_squared = 1;
    }
    joint->geometry = vertex_cosine(y, joint->y_to_x) * vertex_cosine(x, joint->y_to_x) / distance_squared;
    return joint->geometry > 0 && isfinite(joint->geometry);
}

/* All pairs of labels of one connection; what survives weights and shadow ray goes to `out`. */
static int join(const struct integrator *it, struct worker *w, struct joint *joint,
                const struct subpath *light, const struct subpath *camera, struct pending out[PAIRS_MAX])
{
    struct choice of_y[CHOICES_MAX], of_x[CHOICES_MAX];
    int y_count = choices(joint->y, of_y), x_count = choices(joint->x, of_x), count = 0;
    if (!set_edge(joint))
        return 0;
    full_path_copy(&joint->path, light, joint->s, camera, joint->t, joint->s + joint->t - 1);
    joint->path.half_width_nm = w->half_width_nm;
    joint->path.step[joint->s].geometry = joint->geometry;
    for (int i = 0; i < y_count; i++)
        for (int j = 0; j < x_count; j++) {
            struct pending *p = &out[count];
            p->value = contribution(it, w, joint, of_y[i], of_x[j], i * CHOICES_MAX + j, &p->lambda_edge);
            p->lambda_film = joint->t == 1 ? p->lambda_edge : camera->vertex[0].lambda_out;
            if (!(p->value > 0) || !isfinite(p->value))
                continue;
            count++;
            if (it->observe)
                it->observe(it->observer, &joint->path, p->value * visibility(it, joint, p->lambda_edge));
        }
    if (count == 0)
        return 0;
    /* Most edges are open or blocked at every wavelength; only coloured transparency needs a ray for each. */
    double first = visibility(it, joint, out[0].lambda_edge);
    for (int i = 0; i < count; i++)
        out[i].value *=
            i == 0 || first == 0 || first == 1 ? first : visibility(it, joint, out[i].lambda_edge);
    return first == 0 ? 0 : count;
}

static void gather_pending(const struct integrator *it, struct worker *w, const struct pending *p, int count)
{
    for (int i = 0; i < count; i++)
        film_sample_add(it->film, &w->gathered, p[i].value, p[i].lambda_film, it->kappa);
}

/* s = 1: a light point drawn anew for each camera vertex. */
static void connect_light(const struct integrator *it, struct worker *w, int t)
{
    struct vertex y = {.kind = VERTEX_LIGHT, .label = LABEL_FLUORESCENT};
    struct subpath light = {1, &y};
    uint32_t dimension = DIM_NEE + (uint32_t)t * DIMS_PER_NEE;
    float u[3];
    for (int i = 0; i < 3; i++)
        u[i] = random_at(w->random, dimension + (uint32_t)i);
    if (!scene_sample_light(it->scene, u, &y.light, &y.pdf_point))
        return;
    y.position = y.light.position;
    y.unbounded = y.light.distant;
    y.throughput = 1 / (double)y.pdf_point;
    struct joint joint = {.y = &y, .x = &w->camera.vertex[t - 1], .s = 1, .t = t};
    struct pending pending[PAIRS_MAX];
    gather_pending(it, w, pending, join(it, w, &joint, &light, &w->camera, pending));
}

/* t = 1: a lens point drawn anew for each light vertex; the pixel by a filter jitter, so each splat has weight 1 in it. */
static void connect_camera(const struct integrator *it, struct worker *w, int s)
{
    const struct vertex *y = &w->light.vertex[s - 1];
    struct vertex x = {.kind = VERTEX_CAMERA,
                       .label = LABEL_FLUORESCENT,
                       .throughput = 1,
                       .unbounded = scene_camera_is_orthographic(it->scene)};
    struct subpath camera = {1, &x};
    uint32_t dimension = DIM_SPLAT + (uint32_t)s * DIMS_PER_SPLAT;
    float u[4], at[2];
    for (int i = 0; i < 4; i++)
        u[i] = random_at(w->random, dimension + (uint32_t)i);
    if (s == 1 && (y->unbounded || !scene_light_seen_by_camera(it->scene, &y->light)))
        return;
    struct joint joint = {.y = y, .x = &x, .s = s, .t = 1};
    if (!scene_camera_connect(it->scene, y->position, it->settings.filter_width, u, &x.lens, at,
                              &joint.pdf_camera_direction))
        return;
    int px = (int)floorf(at[0] + film_filter_sample(it->settings.filter_width, u[2]));
    int py = (int)floorf(at[1] + film_filter_sample(it->settings.filter_width, u[3]));
    if (px < it->border[0] || px >= it->border[2] || py < it->border[1] || py >= it->border[3])
        return;
    x.position = x.lens.position;
    struct pending pending[PAIRS_MAX];
    int count = join(it, w, &joint, &w->light, &camera, pending);
    for (int i = 0; i < count; i++)
        film_splat(it->film, px, py, pending[i].value, pending[i].lambda_film, it->kappa);
}

static void connect_inner(const struct integrator *it, struct worker *w, int s, int t)
{
    struct joint joint = {.y = &w->light.vertex[s - 1], .x = &w->camera.vertex[t - 1], .s = s, .t = t};
    struct pending pending[PAIRS_MAX];
    gather_pending(it, w, pending, join(it, w, &joint, &w->light, &w->camera, pending));
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
