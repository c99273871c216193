/* Cells of a line of text, as spreadsheets and instruments write them. */
#ifndef SPECTRUM_TEXT_CELLS_H
#define SPECTRUM_TEXT_CELLS_H

#include <stdbool.h>
#include <stddef.h>

struct text_cell {
    const char *start; /* without quotes */
    size_t length;
    bool quoted;
};

enum text_number {
    NUMBER_READ,
    NUMBER_READ_COMMA, /* its comma was taken as a decimal mark */
    NUMBER_DOUBTFUL,   /* 1,125 in quotes: a comma of decimals or of thousands */
    NUMBER_NONE
};

/* Where semicolons part the columns of a line a comma is a decimal mark, as spreadsheets of half of Europe write it: it becomes the point that
   strtod knows. False if there is no semicolon. */
bool text_settle_commas(char *line);

/* Drops quotes about what holds no mark that parts columns: where cells are told apart without text_cell_at. */
void text_drop_quotes(char *line);

/* Commas become points, too, where blanks part numbers that have commas within and no point ("400 0,25"); after text_settle_commas. True
   if there were such commas. */
bool text_settle_blanks(char *line);

/* A cell of a line (0: the first): commas, semicolons, tabs and runs of spaces part them, and quotes hold one together. False if the line has no
   such cell. */
bool text_cell_at(const char *line, int column, struct text_cell *cell);

/* The whole cell as a decimal number. */
enum text_number text_cell_number(const struct text_cell *cell, double *value);

#endif
