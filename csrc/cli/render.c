/* `stokes render`: a scene file to an EXR or PNG. */
#include <getopt.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"

#define OUTPUTS_MAX 8

static const char help[] =
    "Usage: stokes render SCENE -o OUT [OPTION…]\n"
    "\n"
    "Renders a scene file (.stokes). What is not given comes from the scene.\n"
    "\n"
    "  -o, --output FILE        .exr: linear RGBA, spectral bins, and all that `stokes merge` needs;\n"
    "                           .png: as the scene's display and view show it. May be given more than once\n"
    "      --spp N              samples of each pixel\n"
    "  -s, --samples A:B        only the samples [A, B) of each pixel (A counts from 0)\n"
    "  -i, --integrator NAME    pt, pt_nee, lt, mbdpt or bdpt\n"
    "      --techniques LIST    only these light and camera vertex counts, as \"2,2 3,1\"; \"\" is all\n"
    "      --max-path N         edges of the longest path\n"
    "      --lanes N            wavelengths that each path carries: 1, 4 or 8\n"
    "      --shared-wavelength  mbdpt without its kernel, both sub-paths at one wavelength: a study, for scenes\n"
    "                           without fluorescence\n"
    "      --connectable-only   without the paths that no connection can make, such as a lamp seen through two\n"
    "                           pieces of glass; the report says how much light they bring\n"
    "      --d0 NM              half-width of the first sample's spectral kernel\n"
    "      --shrink S           its exponent: the n-th sample has d0 n^-S\n"
    "      --light-paths N      light sub-paths of a sample, on average, up to 64; 0: as many as pay in this\n"
    "                           scene (bdpt), or 1. The camera sees all; one at most is connected to its own\n"
    "      --spectral-bins N[:A:B]  spectral bins in the EXR, over A to B nm (default: the visible part of "
    "the\n"
    "                           scene's range); 0: none\n"
    "      --kernel NAME        constant, incident_reflectance, incident, box or asymmetric\n"
    "      --seed N             another set of random numbers\n"
    "  -t, --threads N          0: all processors\n"
    "      --time-limit S       start no pass that would end later than so many seconds\n"
    "      --snapshots          also OUT-00001, OUT-00002, OUT-00004 …: after so many samples of each "
    "pixel,\n"
    "                           with the bits that a render of so many gives\n"
    "  -q, --quiet              no progress, no report\n"
    "  -h, --help\n"
    "\n"
    "Ctrl-C ends the render; whole passes are written, or what there is of the first (alpha 0 elsewhere).\n"
    "Images depend on scene, seed and samples alone, not on threads: parts of the sample range, rendered\n"
    "anywhere, merge to the bits of the whole.\n"
    "Exit status: 0 done, 1 an error (one line on stderr), 2 wrong usage, 130 cancelled (and written).\n";

struct job {
    const char *scene, *output[OUTPUTS_MAX];
    size_t outputs;
    stokes_overrides overrides;
    bool snapshots, quiet, shows_help;
};

static atomic_bool interrupted; /* a signal handler has nothing else to write to */

static void on_interrupt(int signal_number)
{
    (void)signal_number;
    if (atomic_exchange(&interrupted, true))
        _exit(CLI_CANCELLED); /* asked twice: now */
}

static bool on_cancelled(void *user)
{
    (void)user;
    return interrupted;
}

static void on_warning(void *user, const stokes_error *what)
{
    (void)user;
    fprintf(stderr, "%sstokes: warning: %s%s%s: %s\n", isatty(STDERR_FILENO) ? "\r\033[K" : "", what->object,
            *what->property ? ": " : "", what->property, what->text);
}

static void print_duration(double seconds)
{
    long whole = (long)(seconds + 0.5);
    if (whole >= 3600)
        fprintf(stderr, "%ld h %02ld min", whole / 3600, whole / 60 % 60);
    else if (whole >= 60)
        fprintf(stderr, "%ld min %02ld s", whole / 60, whole % 60);
    else
        fprintf(stderr, "%ld s", whole);
}

static void on_progress(void *user, int sample, int samples, double seconds, double remaining)
{
    (void)user;
    bool terminal = isatty(STDERR_FILENO);
    static const char start[] = "\r\033[K";
    if (!terminal && sample < samples && seconds > 0)
        return; /* a log wants no animation */
    fprintf(stderr, "%ssample %d of %d, ", terminal ? start : "", sample, samples);
    print_duration(seconds);
    if (remaining >= 0 && sample < samples) {
        fputs(", ", stderr);
        print_duration(remaining);
        fputs(" left", stderr);
    }
    if (!terminal || sample == samples)
        fputc('\n', stderr);
}

