/* The passes of a render. Private to render.c and passes.c. */
#ifndef SESSION_PASSES_H
#define SESSION_PASSES_H

#include <stdatomic.h>

#include "session/session.h"

/* What a render has while it lasts. */
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

/* What is to be traced, in units of work: from the film and the integrator. */
void passes_place(struct render *);
/* Passes until the last, a cancel or the end of the time. */
bool passes_trace(struct render *, stokes_error *err);

/* Whether a cancel came: thread_run asks that, too. */
bool passes_should_stop(void *render);

/* To the listener: progress, now and then or `always`; and the picture of a film. `samples` is what the listener hears: 0 while the
   first pass grows. */
void passes_tell(struct render *, bool always);
void passes_show(struct render *, const struct film *, int divisor, int samples);

#endif
