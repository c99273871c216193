/* Progressive passes. A batch of whole passes is traced into a film of its own and merged into the session's film when it is
   whole: what a cancel breaks off is dropped, so the film's sample range is always true and parts merge to the same bits.
   Of a first pass that is broken off there is nothing else to show: the pixels that were done stay (keep_part). */
#include "session/passes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/os.h"
#include "base/thread.h"

#define UNIT_PIXELS 16 /* a unit of work is one sample of so many pixels squared */
#define PROGRESS_EVERY_S 0.1
#define REFRESH_EVERY_S 0.1
#define FIRST_PASS_CHUNK_S 0.5 /* the first pass is shown as it grows */
#define REFRESH_SHARE 20       /* the picture is refreshed when that costs no more than 1/20 of the time, */
#define FIRST_REFRESH_SHARE 8  /* or 1/8 while the first pass grows */
#define MERGE_SHARE 50         /* a batch lasts so much longer than its merge */
#define BATCH_MIN_S 0.1
#define BATCH_MAX_S 5.0

bool passes_should_stop(void *context)
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

void passes_tell(struct render *render, bool always)
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

void passes_show(struct render *render, const struct film *film, int divisor, int samples)
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

void passes_place(struct render *render)
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
        if (passes_should_stop(render))
            return;
        for (int x = x0; x < x1; x++)
            integrator_sample(render->integrator, worker, x, y, sample);
        if (render->done)
            mark_row(render, x0, x1, y);
    }
    atomic_fetch_add_explicit(&render->units_done, 1, memory_order_relaxed);
    if (worker == 0)
        passes_tell(render, false);
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
    while (render->batch_offset < render->units && !passes_should_stop(render)) {
        size_t left = render->units - render->batch_offset;
        size_t count = chunk < left ? chunk : left;
        double before = os_seconds();
        thread_run(render->threads, count, trace_unit, passes_should_stop, render);
        double took = os_seconds() - before;
        render->batch_offset += count;
        chunk = took < FIRST_PASS_CHUNK_S / 2 ? chunk * 2 : chunk;
        if (render->batch_offset < render->units && os_seconds() > render->refresh_at)
            passes_show(render, render->pass, 1, 0);
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

/* The sample at which a batch has to end: the last, that before which the integrator looks again, or that of the next snapshot, 2^k
   samples from the first. */
static int next_stop(const struct render *render)
{
    int traced = render->film->end_sample - render->first_sample,
        look = integrator_next_look(render->integrator, render->film->end_sample);
    int64_t stop = 1, last = look < render->end_sample ? look : render->end_sample;
    if (!render->session->listener.snapshot)
        return (int)last;
    while (stop <= traced)
        stop *= 2;
    return render->first_sample + stop < last ? render->first_sample + (int)stop : (int)last;
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

bool passes_trace(struct render *render, stokes_error *err)
{
    int passes = 1;
    double pass_s = 0;
    while (render->film->end_sample < render->end_sample && !passes_should_stop(render)) {
        bool first = render->film->end_sample == render->first_sample;
        if (!first && out_of_time(render, pass_s))
            break;
        integrator_look(render->integrator, render->film->end_sample, passes_should_stop, render);
        double before = os_seconds();
        passes = first ? 1 : batch_passes(render, passes, pass_s);
        render->batch_sample = render->film->end_sample;
        if (first && !trace_first_pass(render, err))
            return false;
        if (!first)
            thread_run(render->threads, render->units * (size_t)passes, trace_unit, passes_should_stop,
                       render);
        if (atomic_load(&render->stopped) && !(first && first_is_whole(render)))
            break;
        if (!merge_batch(render, passes, err))
            return false;
        pass_s = (os_seconds() - before) / passes;
        if (!take_snapshot(render, err))
            return false;
        int samples = render->film->end_sample - render->first_sample;
        if (render->film->end_sample < render->end_sample && os_seconds() > render->refresh_at)
            passes_show(render, render->film, samples, samples);
    }
    return true;
}
