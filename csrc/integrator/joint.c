/* Edges between sub-paths: geometry, ends, visibility; and where a contribution goes. */
#include "integrator/joint.h"

#include <string.h>

#include "integrator/flight.h"
#include "integrator/gather.h"
#include "integrator/relight.h"
#include "integrator/roulette.h"
#include "integrator/tally.h"
#include "integrator/trial.h"

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

const uint8_t joint_straight[SIDES][LANES_MAX] = {{0, 1, 2, 3, 4, 5, 6, 7}, {0, 1, 2, 3, 4, 5, 6, 7}};

/* --- The edge ---------------------------------------------------------------------------------------------- */

/* What comes to a matte surface on one side leaves it there. */
static bool faces(const struct vertex *v, struct vec3 direction)
{
    return v->kind != VERTEX_SURFACE || !v->surface.is_matte ||
           dot(v->to_prev, v->hit.ng) * dot(direction, v->hit.ng) > 0;
}

static bool look(const struct vertex *y, const struct vertex *x, struct sight *sight)
{
    if (y->unbounded && x->unbounded)
        return false;
    float distance_squared = 1;
    if (y->unbounded) {
        sight->y_to_x = negate(y->light.normal);
    } else {
        struct vec3 edge = sub(x->position, y->position);
        distance_squared = length_squared(edge);
        if (!(distance_squared > 0))
            return false;
        sight->y_to_x = scale(edge, 1 / sqrtf(distance_squared));
        if (x->unbounded)
            distance_squared = 1;
    }
    sight->geometry = vertex_cosine(y, sight->y_to_x) * vertex_cosine(x, sight->y_to_x) / distance_squared;
    return sight->geometry > 0 && isfinite(sight->geometry) && faces(y, sight->y_to_x) &&
           faces(x, negate(sight->y_to_x));
}

bool joint_open(struct joint *joint, const struct vertex *y, const struct vertex *x, uint32_t stamp,
                struct sight *sight)
{
    if (sight->stamp != stamp) {
        sight->stamp = stamp;
        sight->state = look(y, x, sight) ? SIGHT_OPEN : SIGHT_NOTHING;
    }
    joint->sight = sight;
    memcpy(joint->lane, joint_straight, sizeof joint->lane);
    joint->y_to_x = sight->y_to_x;
    joint->geometry = sight->geometry;
    joint->owed = 1;
    return sight->state != SIGHT_NOTHING;
}

static enum scatter_class end_class(const struct joint_end *end, struct vec3 to_other)
{
    return end->as.label == LABEL_FLUORESCENT
               ? SCATTER_DIFFUSE
               : surface_elastic_class(&end->vertex->surface, end->vertex->to_prev, to_other);
}

/* An edge is a ray that leaves its end on the camera's side, whoever traced it; one that looks for a light is a shadow ray. */
static uint32_t edge_kind(const struct joint *joint)
{
    if (joint->t == 1)
        return RAY_CAMERA;
    return joint->s == 1 ? RAY_SHADOW
                         : path_ray_kind(end_class(&joint->end[SIDE_CAMERA], negate(joint->y_to_x)));
}

/* Where a shadow ray from the joint's camera end begins: not nearer than a camera's own rays. */
static struct vec3 camera_start(const struct vertex *x, struct vec3 direction)
{
    float cosine = dot(x->lens.axis, direction);
    return x->lens.near > 0 && cosine > 0 ? along(x->position, direction, x->lens.near / cosine)
                                          : x->position;
}

/* The same in a scene with volumes: what the edge crosses of them, too. */
static double trace_through(const struct integrator *it, const struct joint *joint, float lambda,
                            struct crossing *crossing)
{
    const struct vertex *y = joint->end[SIDE_LIGHT].vertex, *x = joint->end[SIDE_CAMERA].vertex;
    struct vec3 x_to_y = negate(joint->y_to_x);
    struct vec3 from = x->kind == VERTEX_CAMERA ? camera_start(x, x_to_y) : vertex_offset(x, x_to_y);
    struct media media = flight_media(x, x_to_y);
    if (y->unbounded)
        return scene_visibility_distant_through(it->scene, from, x_to_y, lambda, edge_kind(joint), &media,
                                                crossing);
    return scene_visibility_through(it->scene, from, vertex_offset(y, joint->y_to_x), lambda,
                                    edge_kind(joint), &media, crossing);
}

static double trace(const struct integrator *it, const struct joint *joint, float lambda)
{
    const struct vertex *y = joint->end[SIDE_LIGHT].vertex, *x = joint->end[SIDE_CAMERA].vertex;
    struct vec3 x_to_y = negate(joint->y_to_x);
    if (y->unbounded)
        return scene_visibility_distant(it->scene, vertex_offset(x, x_to_y), x_to_y, lambda,
                                        edge_kind(joint));
    return scene_visibility(it->scene, vertex_offset(x, x_to_y), vertex_offset(y, joint->y_to_x), lambda,
                            edge_kind(joint));
}

