/* Merging EXRs of disjoint sample ranges: their sums are integers, so the parts give the bits of the whole. */
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "session/session.h"

#define NOTES_MAX 32

struct part {
    const char *path;
    struct film *film;
    char fingerprint[SESSION_FINGERPRINT_BYTES];
};

/* The notes of the first part, which hold for all: equal fingerprints say so. */
struct notes {
    struct film_note note[NOTES_MAX];
    size_t count;
    bool complete;
};

static void keep_note(void *user, const char *key, const char *value)
{
    struct notes *notes = user;
    char *own_key = strdup(key), *own_value = strdup(value);
    if (notes->count == NOTES_MAX || !own_key || !own_value) {
        free(own_key);
        free(own_value);
        notes->complete = false;
        return;
    }
    notes->note[notes->count++] = (struct film_note){own_key, own_value};
}

static void free_notes(struct notes *notes)
{
    for (size_t i = 0; i < notes->count; i++) {
        free((char *)notes->note[i].key);
        free((char *)notes->note[i].value);
    }
}

static int by_first_sample(const void *a, const void *b)
{
    const struct part *x = a, *y = b;
    return (x->film->first_sample > y->film->first_sample) - (x->film->first_sample < y->film->first_sample);
}

static bool read_parts(struct part *parts, const char *const *paths, size_t count, stokes_error *err)
{
    for (size_t i = 0; i < count; i++) {
        struct part *part = &parts[i];
        part->path = paths[i];
        part->film = film_read_exr(paths[i], part->fingerprint, sizeof part->fingerprint, err);
        if (!part->film)
            return false;
        if (strcmp(part->fingerprint, parts[0].fingerprint) != 0)
            return fail(err, paths[i], "fingerprint",
                        "%s is not %s, that of %.120s: another scene, or other settings", part->fingerprint,
                        parts[0].fingerprint, paths[0]);
    }
    return true;
}

static bool merge_parts(struct part *parts, size_t count, stokes_error *err)
{
    qsort(parts, count, sizeof *parts, by_first_sample);
    for (size_t i = 1; i < count; i++) {
        stokes_error why = {0};
        if (!film_merge(parts[0].film, parts[i].film, &why))
            return fail(err, parts[i].path, why.property, "%s", why.text);
    }
    return true;
}

bool stokes_merge(const char *const *paths, size_t count, const char *out, stokes_error *err)
{
    struct notes notes = {.complete = true};
    struct working_space space;
    if (count == 0)
        return fail(err, out, "merge", "there is nothing to merge");
    struct part *parts = calloc(count, sizeof *parts);
    bool good = parts || fail(err, out, "merge", "out of memory");
    good = good && read_parts(parts, paths, count, err) &&
           film_read_notes(paths[0], &space, keep_note, &notes, err);
    good = good && (notes.complete || fail(err, paths[0], "notes", "do not fit into memory"));
    good = good && merge_parts(parts, count, err);
    good = good && film_write_exr(parts[0].film, &space, notes.note, notes.count, out, err);
    free_notes(&notes);
    for (size_t i = 0; parts && i < count; i++)
        film_destroy(parts[i].film);
    free(parts);
    return good;
}
