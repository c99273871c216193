/* Progressive passes. A batch of whole passes is traced into a film of its own and merged into the session's film when it is
   whole: what a cancel breaks off is dropped, so the film's sample range is always true and parts merge to the same bits.
   Of a first pass that is broken off there is nothing else to show: the pixels that were done stay (keep_part). */
#include <limits.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/os.h"
#include "base/thread.h"
#include "session/session.h"

#define UNIT_PIXELS 16 /* a unit of work is one sample of so many pixels squared */
#define PROGRESS_EVERY_S 0.1
#define REFRESH_EVERY_S 0.1
#define FIRST_PASS_CHUNK_S 0.5 /* the first pass is shown as it grows */
#define REFRESH_SHARE 20       /* the picture is refreshed when that costs no more than 1/20 of the time, */
#define FIRST_REFRESH_SHARE 8  /* or 1/8 while the first pass grows */
#define MERGE_SHARE 50         /* a batch lasts so much longer than its merge */
#define BATCH_MIN_S 0.1
#define BATCH_MAX_S 5.0

struct render {
    stokes_session *session;
    struct session_settings settings; /* with the overrides */
    struct integrator *integrator;
    struct film *film, *pass;
    struct working_space *space;
    float *picture; /* NULL: nobody looks */
    int area[4]; /* pixels to trace: the border's, or the whole frame's where splats come in from outside */
    size_t columns, units;
    int threads, first_sample, end_sample;
    double start, progress_at, refresh_at, merge_s;
    atomic_size_t units_done;
    atomic_bool stopped;
    uint8_t *done;        /* while the first pass is traced: which pixels of the film are; else NULL */
    atomic_size_t traced; /* pixels of `area` of the first pass */
    int batch_sample;     /* what the workers trace now: sample of unit 0 */
    size_t batch_offset;  /* units of the batch that earlier chunks have traced */
};

static bool should_stop(void *context)
{
    struct render *render = context;
    const stokes_listener *listener = &render->session->listener;
    if (atomic_load_explicit(&render->stopped, memory_order_relaxed))
        return true;
    if (!listener->cancelled || !listener->cancelled(listener->user))
        return false;
    atomic_store_explicit(&render->stopped, true, memory_order_relaxed);
    return true;
}

/* --- Telling ----------------------------------------------------------------------------------------------- */

static void tell_progress(struct render *render, bool always)
{
    const stokes_listener *listener = &render->session->listener;
    double now = os_seconds();
    if (!listener->progress || (!always && now - render->progress_at < PROGRESS_EVERY_S))
        return;
    render->progress_at = now;
    int samples = render->end_sample - render->first_sample;
    size_t done = atomic_load_explicit(&render->units_done, memory_order_relaxed);
    double seconds = now - render->start, share = (double)done / ((double)render->units * samples);
    double remaining = share > 0 ? seconds / share - seconds : -1;
    double limit = render->settings.time_limit_s;
    if (limit > 0 && (remaining < 0 || remaining > limit - seconds))
        remaining = fmax(0, limit - seconds);
    listener->progress(listener->user, (int)(done / render->units), samples, seconds, remaining);
}

struct resolving {
    struct render *render;
    const struct film *film;
    int divisor;
};

static void resolve_row(void *context, size_t row, int worker)
{
    const struct resolving *r = context;
    (void)worker;
    film_resolve_row(r->film, r->render->space, r->divisor, (int)row, r->render->picture);
}

/* `samples` is what the listener hears: 0 while the first pass grows. */
static void refresh_picture(struct render *render, const struct film *film, int divisor, int samples)
{
    const stokes_listener *listener = &render->session->listener;
    double now = os_seconds();
    if (!render->picture || divisor < 1)
        return;
    struct resolving resolving = {render, film, divisor};
    thread_run(render->threads, (size_t)film->height, resolve_row, NULL, &resolving);
    double after = os_seconds();
    render->refresh_at =
        after + fmax(REFRESH_EVERY_S, (after - now) * (samples > 0 ? REFRESH_SHARE : FIRST_REFRESH_SHARE));
    const int rect[4] = {0, 0, film->width, film->height};
    if (listener->tile)
        listener->tile(listener->user, rect, samples);
}

/* --- Tracing ----------------------------------------------------------------------------------------------- */