static void set_across(const struct integrator *it, const struct joint *joint, struct haze *haze)
{
    for (int side = 0; side < SIDES; side++) {
        const struct vertex *far = joint->end[side == SIDE_LIGHT ? SIDE_CAMERA : SIDE_LIGHT].vertex;
        haze->across[side] = flight_nominal(it, &haze->crossing, far);
    }
}

static bool is_barred(const struct integrator *it, const struct joint *joint)
{
    const struct vertex *y = joint->end[SIDE_LIGHT].vertex, *x = joint->end[SIDE_CAMERA].vertex;
    return it->has_barriers && joint->s > 1 && joint->t > 1 &&
           scene_is_barred(it->scene, vertex_offset(x, negate(joint->y_to_x)),
                           vertex_offset(y, joint->y_to_x));
}

/* Most edges are open or blocked at every wavelength; only coloured transparency needs a ray for each. */
static void attenuate(const struct integrator *it, struct joint *joint, double value[LANES_MAX])
{
    struct sight *sight = joint->sight;
    if (sight->state == SIGHT_OPEN) {
        sight->visibility = it->has_volumes
                                ? trace_through(it, joint, joint->lambda[0], &sight->haze->crossing)
                                : trace(it, joint, joint->lambda[0]);
        sight->state = sight->visibility > 0 ? SIGHT_TRACED : SIGHT_NOTHING;
        sight->barred = is_barred(it, joint);
        if (it->has_volumes)
            set_across(it, joint, sight->haze);
    }
    for (int side = 0; side < SIDES; side++)
        joint->end[side].across = it->has_volumes ? sight->haze->across[side] : 1;
    if (sight->barred)
        joint->end[SIDE_LIGHT].across = 0;
    for (int i = 0; it->has_volumes && sight->state == SIGHT_TRACED && i < joint->lanes; i++)
        value[i] *= crossing_transmittance(it->scene, &sight->haze->crossing, joint->lambda[i]);
    if (sight->state == SIGHT_TRACED && sight->visibility == 1)
        return;
    for (int i = 0; i < joint->lanes; i++)
        value[i] *= sight->state == SIGHT_NOTHING ? 0 : trace(it, joint, joint->lambda[i]);
}

/* --- Limits ------------------------------------------------------------------------------------------------ */

static bool keeps_bounces(const struct integrator *it, const struct joint *joint, enum scatter_class y,
                          enum scatter_class x)
{
    uint8_t bounces[SCATTER_CLASSES] = {0};
    for (int i = 0; i < SCATTER_CLASSES; i++)
        bounces[i] =
            (uint8_t)((joint->s > 1 ? joint->end[SIDE_LIGHT].vertex->bounces[i] + (i == (int)y) : 0) +
                      (joint->t > 1 ? joint->end[SIDE_CAMERA].vertex->bounces[i] + (i == (int)x) : 0));
    return path_keeps_bounces(&it->settings, bounces);
}

bool joint_is_allowed(const struct integrator *it, const struct joint *joint)
{
    const struct vertex *y = joint->end[SIDE_LIGHT].vertex;
    enum scatter_class y_class = SCATTER_DIFFUSE, x_class = SCATTER_DIFFUSE;
    if (joint->s > 1)
        y_class = end_class(&joint->end[SIDE_LIGHT], joint->y_to_x);
    if (joint->t > 1)
        x_class = end_class(&joint->end[SIDE_CAMERA], negate(joint->y_to_x));
    if (!(y->kinds & (joint->t > 1 ? path_ray_kind(x_class) : RAY_CAMERA)))
        return false;
    if (joint->s > 1 && !(y[-1].kinds & path_ray_kind(y_class)))
        return false;
    return !it->limits_bounces || keeps_bounces(it, joint, y_class, x_class);
}

/* --- Ends -------------------------------------------------------------------------------------------------- */

void joint_set_end(struct joint *joint, enum side side, const struct subpath *path, int at,
                   const struct strand *strand, struct choice as)
{
    struct joint_end *end = &joint->end[side];
    end->path = path;
    end->vertex = &path->vertex[at];
    end->strand = strand;
    end->at = strand ? &strand->at[at] : &end->vertex->arrival;
    end->as = as;
    end->disperses = false;
    *(side == SIDE_LIGHT ? &joint->s : &joint->t) = at + 1;
}

