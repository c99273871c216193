/* `stokes matrix`: reradiation matrices in and out. */
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

static const char help[] =
    "Usage: stokes matrix import FILE -o OUT [--pixel X,Y]\n"
    "       stokes matrix export SCENE.stokes MATERIAL -o OUT [--bands FIRST,LAST,STEP]\n"
    "       stokes matrix show FILE [--pixel X,Y]\n"
    "       stokes matrix list\n"
    "\n"
    "A reradiation matrix says of the energy that arrives in each band of wavelengths which share leaves in\n"
    "each. FILE is CSV (a line of incident wavelengths, then a line for each outgoing one), the matrix text "
    "of\n"
    "the BFC-450, a bispectral OpenEXR, or a name that `list` prints. OUT is CSV, or OpenEXR by its ending\n"
    ".exr. What is done about noise below zero and about missing bands is told in a line each.\n"
    "\n"
    "  import  a measurement: cleaned, and both sides on one grid\n"
    "  export  the matrix of a scene's material, lit at 45° and seen at 0°\n"
    "  show    what each incident band reflects and re-emits\n"
    "  list    the library's measured matrices, where they are from and their licence\n"
    "\n"
    "  -o, --output FILE\n"
    "  -p, --pixel X,Y              of a picture, from the top left; default: the mean of all\n"
    "  -b, --bands FIRST,LAST,STEP  centres in nm; default 300,830,10\n"
    "  -h, --help\n";

struct arguments {
    const char *out, *place[2];
    int places;
    bool has_pixel;
    int pixel[2];
    double bands[3];
};

static void print_note(void *user, const stokes_error *what)
{
    (void)user;
    fprintf(stderr, "stokes: %s: %s: %s\n", what->object, what->property, what->text);
}

/* Exactly `count` numbers with commas between. */
static bool read_list(const char *text, double *numbers, int count)
{
    for (int i = 0; i < count; i++) {
        char *end;
        numbers[i] = strtod(text, &end);
        if (end == text || *end != (i + 1 < count ? ',' : 0) || !isfinite(numbers[i]))
            return false;
        text = end + 1;
    }
    return true;
}

static bool read_option(int option, const char *argument, struct arguments *a)
{
    double pixel[2];
    switch (option) {
    case 'o': a->out = argument; return true;
    case 'b':
        return read_list(argument, a->bands, 3) && a->bands[0] > 0 && a->bands[1] > a->bands[0] &&
               a->bands[2] > 0 && (a->bands[1] - a->bands[0]) / a->bands[2] < 1e6;
    case 'p':
        a->has_pixel = read_list(argument, pixel, 2) && fabs(pixel[0]) < 1e9 && fabs(pixel[1]) < 1e9;
        if (a->has_pixel) {
            a->pixel[0] = (int)pixel[0];
            a->pixel[1] = (int)pixel[1];
        }
        return a->has_pixel;
    default: return false;
    }
}

static bool read_arguments(int argc, char **argv, struct arguments *a)
{
    static const struct option options[] = {{"output", required_argument, NULL, 'o'},
                                            {"pixel", required_argument, NULL, 'p'},
                                            {"bands", required_argument, NULL, 'b'},
                                            {0}};
    int option;
    *a = (struct arguments){.bands = {300, 830, 10}};
    while ((option = getopt_long(argc, argv, "o:p:b:", options, NULL)) != -1) {
        if (option == '?')
            cli_usage("matrix", "'%s' is no option, or lacks its argument", argv[optind - 1]);
        else if (!read_option(option, optarg, a))
            cli_usage("matrix", "'%s' is not what -%c takes", optarg, option);
        else
            continue;
        return false;
    }
    for (; optind < argc && a->places < 2; optind++)
        a->place[a->places++] = argv[optind];
    return true;
}

static int finish(stokes_matrix *m, const char *out, stokes_error *err)
{
    bool good = m && stokes_matrix_write(m, out, err);
    stokes_matrix_destroy(m);
    return good ? 0 : cli_fail(err);
}

static int import(const struct arguments *a)
{
    stokes_error err;
    return finish(stokes_matrix_read(a->place[0], a->has_pixel ? a->pixel : NULL, print_note, NULL, &err),
                  a->out, &err);
}

