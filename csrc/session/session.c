/* Making and ending a session, and what is asked of it after a render. */
#include <stdlib.h>

#include "base/error.h"
#include "session/session.h"

stokes_session *stokes_session_create(const stokes_listener *listener)
{
    stokes_session *session = calloc(1, sizeof *session);
    if (!session)
        return NULL;
    if (listener)
        session->listener = *listener;
    session->settings.integrator = integrator_settings_default();
    session->color.gamma = 1;
    working_space_rec709(&session->color.working_space);
    session->end_sample = 1;
    session->scene = scene_create();
    session->outside = tally_create();
    if (!session->scene || !session->outside) {
        stokes_session_destroy(session);
        return NULL;
    }
    return session;
}

void stokes_session_destroy(stokes_session *session)
{
    if (!session)
        return;
    scene_destroy(session->scene);
    session_color_clear(&session->color);
    spectrum_destroy(session->white);
    tally_destroy(session->outside);
    film_destroy(session->film);
    text_clear(&session->report);
    free(session);
}

void session_color_clear(struct session_color *color)
{
    color_config_close(color->config);
    color->config = NULL;
}

void session_warn(void *user, const stokes_error *what)
{
    stokes_session *session = user;
    if (session->listener.warning)
        session->listener.warning(session->listener.user, what);
}

void stokes_session_size(const stokes_session *session, int *width, int *height)
{
    *width = session->film ? session->film->width : 0;
    *height = session->film ? session->film->height : 0;
}

int stokes_session_samples(const stokes_session *session)
{
    return session->film ? session->film->end_sample - session->film->first_sample : 0;
}

bool stokes_session_is_part(const stokes_session *session)
{
    return session->film && session->film->part;
}

const char *stokes_session_report(const stokes_session *session)
{
    return session->report.data ? session->report.data : "";
}
