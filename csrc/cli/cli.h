/* The sub-commands: each takes its own argc and argv (argv[0] is its name) and returns the exit status. */
#ifndef CLI_CLI_H
#define CLI_CLI_H

#include <stdbool.h>
#include <stdio.h>

#include "stokes.h"

/* Exit statuses beside 0. */
enum { CLI_FAILED = 1, CLI_USAGE = 2, CLI_CANCELLED = 130 };

/* The program as compiled for one width of the processor's vector unit (main.c); an array of them ends with a NULL name. */
struct width {
    const char *name;
    bool usable; /* by the processor that this runs on */
    int (*program)(const struct width *widths, const struct width *own, int argc, char **argv);
};
int program(const struct width *widths, const struct width *own, int argc, char **argv);

int cli_render(int argc, char **argv);
int cli_merge(int argc, char **argv);
int cli_info(int argc, char **argv);
int cli_spectrum(int argc, char **argv);
int cli_matrix(int argc, char **argv);
int cli_serve(int argc, char **argv);

/* Prints `stokes: object: property: text` and returns CLI_FAILED. */
int cli_fail(const stokes_error *);
/* Prints `stokes: COMMAND: text`, points to --help, and returns CLI_USAGE. */
int cli_usage(const char *command, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The sheet of a plot: curves over wavelength as SVG, one colour each. `names` stand in its legend. */
void cli_plot(FILE *, stokes_spectrum *const *, const char *const *names, int count, double from_nm,
              double to_nm);

/* The whole text must be a number within [low, high]. */
bool cli_number(const char *text, double low, double high, double *value);
bool cli_whole(const char *text, double low, double high, int64_t *value);

#endif
