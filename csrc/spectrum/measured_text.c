/* Reradiation matrices as text: CSV, and the matrix text of the BFC-450, a bispectral photometer. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/os.h"
#include "spectrum/measured.h"
#include "spectrum/text_cells.h"

/* One value more than a line may hold. */
#define VALUES (RERADIATION_BANDS_MAX + 2)

/* Lines of a text, ended in place. */
struct lines {
    char *next;
    int number;
};

static char *next_line(struct lines *lines)
{
    char *line = lines->next, *end;
    if (!line)
        return NULL;
    end = line + strcspn(line, "\r\n");
    lines->next = *end ? end + (end[0] == '\r' && end[1] == '\n' ? 2 : 1) : NULL;
    *end = 0;
    lines->number++;
    return line;
}

static char *skip_blanks(char *text)
{
    return text + strspn(text, " \t");
}

/* What parts the values of a line. */
static const char *marks_of(char *line)
{
    if (text_settle_commas(line))
        return ";";
    return strchr(line, ',') ? "," : " \t";
}

/* Values of a line. Where commas or semicolons part them an empty place is a missing value; otherwise blanks part them. Words that are
   no number (nan, -, n/a) are missing, too. Returns how many there are, at most VALUES. */
static int read_values(char *text, float *values)
{
    text_drop_quotes(text);
    const char *marks = marks_of(text);
    bool places = marks[0] != ' ';
    int count = 0;
    text = skip_blanks(text);
    while (count < VALUES && (*text || (count > 0 && places))) {
        size_t length = strcspn(text, marks);
        char after = text[length], *end;
        text[length] = 0;
        double value = strtod(text, &end);
        values[count++] = end == text || *skip_blanks(end) || !isfinite(value) ? NAN : (float)value;
        text += length + (after != 0);
        if (!after)
            break;
        text = skip_blanks(text);
        if (!*text && places) {
            values[count++] = NAN; /* the line ends in a mark */
            break;
        }
    }
    return count;
}

/* A measurement while its lines come: it grows by outgoing bands. */
struct table {
    int count_in, count_out;
    double in[VALUES], out[RERADIATION_BANDS_MAX];
    float *share;
};

static bool add_row(struct table *t, double out, const float *values, int count, int line, const char *name,
                    stokes_error *err)
{
    if (count != t->count_in)
        return fail(err, name, "lines", "line %d has %d values for %d incident bands", line, count,
                    t->count_in);
    if (t->count_out == RERADIATION_BANDS_MAX)
        return fail(err, name, "lines", "more than %d outgoing bands", RERADIATION_BANDS_MAX);
    for (int i = 0; i < count; i++)
        if (!(isnan(values[i]) || fabsf(values[i]) < 1e6f))
            return fail(err, name, "lines", "line %d holds %g, which is no share", line, (double)values[i]);
    float *more = realloc(t->share, (size_t)(t->count_out + 1) * (size_t)t->count_in * sizeof *more);
    if (!more)
        return fail(err, name, "lines", "out of memory");
    t->share = more;
    memcpy(more + (size_t)t->count_out * (size_t)count, values, (size_t)count * sizeof *more);
    t->out[t->count_out++] = out;
    return true;
}

/* Empty lines and those that begin with # say nothing. */
static bool says_nothing(const char *line)
{
    return !line[strspn(line, " \t,;")] || line[strspn(line, " \t")] == '#';
}

/* --- CSV --------------------------------------------------------------------------------------------------- */

/* The first line: a title, then the incident wavelengths. */
static bool read_heading(struct table *t, char *line, float *values, int number, const char *name,
                         stokes_error *err)
{
    int count = read_values(line, values);
    for (int i = 1; i < count; i++) {
        if (isnan(values[i]))
            return fail(err, name, "heading", "line %d: place %d is no incident wavelength", number, i + 1);
        t->in[i - 1] = values[i];
    }
    t->count_in = count - 1;
    return (t->count_in >= 2 && t->count_in <= RERADIATION_BANDS_MAX) ||
           fail(err, name, "heading", "line %d names %d incident wavelengths; 2 to %d are taken", number,
                t->count_in, RERADIATION_BANDS_MAX);
}

static bool read_csv(struct lines *lines, struct table *t, float *values, const char *name, stokes_error *err)
{
    char *line;
    while ((line = next_line(lines))) {
        if (says_nothing(line))
            continue;
        if (t->count_in == 0) {
            if (!read_heading(t, line, values, lines->number, name, err))
                return false;
            continue;
        }
        int count = read_values(line, values);
        if (isnan(values[0]))
            return fail(err, name, "lines", "line %d begins with no wavelength", lines->number);
        if (!add_row(t, values[0], values + 1, count - 1, lines->number, name, err))
            return false;
    }
    return t->count_in > 0 || fail(err, name, "open", "holds no matrix");
}

/* --- BFC-450 ------------------------------------------------------------------------------------------------ */

/* Outgoing start, end and step, number of incident wavelengths, incident start and step; found by their shape. */
static bool read_six(const char *line, int six[6])
{
    int used = 0;
    return sscanf(line, " %d %d %d %d %d %d %n", &six[0], &six[1], &six[2], &six[3], &six[4], &six[5],
                  &used) == 6 &&
           !line[used] && six[0] > 0 && six[1] > six[0] && six[2] > 0 && six[3] > 0 && six[4] > 0 &&
           six[5] > 0;
}

static bool begins_with(const char *line, const char *word)
{
    return strncmp(line + strspn(line, " \t"), word, strlen(word)) == 0;
}

