/* The film as an EXR: a picture that any viewer opens (R, G, B, A), spectral bins in the layout of Fichet
   et al. 2021 ("An OpenEXR Layout for Spectral Images", JCGT 10(3)), and the fixed-point sums, two u32
   channels each, for merging. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "film/film.h"
#include "image/exr.h"
#include "image/png.h"

#define LAYOUT_VERSION 1
#define NOTE_PREFIX "stokes."
#define NOTES_MAX 64
#define OWN_TEXTS 7 /* those of add_texts */
#define TEXT_MAX 256

/* Channels of the file: RGBA, then the bins' radiance, then low and high words of every sum. */
enum { RGBA = 4 };

static size_t picture_channels(const struct film *film)
{
    return RGBA + (size_t)film->bins;
}

static size_t sum_channels(const struct film *film)
{
    return 2 * (size_t)film->channels;
}

/* The bin's centre with a decimal comma, as the layout wants it; no locale has a say in it. */
static void name_bin(const struct film *film, int bin, struct exr_channel *channel)
{
    double width = ((double)film->bin_range.max - film->bin_range.min) / film->bins;
    long long femto = llround((film->bin_range.min + (bin + 0.5) * width) * 1e6);
    snprintf(channel->name, sizeof channel->name, "S0.%lld,%06lldnm", femto / 1000000, femto % 1000000);
}

/* Without a dot: viewers take what stands before a dot for a layer, and a picture with layers for something
   else than a picture. */
static void name_sum(size_t index, struct exr_channel *channel)
{
    snprintf(channel->name, sizeof channel->name, "sum%04zu%s", index / 2, index % 2 ? "high" : "low");
    channel->integer = true;
}

static void name_channels(const struct film *film, struct exr_channel *channels)
{
    for (int i = 0; i < RGBA; i++)
        snprintf(channels[i].name, sizeof channels[i].name, "%c", "RGBA"[i]);
    for (int bin = 0; bin < film->bins; bin++)
        name_bin(film, bin, &channels[RGBA + bin]);
    for (size_t i = 0; i < sum_channels(film); i++)
        name_sum(i, &channels[picture_channels(film) + i]);
}

/* --- Writing --------------------------------------------------------------------------------------- */

struct picture {
    const struct film *film;
    const struct working_space *space;
    double per_unit, per_nm; /* of a sum; of a bin */
};

static float rgba_value(const struct picture *picture, const int64_t *sum, size_t channel)
{
    if (channel == 3)
        return (float)((double)sum[3] * picture->per_unit);
    const double *row = picture->space->xyz_to_rgb + 3 * channel;
    double value = 0;
    for (int i = 0; i < 3; i++)
        value += row[i] * (double)sum[i];
    return (float)(value * picture->per_unit);
}

static void fill_row(const void *user, size_t channel, int y, void *values)
{
    const struct picture *picture = user;
    const struct film *film = picture->film;
    const int64_t *sum = film->sum + (size_t)y * (size_t)film->width * (size_t)film->channels;
    float *real = values;
    uint32_t *word = values;
    size_t pictures = picture_channels(film);
    for (int x = 0; x < film->width; x++, sum += film->channels) {
        if (channel < RGBA)
            real[x] = rgba_value(picture, sum, channel);
        else if (channel < pictures)
            real[x] = (float)((double)sum[channel] * picture->per_unit * picture->per_nm);
        else
            word[x] =
                (uint32_t)((uint64_t)sum[(channel - pictures) / 2] >> ((channel - pictures) % 2 ? 32 : 0));
    }
}

/* Chromaticities of the working space, so that other programs know it. False if a primary has none. */
static bool chromaticities(const struct working_space *space, float xy[8])
{
    for (int i = 0; i < 4; i++) {
        double xyz[3];
        for (int c = 0; c < 3; c++) {
            const double *row = space->rgb_to_xyz + 3 * c;
            xyz[c] = i < 3 ? row[i] : row[0] + row[1] + row[2];
        }
        double sum = xyz[0] + xyz[1] + xyz[2];
        xy[2 * i] = (float)(xyz[0] / sum);
        xy[2 * i + 1] = (float)(xyz[1] / sum);
        if (!isfinite(xy[2 * i]) || !isfinite(xy[2 * i + 1]))
            return false;
    }
    return true;
}

struct header {
    struct exr_text texts[OWN_TEXTS + NOTES_MAX];
    size_t count;
    char text[OWN_TEXTS][TEXT_MAX];
    char name[NOTES_MAX][EXR_NAME_MAX + 1];
};

static void add_text(struct header *header, const char *name, const char *text)
{
    header->texts[header->count++] = (struct exr_text){name, text};
}

