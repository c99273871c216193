/* Cells of a line of text: what parts them, and the numbers in them. */
#include "spectrum/text_cells.h"

#include <stdlib.h>
#include <string.h>

#define NUMBER_LENGTH_MAX 63

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t';
}

/* --- Commas -------------------------------------------------------------------------------------------------- */

bool text_settle_commas(char *line)
{
    bool quoted = false, parted = false;
    for (const char *c = line; *c; c++) {
        quoted ^= *c == '"';
        parted |= *c == ';' && !quoted;
    }
    if (!parted)
        return false;
    for (char *comma = line; (comma = strchr(comma, ','));)
        *comma = '.';
    return true;
}

static bool is_tight_comma(const char *line, const char *c)
{
    return *c == ',' && c > line && is_digit(c[-1]) && is_digit(c[1]);
}

/* What stands in a line outside quotes. */
struct habits {
    bool tight, points;  /* commas between digits; decimal points */
    bool mixed;          /* both in one word, "400,0.25": commas part columns */
    bool blanks, spaced; /* "400 0" and "400, 0" */
};

static struct habits habits_of(const char *line)
{
    struct habits h = {0};
    bool quoted = false, tight = false, points = false;
    for (const char *c = line; *c; c++) {
        quoted ^= *c == '"';
        if (quoted)
            continue;
        if (is_blank(*c)) {
            char before = c > line ? c[-1] : 0, after = c[strspn(c, " \t")];
            bool number = is_digit(after) || after == '-' || after == '+';
            h.blanks |= number && is_digit(before);
            h.spaced |= number && before == ',';
            tight = points = false;
        }
        h.tight |= tight |= is_tight_comma(line, c);
        h.points |= points |= *c == '.' && (is_digit(c[1]) || (c > line && is_digit(c[-1])));
        h.mixed |= tight && points;
    }
    return h;
}

bool text_settle_blanks(char *line)
{
    const struct habits h = habits_of(line);
    if (!h.tight || h.mixed || strchr(line, ';') || !(h.blanks || (h.spaced && !h.points)))
        return false;
    bool quoted = false;
    for (char *c = line; *c; c++) {
        quoted ^= *c == '"';
        if (!quoted && is_tight_comma(line, c))
            *c = '.';
    }
    return true;
}

/* --- Cells --------------------------------------------------------------------------------------------------- */

static bool ends_cell(char c)
{
    return !c || strchr(",; \t", c);
}

/* Past a cell in quotes, "" being a quote within; NULL if what follows belongs to the cell or nothing closes it. */
static const char *past_quotes(const char *open)
{
    const char *c = open + 1;
    while (*c && (c[0] != '"' || c[1] == '"'))
        c += c[0] == '"' ? 2 : 1;
    return *c && ends_cell(c[1]) ? c + 1 : NULL;
}

/* The cell that begins here; returns its end. */
static const char *read_cell(const char *at, struct text_cell *cell)
{
    const char *end = *at == '"' ? past_quotes(at) : NULL;
    cell->quoted = end != NULL;
    if (!end)
        for (end = at; !ends_cell(*end);)
            end++;
    cell->start = at + cell->quoted;
    cell->length = (size_t)(end - at) - 2u * cell->quoted;
    return end;
}

/* Past one mark with the blanks about it: a comma, a semicolon, a tab, or else spaces. */
static const char *past_mark(const char *at)
{
    const char *mark = at + strspn(at, " \t");
    if (*mark != ',' && *mark != ';') {
        mark = at + strspn(at, " ");
        return *mark == '\t' ? mark + 1 + strspn(mark + 1, " ") : mark;
    }
    return mark + 1 + strspn(mark + 1, " \t");
}

bool text_cell_at(const char *line, int column, struct text_cell *cell)
{
    const char *end = read_cell(line + strspn(line, " "), cell);
    for (; column > 0; column--) {
        if (!end[strspn(end, " \t")])
            return false;
        end = read_cell(past_mark(end), cell);
    }
    return true;
}

void text_drop_quotes(char *line)
{
    char *out = line;
    for (const char *c = line; *c;) {
        size_t length = *c == '"' ? strcspn(c + 1, "\",;") : 0;
        bool whole = *c == '"' && c[length + 1] == '"';
        memmove(out, c + whole, whole ? length : 1);
        out += whole ? length : 1;
        c += whole ? length + 2 : 1;
    }
    *out = 0;
}

/* --- Numbers ------------------------------------------------------------------------------------------------- */

/* One to three digits, a comma, three digits: 1,125 may be 1125. 0,125 may not. */
static bool may_be_thousands(const char *number, const char *comma)
{
    const char *first = number + (*number == '-' || *number == '+');
    return *first != '0' && comma - first <= 3 && strspn(comma + 1, "0123456789") == 3 && !comma[4];
}

/* strtod also takes hexadecimal, infinity and nan, which no table of a measurement means. */
static bool read_decimal(const char *text, double *value)
{
    char *end;
    if (!*text || text[strspn(text, "0123456789.+-eE")])
        return false;
    *value = strtod(text, &end);
    return end != text && !*end;
}

enum text_number text_cell_number(const struct text_cell *cell, double *value)
{
    const char *start = cell->start, *end = start + cell->length;
    char text[NUMBER_LENGTH_MAX + 1], *comma;
    while (start < end && is_blank(*start))
        start++;
    while (end > start && is_blank(end[-1]))
        end--;
    if (end - start > NUMBER_LENGTH_MAX)
        return NUMBER_NONE;
    memcpy(text, start, (size_t)(end - start));
    text[end - start] = 0;
    comma = strchr(text, ',');
    if (comma) {
        bool doubtful = may_be_thousands(text, comma);
        *comma = '.';
        return !read_decimal(text, value) ? NUMBER_NONE : doubtful ? NUMBER_DOUBTFUL : NUMBER_READ_COMMA;
    }
    return read_decimal(text, value) ? NUMBER_READ : NUMBER_NONE;
}
