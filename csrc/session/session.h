/* A session: one scene, its settings and its film. Private to csrc/session and csrc/stream; the outside sees stokes.h. */
#ifndef SESSION_SESSION_H
#define SESSION_SESSION_H

#include "color/color.h"
#include "film/film.h"
#include "integrator/integrator.h"
#include "scene/build.h"
#include "stokes.h"

#define SESSION_FINGERPRINT_BYTES 17

/* The `settings` message; integrator.name is one of integrator_name_at. */
struct session_settings {
    struct integrator_settings integrator;
    enum uv_rule uv_rule;
    int threads;         /* 0: all processors */
    double time_limit_s; /* 0: none */
};

/* The `color` message. */
struct session_color {
    struct color_config *config; /* NULL: none */
    struct working_space working_space;
    char name[128], display[128], view[128], look[128];
    double exposure, gamma;
};

/* Lines of text, grown as needed. */
struct text {
    char *data;
    size_t bytes;
};

struct stokes_session {
    stokes_listener listener;
    struct scene *scene;
    struct session_settings settings;
    struct session_color color;
    struct spectrum
        *white;   /* what an RGB light of (1,1,1) emits; made when first asked for (stream/emission.c) */
    bool greeted; /* `hello` has come */
    bool has_camera;
    bool uses_colors; /* something holds spectra or pixels: working space, Λ and uv_rule stay from here on */
    int first_sample, end_sample; /* of the `render` message */
    uint64_t scene_hash;          /* of all that was applied and changes the image, settings apart */
    struct tally *outside;        /* colours out of reach, by object (tally.c) */

    /* The last render. */
    struct film *film;
    struct session_settings rendered; /* with its overrides */
    char fingerprint[SESSION_FINGERPRINT_BYTES];
    bool cancelled;
    double share; /* of the first pass, where only a part of it was traced (film->part) */
    double seconds;
    double unconnected_share; /* of the light, over paths that no connection makes */
    double light_paths;       /* light sub-paths of a sample, of the last one; 0: the integrator has none */
    int light_paths_from;     /* first sample with so many */
    struct text report;
};

/* NULL: no integrator has this name. */
const char *session_integrator_name(const char *name);

/* Cross-checks of a whole set of settings. */
bool session_settings_check(const struct session_settings *, stokes_error *err);
/* The settings with a caller's overrides. */
bool session_settings_override(struct session_settings *, const stokes_overrides *, stokes_error *err);
int session_threads(const struct session_settings *);

/* A whole text file, ended by NUL; free. UTF-16 that begins with its mark becomes UTF-8. NULL with *err, also where it holds a NUL. */
char *session_read_text(const char *path, stokes_error *err);

/* Compiles and builds what the messages brought. */
bool session_commit(stokes_session *, const struct session_settings *, stokes_error *err);

void session_warn(void *session, const stokes_error *what);
void session_color_clear(struct session_color *);

/* Adds a printf line to a text; false without memory (the line is lost then). */
bool text_line(struct text *, const char *format, ...) __attribute__((format(printf, 2, 3)));
void text_clear(struct text *);

/* Counts of colours that no reflectance reaches, by object: replacing an object replaces its count. */
struct tally;
struct tally *tally_create(void);
void tally_destroy(struct tally *);
void tally_set(struct tally *, const char *kind, const char *name, size_t count);
size_t tally_sum(const struct tally *);

/* After a render, in report.c. */
void session_write_report(stokes_session *);
/* Of scene and settings, less what changes no path's value: merging compares it. */
void session_fingerprint(const stokes_session *, const struct session_settings *,
                         char text[SESSION_FINGERPRINT_BYTES]);
/* One more word in a running hash. */
uint64_t session_hash(uint64_t hash, const void *data, size_t bytes);

#endif