/* --- Options ----------------------------------------------------------------------------------------------- */

enum {
    OPTION_TECHNIQUES = 256,
    OPTION_MAX_PATH,
    OPTION_D0,
    OPTION_SHRINK,
    OPTION_LIGHT_PATHS,
    OPTION_BINS,
    OPTION_CONNECTABLE_ONLY,
    OPTION_SHARED_WAVELENGTH,
    OPTION_KERNEL,
    OPTION_LANES,
    OPTION_SEED,
    OPTION_TIME_LIMIT,
    OPTION_SNAPSHOTS
};

static const struct option options[] = {
    {"output", required_argument, NULL, 'o'},
    {"samples", required_argument, NULL, 's'},
    {"integrator", required_argument, NULL, 'i'},
    {"techniques", required_argument, NULL, OPTION_TECHNIQUES},
    {"max-path", required_argument, NULL, OPTION_MAX_PATH},
    {"shared-wavelength", no_argument, NULL, OPTION_SHARED_WAVELENGTH},
    {"connectable-only", no_argument, NULL, OPTION_CONNECTABLE_ONLY},
    {"kernel", required_argument, NULL, OPTION_KERNEL},
    {"lanes", required_argument, NULL, OPTION_LANES},
    {"d0", required_argument, NULL, OPTION_D0},
    {"shrink", required_argument, NULL, OPTION_SHRINK},
    {"light-paths", required_argument, NULL, OPTION_LIGHT_PATHS},
    {"spp", required_argument, NULL, 's'},
    {"spectral-bins", required_argument, NULL, OPTION_BINS},
    {"seed", required_argument, NULL, OPTION_SEED},
    {"threads", required_argument, NULL, 't'},
    {"time-limit", required_argument, NULL, OPTION_TIME_LIMIT},
    {"snapshots", no_argument, NULL, OPTION_SNAPSHOTS},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {0},
};

static bool read_range(const char *text, double high, double *first, double *end)
{
    char start[64];
    const char *colon = strchr(text, ':');
    if (!colon || (size_t)(colon - text) >= sizeof start)
        return false;
    memcpy(start, text, (size_t)(colon - text));
    start[colon - text] = '\0';
    return cli_number(start, 0, high, first) && cli_number(colon + 1, *first, high, end) && *first < *end;
}

static bool read_samples(const char *text, stokes_overrides *o)
{
    double first = 0, end = 0;
    if (!read_range(text, 1 << 30, &first, &end) && !cli_number(text, 1, 1 << 30, &end))
        return false;
    o->first_sample = (int)first;
    o->end_sample = (int)end;
    return first == o->first_sample && end == o->end_sample;
}

static bool read_int(const char *text, int *value)
{
    int64_t whole;
    if (!cli_whole(text, 0, 1 << 30, &whole))
        return false;
    *value = (int)whole;
    return true;
}

/* N, or N:A:B. */
static bool read_bins(const char *text, stokes_overrides *o)
{
    const char *colon = strchr(text, ':');
    char count[16] = "";
    if (!colon)
        return read_int(text, &o->spectral_bins);
    if ((size_t)(colon - text) >= sizeof count)
        return false;
    memcpy(count, text, (size_t)(colon - text));
    return read_int(count, &o->spectral_bins) && read_range(colon + 1, 1e6, &o->bins_min_nm, &o->bins_max_nm);
}

/* False if the argument is not what the option takes. */
static bool read_option(int option, struct job *job)
{
    stokes_overrides *o = &job->overrides;
    switch (option) {
    case 'o':
        if (job->outputs == OUTPUTS_MAX)
            return false;
        job->output[job->outputs++] = optarg;
        return true;
    case 's': return read_samples(optarg, o);
    case 'i': o->integrator = optarg; return true;
    case 't': return read_int(optarg, &o->threads);
    case 'q': job->quiet = true; return true;
    case 'h': job->shows_help = true; return true;
    case OPTION_TECHNIQUES: o->techniques = optarg; return true;
    case OPTION_MAX_PATH: return read_int(optarg, &o->max_path);
    case OPTION_SHARED_WAVELENGTH: o->shared_wavelength = true; return true;
    case OPTION_CONNECTABLE_ONLY: o->connectable_only = true; return true;
    case OPTION_KERNEL: o->kernel = optarg; return true;
    case OPTION_LANES: return read_int(optarg, &o->lanes);
    case OPTION_D0: return cli_number(optarg, 0, 1e6, &o->d0_nm);
    case OPTION_SHRINK: return cli_number(optarg, 0, 1, &o->shrink);
    case OPTION_LIGHT_PATHS: return cli_number(optarg, 0, 64, &o->light_paths);
    case OPTION_BINS: return read_bins(optarg, o);
    case OPTION_SEED: return cli_whole(optarg, 0, UINT32_MAX, &o->seed);
    case OPTION_SNAPSHOTS: job->snapshots = true; return true;
    case OPTION_TIME_LIMIT: return cli_number(optarg, 0, 1e9, &o->time_limit_s);
    }
    return false;
}