/* A row of a unit of the first pass has its sample. */
static void mark_row(struct render *render, int x0, int x1, int y)
{
    const struct film *film = render->pass;
    atomic_fetch_add_explicit(&render->traced, (size_t)(x1 - x0), memory_order_relaxed);
    x0 = x0 > film->x0 ? x0 - film->x0 : 0;
    x1 = (x1 < film->x0 + film->width ? x1 : film->x0 + film->width) - film->x0;
    y -= film->y0;
    if (x0 < x1 && y >= 0 && y < film->height)
        memset(render->done + (size_t)y * (size_t)film->width + x0, 1, (size_t)(x1 - x0));
}

/* Units run from the top row down, pass after pass. */
static void trace_unit(void *context, size_t index, int worker)
{
    struct render *render = context;
    index += render->batch_offset;
    int sample = render->batch_sample + (int)(index / render->units);
    size_t unit = index % render->units;
    int x0 = render->area[0] + (int)(unit % render->columns) * UNIT_PIXELS;
    int y1 = render->area[3] - (int)(unit / render->columns) * UNIT_PIXELS;
    int x1 = x0 + UNIT_PIXELS < render->area[2] ? x0 + UNIT_PIXELS : render->area[2];
    int y0 = y1 - UNIT_PIXELS > render->area[1] ? y1 - UNIT_PIXELS : render->area[1];
    for (int y = y0; y < y1; y++) {
        if (should_stop(render))
            return;
        for (int x = x0; x < x1; x++)
            integrator_sample(render->integrator, worker, x, y, sample);
        if (render->done)
            mark_row(render, x0, x1, y);
    }
    atomic_fetch_add_explicit(&render->units_done, 1, memory_order_relaxed);
    if (worker == 0)
        tell_progress(render, false);
}

static size_t area_pixels(const struct render *render)
{
    const int *area = render->area;
    return (size_t)(area[2] - area[0]) * (size_t)(area[3] - area[1]);
}

/* Whether the first pass was traced to its end, perhaps while a cancel came. */
static bool first_is_whole(const struct render *render)
{
    return render->traced == area_pixels(render);
}

/* What is kept of a first pass that is broken off. */
static void keep_part(struct render *render)
{
    struct film *part = render->pass;
    if (render->traced == 0 || first_is_whole(render))
        return;
    render->session->share = (double)render->traced / (double)area_pixels(render);
    part->first_sample = render->first_sample;
    film_close_part(part, render->done, render->session->share);
    render->pass = render->film;
    render->film = part;
}

/* The first pass in chunks, each followed by a look at what there is. Its splats go to the film that is still empty: apart from
   what pixels got from the camera, whichever of the two is broken off. False: no memory. */
static bool trace_first_pass(struct render *render, stokes_error *err)
{
    size_t pixels = (size_t)render->film->width * (size_t)render->film->height;
    if (!(render->done = calloc(pixels, 1)))
        return fail(err, "film", "resolution", "no memory for %zu pixels", pixels);
    render->pass->splats = render->film;
    size_t chunk = (size_t)render->threads * 4;
    while (render->batch_offset < render->units && !should_stop(render)) {
        size_t left = render->units - render->batch_offset;
        size_t count = chunk < left ? chunk : left;
        double before = os_seconds();
        thread_run(render->threads, count, trace_unit, should_stop, render);
        double took = os_seconds() - before;
        render->batch_offset += count;
        chunk = took < FIRST_PASS_CHUNK_S / 2 ? chunk * 2 : chunk;
        if (render->batch_offset < render->units && os_seconds() > render->refresh_at)
            refresh_picture(render, render->pass, 1, 0);
    }
    render->batch_offset = 0;
    if (atomic_load(&render->stopped))
        keep_part(render);
    render->pass->splats = NULL;
    free(render->done);
    render->done = NULL;
    return true;
}

static bool merge_batch(struct render *render, int passes, stokes_error *err)
{
    double before = os_seconds();
    render->pass->first_sample = render->batch_sample;
    render->pass->end_sample = render->batch_sample + passes;
    if (!film_merge(render->film, render->pass, err))
        return false;
    film_clear(render->pass);
    render->merge_s = os_seconds() - before;
    return true;
}

/* The sample at which a batch has to end: the last, or that of the next snapshot, 2^k samples from the first. */
static int next_stop(const struct render *render)
{
    int samples = render->end_sample - render->first_sample,
        traced = render->film->end_sample - render->first_sample;
    int64_t stop = 1;
    if (!render->session->listener.snapshot)
        return render->end_sample;
    while (stop <= traced)
        stop *= 2;
    return stop < samples ? render->first_sample + (int)stop : render->end_sample;
}

