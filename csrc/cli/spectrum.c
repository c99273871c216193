/* `stokes spectrum`: the library's spectra, and users' own. */
#include <getopt.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

static const char help[] =
    "Usage: stokes spectrum list [--long] [PREFIX]\n"
    "       stokes spectrum show SPECTRUM [FROM TO [STEP]]\n"
    "       stokes spectrum plot SPECTRUM… [-o OUT.svg] [--range FROM,TO]\n"
    "       stokes spectrum import FILE -o OUT [--percent]\n"
    "\n"
    "SPECTRUM is a name of the library, as {\"library\": NAME} takes it (of glasses, their index), or a\n"
    "file: lines of a wavelength and a value, parted by commas, semicolons, tabs or spaces, in UTF-8 or in\n"
    "UTF-16 with its mark. Beside semicolons, and where commas cannot part columns, a comma is a decimal\n"
    "mark. Lines that do not begin with a number are titles. Wavelengths are in nm, or in Å where a title\n"
    "above them says so.\n"
    "\n"
    "  list    names; with --long also the wavelengths that were measured, where they are from and their\n"
    "          licence, and quantum yields of dyes\n"
    "  show    wavelength and value, a line each, from 360 to 830 nm by 10 unless told otherwise; of a "
    "file,\n"
    "          its own wavelengths. Where an entry is from goes to stderr\n"
    "  plot    a sheet of curves as SVG, to stdout without -o\n"
    "  import  checks and sorts a file, takes what is below zero as 0, and writes it as OUT: CSV or, by its\n"
    "          ending .json, as the stream takes it, {\"table\": …}\n"
    "\n"
    "  -o, --output FILE\n"
    "  -c, --column N       of a file, which holds the values; the wavelengths are column 0; default 1\n"
    "  -r, --range FROM,TO  of a plot, nm; default 300,830\n"
    "  -p, --percent        100 in the file means all of the light\n"
    "  -l, --long\n"
    "  -h, --help\n";

#define CURVES_MAX 32

struct arguments {
    const char *out, *place[CURVES_MAX];
    int places, column;
    double from, to;
    bool percent, is_long;
};

static bool read_option(int option, const char *argument, struct arguments *a)
{
    int64_t column;
    char *end;
    switch (option) {
    case 'o': a->out = argument; return true;
    case 'l': return a->is_long = true;
    case 'p': return a->percent = true;
    case 'c':
        if (!cli_whole(argument, 1, 1000, &column))
            return false;
        a->column = (int)column;
        return true;
    case 'r':
        a->from = strtod(argument, &end);
        return *end == ',' && cli_number(end + 1, 1, 1e6, &a->to) && a->from >= 1 && a->from < a->to;
    default: return false;
    }
}

static bool read_arguments(int argc, char **argv, struct arguments *a)
{
    static const struct option options[] = {
        {"output", required_argument, NULL, 'o'}, {"column", required_argument, NULL, 'c'},
        {"range", required_argument, NULL, 'r'},  {"percent", no_argument, NULL, 'p'},
        {"long", no_argument, NULL, 'l'},         {0}};
    int option;
    *a = (struct arguments){.column = 1, .from = 300, .to = 830};
    while ((option = getopt_long(argc, argv, "o:c:r:pl", options, NULL)) != -1) {
        if (option == '?')
            cli_usage("spectrum", "'%s' is no option, or lacks its argument", argv[optind - 1]);
        else if (!read_option(option, optarg, a))
            cli_usage("spectrum", "'%s' is not what -%c takes", optarg, option);
        else
            continue;
        return false;
    }
    for (; optind < argc; optind++) {
        if (a->places == CURVES_MAX) {
            cli_usage("spectrum", "at most %d spectra are taken", CURVES_MAX);
            return false;
        }
        a->place[a->places++] = argv[optind];
    }
    return true;
}

static void print_note(void *user, const stokes_error *what)
{
    (void)user;
    fprintf(stderr, "stokes: %s: %s: %s\n", what->object, what->property, what->text);
}

/* --- list ---------------------------------------------------------------------------------------------------- */

static void print_long(const char *name)
{
    stokes_library_notes notes;
    if (!stokes_library_about(name, &notes))
        return;
    printf("%s  %g–%g nm  %s (%s)", name, notes.first_nm, notes.last_nm, notes.source, notes.licence);
    if (notes.yield_source)
        printf("; quantum yield %g: %s", notes.quantum_yield, notes.yield_source);
    putchar('\n');
}

static int list(const struct arguments *a)
{
    const char *name, *prefix = a->places ? a->place[0] : "";
    size_t printed = 0;
    for (size_t i = 0; (name = stokes_library_name(i)); i++) {
        if (strncmp(name, prefix, strlen(prefix)) != 0)
            continue;
        printed++;
        if (a->is_long)
            print_long(name);
        else
            puts(name);
    }
    return printed > 0 ? 0 : cli_usage("spectrum", "no name begins with '%s'", prefix);
}

/* --- show ---------------------------------------------------------------------------------------------------- */

/* To stderr, so that the numbers can be piped on. False if it is no entry. */
static bool print_notes(const char *name)
{
    stokes_library_notes notes;
    if (!stokes_library_about(name, &notes))
        return false;
    fprintf(stderr, "%s, %g to %g nm: %s (%s)\n", name, notes.first_nm, notes.last_nm, notes.source,
            notes.licence);
    if (notes.yield_source)
        fprintf(stderr, "quantum yield %g: %s\n", notes.quantum_yield, notes.yield_source);
    return true;
}

