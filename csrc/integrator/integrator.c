/* One sample of one pixel: camera sub-path, light sub-path, connections; and what is prepared for that once per scene. */
#include "integrator/integrator.h"

#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "integrator/connect.h"
#include "integrator/exact.h"
#include "integrator/joint.h"
#include "integrator/kinds.h"
#include "integrator/path.h"
#include "integrator/relight.h"

struct integrator_settings integrator_settings_default(void)
{
    return (struct integrator_settings){
        .name = "bdpt",
        .lanes = 1,
        .d0_nm = 50,
        .shrink = 0.2,
        .kernel = KERNEL_CONSTANT,
        .mollify_side = SIDE_LIGHT,
        .max_path = PATH_EDGES_MAX,
        .max_camera = PATH_EDGES_MAX,
        .max_light = PATH_EDGES_MAX,
        .max_diffuse = PATH_EDGES_MAX,
        .max_glossy = PATH_EDGES_MAX,
        .max_transmission = PATH_EDGES_MAX,
        .max_volume = PATH_EDGES_MAX,
        .max_transparent = PATH_EDGES_MAX,
        .roulette_start = 4,
        .lambda_min = 300,
        .lambda_max = 830,
        .filter_width = 1.5f,
        .all_techniques = true,
    };
}

const char *integrator_name_at(size_t index)
{
    const struct integrator_kind *kind = integrator_kind_at(index);
    return kind ? kind->name : NULL;
}

/* The techniques of the kind, of the user's choice, and within the limits on depth; and the longest sub-paths that they need. */
static void choose_techniques(struct integrator *it, const struct integrator_kind *kind)
{
    struct integrator_settings *settings = &it->settings;
    bool splats = false;
    for (int s = 0; s < TECHNIQUES_MAX; s++)
        for (int t = 0; t < TECHNIQUES_MAX; t++) {
            bool chosen = settings->all_techniques || settings->technique[s][t];
            bool fits = t >= 1 && s + t >= 2 && s + t - 1 <= settings->max_path &&
                        s - 1 <= settings->max_light && t - 1 <= settings->max_camera;
            bool used = chosen && fits && kind->uses(s, t);
            settings->technique[s][t] = used;
            it->traces_camera |= used && t >= 2;
            it->traces_light |= used && (s >= 2 || t == 1);
            splats |= used && t == 1;
            it->connects |= used && s >= 1;
            it->meets |= used && s >= 2 && t >= 2;
            if (used && t - 1 > it->camera_edges)
                it->camera_edges = t - 1;
            if (used && (s >= 2 || t == 1) && s - 1 > it->light_edges)
                it->light_edges = s - 1;
        }
    it->splats = splats;
    int edges = settings->max_path;
    it->limits_bounces = settings->max_diffuse < edges || settings->max_glossy < edges ||
                         settings->max_transmission < edges || settings->max_volume < edges;
}

/* How the cuts of a path of each length share it. */
static enum cuts name_cuts(const struct integrator_settings *settings)
{
    bool one = true, lights = true, all = true;
    for (int edges = 1; edges <= settings->max_path; edges++) {
        int used = 0;
        for (int s = 0; s <= edges; s++) {
            bool is = settings->technique[s][edges + 1 - s];
            used += is;
            lights &= is == (s <= 1 && edges + 1 - s >= 2);
            all &= is;
        }
        one &= used <= 1;
    }
    return one ? CUTS_ONE : all ? CUTS_ALL : lights ? CUTS_LIGHTS : CUTS_CHOSEN;
}

static bool check_settings(const struct integrator_settings *s, stokes_error *err)
{
    if (!(s->lambda_min >= 100) || !(s->lambda_max <= 3000) || !(s->lambda_min + 1 <= s->lambda_max))
        return fail(err, "settings", "lambda_min, lambda_max",
                    "%g to %g nm is no range within 100 to 3000 nm", s->lambda_min, s->lambda_max);
    if (!(s->d0_nm > 0) || !(s->d0_nm <= 1000) || !(s->shrink >= 0) || !(s->shrink <= 2))
        return fail(err, "settings", "d0, shrink", "%g nm and %g are not within (0, 1000] nm and [0, 2]",
                    s->d0_nm, s->shrink);
    if (s->max_path < 1 || s->max_path > PATH_EDGES_MAX || s->max_camera < 0 ||
        s->max_camera > PATH_EDGES_MAX || s->max_light < 0 || s->max_light > PATH_EDGES_MAX)
        return fail(err, "settings", "max_path, max_camera, max_light",
                    "%d, %d, %d are not within 0 to %d edges", s->max_path, s->max_camera, s->max_light,
                    PATH_EDGES_MAX);
    if (!(s->light_paths >= 0) || !(s->light_paths <= LIGHT_PATHS_MAX))
        return fail(err, "settings", "light_paths", "%g is not within 0 to %d", s->light_paths,
                    LIGHT_PATHS_MAX);
    if (s->lanes != 1 && s->lanes != 4 && s->lanes != 8)
        return fail(err, "settings", "lanes", "%d is not 1, 4 or 8", s->lanes);
    return true;
}

