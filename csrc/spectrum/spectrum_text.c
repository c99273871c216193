/* Reading a user's own spectrum. */
#include "spectrum/spectrum_text.h"

#include <stdlib.h>
#include <string.h>

#include "base/error.h"

#define ROWS_MAX (1 << 16)
#define VALUE_MAX 1e30

struct row {
    double lambda, value;
};

static int by_wavelength(const void *a, const void *b)
{
    double x = ((const struct row *)a)->lambda, y = ((const struct row *)b)->lambda;
    return (x > y) - (x < y);
}

bool text_settle_commas(char *line)
{
    if (!strchr(line, ';'))
        return false;
    for (char *comma = line; (comma = strchr(comma, ','));)
        *comma = '.';
    return true;
}

/* The number in a column of a line (0: the first), parted by any run of commas, semicolons and blanks. */
static bool number_at(const char *line, int column, double *value)
{
    static const char marks[] = ",; \t";
    for (line += strspn(line, marks); column > 0; column--) {
        line += strcspn(line, marks);
        line += strspn(line, marks);
    }
    char *end;
    *value = strtod(line, &end);
    return end != line && (!*end || strchr(marks, *end));
}

/* False where the line says a wavelength and no value. */
static bool read_line(char *line, int number, int column, struct row *rows, size_t *count, const char *name,
                      stokes_error *err)
{
    struct row row;
    text_settle_commas(line);
    if (!number_at(line, 0, &row.lambda))
        return true;
    if (!number_at(line, column, &row.value))
        return fail(err, name, "lines", "line %d: no number in column %d", number, column + 1);
    if (!(row.lambda > 0 && row.lambda < 1e6 && fabs(row.value) < VALUE_MAX))
        return fail(err, name, "lines", "line %d: %g nm, %g", number, row.lambda, row.value);
    if (*count == ROWS_MAX)
        return fail(err, name, "lines", "more than %d", ROWS_MAX);
    rows[(*count)++] = row;
    return true;
}

static bool read_rows(char *text, int column, struct row *rows, size_t *count, const char *name,
                      stokes_error *err)
{
    int number = 0;
    for (char *line = text, *next; line; line = next) {
        next = line + strcspn(line, "\r\n");
        bool last = !*next, pair = next[0] == '\r' && next[1] == '\n';
        *next = 0;
        if (!read_line(line, ++number, column, rows, count, name, err))
            return false;
        next = last ? NULL : next + (pair ? 2 : 1);
    }
    if (*count < 2)
        return fail(err, name, "lines", "at least two of a wavelength and a value are wanted");
    qsort(rows, *count, sizeof *rows, by_wavelength);
    for (size_t i = 1; i < *count; i++)
        if (rows[i].lambda == rows[i - 1].lambda)
            return fail(err, name, "lines", "wavelength %g stands twice", rows[i].lambda);
    return rows[*count - 1].lambda >= TABLE_SHORTEST_NM ||
           fail(err, name, "lines", "wavelengths end at %g: they are wanted in nm, not in µm",
                rows[*count - 1].lambda);
}

stokes_spectrum *spectrum_from_text(char *text, int column, const char *name, stokes_error *err)
{
    struct row *rows = malloc(ROWS_MAX * sizeof *rows);
    stokes_spectrum *s = NULL;
    size_t count = 0;
    if (strncmp(text, "\xef\xbb\xbf", 3) == 0)
        text += 3;
    if (!rows) {
        fail(err, name, "open", "out of memory");
    } else if (read_rows(text, column, rows, &count, name, err)) {
        s = malloc(sizeof *s + 2 * count * sizeof(double));
        if (s) {
            *s = (stokes_spectrum){
                .count = count, .lambda_nm = (double *)(s + 1), .value = (double *)(s + 1) + count};
            for (size_t i = 0; i < count; i++) {
                s->lambda_nm[i] = rows[i].lambda;
                s->value[i] = rows[i].value;
            }
        } else {
            fail(err, name, "open", "out of memory");
        }
    }
    free(rows);
    return s;
}
