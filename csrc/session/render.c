/* A whole render: its settings, the committed scene, films and integrator; then the passes, and what is left of them. */
#include "base/error.h"
#include "base/os.h"
#include "session/passes.h"

static bool pick_samples(struct render *render, const stokes_overrides *o, stokes_error *err)
{
    render->first_sample = o && o->first_sample >= 0 ? o->first_sample : render->session->first_sample;
    render->end_sample = o && o->end_sample >= 0 ? o->end_sample : render->session->end_sample;
    if (render->first_sample < render->end_sample)
        return true;
    return fail(err, "render", "samples", "[%d, %d) is empty", render->first_sample, render->end_sample);
}

static bool is_cancelled(void *user)
{
    const stokes_listener *listener = &((stokes_session *)user)->listener;
    return listener->cancelled && listener->cancelled(listener->user);
}

bool session_commit(stokes_session *session, const struct session_settings *settings, stokes_error *err)
{
    const struct scene_setup setup = {
        .range = {settings->integrator.lambda_min, settings->integrator.lambda_max},
        .uv_rule = settings->uv_rule,
        .working_space = session->color.working_space,
        .threads = session_threads(settings),
        .warn = session_warn,
        .stop = is_cancelled,
        .user = session,
    };
    return scene_commit(session->scene, &setup, err);
}

static bool make_films(struct render *render, const struct integrator_settings *s, stokes_error *err)
{
    int full[2], border[4];
    const struct range bins = {s->bins_min, s->bins_max};
    scene_camera_size(render->session->scene, full, border);
    render->film = film_create(full[0], full[1], border, s->spectral_bins, bins, err);
    render->pass = render->film ? film_create(full[0], full[1], border, s->spectral_bins, bins, err) : NULL;
    if (!render->pass)
        return false;
    render->film->first_sample = render->film->end_sample = render->first_sample;
    return true;
}

static bool check_picture(const struct render *render, size_t floats, stokes_error *err)
{
    size_t needs = (size_t)render->film->width * (size_t)render->film->height * 4;
    if (!render->picture || floats >= needs)
        return true;
    return fail(err, "render", "film", "the picture's memory holds %zu floats; it needs %zu", floats, needs);
}

static bool prepare(struct render *render, size_t picture_floats, stokes_error *err)
{
    stokes_session *session = render->session;
    const struct integrator_settings *s = &render->settings.integrator;
    if (!make_films(render, s, err) || !check_picture(render, picture_floats, err))
        return false;
    render->integrator =
        integrator_create(s, session->scene, render->pass, render->threads, session_warn, session, err);
    if (!render->integrator)
        return false;
    passes_place(render);
    return true;
}

/* The film, if any, is the session's from here on, and the report is written. */
static void finish(struct render *render)
{
    stokes_session *session = render->session;
    session->seconds = os_seconds() - render->start;
    session->cancelled = atomic_load(&render->stopped);
    session->film = render->film;
    render->film = NULL;
    session_write_report(session);
    if (!session->film)
        return;
    passes_show(render, session->film, film_divisor(session->film), stokes_session_samples(session));
    passes_tell(render, true);
}

static bool trace(struct render *render, size_t picture_floats, stokes_error *err)
{
    if (!prepare(render, picture_floats, err))
        return false;
    render->start = os_seconds();
    return passes_trace(render, err);
}

bool stokes_session_render(stokes_session *session, const stokes_overrides *overrides, float *picture,
                           size_t picture_floats, stokes_error *err)
{
    struct render render = {.session = session,
                            .settings = session->settings,
                            .space = &session->color.working_space,
                            .picture = picture,
                            .start = os_seconds()};
    if ((overrides && !session_settings_override(&render.settings, overrides, err)) ||
        !pick_samples(&render, overrides, err))
        return false;
    render.threads = session_threads(&render.settings);
    bool committed = session->has_camera ? session_commit(session, &render.settings, err)
                                         : fail(err, "scene", "camera", "the scene has no camera");
    if (!committed && !passes_should_stop(&render))
        return false;
    /* The last picture goes first: with spectral bins a film is large. */
    film_destroy(session->film);
    session->film = NULL;
    session->rendered = render.settings;
    session_fingerprint(session, &session->rendered, session->fingerprint);
    bool good = !committed || trace(&render, picture_floats, err);
    session->light_paths =
        render.integrator ? integrator_light_paths(render.integrator, &session->light_paths_from) : 0;
    session->unconnected_share = render.integrator ? integrator_unconnected_share(render.integrator) : 0;
    if (good)
        finish(&render);
    integrator_destroy(render.integrator);
    film_destroy(render.film);
    film_destroy(render.pass);
    return good;
}
