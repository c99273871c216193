/* Look-up in the generated tables. */
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "spectrum/library/library.h"

#include "spectrum/library/colorchecker.inc"
#include "spectrum/library/dyes.inc"
#include "spectrum/library/lamps.inc"
#include "spectrum/library/matrices.inc"
#include "spectrum/library/metals.inc"

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* What the tables' own heads say. */
#define COLOUR_SCIENCE "PyPI colour-science 0.4.7"
static const struct shelf {
    const struct library_entry *entries;
    size_t count;
    const char *source, *licence;
} shelves[] = {
    {colorchecker_entries, COUNT(colorchecker_entries),
     "ColorChecker as measured by N. Ohta; " COLOUR_SCIENCE, "BSD-3-Clause"},
    {dye_entries, COUNT(dye_entries),
     "McNamara-Boswell and Life Technologies collections, as distributed with ISETFluorescence",
     "measured facts"},
    {lamp_entries, COUNT(lamp_entries), "CIE 015:2018; " COLOUR_SCIENCE, "BSD-3-Clause"},
    {metal_entries, COUNT(metal_entries), "refractiveindex.info", "CC0"},
};

static const struct glass glasses[] = {
#include "spectrum/library/glasses.inc"
};

_Static_assert(COUNT(daylight_components) == DAYLIGHT_COUNT, "300 to 830 nm by 5");

const struct library_entry *library_at(size_t index)
{
    for (size_t i = 0; i < COUNT(shelves); i++) {
        if (index < shelves[i].count)
            return &shelves[i].entries[index];
        index -= shelves[i].count;
    }
    return NULL;
}

size_t library_count(void)
{
    size_t count = 0;
    for (size_t i = 0; i < COUNT(shelves); i++)
        count += shelves[i].count;
    return count;
}

static const struct shelf *shelf_of(const struct library_entry *entry)
{
    size_t i = 0;
    while (entry < shelves[i].entries || entry >= shelves[i].entries + shelves[i].count)
        i++;
    return &shelves[i];
}

const char *library_source(const struct library_entry *entry)
{
    return entry->source ? entry->source : shelf_of(entry)->source;
}

const char *library_licence(const struct library_entry *entry)
{
    return shelf_of(entry)->licence;
}

const struct library_entry *library_find(const char *name)
{
    const struct library_entry *entry;
    for (size_t i = 0; (entry = library_at(i)); i++)
        if (strcmp(entry->name, name) == 0)
            return entry;
    return NULL;
}

const char *library_name(size_t index)
{
    const struct library_entry *entry = library_at(index);
    return entry ? entry->name : NULL;
}

float library_entry_lambda(const struct library_entry *entry, size_t knot)
{
    return entry->lambda ? entry->lambda[knot] : (float)(entry->first_nm + knot * entry->step_nm);
}

float library_entry_value(const struct library_entry *entry, size_t knot)
{
    return entry->packed ? (float)entry->packed[knot] / 10000 : entry->value[knot];
}

bool library_value(const char *name, double lambda_nm, double *value)
{
    const struct library_entry *entry = library_find(name);
    if (!entry)
        return false;
    size_t last = (size_t)entry->count - 1, i = 0;
    while (i < last && library_entry_lambda(entry, i + 1) < lambda_nm)
        i++;
    double l0 = library_entry_lambda(entry, i), v0 = library_entry_value(entry, i);
    double l1 = library_entry_lambda(entry, i < last ? i + 1 : i),
           v1 = library_entry_value(entry, i < last ? i + 1 : i);
    bool outside = lambda_nm < l0 || lambda_nm > l1;
    double t = lambda_nm <= l0 || l1 <= l0 ? 0 : lambda_nm >= l1 ? 1 : (lambda_nm - l0) / (l1 - l0);
    *value = outside && entry->beyond == BEYOND_ZERO ? 0 : v0 + t * (v1 - v0);
    return true;
}

struct spectrum *spectrum_library(struct range range, const char *name, const char *object, stokes_error *err)
{
    const struct library_entry *entry = library_find(name);
    if (!entry && illuminant_is_computed(name))
        return spectrum_illuminant(range, name + strlen("illuminant/"), object, err);
    if (!entry) {
        fail(err, object, "library", "there is no entry named %.64s", name);
        return NULL;
    }
    float *lambda = malloc(2 * entry->count * sizeof *lambda);
    if (!lambda) {
        fail(err, object, "library", "out of memory");
        return NULL;
    }
    float *value = lambda + entry->count;
    for (size_t i = 0; i < entry->count; i++) {
        lambda[i] = library_entry_lambda(entry, i);
        value[i] = library_entry_value(entry, i);
    }
    struct spectrum *made = spectrum_table(range, lambda, value, entry->count, entry->beyond, object, err);
    free(lambda);
    return made;
}

const float *library_daylight(int i)
{
    return daylight_components[i];
}

const struct library_matrix *library_matrix_at(size_t index)
{
    return index < COUNT(matrix_entries) ? &matrix_entries[index] : NULL;
}

const struct library_matrix *library_matrix_find(const char *name)
{
    for (size_t i = 0; i < COUNT(matrix_entries); i++)
        if (strcmp(matrix_entries[i].name, name) == 0)
            return &matrix_entries[i];
    return NULL;
}

const struct glass *glass_at(size_t index)
{
    return index < COUNT(glasses) ? &glasses[index] : NULL;
}

const struct glass *glass_find(const char *name)
{
    static const char shelf[] = "glass/";
    if (strncmp(name, shelf, strlen(shelf)) == 0)
        name += strlen(shelf);
    for (size_t i = 0; i < COUNT(glasses); i++)
        if (strcmp(glasses[i].name + strlen(shelf), name) == 0)
            return &glasses[i];
    return NULL;
}
