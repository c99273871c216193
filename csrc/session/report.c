/* What a render says of itself: the lines of its report, and the fingerprint that merging compares. */
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/random.h"
#include "session/session.h"

bool text_line(struct text *text, const char *format, ...)
{
    char line[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line - 1, format, arguments);
    va_end(arguments);
    strcat(line, "\n");
    size_t bytes = strlen(line);
    char *data = realloc(text->data, text->bytes + bytes + 1);
    if (!data)
        return false;
    memcpy(data + text->bytes, line, bytes + 1);
    text->data = data;
    text->bytes += bytes;
    return true;
}

void text_clear(struct text *text)
{
    free(text->data);
    *text = (struct text){0};
}

static void report_film(const stokes_session *session, const struct film *film, struct text *out)
{
    double pixel_samples =
        (double)film->width * film->height * film_divisor(film) * (film->part ? session->share : 1);
    text_line(out, "film: %d x %d pixels, samples %d to %d of each", film->width, film->height,
              film->first_sample, film->end_sample);
    text_line(out, "time: %.2f s, %.4g samples/s with %d threads", session->seconds,
              session->seconds > 0 ? pixel_samples / session->seconds : 0,
              session_threads(&session->rendered));
    if (session->light_paths > 0 && session->light_paths_from > film->first_sample)
        text_line(out, "paths: %g light sub-paths for each of the camera's, from sample %d on",
                  session->light_paths, session->light_paths_from);
    else if (session->light_paths > 0)
        text_line(out, "paths: %g light sub-paths for each of the camera's", session->light_paths);
    if (session->unconnected_share > 0)
        text_line(out, "paths: %.3g %% of the light came over some that no connection makes",
                  100 * session->unconnected_share);
    if (film->saturated > 0)
        text_line(out, "film: %" PRIu64 " sums reached the limit and stay there", film->saturated);
    if (film->rejected > 0)
        text_line(out, "film: %" PRIu64 " contributions were not finite and were left out", film->rejected);
}

void session_write_report(stokes_session *session)
{
    struct scene_statistics scene = scene_statistics(session->scene);
    const struct film *film = session->film;
    struct text *out = &session->report;
    int samples = stokes_session_samples(session);
    size_t outside = tally_sum(session->outside) + scene.colors_out_of_reach;
    text_clear(out);
    text_line(out, "scene: %zu meshes, %zu instances, %zu triangles, %zu lights, %zu materials, %zu images",
              scene.meshes, scene.instances, scene.triangles, scene.lights, scene.materials, scene.images);
    if (scene.lights_lost > 0)
        text_line(out,
                  "lights: %zu at infinity (suns, the world's own) left out: nothing arrives through the "
                  "world's volume",
                  scene.lights_lost);
    if (film)
        report_film(session, film, out);
    if (session->cancelled && stokes_session_is_part(session))
        text_line(out, "cancelled within the first pass, of which %.3g %% is kept", 100 * session->share);
    else if (session->cancelled)
        text_line(out, "cancelled after %d whole passes", samples);
    if (outside > 0)
        text_line(out, "colors: %zu out of reach of any reflectance; the nearest was used", outside);
}

uint64_t session_hash(uint64_t hash, const void *data, size_t bytes)
{
    const unsigned char *at = data;
    uint64_t word;
    for (; bytes >= sizeof word; at += sizeof word, bytes -= sizeof word) {
        memcpy(&word, at, sizeof word);
        hash = random_mix(hash ^ word) + 1;
    }
    word = 0;
    if (bytes > 0)
        memcpy(&word, at, bytes);
    return random_mix(hash ^ word ^ (uint64_t)bytes << 56) + 1;
}

static uint64_t hash_techniques(const struct integrator_settings *s, uint64_t hash)
{
    if (s->all_techniques)
        return hash;
    for (int i = 0; i < TECHNIQUES_MAX; i++)
        for (int j = 0; j < TECHNIQUES_MAX; j++)
            if (s->technique[i][j])
                hash = session_hash(hash, (int[2]){i, j}, sizeof(int[2]));
    return hash;
}

void session_fingerprint(const stokes_session *session, const struct session_settings *settings,
                         char text[SESSION_FINGERPRINT_BYTES])
{
    const struct integrator_settings *s = &settings->integrator;
    const int whole[] = {s->lanes,          s->connectable_only, s->shared_wavelength,        s->kernel,          s->mollify_side,   s->max_path,         s->max_camera,
                         s->max_light,       s->max_diffuse,    s->max_glossy,       s->max_transmission, s->max_volume,
                         s->max_transparent, s->roulette_start, s->film_transparent, s->spectral_bins,
                         settings->uv_rule,  (int)s->seed};
    const double real[] = {s->d0_nm,
                           s->shrink,
                           s->light_paths,
                           s->lambda_min,
                           s->lambda_max,
                           s->filter_width,
                           s->spectral_bins ? s->bins_min : 0,
                           s->spectral_bins ? s->bins_max : 0};
    uint64_t hash = session_hash(session->scene_hash, STOKES_VERSION, sizeof STOKES_VERSION);
    hash = session_hash(hash, s->name, strlen(s->name));
    hash = session_hash(hash, whole, sizeof whole);
    hash = session_hash(hash, real, sizeof real);
    hash = session_hash(hash, session->color.working_space.rgb_to_xyz,
                        sizeof session->color.working_space.rgb_to_xyz);
    hash = hash_techniques(s, hash);
    snprintf(text, SESSION_FINGERPRINT_BYTES, "%016" PRIx64, hash);
}