static void add_texts(struct header *header, const struct film *film, const struct working_space *space)
{
    const double *m = space->rgb_to_xyz;
    snprintf(header->text[0], TEXT_MAX, "%d %d", LAYOUT_VERSION, FILM_FRACTION_BITS);
    add_text(header, "stokesFilm", header->text[0]);
    snprintf(header->text[1], TEXT_MAX, "%d %d", film->first_sample, film->end_sample);
    add_text(header, "stokesSamples", header->text[1]);
    snprintf(header->text[2], TEXT_MAX, "%d %.9g %.9g", film->bins, (double)film->bin_range.min,
             (double)film->bin_range.max);
    add_text(header, "stokesBins", header->text[2]);
    snprintf(header->text[3], TEXT_MAX, "%" PRIu64 " %" PRIu64, film->saturated, film->rejected);
    add_text(header, "stokesCounts", header->text[3]);
    snprintf(header->text[4], TEXT_MAX, "%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g", m[0], m[1],
             m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
    add_text(header, "stokesToXYZ", header->text[4]);
    if (film->bins) {
        add_text(header, "spectralLayoutVersion", "1.0");
        add_text(header, "emissiveUnits", "W.m^-2.sr^-1.nm^-1");
    }
}

static bool add_notes(struct header *header, const struct film_note *notes, size_t count, const char *path,
                      stokes_error *err)
{
    if (count > NOTES_MAX)
        return fail(err, path, "notes", "%zu are more than %d", count, NOTES_MAX);
    for (size_t i = 0; i < count; i++) {
        int length = snprintf(header->name[i], sizeof header->name[i], NOTE_PREFIX "%s", notes[i].key);
        if (length > EXR_NAME_MAX)
            return fail(err, path, notes[i].key, "the note's name is too long");
        add_text(header, header->name[i], notes[i].value);
    }
    return true;
}

static bool write_layout(const struct film *film, const struct working_space *space,
                         const struct header *header, struct exr_channel *channels, const char *path,
                         stokes_error *err)
{
    float xy[8];
    int samples = film_divisor(film);
    struct exr_layout layout = {
        .full_width = film->full_width,
        .full_height = film->full_height,
        .x0 = film->x0,
        .y0 = film->y0,
        .width = film->width,
        .height = film->height,
        .channels = channels,
        .channel_count = picture_channels(film) + sum_channels(film),
        .texts = header->texts,
        .text_count = header->count,
        .chromaticities = chromaticities(space, xy) ? xy : NULL,
    };
    struct picture picture = {
        .film = film,
        .space = space,
        .per_unit = samples > 0 ? ldexp(1.0, -FILM_FRACTION_BITS) / samples : 0,
        .per_nm = film->bins ? film->bins / ((double)film->bin_range.max - film->bin_range.min) : 0,
    };
    name_channels(film, channels);
    return exr_write(&layout, fill_row, &picture, path, err);
}

bool film_write_exr(const struct film *film, const struct working_space *space, const struct film_note *notes,
                    size_t note_count, const char *path, stokes_error *err)
{
    struct header *header = calloc(1, sizeof *header);
    struct exr_channel *channels = calloc(picture_channels(film) + sum_channels(film), sizeof *channels);
    bool good = header && channels;
    if (!good)
        fail(err, path, "write", "out of memory");
    if (good) {
        add_texts(header, film, space);
        good = add_notes(header, notes, note_count, path, err) &&
               write_layout(film, space, header, channels, path, err);
    }
    free(header);
    free(channels);
    return good;
}

bool film_write_png(int width, int height, const float *rgba, const char *path, stokes_error *err)
{
    return png_write_rgba(width, height, rgba, path, err);
}

/* --- Reading --------------------------------------------------------------------------------------- */

/* `count` finite numbers and nothing else. */
static bool read_numbers(struct exr_file *file, const char *name, double *numbers, int count)
{
    const char *text = exr_text_named(file, name);
    for (int i = 0; text && i < count; i++) {
        char *end;
        numbers[i] = strtod(text, &end);
        text = end > text && isfinite(numbers[i]) ? end : NULL;
    }
    return text && !*text;
}

static bool is_integer(double number, double low, double high)
{
    return number >= low && number <= high && number == floor(number);
}

static bool read_matrix(struct exr_file *file, const char *path, struct working_space *space,
                        stokes_error *err)
{
    double m[9];
    if (!read_numbers(file, "stokesToXYZ", m, 9))
        return fail(err, path, "stokesToXYZ", "is not nine numbers");
    return working_space_set(space, m, err);
}

static bool check_version(struct exr_file *file, const char *path, stokes_error *err)
{
    double layout[2];
    if (!read_numbers(file, "stokesFilm", layout, 2))
        return fail(err, path, "stokesFilm", "the file holds no sums of Stokes");
    if (layout[0] != LAYOUT_VERSION || layout[1] != FILM_FRACTION_BITS)
        return fail(err, path, "stokesFilm", "layout %g with %g bits is not %d with %d", layout[0], layout[1],
                    LAYOUT_VERSION, FILM_FRACTION_BITS);
    return true;
}

bool film_read_notes(const char *path, struct working_space *space,
                     void (*note)(void *user, const char *key, const char *value), void *user,
                     stokes_error *err)
{
    struct exr_file *file = exr_open(path, err);
    if (!file)
        return false;
    bool good = check_version(file, path, err) && (!space || read_matrix(file, path, space, err));
    for (size_t i = 0; good && note && i < exr_text_count(file); i++) {
        const char *name, *text = exr_text_at(file, i, &name);
        if (text && strncmp(name, NOTE_PREFIX, strlen(NOTE_PREFIX)) == 0)
            note(user, name + strlen(NOTE_PREFIX), text);
    }
    exr_close(file);
    return good;
}

/* The header's numbers, checked; the film they describe. */
static struct film *read_header(struct exr_file *file, const char *path, stokes_error *err)
{
    struct exr_layout window;
    if (!check_version(file, path, err) || !exr_windows(file, &window, err))
        return NULL;
    double samples[2], bins[3], counts[2];
    if (!read_numbers(file, "stokesSamples", samples, 2) || !is_integer(samples[0], 0, INT32_MAX) ||
        !is_integer(samples[1], samples[0], INT32_MAX)) {
        fail(err, path, "stokesSamples", "is no range of samples");
        return NULL;
    }
    if (!read_numbers(file, "stokesBins", bins, 3) || !is_integer(bins[0], 0, FILM_BINS_MAX)) {
        fail(err, path, "stokesBins", "is not a count and a range");
        return NULL;
    }
    if (!read_numbers(file, "stokesCounts", counts, 2) || !is_integer(counts[1], 0, 0x1p63)) {
        fail(err, path, "stokesCounts", "is not two counts");
        return NULL;
    }
    const int border[4] = {window.x0, window.y0, window.x0 + window.width, window.y0 + window.height};
    struct film *film = film_create(window.full_width, window.full_height, border, (int)bins[0],
                                    (struct range){(float)bins[1], (float)bins[2]}, err);
    if (film) {
        film->first_sample = (int)samples[0];
        film->end_sample = (int)samples[1];
        film->part = samples[0] == samples[1];
        film->rejected = (uint64_t)counts[1];
    }
    return film;
}

/* Low and high words arrive in any order. */
static bool take_row(void *user, size_t channel, int y, const void *values, stokes_error *err)
{
    struct film *film = user;
    (void)err;
    const uint32_t *word = values;
    int64_t *sum = film->sum + (size_t)y * (size_t)film->width * (size_t)film->channels + channel / 2;
    int shift = channel % 2 ? 32 : 0;
    for (int x = 0; x < film->width; x++, sum += film->channels)
        *sum = (int64_t)((uint64_t)*sum | (uint64_t)word[x] << shift);
    return true;
}

static bool check_sums(struct film *film, const char *path, stokes_error *err)
{
    size_t count = (size_t)film->width * (size_t)film->height * (size_t)film->channels;
    for (size_t i = 0; i < count; i++) {
        if (film->sum[i] < 0 || film->sum[i] > FILM_SUM_MAX)
            return fail(err, path, "sums", "%" PRId64 " is outside what a sum can be", film->sum[i]);
        film->saturated += film->sum[i] == FILM_SUM_MAX;
    }
    return true;
}

static bool read_sums(struct exr_file *file, struct film *film, const char *path, stokes_error *err)
{
    struct exr_channel *channels = calloc(sum_channels(film), sizeof *channels);
    if (!channels)
        return fail(err, path, "sums", "out of memory");
    for (size_t i = 0; i < sum_channels(film); i++)
        name_sum(i, &channels[i]);
    bool good =
        exr_read(file, channels, sum_channels(film), take_row, film, err) && check_sums(film, path, err);
    free(channels);
    return good;
}

struct film *film_read_exr(const char *path, char *fingerprint, size_t fingerprint_size, stokes_error *err)
{
    struct exr_file *file = exr_open(path, err);
    if (!file)
        return NULL;
    struct film *film = read_header(file, path, err);
    if (film && !read_sums(file, film, path, err)) {
        film_destroy(film);
        film = NULL;
    }
    if (film && fingerprint && fingerprint_size) {
        const char *text = exr_text_named(file, NOTE_PREFIX "fingerprint");
        snprintf(fingerprint, fingerprint_size, "%s", text ? text : "");
    }
    exr_close(file);
    return film;
}