static void warn_of_invisible_lights(const struct integrator *it, void (*warn)(void *, const stokes_error *),
                                     void *user)
{
    if (it->connects || !warn)
        return;
    for (int i = 0; i < scene_light_count(it->scene); i++)
        if (scene_light_is_delta(it->scene, i)) {
            stokes_error what;
            fail(&what, scene_light_name(it->scene, i), "light",
                 "has no area or angle, so integrator %s cannot see it and leaves it out", it->settings.name);
            warn(user, &what);
        }
}

static bool create_subpath(struct subpath *path)
{
    path->vertex = calloc(PATH_VERTICES, sizeof *path->vertex);
    path->memo = calloc(PATH_VERTICES * MEMOS, sizeof *path->memo);
    for (int i = 0; path->vertex && path->memo && i < PATH_VERTICES; i++) {
        path->vertex[i].memo = &path->memo[i * MEMOS];
        path->vertex[i].inside.ahead = path->vertex[i].inside.back = 1;
    }
    return path->vertex && path->memo;
}

static bool create_worker(const struct integrator *it, struct worker *w)
{
    size_t bins = (size_t)it->film->bins;
    w->gathered.bin = bins ? calloc(bins, sizeof *w->gathered.bin) : NULL;
    w->sight = calloc((size_t)PATH_VERTICES * PATH_VERTICES, sizeof *w->sight);
    w->haze = it->has_volumes ? calloc((size_t)PATH_VERTICES * PATH_VERTICES, sizeof *w->haze) : NULL;
    for (int side = 0; side < SIDES; side++)
        w->strand[side] = calloc(1, sizeof *w->strand[side]);
    for (int i = 0; w->sight && w->haze && i < PATH_VERTICES * PATH_VERTICES; i++)
        w->sight[i].haze = &w->haze[i];
    return create_subpath(&w->camera) && create_subpath(&w->light) && create_subpath(&w->copy) && w->sight &&
           (w->haze || !it->has_volumes) && w->strand[SIDE_LIGHT] && w->strand[SIDE_CAMERA] &&
           (!bins || w->gathered.bin);
}

static bool create_workers(struct integrator *it, stokes_error *err)
{
    it->worker = calloc((size_t)it->worker_count, sizeof *it->worker);
    bool good = it->worker;
    for (int i = 0; good && i < it->worker_count; i++)
        good = create_worker(it, &it->worker[i]);
    return good || fail(err, "integrator", "memory", "not enough for %d workers", it->worker_count);
}

static void destroy_worker(struct worker *w)
{
    struct subpath *paths[] = {&w->camera, &w->light, &w->copy};
    for (int i = 0; i < 3; i++) {
        free(paths[i]->vertex);
        free(paths[i]->memo);
    }
    free(w->gathered.bin);
    free(w->sight);
    free(w->haze);
    free(w->strand[SIDE_LIGHT]);
    free(w->strand[SIDE_CAMERA]);
}

struct integrator *integrator_create(const struct integrator_settings *settings, const struct scene *scene,
                                     struct film *film, int threads,
                                     void (*warn)(void *, const stokes_error *), void *user,
                                     stokes_error *err)
{
    const struct integrator_kind *kind = integrator_kind_find(settings->name);
    if (!kind) {
        fail(err, "settings", "integrator", "there is no '%s'", settings->name);
        return NULL;
    }
    if (!check_settings(settings, err))
        return NULL;
    struct integrator *it = calloc(1, sizeof *it);
    if (!it) {
        fail(err, "integrator", "memory", "not enough");
        return NULL;
    }
    it->settings = *settings;
    it->settings.name = kind->name;
    it->exact = kind->exact;
    it->scene = scene;
    it->film = film;
    it->kappa = cmf_normalization(settings->lambda_min, settings->lambda_max);
    it->worker_count = threads > 1 ? threads : 1;
    it->has_volumes = scene_has_volumes(scene);
    it->has_barriers = scene_has_barriers(scene);
    scene_camera_size(scene, it->full, it->border);
    it->lanes = settings->lanes;
    it->light_paths = settings->light_paths > 0 ? settings->light_paths : 1;
    it->splat_trust = scene_camera_blurs(scene) ? 1 : 0.5 / (it->lanes * it->lanes);
    choose_techniques(it, kind);
    it->cuts = name_cuts(&it->settings);
    if (!wavelengths_create(&it->wavelengths, settings, scene, err) || !create_workers(it, err)) {
        integrator_destroy(it);
        return NULL;
    }
    if (settings->shared_wavelength &&
        (it->exact || it->lanes > 1 || it->light_paths != 1 || it->wavelengths.fluorophores > 0)) {
        fail(err, "settings", "shared_wavelength",
             "is for mbdpt, one lane, one light path, and a scene without fluorescence");
        integrator_destroy(it);
        return NULL;
    }
    warn_of_invisible_lights(it, warn, user);
    return it;
}