static bool is_picture(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot && (strcmp(dot, ".exr") == 0 || strcmp(dot, ".png") == 0);
}

/* 0, or the exit status of wrong usage. */
static int read_options(int argc, char **argv, struct job *job)
{
    int option, index = -1;
    *job = (struct job){.overrides = stokes_overrides_default()};
    while ((option = getopt_long(argc, argv, "o:s:i:t:qh", options, &index)) != -1) {
        if (option == '?')
            return cli_usage("render", "'%s' is no option, or lacks its argument", argv[optind - 1]);
        if (!read_option(option, job))
            return cli_usage("render", "'%s' is not what %s takes", optarg,
                             argv[optind - (optarg == argv[optind - 1] ? 2 : 1)]);
    }
    if (job->shows_help)
        return 0;
    if (optind + 1 != argc)
        return cli_usage("render", "%s",
                         optind == argc ? "a scene file is wanted" : "one scene file is wanted");
    job->scene = argv[optind];
    if (job->outputs == 0)
        return cli_usage("render", "an output is wanted (-o)");
    for (size_t i = 0; i < job->outputs; i++)
        if (!is_picture(job->output[i]))
            return cli_usage("render", "'%s' ends neither in .exr nor in .png", job->output[i]);
    return 0;
}

/* --- The job ----------------------------------------------------------------------------------------------- */

/* out.exr → out-00004.exr */
static bool write_snapshot(stokes_session *session, const char *output, int samples, stokes_error *err)
{
    const char *dot = strrchr(output, '.');
    char *path;
    if (asprintf(&path, "%.*s-%05d%s", (int)(dot - output), output, samples, dot) < 0) {
        snprintf(err->text, sizeof err->text, "out of memory");
        return false;
    }
    bool good = stokes_session_write(session, path, err);
    free(path);
    return good;
}

static bool on_snapshot(void *user, stokes_session *session, int samples, stokes_error *err)
{
    const struct job *job = user;
    for (size_t i = 0; i < job->outputs; i++)
        if (!write_snapshot(session, job->output[i], samples, err))
            return false;
    return true;
}

static bool run(stokes_session *session, const struct job *job, stokes_error *err)
{
    if (!stokes_session_load(session, job->scene, err) ||
        !stokes_session_render(session, &job->overrides, NULL, 0, err))
        return false;
    if (interrupted && stokes_session_samples(session) == 0 && !stokes_session_is_part(session)) {
        fputs("stokes: render: cancelled before the first sample: nothing is written\n", stderr);
        return true;
    }
    for (size_t i = 0; i < job->outputs; i++)
        if (!stokes_session_write(session, job->output[i], err))
            return false;
    return true;
}

int cli_render(int argc, char **argv)
{
    struct job job;
    stokes_error err = {.text = "out of memory"};
    int status = read_options(argc, argv, &job);
    if (status)
        return status;
    if (job.shows_help) {
        fputs(help, stdout);
        return 0;
    }
    const stokes_listener listener = {.user = &job,
                                      .warning = on_warning,
                                      .progress = job.quiet ? NULL : on_progress,
                                      .cancelled = on_cancelled,
                                      .snapshot = job.snapshots ? on_snapshot : NULL};
    struct sigaction action = {.sa_handler = on_interrupt};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    stokes_session *session = stokes_session_create(&listener);
    bool good = session && run(session, &job, &err);
    if (!good)
        cli_fail(&err);
    else if (!job.quiet)
        fputs(stokes_session_report(session), stderr);
    stokes_session_destroy(session);
    return !good ? CLI_FAILED : interrupted ? CLI_CANCELLED : 0;
}
