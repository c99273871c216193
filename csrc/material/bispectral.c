/* Bispectral OpenEXR files, read and written. */
#include "material/bispectral.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "image/exr.h"
#include "spectrum/measured.h"

#define LAYOUT_VERSION "spectralLayoutVersion"
#define CHANNELS_MAX ((size_t)RERADIATION_BANDS_MAX * RERADIATION_BANDS_MAX)
/* Wavelengths nearer to each other than this are one, nm. */
#define SAME_NM 0.01
#define SPEED_OF_LIGHT_NM_S 2.99792458e17

/* --- Names of channels -------------------------------------------------------------------------------------- */

/* nm of metres or hertz with a prefix; 0 if it is neither. */
static double nm_of(double value, const char *unit)
{
    static const char prefixes[] = "YZEPTGMk munp"; /* 1000^8 down to 1000^-4 */
    const char *prefix =
        *unit && strcmp(unit, "m") != 0 && strcmp(unit, "Hz") != 0 ? strchr(prefixes, *unit) : NULL;
    double thousands = prefix ? 8 - (double)(prefix - prefixes) : 0;
    unit += prefix != NULL;
    if (strcmp(unit, "m") == 0)
        return value * pow(1000, thousands + 3);
    return strcmp(unit, "Hz") == 0 ? SPEED_OF_LIGHT_NM_S / (value * pow(1000, thousands)) : 0;
}

/* "380,000000nm": a number with a comma and its unit. Ends at a dot or the name's end. */
static bool read_wavelength(const char **text, double *nm)
{
    char part[EXR_NAME_MAX + 1], *end, *comma;
    size_t length = strcspn(*text, ".");
    if (length == 0 || length > EXR_NAME_MAX)
        return false;
    memcpy(part, *text, length);
    part[length] = 0;
    if ((comma = strchr(part, ',')))
        *comma = '.';
    double value = strtod(part, &end);
    *nm = nm_of(value, end);
    *text += length + ((*text)[length] == '.');
    return isfinite(*nm) && *nm > 0;
}

/* T.λ or T.λi.λo, and M00 for T as the layout's draft had it; other channels (RGB, emission, polarisation) are no reradiation. */
static bool read_name(const char *name, double *in, double *out)
{
    size_t head = strncmp(name, "T.", 2) == 0 ? 2 : strncmp(name, "M00.", 4) == 0 ? 4 : 0;
    if (head == 0)
        return false;
    name += head;
    if (!read_wavelength(&name, in))
        return false;
    *out = *in;
    return !*name || (read_wavelength(&name, out) && !*name);
}

/* --- Reading ------------------------------------------------------------------------------------------------ */

struct pair {
    double in, out;
};

struct reading {
    struct exr_channel *channel;
    struct pair *pair;
    size_t count;
    const int *pixel;
    int width, height;
    double *sum;
    float *first; /* of each channel's pixels, to see whether all are alike */
    bool differ;
};

static void reading_free(struct reading *r)
{
    free(r->channel);
    free(r->pair);
    free(r->sum);
    free(r->first);
}

static bool find_channels(struct exr_file *file, struct reading *r, const char *path, stokes_error *err)
{
    size_t all = exr_channel_count(file);
    bool integer;
    if (all > CHANNELS_MAX)
        return fail(err, path, "channels", "are %zu; at most %zu are taken", all, CHANNELS_MAX);
    r->channel = calloc(all + 1, sizeof *r->channel);
    r->pair = calloc(all + 1, sizeof *r->pair);
    r->sum = calloc(all + 1, sizeof *r->sum);
    r->first = calloc(all + 1, sizeof *r->first);
    if (!r->channel || !r->pair || !r->sum || !r->first)
        return fail(err, path, "channels", "out of memory");
    for (size_t i = 0; i < all; i++) {
        const char *name = exr_channel_at(file, i, &integer);
        if (!name || integer || strlen(name) > EXR_NAME_MAX ||
            !read_name(name, &r->pair[r->count].in, &r->pair[r->count].out))
            continue;
        snprintf(r->channel[r->count++].name, sizeof r->channel->name, "%s", name);
    }
    return r->count > 0 ||
           fail(err, path, "channels", "none is named as T.380,000000nm or T.380,000000nm.400,000000nm");
}

