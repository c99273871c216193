/* `stokes` once the width of its vectors is known: picks the sub-command. */
#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <string.h>

#include "cli.h"

static const struct command {
    const char *name, *summary;
    int (*run)(int argc, char **argv);
} commands[] = {
    {"render", "render a scene file", cli_render},
    {"merge", "merge EXRs of disjoint sample ranges", cli_merge},
    {"info", "say what a scene file or an EXR holds", cli_info},
    {"spectrum", "list, show, plot and import spectra", cli_spectrum},
    {"matrix", "import, export and show reradiation matrices", cli_matrix},
    {"serve", "speak the stream on stdin and stdout (for the add-on)", cli_serve},
};

static void print_help(FILE *out, const struct width *widths, const struct width *own)
{
    fputs("Stokes " STOKES_VERSION
          ": fluorescent spectral rendering.\n\nUsage: stokes COMMAND [OPTION…] [ARGUMENT…]\n\n",
          out);
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
        fprintf(out, "  %-10s %s\n", commands[i].name, commands[i].summary);
    fputs("\n`stokes COMMAND --help` tells all of a command.\n\nVectors on this machine: ", out);
    for (const struct width *w = widths; w->name; w++)
        if (w->usable)
            fprintf(out, "%s%s", w == widths ? "" : ", ", w->name);
    fprintf(out, "; now %s. STOKES_VECTORS=NAME picks others; pictures keep their bits.\n", own->name);
}

/* What was printed may still be on its way: a full disk shows here. */
static int finish(int status)
{
    stokes_error err = {.object = "standard output", .property = "write"};
    bool was_lost = ferror(stdout), is_lost = fflush(stdout) != 0;
    if (status || !(was_lost || is_lost))
        return status;
    snprintf(err.text, sizeof err.text, "%s", is_lost ? strerror(errno) : "a part was lost");
    return cli_fail(&err);
}

int program(const struct width *widths, const struct width *own, int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "";
    opterr = 0; /* errors are one line, and ours */
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
        if (strcmp(name, commands[i].name) == 0)
            return finish(commands[i].run(argc - 1, argv + 1));
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0 || strcmp(name, "help") == 0) {
        print_help(stdout, widths, own);
        return finish(0);
    }
    if (strcmp(name, "--version") == 0) {
        puts("stokes " STOKES_VERSION);
        return finish(0);
    }
    if (*name)
        fprintf(stderr, "stokes: %s: command: is unknown; see `stokes --help`\n", name);
    else
        print_help(stderr, widths, own);
    return CLI_USAGE;
}