static void light_end(const struct integrator *it, struct joint *joint)
{
    struct joint_end *end = &joint->end[SIDE_LIGHT];
    const struct light_point *light = &end->vertex->light;
    float direction = scene_pdf_light_direction(it->scene, light, joint->y_to_x);
    for (int i = 0; i < joint->lanes; i++) {
        end->draw[i] = path_light_draw(it, light, joint->lambda[i]);
        end->steps.value[i] = scene_light_emission(it->scene, light, joint->y_to_x, joint->lambda[i]);
        end->steps.pdf[i] = end->draw[i] * direction;
        end->steps.pdf_other[i] = 0;
    }
}

static void camera_end(const struct integrator *it, struct joint *joint)
{
    struct joint_end *end = &joint->end[SIDE_CAMERA];
    for (int i = 0; i < joint->lanes; i++) {
        end->draw[i] = spectrum_pdf(it->wavelengths.camera, joint->lambda[i]);
        end->steps.value[i] = joint->pdf_camera_direction;
        end->steps.pdf[i] = end->draw[i] * joint->pdf_camera_direction;
        end->steps.pdf_other[i] = 0;
    }
}

static void surface_end(struct joint *joint, enum side side)
{
    struct joint_end *end = &joint->end[side];
    const struct vertex *v = end->vertex;
    struct vec3 to_other = side == SIDE_LIGHT ? joint->y_to_x : negate(joint->y_to_x);
    bool dye = end->as.label == LABEL_FLUORESCENT;
    surface_steps(&v->surface, side, end->as.label, end->as.lobe, v->to_prev, to_other, joint->lanes,
                  dye ? end->at->lambda : joint->lambda, joint->lambda, v->memo, &end->steps);
    end->disperses = !dye && surface_elastic_disperses(&v->surface, v->to_prev, to_other);
    for (int i = 0; i < joint->lanes; i++)
        end->draw[i] = dye ? end->steps.draw[i] : end->at->draw[i];
}

/* What the connecting run's wavelength is drawn from on one side: the end itself, or the start of the run that it is in. */
static int origin_of(const struct integrator *it, const struct joint_end *end, enum side side)
{
    if (end->as.label == LABEL_ELASTIC)
        return end->at->origin;
    if (end->vertex->kind != VERTEX_SURFACE)
        return end->vertex->arrival.origin;
    return wavelengths_dye(&it->wavelengths, side, surface_fluorophore(&end->vertex->surface, end->as.lobe));
}

static bool is_dye(const struct joint_end *end)
{
    return end->vertex->kind == VERTEX_SURFACE && end->as.label == LABEL_FLUORESCENT;
}

void joint_name_run(const struct integrator *it, struct joint *joint)
{
    const struct joint_end *y = &joint->end[SIDE_LIGHT], *x = &joint->end[SIDE_CAMERA];
    joint->source = origin_of(it, y, SIDE_LIGHT);
    joint->sink = origin_of(it, x, SIDE_CAMERA);
    joint->dyes = y->at->dyes + x->at->dyes + is_dye(y) + is_dye(x);
}

bool joint_evaluate_end(const struct integrator *it, struct joint *joint, enum side side)
{
    struct joint_end *end = &joint->end[side];
    switch (end->vertex->kind) {
    case VERTEX_LIGHT: light_end(it, joint); break;
    case VERTEX_CAMERA: camera_end(it, joint); break;
    case VERTEX_SURFACE: surface_end(joint, side); break;
    }
    double live = 0;
    for (int i = 0; i < joint->lanes; i++)
        live += end->steps.value[i] * end->at->throughput[i];
    return live > 0;
}

/* What an end may send on to the other one. */
static float reach(const struct joint_end *end)
{
    return end->vertex->kind == VERTEX_SURFACE ? roulette_value(end->vertex, end->as.label) : 1;
}

bool joint_survives(const struct integrator *it, struct worker *w, struct joint *joint,
                    const double density[LANES_MAX], const float lambda_film[LANES_MAX])
{
    const struct joint_end *y = &joint->end[SIDE_LIGHT], *x = &joint->end[SIDE_CAMERA];
    double owed = joint->owed / technique_rate(it, joint->s, joint->t);
    double sum = 0, common = owed * (double)(joint->geometry * reach(y) * reach(x));
    if (joint->t < 2)
        return true;
    for (int i = 0; i < joint->lanes; i++)
        sum += roulette_color(it, lambda_film[i]) * y->at->throughput[i] * x->at->throughput[i] *
               (joint->s > 1 ? 1 : (double)y->steps.value[i]) /
               (density ? density[i] * joint->lanes : joint->lanes);
    joint->owed *= roulette(it, w, common * sum);
    return joint->owed > 0;
}

