/* Spectra for those outside: the library's, and users' own. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/error.h"
#include "base/os.h"
#include "material/lobe.h"
#include "session/session.h"
#include "spectrum/library/library.h"
#include "spectrum/spectrum_text.h"

/* Illuminants that are computed and glasses, which are formulas, are handed out as tables like the rest. */
#define TABLE_STEP_NM 5
#define LIGHT_MIN_NM 300
#define LIGHT_MAX_NM 830

const char *stokes_library_name(size_t index)
{
    if (index < library_count())
        return library_name(index);
    index -= library_count();
    size_t computed = 0;
    while (illuminant_computed_at(computed))
        computed++;
    if (index < computed)
        return illuminant_computed_at(index);
    const struct glass *glass = glass_at(index - computed);
    return glass ? glass->name : NULL;
}

/* "dye/NAME/emission" → NAME. */
static bool dye_of(const char *name, char dye[96])
{
    const char *end = strrchr(name, '/');
    return strncmp(name, "dye/", 4) == 0 && end > name + 4 &&
           snprintf(dye, 96, "%.*s", (int)(end - name - 4), name + 4) < 96;
}

/* By the name that stokes_library_name says: what an `ior` may call BK7 is glass/BK7 here. */
static const struct glass *listed_glass(const char *name)
{
    const struct glass *glass = glass_find(name);
    return glass && strcmp(glass->name, name) == 0 ? glass : NULL;
}

/* Of what is no table of values over wavelengths. */
static bool about_other(const char *name, stokes_library_notes *notes)
{
    const struct glass *glass = listed_glass(name);
    const struct library_matrix *matrix = library_matrix_find(name);
    if (matrix)
        *notes = (stokes_library_notes){
            .source = matrix->source,
            .licence = matrix->licence,
            .first_nm = (double)matrix->first_in,
            .last_nm = (double)(matrix->first_in + matrix->step * (float)(matrix->count_in - 1))};
    else if (glass)
        *notes = (stokes_library_notes){.source = glass->source,
                                        .licence = "CC0",
                                        .first_nm = (double)glass->min_nm,
                                        .last_nm = (double)glass->max_nm};
    else if (illuminant_is_computed(name))
        *notes = (stokes_library_notes){
            .source = "CIE 015:2018, A and E by formula, daylight from PyPI colour-science 0.4.7",
            .licence = "BSD-3-Clause",
            .first_nm = LIGHT_MIN_NM,
            .last_nm = LIGHT_MAX_NM};
    else
        return false;
    return true;
}

bool stokes_library_about(const char *name, stokes_library_notes *notes)
{
    const struct library_entry *entry = library_find(name);
    char dye[96];
    if (!entry)
        return about_other(name, notes);
    *notes = (stokes_library_notes){
        .source = library_source(entry),
        .licence = library_licence(entry),
        .first_nm = library_entry_lambda(entry, 0),
        .last_nm = library_entry_lambda(entry, (size_t)entry->count - 1),
    };
    if (dye_of(name, dye))
        library_yield(dye, &notes->quantum_yield, &notes->yield_source);
    return true;
}

static stokes_spectrum *table_create(size_t count, bool holds)
{
    stokes_spectrum *s = malloc(sizeof *s + 2 * count * sizeof(double));
    if (s)
        *s = (stokes_spectrum){count, (double *)(s + 1), (double *)(s + 1) + count, holds};
    return s;
}

static stokes_spectrum *of_entry(const struct library_entry *entry)
{
    stokes_spectrum *s = table_create(entry->count, entry->beyond == BEYOND_HOLD);
    for (size_t i = 0; s && i < entry->count; i++) {
        s->lambda_nm[i] = (double)library_entry_lambda(entry, i);
        s->value[i] = (double)library_entry_value(entry, i);
    }
    return s;
}

