/* `stokes merge` and `stokes info`: what is done with files that are there. */
#include <getopt.h>
#include <stdio.h>
#include <string.h>

#include "cli.h"

static const char merge_help[] = "Usage: stokes merge PART.exr… -o OUT.exr\n"
                                 "\n"
                                 "Merges EXRs of one scene whose sample ranges touch without overlapping. "
                                 "The result has the bits of one render of\n"
                                 "the whole range, whatever the order of the parts.\n"
                                 "\n"
                                 "  -o, --output FILE\n"
                                 "  -h, --help\n";

static const char info_help[] = "Usage: stokes info FILE…\n"
                                "\n"
                                "Prints a line for each message of a scene file, or what an EXR of Stokes "
                                "holds: its size, its samples, its\n"
                                "spectral bins, and how it was made.\n";

int cli_merge(int argc, char **argv)
{
    static const struct option options[] = {
        {"output", required_argument, NULL, 'o'}, {"help", no_argument, NULL, 'h'}, {0}};
    const char *out = NULL;
    stokes_error err;
    int option;
    while ((option = getopt_long(argc, argv, "o:h", options, NULL)) != -1) {
        if (option == 'h') {
            fputs(merge_help, stdout);
            return 0;
        }
        if (option != 'o')
            return cli_usage("merge", "'%s' is no option, or lacks its argument", argv[optind - 1]);
        out = optarg;
    }
    if (!out || optind == argc)
        return cli_usage("merge", "%s", out ? "parts are wanted" : "an output is wanted (-o)");
    return stokes_merge((const char *const *)argv + optind, (size_t)(argc - optind), out, &err)
               ? 0
               : cli_fail(&err);
}

int cli_info(int argc, char **argv)
{
    stokes_error err;
    if (argc < 2)
        return cli_usage("info", "a file is wanted");
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
        fputs(info_help, stdout);
        return 0;
    }
    for (int i = 1; i < argc; i++) {
        if (argc > 2)
            printf("%s%s:\n", i > 1 ? "\n" : "", argv[i]);
        if (!stokes_info(argv[i], &err)) {
            fflush(stdout);
            return cli_fail(&err);
        }
    }
    return 0;
}