void integrator_destroy(struct integrator *it)
{
    if (!it)
        return;
    for (int i = 0; it->worker && i < it->worker_count; i++)
        destroy_worker(&it->worker[i]);
    free(it->worker);
    wavelengths_destroy(&it->wavelengths);
    free(it);
}

double integrator_unconnected_share(const struct integrator *it)
{
    double all = 0, unconnected = 0;
    for (int i = 0; i < it->worker_count; i++) {
        all += it->worker[i].all;
        unconnected += it->worker[i].unconnected;
    }
    return all > 0 ? unconnected * it->kappa / all : 0;
}

bool integrator_splats(const struct integrator *it)
{
    return it->splats;
}

/* Light sub-paths beyond the first are seen by the camera, and that is all. */
static void trace_lights(const struct integrator *it, struct worker *w, const struct random_path *random)
{
    void (*see)(const struct integrator *, struct worker *) = it->exact ? exact_see_lights : connect_lenses;
    for (int i = 1; i < w->light_paths; i++) {
        w->random = random_branch(*random, (uint32_t)i);
        w->light.count = 0;
        path_trace_light(it, w);
        see(it, w);
    }
}

void integrator_trace(const struct integrator *it, struct worker *w, int x, int y, uint32_t seed, int sample)
{
    const struct integrator_settings *settings = &it->settings;
    bool inside = x >= it->border[0] && x < it->border[2] && y >= it->border[1] && y < it->border[3];
    w->random = random_path(seed, (uint32_t)y * (uint32_t)it->full[0] + (uint32_t)x, (uint32_t)sample);
    w->half_width_nm = (float)(settings->d0_nm * pow(sample + 1, -settings->shrink));
    w->reach_nm = 1 / (double)kernel_density(settings->kernel, 550, 550, w->half_width_nm);
    w->camera.count = w->light.count = w->copy.count = 0;
    w->sightings = w->spins = 0;
    w->taken = 0;
    w->hole = w->veil = 0;
    w->stamp++;
    film_sample_clear(it->film, &w->gathered);
    w->gathered.alpha = settings->film_transparent ? 0 : 1;
    if (inside && it->traces_camera) {
        float width = settings->filter_width;
        path_trace_camera(it, w, (float)x + 0.5f + film_filter_sample(width, random_at(w->random, DIM_FILM)),
                          (float)y + 0.5f + film_filter_sample(width, random_at(w->random, DIM_FILM + 1)));
    }
    w->light_paths = it->traces_light && (inside || it->splats)
                         ? (int)(it->light_paths + (double)random_at(w->random, DIM_LIGHT_PATHS))
                         : 0;
    if (w->light_paths > 0)
        path_trace_light(it, w);
    if (w->camera.count > 1 || w->hole > 0)
        w->gathered.alpha = 1 - w->hole;
    else if (settings->film_transparent)
        w->gathered.alpha = w->veil;
    if (it->connects)
        (it->exact ? exact_connect_all : connect_all)(it, w);
    if (it->splats && w->light_paths > 1) {
        struct random_path random = w->random;
        trace_lights(it, w, &random);
    }
}

void integrator_sample(struct integrator *it, int worker, int x, int y, int sample)
{
    struct worker *w = &it->worker[worker];
    integrator_trace(it, w, x, y, it->settings.seed, sample);
    if (x >= it->border[0] && x < it->border[2] && y >= it->border[1] && y < it->border[3])
        film_add(it->film, x, y, &w->gathered);
    w->all += w->gathered.xyz[0] + w->gathered.xyz[1] + w->gathered.xyz[2];
}
