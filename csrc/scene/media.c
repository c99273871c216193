/* Media along rays. Lengths are sums over boundaries, whatever their order: entered at t, a volume has the rest of the segment. */
#include "scene/media.h"

#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "scene/state.h"

bool scene_has_volumes(const struct scene *scene)
{
    return scene->volumes.bounded || scene->volumes.world;
}

bool scene_has_bounded_volumes(const struct scene *scene)
{
    return scene->volumes.bounded;
}

/* --- Sets ---------------------------------------------------------------------------------------------- */

static int find(const struct media *media, int volume)
{
    int i = 0;
    while (i < media->count && media->in[i].volume != volume)
        i++;
    return i;
}

void media_pass(struct media *media, int volume, bool enters)
{
    int i = find(media, volume);
    if (i == media->count) {
        if (!enters || media->count == MEDIA_MAX)
            return;
        media->in[media->count].volume = (int16_t)volume;
        media->in[media->count++].times = 0;
    }
    if (media->in[i].times < INT16_MAX || !enters)
        media->in[i].times = (int16_t)(media->in[i].times + (enters ? 1 : -1));
    if (media->in[i].times <= 0)
        media->in[i] = media->in[--media->count];
}

struct media scene_open_media(const struct scene *scene)
{
    struct media media = {.count = 0};
    if (scene->volumes.world)
        media_pass(&media, 0, true);
    return media;
}

/* --- Boundaries along a ray ------------------------------------------------------------------------------- */

static void boundaries_begin(struct boundaries *b, const struct media *media)
{
    b->count = media->count;
    for (int i = 0; i < media->count; i++)
        b->at[i] = (struct boundary){media->in[i].volume, media->in[i].times, 0};
}

void boundaries_meet(struct boundaries *b, int volume, bool enters, double t)
{
    int i = 0, sign = enters ? 1 : -1;
    while (i < b->count && b->at[i].volume != volume)
        i++;
    if (i == BOUNDARIES_MAX)
        return;
    if (i == b->count)
        b->at[b->count++] = (struct boundary){volume, 0, 0};
    b->at[i].times += sign;
    b->at[i].sum += sign * t;
}

struct media scene_media_at(const struct scene *scene, struct vec3 point, struct vec3 direction)
{
    struct media media = scene_open_media(scene);
    struct boundaries met = {.count = 0};
    if (!scene->volumes.bounded)
        return media;
    accel_boundaries(scene, point, direction, &met);
    /* Far away, nothing is left of what boundaries enclose. */
    for (int i = 0; i < met.count; i++)
        for (int k = met.at[i].times; k < 0; k++)
            media_pass(&media, met.at[i].volume, true);
    return media;
}

struct media scene_camera_media(const struct scene *scene, struct vec3 point, struct vec3 direction)
{
    return scene->volumes.camera_inside ? scene_media_at(scene, point, direction) : scene_open_media(scene);
}

/* --- Crossings ------------------------------------------------------------------------------------------- */

static void add_length(struct crossing *crossing, int volume, float length)
{
    int i = 0;
    if (!(length > 0) || crossing->count > CROSSING_MAX)
        return;
    while (i < crossing->count && crossing->at[i].volume != volume)
        i++;
    if (i < crossing->count) {
        crossing->at[i].length += length;
        return;
    }
    if (crossing->count++ < CROSSING_MAX) {
        crossing->at[i].volume = (int16_t)volume;
        crossing->at[i].length = length;
    }
}

void crossing_add(struct crossing *crossing, const struct media *media, float length)
{
    for (int i = 0; i < media->count; i++)
        add_length(crossing, media->in[i].volume, length * media->in[i].times);
}

double crossing_transmittance(const struct scene *scene, const struct crossing *crossing, float lambda)
{
    double depth = 0;
    if (crossing->count > CROSSING_MAX)
        return 0;
    for (int i = 0; i < crossing->count; i++) {
        double sigma = spectrum_eval(scene->volumes.list[crossing->at[i].volume]->extinction, lambda);
        if (sigma > 0) /* 0 × ∞ is 0 */
            depth += sigma * crossing->at[i].length;
    }
    return depth > 0 ? exp(-depth) : 1;
}

double crossing_depth(const struct scene *scene, const struct crossing *crossing, int rate)
{
    double depth = 0;
    for (int i = 0; i < crossing->count && i < CROSSING_MAX; i++) {
        double sigma = scene->volumes.list[crossing->at[i].volume]->rate[rate];
        if (sigma > 0)
            depth += sigma * crossing->at[i].length;
    }
    return depth;
}

double media_rate(const struct scene *scene, const struct media *media, int rate)
{
    double sum = 0;
    for (int i = 0; i < media->count; i++)
        sum += media->in[i].times * scene->volumes.list[media->in[i].volume]->rate[rate];
    return sum;
}

void crossing_densities(const struct scene *scene, const struct crossing *crossing, const struct media *end,
                        double density[VOLUME_RATES])
{
    for (int k = 0; k < VOLUME_RATES; k++) {
        double depth = crossing_depth(scene, crossing, k);
        density[k] = (depth > 0 ? exp(-depth) : 1) * (end ? media_rate(scene, end, k) : 1);
    }
}

bool scene_shade_media(const struct scene *scene, const struct media *media, struct surface *surface)
{
    const struct volume *volume[MEDIA_MAX];
    int times[MEDIA_MAX];
    for (int i = 0; i < media->count; i++) {
        volume[i] = scene->volumes.list[media->in[i].volume];
        times[i] = media->in[i].times;
    }
    volume_shade(volume, times, media->count, scene->default_material, surface);
    return surface->lobe_count > 0;
}

/* --- Shadow rays ------------------------------------------------------------------------------------------- */

static void lengths(const struct boundaries *b, double far, struct crossing *crossing)
{
    crossing->count = 0;
    for (int i = 0; i < b->count; i++) {
        double length = b->at[i].times == 0 ? -b->at[i].sum : b->at[i].times * far - b->at[i].sum;
        add_length(crossing, b->at[i].volume, (float)length);
    }
    if (b->count == BOUNDARIES_MAX)
        crossing->count = CROSSING_MAX + 1;
}

float scene_visibility_through(const struct scene *scene, struct vec3 from, struct vec3 to, float lambda,
                               uint32_t kind, const struct media *media, struct crossing *crossing)
{
    struct boundaries met;
    boundaries_begin(&met, media);
    float visible = accel_transmittance(scene, from, sub(to, from), scene_segment_end, lambda, kind, &met);
    lengths(&met, length(sub(to, from)), crossing);
    return visible;
}

float scene_visibility_distant_through(const struct scene *scene, struct vec3 from, struct vec3 direction,
                                       float lambda, uint32_t kind, const struct media *media,
                                       struct crossing *crossing)
{
    struct boundaries met;
    boundaries_begin(&met, media);
    float visible = accel_transmittance(scene, from, direction, INFINITY, lambda, kind, &met);
    lengths(&met, INFINITY, crossing);
    return visible;
}
