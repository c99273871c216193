/* Edges between sub-paths: geometry, ends, visibility; and where a contribution goes. */
#include "integrator/joint.h"

int joint_choices(const struct vertex *v, struct choice out[CHOICES_MAX])
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

/* --- The edge ---------------------------------------------------------------------------------------------- */

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

bool joint_open(const struct worker *w, struct joint *joint, const struct subpath *light,
                const struct subpath *camera)
{
    if (!set_edge(joint))
        return false;
    joint->throughput_y = joint->y->throughput;
    joint->throughput_x = joint->x->throughput;
    full_path_copy(&joint->path, light, joint->s, camera, joint->t, joint->s + joint->t - 1);
    joint->path.half_width_nm = w->half_width_nm;
    joint->path.step[joint->s].geometry = joint->geometry;
    return true;
}

double joint_visibility(const struct integrator *it, const struct joint *joint, float lambda)
{
    struct vec3 x_to_y = negate(joint->y_to_x);
    if (joint->y->unbounded)
        return scene_visibility_distant(it->scene, vertex_offset(joint->x, x_to_y), x_to_y, lambda);
    return scene_visibility(it->scene, vertex_offset(joint->x, x_to_y),
                            vertex_offset(joint->y, joint->y_to_x), lambda);
}

static enum scatter_class end_class(const struct vertex *v, struct choice as, struct vec3 to_other)
{
    return as.label == LABEL_FLUORESCENT ? SCATTER_DIFFUSE
                                         : surface_elastic_class(&v->surface, v->to_prev, to_other);
}

static bool keeps_bounces(const struct integrator *it, const struct joint *joint, enum scatter_class y,
                          enum scatter_class x)
{
    uint8_t bounces[SCATTER_CLASSES] = {0};
    for (int i = 0; i < SCATTER_CLASSES; i++)
        bounces[i] = (uint8_t)((joint->s > 1 ? joint->y->bounces[i] + (i == (int)y) : 0) +
                               (joint->t > 1 ? joint->x->bounces[i] + (i == (int)x) : 0));
    return path_keeps_bounces(&it->settings, bounces);
}

bool joint_is_allowed(const struct integrator *it, const struct joint *joint, struct choice as_y,
                      struct choice as_x)
{
    const struct vertex *y = joint->y, *x = joint->x;
    enum scatter_class y_class = SCATTER_DIFFUSE, x_class = SCATTER_DIFFUSE;
    if (joint->s > 1)
        y_class = end_class(y, as_y, joint->y_to_x);
    if (joint->t > 1)
        x_class = end_class(x, as_x, negate(joint->y_to_x));
    if (!(y->kinds & (joint->t > 1 ? path_ray_kind(x_class) : RAY_CAMERA)))
        return false;
    if (joint->s > 1 && !(y[-1].kinds & path_ray_kind(y_class)))
        return false;
    return !it->limits_bounces || keeps_bounces(it, joint, y_class, x_class);
}

/* --- Ends -------------------------------------------------------------------------------------------------- */