/* What a photometer sees of a mirror. */
static void tell_dark(const stokes_matrix *m, const char *material)
{
    double most = 0;
    for (int i = 0; m && i < m->count_in * m->count_out; i++)
        most = fmax(most, (double)m->share[i]);
    if (m && most <= 0)
        fprintf(stderr,
                "stokes: %s: matrix: nothing leaves at 0° of what arrives at 45°, as of black, mirrors and "
                "glass\n",
                material);
}

static int export(const struct arguments *a)
{
    const stokes_listener listener = {.warning = print_note};
    stokes_session *session = stokes_session_create(&listener);
    stokes_error err = {.object = "stokes", .text = "out of memory"};
    stokes_matrix *m = NULL;
    if (session && stokes_session_load(session, a->place[0], &err))
        m = stokes_session_matrix(session, a->place[1], a->bands[0],
                                  (int)((a->bands[1] - a->bands[0]) / a->bands[2] + 1e-6) + 1, a->bands[2],
                                  &err);
    tell_dark(m, a->place[1]);
    int status = finish(m, a->out, &err);
    stokes_session_destroy(session);
    return status;
}

/* A line an incident band; photons are counted as share × λo/λi. */
static void print_band(const stokes_matrix *m, int in)
{
    double incident = m->first_in_nm + in * m->step_nm, diagonal = NAN, energy = 0, photons = 0, most = 0,
           peak = NAN;
    for (int out = 0; out < m->count_out; out++) {
        double share = m->share[out * m->count_in + in], outgoing = m->first_out_nm + out * m->step_nm;
        if (fabs(outgoing - incident) < 0.5 * m->step_nm) {
            diagonal = share;
            continue;
        }
        energy += share;
        photons += share * outgoing / incident;
        if (share > most) {
            most = share;
            peak = outgoing;
        }
    }
    printf("%8g", incident);
    if (isnan(diagonal))
        printf("%10s", "-");
    else
        printf("%10.4f", diagonal);
    printf("%12.4f%10.4f", energy, photons);
    if (isnan(peak))
        printf("%10s\n", "-");
    else
        printf("%10g\n", peak);
}

static int show(const struct arguments *a)
{
    stokes_error err;
    stokes_matrix *m =
        stokes_matrix_read(a->place[0], a->has_pixel ? a->pixel : NULL, print_note, NULL, &err);
    if (!m)
        return cli_fail(&err);
    printf("bands of %g nm: incident %g to %g, outgoing %g to %g\n", m->step_nm, m->first_in_nm,
           m->first_in_nm + (m->count_in - 1) * m->step_nm, m->first_out_nm,
           m->first_out_nm + (m->count_out - 1) * m->step_nm);
    printf("%8s%10s%12s%10s%10s\n", "incident", "diagonal", "re-emitted", "photons", "peak");
    for (int in = 0; in < m->count_in; in++)
        print_band(m, in);
    stokes_matrix_destroy(m);
    return 0;
}

static int list(const struct arguments *a)
{
    const char *name;
    stokes_library_notes notes;
    (void)a;
    for (size_t i = 0; (name = stokes_matrix_name(i)); i++)
        if (stokes_library_about(name, &notes))
            printf("%s  %g–%g nm  %s (%s)\n", name, notes.first_nm, notes.last_nm, notes.source,
                   notes.licence);
    return 0;
}

static const struct verb {
    const char *name, *wants;
    int (*run)(const struct arguments *);
    int places;
    bool writes;
} verbs[] = {
    {"import", "FILE and an output (-o)", import, 1, true},
    {"export", "SCENE.stokes, MATERIAL and an output (-o)", export, 2, true},
    {"show", "FILE", show, 1, false},
    {"list", "nothing", list, 0, false},
};

int cli_matrix(int argc, char **argv)
{
    const char *what = argc > 1 ? argv[1] : "";
    struct arguments a;
    if (strcmp(what, "--help") == 0 || strcmp(what, "-h") == 0) {
        fputs(help, stdout);
        return 0;
    }
    for (size_t i = 0; i < sizeof verbs / sizeof *verbs; i++) {
        if (strcmp(what, verbs[i].name) != 0)
            continue;
        if (!read_arguments(argc - 1, argv + 1, &a))
            return CLI_USAGE;
        if (a.places != verbs[i].places || (a.out != NULL) != verbs[i].writes)
            return cli_usage("matrix", "%s is wanted", verbs[i].wants);
        return verbs[i].run(&a);
    }
    return cli_usage("matrix", "import, export, show or list is wanted");
}