static bool take_row(void *user, size_t channel, int y, const void *values, stokes_error *err)
{
    struct reading *r = user;
    const float *row = values;
    (void)err;
    if (r->pixel) {
        if (r->height - 1 - y == r->pixel[1])
            r->sum[channel] = row[r->pixel[0]];
        return true;
    }
    if (y == r->height - 1)
        r->first[channel] = row[0];
    for (int x = 0; x < r->width; x++) {
        r->sum[channel] += row[x];
        r->differ |= row[x] != r->first[channel];
    }
    return true;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts, and keeps one of those that are the same. Returns how many are left. */
static int unique(double *nm, int count)
{
    int kept = 0;
    qsort(nm, (size_t)count, sizeof *nm, compare);
    for (int i = 0; i < count; i++)
        if (kept == 0 || nm[i] - nm[kept - 1] > SAME_NM)
            nm[kept++] = nm[i];
    return kept;
}

static int place_of(const double *nm, int count, double wanted)
{
    int low = 0, high = count - 1;
    while (low < high) {
        int middle = (low + high) / 2;
        if (nm[middle] < wanted - SAME_NM)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* A band that only one side names is not of the other; a diagonal that no channel names was not measured. */
static struct measured *measured_of(const struct reading *r, const char *path, stokes_error *err)
{
    double *in = malloc(2 * r->count * sizeof *in), *out = in + r->count;
    struct measured *m = NULL;
    if (in) {
        for (size_t i = 0; i < r->count; i++) {
            in[i] = r->pair[i].in;
            out[i] = r->pair[i].out;
        }
        int count_in = unique(in, (int)r->count), count_out = unique(out, (int)r->count);
        m = measured_create(count_in, count_out, path, err);
        double scale = r->pixel ? 1 : 1 / ((double)r->width * r->height);
        for (int i = 0; m && i < count_in; i++)
            m->in[i] = in[i];
        for (int o = 0; m && o < count_out; o++)
            m->out[o] = out[o];
        for (int i = 0; m && i < count_in; i++)
            for (int o = 0; o < count_out; o++)
                if (fabs(in[i] - out[o]) <= SAME_NM)
                    m->share[o * count_in + i] = NAN;
        for (size_t k = 0; m && k < r->count; k++)
            m->share[place_of(out, count_out, r->pair[k].out) * count_in +
                     place_of(in, count_in, r->pair[k].in)] = (float)(r->sum[k] * scale);
    } else {
        fail(err, path, "channels", "out of memory");
    }
    free(in);
    return m;
}

static bool read_pixels(struct exr_file *file, struct reading *r, const char *path, reradiation_note note,
                        void *user, stokes_error *err)
{
    struct exr_layout windows;
    stokes_error what;
    if (!find_channels(file, r, path, err) || !exr_windows(file, &windows, err))
        return false;
    r->width = windows.width;
    r->height = windows.height;
    if (r->pixel &&
        (r->pixel[0] < 0 || r->pixel[0] >= r->width || r->pixel[1] < 0 || r->pixel[1] >= r->height))
        return fail(err, path, "pixel", "%d, %d is outside of %d × %d", r->pixel[0], r->pixel[1], r->width,
                    r->height);
    if (!exr_read(file, r->channel, r->count, take_row, r, err))
        return false;
    if (r->differ && note) {
        fail(&what, path, "pixels", "are not alike: their mean is taken; one can be named (x, y)");
        note(user, &what);
    }
    return true;
}

stokes_matrix *bispectral_read(const char *path, const int *pixel, reradiation_note note, void *user,
                               stokes_error *err)
{
    struct exr_file *file = exr_open(path, err);
    struct reading r = {.pixel = pixel};
    struct measured *raw = NULL;
    if (file && read_pixels(file, &r, path, note, user, err))
        raw = measured_of(&r, path, err);
    exr_close(file);
    reading_free(&r);
    return raw ? measured_finish(raw, path, note, user, err) : NULL;
}

/* --- Writing ------------------------------------------------------------------------------------------------ */

static void put_wavelength(char *text, size_t room, double nm)
{
    snprintf(text, room, "%.6fnm", nm);
    text[strcspn(text, ".")] = ',';
}

static void put_name(char name[EXR_NAME_MAX + 1], double in, double out, bool diagonal)
{
    char first[24], second[24];
    put_wavelength(first, sizeof first, in);
    put_wavelength(second, sizeof second, out);
    snprintf(name, EXR_NAME_MAX + 1, diagonal ? "T.%.14s" : "T.%.14s.%.14s", first, second);
}

static void give_pixel(const void *user, size_t channel, int y, void *values)
{
    const float *const *shares = user;
    (void)y;
    *(float *)values = *shares[channel];
}

bool bispectral_write(const stokes_matrix *m, const char *path, stokes_error *err)
{
    size_t room = (size_t)m->count_in * (size_t)m->count_out, count = 0;
    struct exr_channel *channel = calloc(room, sizeof *channel);
    const float **share = calloc(room, sizeof *share);
    bool good = channel && share;
    for (int in = 0; good && in < m->count_in; in++)
        for (int out = 0; out < m->count_out; out++) {
            int shift = out - in - reradiation_shift(m);
            const float *value = &m->share[out * m->count_in + in];
            if (shift < 0 && !(*value > 0))
                continue;
            put_name(channel[count].name, m->first_in_nm + in * m->step_nm,
                     m->first_out_nm + out * m->step_nm, shift == 0);
            share[count++] = value;
        }
    const struct exr_text version = {LAYOUT_VERSION, "1.0"};
    const struct exr_layout layout = {.full_width = 1,
                                      .full_height = 1,
                                      .width = 1,
                                      .height = 1,
                                      .channels = channel,
                                      .channel_count = count,
                                      .texts = &version,
                                      .text_count = 1};
    if (good && count == 0)
        good = fail(err, path, "write", "the matrix has no channel to write");
    else
        good = good ? exr_write(&layout, give_pixel, share, path, err)
                    : fail(err, path, "write", "out of memory");
    free(channel);
    free(share);
    return good;
}
