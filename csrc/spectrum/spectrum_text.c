/* Reading a user's own spectrum. */
#include "spectrum/spectrum_text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "spectrum/text_cells.h"
#include "spectrum/text_unit.h"

#define ROWS_MAX 65534 /* the stream takes 65 536, and lights end in two more */
#define VALUE_MAX 1e30
/* Where a table of nm is likely to have something to say: it begins where the eye still sees and ends where no scene carries light (Λ). */
#define LIKELY_FIRST_NM 830.0
#define LIKELY_LAST_NM 4000.0
/* A table of Å reaches the light that a scene carries unless told otherwise. */
#define LIKELY_LAST_ANGSTROM 3000.0

struct row {
    double lambda, value;
};

struct rows {
    const char *name;
    int column, line; /* the line that is being read */
    size_t count;
    enum text_unit unit;
    int unit_line, comma_line; /* the lines that said so; 0: none */
    struct row row[ROWS_MAX];
};

static int by_wavelength(const void *a, const void *b)
{
    double x = ((const struct row *)a)->lambda, y = ((const struct row *)b)->lambda;
    return (x > y) - (x < y);
}

/* --- Lines --------------------------------------------------------------------------------------------------- */

/* What a cell holds, for one line of a message: nothing where it would not look like text there. */
static void quote_cell(const struct text_cell *cell, char quote[32])
{
    int length = cell->length < 24 ? (int)cell->length : 24;
    quote[0] = 0;
    while (length > 0 && ((unsigned char)cell->start[length] & 0xc0) == 0x80)
        length--; /* no half of a letter */
    for (int i = 0; i < length; i++)
        if ((unsigned char)cell->start[i] < ' ' || cell->start[i] == 0x7f)
            return;
    if (length > 0)
        snprintf(quote, 32, ": '%.*s'", length, cell->start);
}

static bool read_number(struct rows *rows, int column, const struct text_cell *cell, double *value,
                        stokes_error *err)
{
    char quote[32];
    quote_cell(cell, quote);
    switch (text_cell_number(cell, value)) {
    case NUMBER_READ: return true;
    case NUMBER_READ_COMMA: rows->comma_line = rows->comma_line ? rows->comma_line : rows->line; return true;
    case NUMBER_DOUBTFUL:
        return fail(err, rows->name, "lines",
                    "line %d: the comma in column %d may be one of decimals or of thousands%s", rows->line,
                    column, quote);
    case NUMBER_NONE: break;
    }
    return fail(err, rows->name, "lines", "line %d: no number in column %d%s (the wavelengths are column 0)",
                rows->line, column, quote);
}

/* Once rows have come, a line that begins with a digit or an empty cell is a broken row. */
static bool is_title(const struct rows *rows, const char *line, const struct text_cell *first)
{
    double ignored;
    if (line[0] == '#' || !line[strspn(line, ",; \t\"")])
        return true;
    if (text_cell_number(first, &ignored) != NUMBER_NONE)
        return false;
    return rows->count == 0 || (first->length > 0 && !strchr("0123456789.", *first->start));
}

static void read_title(struct rows *rows, const char *line)
{
    enum text_unit unit = rows->count == 0 ? text_unit_of(line) : UNIT_UNSAID;
    if (unit != UNIT_UNSAID) {
        rows->unit = unit;
        rows->unit_line = rows->line;
    }
}

static bool add_row(struct rows *rows, struct row row, stokes_error *err)
{
    if (!(row.lambda > 0 && row.lambda < 1e6 && fabs(row.value) < VALUE_MAX))
        return fail(err, rows->name, "lines", "line %d: wavelength %g, value %g: out of range", rows->line,
                    row.lambda, row.value);
    if (rows->count == ROWS_MAX)
        return fail(err, rows->name, "lines", "more than %d", ROWS_MAX);
    rows->row[rows->count++] = row;
    return true;
}

/* False where the line says a wavelength and no value. */
static bool read_line(struct rows *rows, char *line, stokes_error *err)
{
    struct text_cell first, cell;
    struct row row;
    line += strspn(line, " ");
    if (line[0] != '#')
        line[strcspn(line, "#")] = 0;
    bool comma = !text_settle_commas(line) && text_settle_blanks(line);
    text_cell_at(line, 0, &first);
    if (is_title(rows, line, &first)) {
        read_title(rows, line);
        return true;
    }
    if (comma && !rows->comma_line)
        rows->comma_line = rows->line;
    if (!text_cell_at(line, rows->column, &cell))
        cell = (struct text_cell){"", 0, false};
    return read_number(rows, 0, &first, &row.lambda, err) &&
           read_number(rows, rows->column, &cell, &row.value, err) && add_row(rows, row, err);
}