static int show(const struct arguments *a)
{
    double from = 360, to = 830, step = 10;
    stokes_error err;
    if ((a->places != 1 && a->places != 3 && a->places != 4) ||
        (a->places > 1 &&
         (!cli_number(a->place[1], 1, 1e6, &from) || !cli_number(a->place[2], from, 1e6, &to))) ||
        (a->places > 3 && !cli_number(a->place[3], 1e-3, 1e6, &step)))
        return cli_usage("spectrum", "SPECTRUM, or SPECTRUM FROM TO, or SPECTRUM FROM TO STEP is wanted");
    stokes_spectrum *s = stokes_spectrum_read(a->place[0], a->column, print_note, NULL, &err);
    if (!s)
        return cli_fail(&err);
    if (!print_notes(a->place[0]) && a->places == 1)
        for (size_t i = 0; i < s->count; i++)
            printf("%g %.6g\n", s->lambda_nm[i], s->value[i]);
    else
        for (int i = 0; from + i * step <= to; i++)
            printf("%g %.6g\n", from + i * step, stokes_spectrum_value(s, from + i * step));
    stokes_spectrum_destroy(s);
    return 0;
}

/* --- plot ---------------------------------------------------------------------------------------------------- */

static int write_plot(const struct arguments *a, stokes_spectrum *const *spectra)
{
    char *text = NULL;
    size_t bytes = 0;
    stokes_error err = {.object = "stokes", .text = "out of memory"};
    FILE *out = a->out ? open_memstream(&text, &bytes) : stdout;
    if (!out)
        return cli_fail(&err);
    cli_plot(out, spectra, a->place, a->places, a->from, a->to);
    if (!a->out)
        return 0;
    bool good = fclose(out) == 0 && stokes_text_write(a->out, text, bytes, &err);
    free(text);
    return good ? 0 : cli_fail(&err);
}

static int plot(const struct arguments *a)
{
    stokes_spectrum *spectra[CURVES_MAX] = {0};
    stokes_error err;
    int status = 0, count = 0;
    if (a->places == 0)
        return cli_usage("spectrum", "at least one SPECTRUM is wanted");
    while (status == 0 && count < a->places)
        if ((spectra[count] = stokes_spectrum_read(a->place[count], a->column, print_note, NULL, &err)))
            count++;
        else
            status = cli_fail(&err);
    if (status == 0)
        status = write_plot(a, spectra);
    while (count > 0)
        stokes_spectrum_destroy(spectra[--count]);
    return status;
}

/* --- import -------------------------------------------------------------------------------------------------- */

static void tell(const char *path, const stokes_spectrum *s)
{
    double low = s->value[0], high = s->value[0];
    for (size_t i = 1; i < s->count; i++) {
        low = s->value[i] < low ? s->value[i] : low;
        high = s->value[i] > high ? s->value[i] : high;
    }
    printf("%s: %zu values of %g to %g, %g to %g nm\n", path, s->count, low, high, s->lambda_nm[0],
           s->lambda_nm[s->count - 1]);
}

/* An instrument's noise about zero: no light is negative, and the stream takes none. */
static void cut_noise(const char *path, stokes_spectrum *s)
{
    size_t cut = 0;
    double low = 0;
    for (size_t i = 0; i < s->count; i++)
        if (s->value[i] < 0) {
            low = s->value[i] < low ? s->value[i] : low;
            s->value[i] = 0;
            cut++;
        }
    if (cut > 0)
        fprintf(stderr, "stokes: %s: %zu of %zu values are below zero, down to %.3g: taken as 0\n", path, cut,
                s->count, low);
}

static int import(const struct arguments *a)
{
    stokes_error err;
    if (a->places != 1 || !a->out)
        return cli_usage("spectrum", "FILE and an output (-o) are wanted");
    stokes_spectrum *s = stokes_spectrum_read(a->place[0], a->column, print_note, NULL, &err);
    if (!s)
        return cli_fail(&err);
    for (size_t i = 0; a->percent && i < s->count; i++)
        s->value[i] /= 100;
    cut_noise(a->place[0], s);
    bool good = stokes_spectrum_write(s, a->out, &err);
    if (good)
        tell(a->place[0], s);
    stokes_spectrum_destroy(s);
    return good ? 0 : cli_fail(&err);
}

int cli_spectrum(int argc, char **argv)
{
    static const struct {
        const char *name;
        int (*run)(const struct arguments *);
    } verbs[] = {{"list", list}, {"show", show}, {"plot", plot}, {"import", import}};
    const char *what = argc > 1 ? argv[1] : "";
    struct arguments a;
    if (strcmp(what, "--help") == 0 || strcmp(what, "-h") == 0) {
        fputs(help, stdout);
        return 0;
    }
    for (size_t i = 0; i < sizeof verbs / sizeof *verbs; i++)
        if (strcmp(what, verbs[i].name) == 0)
            return read_arguments(argc - 1, argv + 1, &a) ? verbs[i].run(&a) : CLI_USAGE;
    return cli_usage("spectrum", "list, show, plot or import is wanted");
}