/* Up to the line of incident wavelengths, which is handed out without its mark. A head may hold anything, so the last six numbers count. */
static char *read_bfc_head(struct lines *lines, int six[6], const char *name, stokes_error *err)
{
    char *line;
    int found[6];
    memset(six, 0, 6 * sizeof *six);
    while ((line = next_line(lines)) && !begins_with(line, "r:c:"))
        if (read_six(line, found))
            memcpy(six, found, sizeof found);
    if (six[3] == 0)
        fail(err, name, "head", "has no line of six whole numbers (bands)");
    else if (six[3] < 2 || six[3] > RERADIATION_BANDS_MAX)
        fail(err, name, "head", "names %d incident wavelengths; 2 to %d are taken", six[3],
             RERADIATION_BANDS_MAX);
    else if (line)
        return strstr(line, "r:c:") + strlen("r:c:");
    else
        fail(err, name, "head", "has no line that begins with r:c:");
    return NULL;
}

/* Incident wavelengths as the six numbers have them; what the line after r:c: says must be the same. */
static bool read_incident(struct table *t, char *line, const int six[6], float *values, int number,
                          const char *name, stokes_error *err)
{
    int count = read_values(line, values);
    t->count_in = six[3];
    for (int i = 0; i < six[3]; i++)
        t->in[i] = six[4] + (double)i * six[5];
    if (count > 0 && count != six[3])
        return fail(err, name, "head", "line %d names %d incident wavelengths, the line of bands %d", number,
                    count, six[3]);
    for (int i = 0; i < count; i++)
        if (!(fabs(values[i] - t->in[i]) < 0.5))
            return fail(err, name, "head", "line %d: place %d is %g nm, by the line of bands %g", number,
                        i + 1, (double)values[i], t->in[i]);
    return true;
}

/* Lines that begin with ; are the operator's. */
static bool is_remark(const char *line)
{
    return says_nothing(line) || begins_with(line, ";");
}

static bool read_bfc(struct lines *lines, struct table *t, float *values, const char *name, stokes_error *err)
{
    int six[6];
    char *line = read_bfc_head(lines, six, name, err);
    if (!line || !read_incident(t, line, six, values, lines->number, name, err))
        return false;
    while ((line = next_line(lines)) && !begins_with(line, "EOD")) {
        if (is_remark(line))
            continue;
        int count = read_values(line, values);
        double out = six[0] + (double)t->count_out * six[2];
        if (!(fabs(values[0] - out) < 0.5))
            return fail(err, name, "lines", "line %d is of %g nm, by the line of bands of %g", lines->number,
                        (double)values[0], out);
        if (!add_row(t, out, values + 1, count - 1, lines->number, name, err))
            return false;
    }
    int wanted = (six[1] - six[0]) / six[2] + 1;
    return t->count_out == wanted || fail(err, name, "lines", "%d outgoing bands follow a head of %d%s",
                                          t->count_out, wanted, line ? "" : ", and no EOD");
}

/* --- Either ------------------------------------------------------------------------------------------------- */

/* By a line's beginning: a CSV may say in a remark what measured it. */
static bool is_bfc(const char *text)
{
    for (; text; text = strpbrk(text, "\r\n")) {
        text += strspn(text, " \t\r\n");
        if (begins_with(text, "VEC_01") || begins_with(text, "BFC-450 Matrix") || begins_with(text, "r:c:"))
            return true;
    }
    return false;
}

static struct measured *measured_of(const struct table *t, const char *name, stokes_error *err)
{
    struct measured *m = measured_create(t->count_in, t->count_out, name, err);
    if (!m)
        return NULL;
    memcpy(m->in, t->in, (size_t)t->count_in * sizeof *m->in);
    memcpy(m->out, t->out, (size_t)t->count_out * sizeof *m->out);
    memcpy(m->share, t->share, (size_t)t->count_in * (size_t)t->count_out * sizeof *m->share);
    return m;
}

stokes_matrix *reradiation_from_text(char *text, const char *name, reradiation_note note, void *user,
                                     stokes_error *err)
{
    struct lines lines = {.next = strncmp(text, "\xef\xbb\xbf", 3) == 0 ? text + 3 : text};
    struct table *t = calloc(1, sizeof *t);
    float *values = calloc(VALUES, sizeof *values);
    struct measured *raw = NULL;
    if (!t || !values)
        fail(err, name, "open", "out of memory");
    else if ((is_bfc(lines.next) ? read_bfc : read_csv)(&lines, t, values, name, err))
        raw = measured_of(t, name, err);
    if (t)
        free(t->share);
    free(t);
    free(values);
    return raw ? measured_finish(raw, name, note, user, err) : NULL;
}

/* --- Writing ------------------------------------------------------------------------------------------------ */

static void print_csv(const stokes_matrix *m, FILE *file)
{
    fputs("outgoing_nm\\incident_nm", file);
    for (int in = 0; in < m->count_in; in++)
        fprintf(file, ",%.9g", m->first_in_nm + in * m->step_nm);
    for (int out = 0; out < m->count_out; out++) {
        fprintf(file, "\n%.9g", m->first_out_nm + out * m->step_nm);
        for (int in = 0; in < m->count_in; in++)
            fprintf(file, ",%.9g", (double)m->share[out * m->count_in + in]);
    }
    fputc('\n', file);
}

bool reradiation_write_csv(const stokes_matrix *m, const char *path, stokes_error *err)
{
    char *text = NULL;
    size_t bytes = 0;
    FILE *file = open_memstream(&text, &bytes);
    if (file)
        print_csv(m, file);
    bool good = file && !ferror(file);
    if (file)
        good = fclose(file) == 0 && good;
    good = good ? os_write_file(path, text, bytes, err) : fail(err, path, "write", "out of memory");
    free(text);
    return good;
}