static stokes_spectrum *of_glass(const struct glass *glass)
{
    struct ior ior;
    int first = (int)ceilf(glass->min_nm / TABLE_STEP_NM), last = (int)(glass->max_nm / TABLE_STEP_NM);
    stokes_spectrum *s = table_create((size_t)(last - first + 1), true);
    for (size_t i = 0; s && ior_library(glass->name, &ior) && i < s->count; i++) {
        s->lambda_nm[i] = TABLE_STEP_NM * (first + (double)i);
        s->value[i] = (double)ior_eval(&ior, (float)s->lambda_nm[i]);
    }
    return s;
}

static stokes_spectrum *of_illuminant(const char *name, stokes_error *err)
{
    const struct range range = {LIGHT_MIN_NM, LIGHT_MAX_NM};
    struct spectrum *light = spectrum_library(range, name, name, err);
    stokes_spectrum *s =
        light ? table_create((LIGHT_MAX_NM - LIGHT_MIN_NM) / TABLE_STEP_NM + 1, false) : NULL;
    for (size_t i = 0; s && i < s->count; i++) {
        s->lambda_nm[i] = LIGHT_MIN_NM + TABLE_STEP_NM * (double)i;
        s->value[i] = (double)spectrum_eval(light, (float)s->lambda_nm[i]);
    }
    spectrum_destroy(light);
    return s;
}

stokes_spectrum *stokes_spectrum_read(const char *what, int column,
                                      void (*note)(void *user, const stokes_error *what), void *user,
                                      stokes_error *err)
{
    const struct library_entry *entry = library_find(what);
    const struct glass *glass = listed_glass(what);
    if (entry || glass || illuminant_is_computed(what)) {
        fail(err, what, "library", "out of memory");
        return entry ? of_entry(entry) : glass ? of_glass(glass) : of_illuminant(what, err);
    }
    char *text = session_read_text(what, err);
    stokes_spectrum *s = text ? spectrum_from_text(text, column, what, note, user, err) : NULL;
    free(text);
    return s;
}

double stokes_spectrum_value(const stokes_spectrum *s, double lambda_nm)
{
    size_t low = 0, high = s->count - 1;
    if (lambda_nm <= s->lambda_nm[0] || lambda_nm >= s->lambda_nm[high]) {
        size_t end = lambda_nm <= s->lambda_nm[0] ? 0 : high;
        return s->holds || lambda_nm == s->lambda_nm[end] ? s->value[end] : 0;
    }
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if (s->lambda_nm[middle] <= lambda_nm)
            low = middle;
        else
            high = middle;
    }
    double t = (lambda_nm - s->lambda_nm[low]) / (s->lambda_nm[high] - s->lambda_nm[low]);
    return s->value[low] + t * (s->value[high] - s->value[low]);
}

static void print_csv(const stokes_spectrum *s, FILE *file)
{
    fputs("nm,value\n", file);
    for (size_t i = 0; i < s->count; i++)
        fprintf(file, "%.9g,%.9g\n", s->lambda_nm[i], s->value[i]);
}

static void print_list(const double *values, size_t count, FILE *file)
{
    for (size_t i = 0; i < count; i++)
        fprintf(file, "%s%.9g", i ? ", " : "", values[i]);
}

static void print_json(const stokes_spectrum *s, FILE *file)
{
    fputs("{\"table\": {\"lambda\": [", file);
    print_list(s->lambda_nm, s->count, file);
    fputs("], \"value\": [", file);
    print_list(s->value, s->count, file);
    fputs("]}}\n", file);
}

bool stokes_spectrum_write(const stokes_spectrum *s, const char *path, stokes_error *err)
{
    char *text = NULL;
    size_t bytes = 0, length = strlen(path);
    FILE *file = open_memstream(&text, &bytes);
    if (file)
        (length > 5 && strcasecmp(path + length - 5, ".json") == 0 ? print_json : print_csv)(s, file);
    bool good = file && !ferror(file);
    if (file)
        good = fclose(file) == 0 && good;
    good = good ? os_write_file(path, text, bytes, err) : fail(err, path, "write", "out of memory");
    free(text);
    return good;
}

bool stokes_text_write(const char *path, const char *text, size_t bytes, stokes_error *err)
{
    return os_write_file(path, text, bytes, err);
}

void stokes_spectrum_destroy(stokes_spectrum *s)
{
    free(s);
}