static struct end surface_end(const struct vertex *v, enum side own, struct choice as, struct vec3 to_other,
                              float lambda_edge)
{
    enum side other = own == SIDE_LIGHT ? SIDE_CAMERA : SIDE_LIGHT;
    struct vec3 to_light = own == SIDE_LIGHT ? v->to_prev : to_other;
    struct vec3 to_camera = own == SIDE_LIGHT ? to_other : v->to_prev;
    const struct surface *surface = &v->surface;
    struct end end = {.dye = -1};
    double pdf_own, pdf_other;
    if (as.label == LABEL_FLUORESCENT) {
        float lambda_in = own == SIDE_LIGHT ? v->lambda_in : lambda_edge;
        float lambda_out = own == SIDE_LIGHT ? lambda_edge : v->lambda_in;
        end.value = surface_fluorescent(surface, as.lobe, to_light, to_camera, lambda_in, lambda_out);
        end.dye = surface_fluorophore(surface, as.lobe);
        if (!(end.value > 0))
            return end;
        pdf_own =
            surface_pdf_fluorescent(surface, own, as.lobe, v->to_prev, to_other, v->lambda_in, lambda_edge);
        pdf_other =
            surface_pdf_fluorescent(surface, other, as.lobe, to_other, v->to_prev, lambda_edge, v->lambda_in);
    } else {
        end.value = surface_elastic(surface, to_light, to_camera, lambda_edge);
        if (!(end.value > 0))
            return end;
        pdf_own = surface_pdf_elastic(surface, own, v->to_prev, to_other, lambda_edge);
        pdf_other = surface_pdf_elastic(surface, other, to_other, v->to_prev, lambda_edge);
        end.disperses = surface_elastic_disperses(surface, v->to_prev, to_other);
    }
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

struct end joint_end(const struct integrator *it, const struct joint *joint, enum side side, struct choice as,
                     float lambda_edge)
{
    const struct vertex *v = side == SIDE_LIGHT ? joint->y : joint->x;
    struct vec3 direction = side == SIDE_LIGHT ? joint->y_to_x : negate(joint->y_to_x);
    switch (v->kind) {
    case VERTEX_LIGHT: return light_end(it, v, direction, lambda_edge);
    case VERTEX_CAMERA: return camera_end(it, joint, lambda_edge);
    case VERTEX_SURFACE: break;
    }
    return surface_end(v, side, as, direction, lambda_edge);
}

static void put_end(struct full_step *step, const struct end *end, enum label label)
{
    step->fwd = end->fwd;
    step->rev = end->rev;
    step->label = label;
    step->dye = end->dye;
    step->disperses = end->disperses;
}

double joint_value(const struct integrator *it, struct joint *joint, const struct end *y, struct choice as_y,
                   const struct end *x, struct choice as_x, float lambda_edge)
{
    double value = joint->throughput_y * y->value * joint->geometry * x->value * joint->throughput_x;
    if (!(value > 0))
        return 0;
    put_end(&joint->path.step[joint->s - 1], y, as_y.label);
    put_end(&joint->path.step[joint->s], x, as_x.label);
    joint->path.step[joint->s].lambda = lambda_edge;
    return value * mis_weight(it, &joint->path);
}

/* --- Contributions ----------------------------------------------------------------------------------------- */

void pendings_add(const struct integrator *it, struct pendings *p, const struct joint *joint, double value,
                  float lambda_edge, float lambda_film)
{
    if (!(value > 0) || !isfinite(value))
        return;
    p->at[p->count++] = (struct pending){value, lambda_edge, lambda_film};
    if (it->observe)
        it->observe(it->observer, &joint->path, value * joint_visibility(it, joint, lambda_edge));
}

void pendings_resolve(const struct integrator *it, struct pendings *p, const struct joint *joint)
{
    if (p->count == 0)
        return;
    /* Most edges are open or blocked at every wavelength; only coloured transparency needs a ray for each. */
    double first = joint_visibility(it, joint, p->at[0].lambda_edge);
    if (first == 0) {
        p->count = 0;
        return;
    }
    for (int i = 0; i < p->count; i++)
        p->at[i].value *= i == 0 || first == 1 ? first : joint_visibility(it, joint, p->at[i].lambda_edge);
}

void pendings_gather(const struct integrator *it, struct worker *w, const struct pendings *p)
{
    for (int i = 0; i < p->count; i++)
        film_sample_add(it->film, &w->gathered, p->at[i].value, p->at[i].lambda_film, it->kappa);
}

void pendings_splat(const struct integrator *it, const struct pendings *p, const int pixel[2])
{
    for (int i = 0; i < p->count; i++)
        film_splat(it->film, pixel[0], pixel[1], p->at[i].value, p->at[i].lambda_film, it->kappa);
}

/* --- Vertices that are drawn for one connection --------------------------------------------------------------- */

bool joint_light_vertex(const struct integrator *it, const float u[3], struct vertex *y)
{
    vertex_begin(y, VERTEX_LIGHT);
    if (!scene_sample_light(it->scene, u, &y->light, &y->pdf_point))
        return false;
    y->position = y->light.position;
    y->unbounded = y->light.distant;
    y->kinds = scene_light_kinds(it->scene, y->light.light);
    y->throughput = 1 / (double)y->pdf_point;
    return true;
}

bool joint_camera_vertex(const struct integrator *it, struct joint *joint, struct vertex *x, const float u[4],
                         int pixel[2])
{
    const struct vertex *y = joint->y;
    float at[2], width = it->settings.filter_width;
    vertex_begin(x, VERTEX_CAMERA);
    x->unbounded = scene_camera_is_orthographic(it->scene);
    if (joint->s == 1 && (y->unbounded || !scene_light_seen_by_camera(it->scene, &y->light)))
        return false;
    if (!scene_camera_connect(it->scene, y->position, width, u, &x->lens, at, &joint->pdf_camera_direction))
        return false;
    /* One of the pixels whose camera samples look through `at`, as often as they do. */
    float weight[2];
    for (int i = 0; i < 2; i++)
        pixel[i] = film_filter_pixel(width, at[i], u[2 + i], &weight[i]);
    x->throughput = weight[0] * weight[1];
    x->position = x->lens.position;
    return pixel[0] >= it->border[0] && pixel[0] < it->border[2] && pixel[1] >= it->border[1] &&
           pixel[1] < it->border[3];
}