/* --- Tables -------------------------------------------------------------------------------------------------- */

/* Wavelengths in nm. What titles say of their unit must go with what they are. */
static bool settle_unit(struct rows *rows, stokes_error *err)
{
    double first = rows->row[0].lambda, last = rows->row[rows->count - 1].lambda;
    switch (rows->unit) {
    case UNIT_OTHER:
        return fail(err, rows->name, "lines",
                    "line %d names wavenumbers or frequencies: wavelengths are wanted, in nm or Å",
                    rows->unit_line);
    case UNIT_ANGSTROM:
        if (first <= LIKELY_FIRST_NM && last < LIKELY_LAST_ANGSTROM)
            return fail(err, rows->name, "lines", "line %d says Å, but wavelengths of %g to %g look like nm",
                        rows->unit_line, first, last);
        for (size_t i = 0; i < rows->count; i++)
            rows->row[i].lambda /= 10;
        return true;
    case UNIT_UNSAID:
        if (last >= TABLE_SHORTEST_NM && first < 1)
            return fail(err, rows->name, "lines", "wavelengths begin at %g: they are wanted in nm, not in µm",
                        first);
        if (first > LIKELY_FIRST_NM || last > LIKELY_LAST_NM)
            return fail(err, rows->name, "lines",
                        "wavelengths of %g to %g: a title above them must say whether they are in nm or Å",
                        first, last);
        break;
    case UNIT_NM: break;
    }
    return last >= TABLE_SHORTEST_NM ||
           fail(err, rows->name, "lines", "wavelengths end at %g: they are wanted in nm, not in µm", last);
}

static bool read_rows(struct rows *rows, char *text, stokes_error *err)
{
    for (char *line = text, *next; line; line = next) {
        next = line + strcspn(line, "\r\n");
        bool last = !*next, pair = next[0] == '\r' && next[1] == '\n';
        *next = 0;
        rows->line++;
        if (!read_line(rows, line, err))
            return false;
        next = last ? NULL : next + (pair ? 2 : 1);
    }
    if (rows->count < 2)
        return fail(err, rows->name, "lines", "at least two of a wavelength and a value are wanted");
    qsort(rows->row, rows->count, sizeof *rows->row, by_wavelength);
    for (size_t i = 1; i < rows->count; i++)
        if (rows->row[i].lambda == rows->row[i - 1].lambda)
            return fail(err, rows->name, "lines", "wavelength %g stands twice", rows->row[i].lambda);
    return settle_unit(rows, err);
}

static void tell(const struct rows *rows, void (*note)(void *, const stokes_error *), void *user)
{
    stokes_error what;
    if (note && rows->unit == UNIT_ANGSTROM) {
        fail(&what, rows->name, "lines",
             "wavelengths are in Å by line %d: a tenth of each is taken, the values as they are",
             rows->unit_line);
        note(user, &what);
    }
    if (note && rows->comma_line) {
        fail(&what, rows->name, "lines", "commas within numbers, as in line %d, are taken as decimal marks",
             rows->comma_line);
        note(user, &what);
    }
}

static stokes_spectrum *table_of(const struct rows *rows)
{
    stokes_spectrum *s = malloc(sizeof *s + 2 * rows->count * sizeof(double));
    if (!s)
        return NULL;
    *s = (stokes_spectrum){
        .count = rows->count, .lambda_nm = (double *)(s + 1), .value = (double *)(s + 1) + rows->count};
    for (size_t i = 0; i < rows->count; i++) {
        s->lambda_nm[i] = rows->row[i].lambda;
        s->value[i] = rows->row[i].value;
    }
    return s;
}

stokes_spectrum *spectrum_from_text(char *text, int column, const char *name,
                                    void (*note)(void *user, const stokes_error *what), void *user,
                                    stokes_error *err)
{
    struct rows *rows = calloc(1, sizeof *rows);
    stokes_spectrum *s = NULL;
    bool good = false;
    if (rows) {
        rows->name = name;
        rows->column = column;
        good = read_rows(rows, strncmp(text, "\xef\xbb\xbf", 3) == 0 ? text + 3 : text, err);
        s = good ? table_of(rows) : NULL;
    }
    if (s)
        tell(rows, note, user);
    else if (!rows || good)
        fail(err, name, "open", "out of memory");
    free(rows);
    return s;
}
