/* The public face of libstokes: everything that a program outside csrc/ may call.
   Sessions share no state; one session is driven by one thread. */
#ifndef STOKES_H
#define STOKES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define STOKES_VERSION "0.1.0"
#define STOKES_API __attribute__((visibility("default")))

/* What went wrong: the object's name (a mesh, a file), its property, and a sentence without a full stop.
   Filled where the fault is known; functions that fill it return false. */
typedef struct stokes_error {
    char object[128];
    char property[64];
    char text[320];
} stokes_error;

typedef struct stokes_session stokes_session;

/* What a session tells while it works. Called from the thread that drives the session; any may be NULL. */
typedef struct stokes_listener {
    void *user;
    void (*warning)(void *user, const stokes_error *what);
    /* Seconds elapsed and expected to remain (< 0: not known yet). */
    void (*progress)(void *user, int sample, int samples, double seconds, double remaining);
    /* The picture [x0,y0,x1,y1) of the border's rectangle holds `samples` samples now, 0 while the first pass
       grows. */
    void (*tile)(void *user, const int rect[4], int samples);
    /* Asked between passes and between small units of work, from any worker thread. True stops the render. */
    bool (*cancelled)(void *user);
    /* The film holds 1, 2, 4, 8 … samples of each pixel, exactly as a render of so many ends. For the call it
       may be written (stokes_session_write); false with *err ends the render. Not NULL: passes end at these. */
    bool (*snapshot)(void *user, stokes_session *, int samples, stokes_error *err);
} stokes_listener;

/* A session holds one scene and renders it. `listener` is copied. */
STOKES_API stokes_session *stokes_session_create(const stokes_listener *listener);
STOKES_API void stokes_session_destroy(stokes_session *);

/* Applies one frame of the stream (csrc/stream/STREAM.md): its name, its JSON text and its blob area, all
   borrowed for the call. `shared` is the parent's shared memory or NULL. On false nothing has changed and *err
   says why. `render`, `cancel` and `quit` are not applied here: they belong to who drives the session. */
STOKES_API bool stokes_session_apply(stokes_session *, const char *name, bool mandatory, const char *json,
                                     size_t json_bytes, const void *blobs, size_t blob_bytes,
                                     const void *shared, size_t shared_bytes, stokes_error *err);

/* What `stokes render` may override; negative numbers and NULL leave the scene's own value. Bins where the scene
   has none lie over the visible part of its range. */
typedef struct stokes_overrides {
    const char *integrator; /* "pt", "pt_nee", "lt", "mbdpt", "bdpt" */
    int64_t seed;
    int first_sample, end_sample; /* [first, end) */
    bool shared_wavelength;       /* mbdpt without its kernel, both sub-paths at one wavelength */
    bool connectable_only;        /* leave out paths that no connection can make */
    int lanes;                    /* 1, 4 or 8 wavelengths a path */
    int threads;                  /* 0: all processors */
    double d0_nm, shrink;
    const char *kernel; /* "constant", … */
    double light_paths; /* of each sample; 0: as many as pay */
    int spectral_bins; /* 0: none */
    double bins_min_nm, bins_max_nm;
    const char *techniques; /* "2,2 3,1", NULL: the scene's own */
    int max_path;
    double time_limit_s;
} stokes_overrides;
STOKES_API stokes_overrides stokes_overrides_default(void);

/* Renders the scene's sample range; `overrides` may be NULL. `picture` may be NULL or points to RGBA f32, the
   border's rectangle, bottom row first; it is refreshed as the render goes. A cancelled render returns true and
   keeps its whole passes; within the first it keeps the pixels that were done (stokes_session_is_part). */
STOKES_API bool stokes_session_render(stokes_session *, const stokes_overrides *, float *picture,
                                      size_t picture_floats, stokes_error *err);

/* After a render: the picture's size, the samples it holds, and the lines of its report. */
STOKES_API void stokes_session_size(const stokes_session *, int *width, int *height);
STOKES_API int stokes_session_samples(const stokes_session *);
/* True if a cancel left but a part of the first pass, and so no samples: what is written then has alpha 0 where nothing was
   traced, and cannot be merged. */
STOKES_API bool stokes_session_is_part(const stokes_session *);
STOKES_API const char *stokes_session_report(const stokes_session *);

/* Writes the film: EXR (linear RGBA, spectral bins, and what merging needs) or, by its ending, PNG through
   the config's display and view. Written under a temporary name and renamed. */
