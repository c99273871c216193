/* Spectra for those outside: the library's, and users' own. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/error.h"
#include "base/os.h"
#include "session/session.h"
#include "spectrum/library/library.h"
#include "spectrum/spectrum_text.h"

const char *stokes_library_name(size_t index)
{
    return library_name(index);
}

/* "dye/NAME/emission" → NAME. */
static bool dye_of(const char *name, char dye[96])
{
    const char *end = strrchr(name, '/');
    return strncmp(name, "dye/", 4) == 0 && end > name + 4 &&
           snprintf(dye, 96, "%.*s", (int)(end - name - 4), name + 4) < 96;
}

bool stokes_library_about(const char *name, stokes_library_notes *notes)
{
    const struct library_entry *entry = library_find(name);
    char dye[96];
    if (!entry)
        return false;
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

static stokes_spectrum *of_library(const struct library_entry *entry)
{
    stokes_spectrum *s = malloc(sizeof *s + 2 * (size_t)entry->count * sizeof(double));
    if (!s)
        return NULL;
    double *lambda = (double *)(s + 1), *value = lambda + entry->count;
    *s = (stokes_spectrum){entry->count, lambda, value, entry->beyond == BEYOND_HOLD};
    for (size_t i = 0; i < entry->count; i++) {
        lambda[i] = library_entry_lambda(entry, i);
        value[i] = library_entry_value(entry, i);
    }
    return s;
}

stokes_spectrum *stokes_spectrum_read(const char *what, int column, stokes_error *err)
{
    const struct library_entry *entry = library_find(what);
    if (entry) {
        stokes_spectrum *s = of_library(entry);
        if (!s)
            fail(err, what, "library", "out of memory");
        return s;
    }
    char *text = session_read_text(what, err);
    stokes_spectrum *s = text ? spectrum_from_text(text, column, what, err) : NULL;
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