bool joint_evaluate(const struct integrator *it, struct worker *w, struct joint *joint,
                    const double density[LANES_MAX], const float lambda_film[LANES_MAX])
{
    bool from_light = joint->s == 1;
    return (!from_light || joint_evaluate_end(it, joint, SIDE_LIGHT)) &&
           joint_survives(it, w, joint, density, lambda_film) &&
           (from_light || joint_evaluate_end(it, joint, SIDE_LIGHT)) &&
           joint_evaluate_end(it, joint, SIDE_CAMERA);
}

/* --- Contributions ----------------------------------------------------------------------------------------- */

static void observe(const struct integrator *it, const struct worker *w, const struct joint *joint,
                    const double value[LANES_MAX], const double weight[LANES_MAX])
{
    for (int i = 0; i < joint->lanes; i++) {
        struct full_path path;
        full_path_of_joint(it, w, joint, i, &path);
        path.weight = weight[i];
        if (value[i] > 0)
            it->observe(it->observer, &path, value[i]);
    }
}

void joint_contribute(const struct integrator *it, struct worker *w, struct joint *joint,
                      const double density[LANES_MAX], const float lambda_film[LANES_MAX], const int splat[2])
{
    const struct joint_end *y = &joint->end[SIDE_LIGHT], *x = &joint->end[SIDE_CAMERA];
    double value[LANES_MAX], weight[LANES_MAX];
    double common = /* a look goes on with all (roulette.c) */
        (w->trial ? 1 : joint->owed) / technique_rate(it, joint->s, joint->t) * (double)joint->geometry;
    for (int i = 0; i < joint->lanes; i++)
        value[i] = common * y->at->throughput[i] * y->steps.value[i] * x->steps.value[i] *
                   x->at->throughput[i] / (density ? density[i] * joint->lanes : joint->lanes);
    if (!(lanes_sum(value, joint->lanes) > 0))
        return;
    attenuate(it, joint, value);
    if (w->trial)
        trial_count(w, joint);
    if (!(lanes_sum(value, joint->lanes) > 0))
        return;
    joint_name_run(it, joint);
    if (it->cuts == CUTS_CHOSEN)
        mis_weigh_plainly(it, w, joint, weight);
    else
        tally_weigh(it, w, joint, weight);
    for (int i = 0; i < joint->lanes; i++) {
        value[i] *= weight[i];
        if (!(value[i] > 0) || !isfinite(value[i]))
            value[i] = 0;
        else if (splat && w->trial)
            continue;
        else if (splat) {
            film_splat(it->film, splat[0], splat[1], value[i], lambda_film[i], it->kappa);
            w->all += it->kappa * value[i] * gather_cmf_sum(lambda_film[i]);
        } else
            film_sample_add(it->film, &w->gathered, value[i], lambda_film[i], it->kappa);
        w->taken += splat ? 0 : value[i];
    }
    if (w->trial)
        trial_add_joint(it, w, joint, value, lambda_film, splat);
    if (it->observe)
        observe(it, w, joint, value, weight);
}

/* --- Vertices that are drawn for one connection --------------------------------------------------------------- */

bool joint_camera_vertex(const struct integrator *it, const struct vertex *y, struct vertex *x,
                         const float u[4], int pixel[2], float *pdf_direction)
{
    float at[2], width = it->settings.filter_width;
    vertex_begin(x, VERTEX_CAMERA);
    x->unbounded = scene_camera_is_orthographic(it->scene);
    const struct hit *seen = y->in_volume                ? NULL
                             : y->kind == VERTEX_SURFACE ? &y->hit
                             : y->light.on_mesh          ? &y->light.hit
                                                         : NULL;
    if (seen && scene_hit_is_holdout(it->scene, seen))
        return false;
    if (y->kind == VERTEX_LIGHT && (y->unbounded || !scene_light_seen_by_camera(it->scene, &y->light)))
        return false;
    if (!scene_camera_connect(it->scene, y->position, width, u, &x->lens, at, pdf_direction))
        return false;
    /* One of the pixels whose camera samples look through `at`, as often as they do. */
    float weight[2];
    for (int i = 0; i < 2; i++)
        pixel[i] = film_filter_pixel(width, at[i], u[2 + i], &weight[i]);
    arrival_begin(&x->arrival, it->lanes, weight[0] * weight[1], wavelengths_sink_camera(&it->wavelengths));
    x->position = x->lens.position;
    if (it->has_volumes) {
        struct vec3 direction = x->unbounded ? x->lens.axis : normalize(sub(y->position, x->position));
        x->inside.media = scene_camera_media(it->scene, camera_start(x, direction), direction);
    }
    return pixel[0] >= it->border[0] && pixel[0] < it->border[2] && pixel[1] >= it->border[1] &&
           pixel[1] < it->border[3];
}