/* The film is the session's for the call, so that it can be written as after a render. */
static bool take_snapshot(struct render *render, stokes_error *err)
{
    stokes_session *session = render->session;
    int samples = render->film->end_sample - render->first_sample;
    if (!session->listener.snapshot || (samples & (samples - 1)) != 0)
        return true;
    session->film = render->film;
    bool good = session->listener.snapshot(session->listener.user, session, samples, err);
    session->film = NULL;
    return good;
}

/* How many passes next: enough that merging costs little, few enough that a cancel loses little and a limit is kept. */
static int batch_passes(const struct render *render, int last, double pass_s)
{
    double target = fmin(fmax(BATCH_MIN_S, render->merge_s * MERGE_SHARE), BATCH_MAX_S);
    double limit = render->settings.time_limit_s;
    if (limit > 0)
        target = fmin(target, limit - (os_seconds() - render->start));
    double fits = fmin(target / fmax(pass_s, 1e-9), 2.0 * last);
    int left = next_stop(render) - render->film->end_sample;
    return fits >= left ? left : fits < 1 ? 1 : (int)fits;
}

static bool out_of_time(const struct render *render, double pass_s)
{
    double limit = render->settings.time_limit_s;
    return limit > 0 && os_seconds() - render->start + pass_s > limit;
}

static bool trace_passes(struct render *render, stokes_error *err)
{
    int passes = 1;
    double pass_s = 0;
    while (render->film->end_sample < render->end_sample && !should_stop(render)) {
        bool first = render->film->end_sample == render->first_sample;
        if (!first && out_of_time(render, pass_s))
            break;
        double before = os_seconds();
        passes = first ? 1 : batch_passes(render, passes, pass_s);
        render->batch_sample = render->film->end_sample;
        if (first && !trace_first_pass(render, err))
            return false;
        if (!first)
            thread_run(render->threads, render->units * (size_t)passes, trace_unit, should_stop, render);
        if (atomic_load(&render->stopped) && !(first && first_is_whole(render)))
            break;
        if (!merge_batch(render, passes, err))
            return false;
        pass_s = (os_seconds() - before) / passes;
        if (!take_snapshot(render, err))
            return false;
        int samples = render->film->end_sample - render->first_sample;
        if (render->film->end_sample < render->end_sample && os_seconds() > render->refresh_at)
            refresh_picture(render, render->film, samples, samples);
    }
    return true;
}

/* --- A whole render ---------------------------------------------------------------------------------------- */

static bool pick_samples(struct render *render, const stokes_overrides *o, stokes_error *err)
{
    render->first_sample = o && o->first_sample >= 0 ? o->first_sample : render->session->first_sample;
    render->end_sample = o && o->end_sample >= 0 ? o->end_sample : render->session->end_sample;
    if (render->first_sample < render->end_sample)
        return true;
    return fail(err, "render", "samples", "[%d, %d) is empty", render->first_sample, render->end_sample);
}

static bool commit_is_cancelled(void *user)
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
        .stop = commit_is_cancelled,
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

static void place_units(struct render *render)
{
    const struct film *film = render->film;
    bool whole = integrator_splats(render->integrator);
    const int border[4] = {film->x0, film->y0, film->x0 + film->width, film->y0 + film->height};
    const int frame[4] = {0, 0, film->full_width, film->full_height};
    for (int i = 0; i < 4; i++)
        render->area[i] = whole ? frame[i] : border[i];
    size_t width = (size_t)(render->area[2] - render->area[0]),
           height = (size_t)(render->area[3] - render->area[1]);
    render->columns = (width + UNIT_PIXELS - 1) / UNIT_PIXELS;
    render->units = render->columns * ((height + UNIT_PIXELS - 1) / UNIT_PIXELS);
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
    place_units(render);
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
    refresh_picture(render, session->film, film_divisor(session->film), stokes_session_samples(session));
    tell_progress(render, true);
}

static bool trace(struct render *render, size_t picture_floats, stokes_error *err)
{
    if (!prepare(render, picture_floats, err))
        return false;
    render->start = os_seconds();
    return trace_passes(render, err);
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
    if (!committed && !should_stop(&render))
        return false;
    /* The last picture goes first: with spectral bins a film is large. */
    film_destroy(session->film);
    session->film = NULL;
    session->rendered = render.settings;
    session_fingerprint(session, &session->rendered, session->fingerprint);
    bool good = !committed || trace(&render, picture_floats, err);
    session->unconnected_share = render.integrator ? integrator_unconnected_share(render.integrator) : 0;
    if (good)
        finish(&render);
    integrator_destroy(render.integrator);
    film_destroy(render.film);
    film_destroy(render.pass);
    return good;
}