STOKES_API bool stokes_session_write(stokes_session *, const char *path, stokes_error *err);

/* Replays a scene file into a session; stops at the first error. */
STOKES_API bool stokes_session_load(stokes_session *, const char *path, stokes_error *err);

/* Merges EXRs of disjoint sample ranges of one scene, bit by bit what one render gives. */
STOKES_API bool stokes_merge(const char *const *paths, size_t count, const char *out, stokes_error *err);

/* Writes to stdout, a line each, what a scene file or an EXR of ours holds. */
STOKES_API bool stokes_info(const char *path, stokes_error *err);

/* `stokes serve`: speaks the stream on two file descriptors until `quit` or end of input. `memory_fd` and
   `film_fd` are shared memories or −1. Returns the process' exit status. */
STOKES_API int stokes_serve(int in_fd, int out_fd, int memory_fd, int film_fd);

/* A reradiation matrix: of the energy that arrives in each band, the share that leaves in each. Bands are `step_nm` wide about
   their centres; share[out * count_in + in]. */
typedef struct stokes_matrix {
    double step_nm, first_in_nm, first_out_nm;
    int count_in, count_out;
    float *share;
} stokes_matrix;

/* Reads CSV, the BFC-450 matrix text, a bispectral OpenEXR, or an entry of the library ("matrix/yellow_note"); yours
   (stokes_matrix_destroy). `pixel` picks one (x, y from the top left) of a picture, NULL their mean. What was done about noise and
   missing bands is told to `note` (may be NULL), a line each. NULL with *err. */
STOKES_API stokes_matrix *stokes_matrix_read(const char *path, const int *pixel,
                                             void (*note)(void *user, const stokes_error *what), void *user,
                                             stokes_error *err);
/* The matrix of a loaded scene's material, lit at 45° and seen at 0° as by a bispectral photometer: `count` bands on both sides. */
STOKES_API stokes_matrix *stokes_session_matrix(stokes_session *, const char *material, double first_nm,
                                                int count, double step_nm, stokes_error *err);
/* As CSV or, by its ending .exr, as bispectral OpenEXR. Written under a temporary name and renamed. */
STOKES_API bool stokes_matrix_write(const stokes_matrix *, const char *path, stokes_error *err);
STOKES_API void stokes_matrix_destroy(stokes_matrix *);
/* The library's matrices: the name at `index`, or NULL past the end. */
STOKES_API const char *stokes_matrix_name(size_t index);

/* The spectrum library: the name at `index`, or NULL past the end; and what is known of an entry (false if there is none). */
STOKES_API const char *stokes_library_name(size_t index);
typedef struct stokes_library_notes {
    const char *source, *licence;
    double first_nm, last_nm;
    double quantum_yield; /* of a dye, 0 where no source is known */
    const char *yield_source;
} stokes_library_notes;
STOKES_API bool stokes_library_about(const char *name, stokes_library_notes *);

/* A table of wavelengths, ascending, linear between; beyond its ends it holds or is zero. */
typedef struct stokes_spectrum {
    size_t count;
    double *lambda_nm, *value;
    bool holds;
} stokes_spectrum;
/* An entry of the library, or a file: lines of a wavelength and, in `column` (from 1 on: the wavelengths are column 0), a value, parted by commas,
   semicolons, tabs or spaces, in UTF-8 or in UTF-16 with its mark. In nm, or in Å where a title above them says so. What was taken for granted
   is told to `note` (may be NULL), a line each. Yours (stokes_spectrum_destroy); NULL with *err. */
STOKES_API stokes_spectrum *stokes_spectrum_read(const char *name_or_path, int column,
                                                 void (*note)(void *user, const stokes_error *what),
                                                 void *user, stokes_error *err);
STOKES_API double stokes_spectrum_value(const stokes_spectrum *, double lambda_nm);
/* As lines of a wavelength and a value or, by its ending .json, as the stream takes it: {"table": …}. */
STOKES_API bool stokes_spectrum_write(const stokes_spectrum *, const char *path, stokes_error *err);
STOKES_API void stokes_spectrum_destroy(stokes_spectrum *);
/* Writes a text file whole or not at all. */
STOKES_API bool stokes_text_write(const char *path, const char *text, size_t bytes, stokes_error *err);

#ifdef __cplusplus
}
#endif
#endif
