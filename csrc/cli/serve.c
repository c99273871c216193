/* `stokes serve`: the core as a child of the add-on. */
#include <getopt.h>
#include <stdio.h>
#include <unistd.h>

#include "cli.h"

static const char help[] =
    "Usage: stokes serve [--memory FD] [--film FD]\n"
    "\n"
    "Speaks the Stokes stream (csrc/stream/STREAM.md): frames of the parent on stdin, replies on stdout. "
    "Ends with `quit`, or\n"
    "when stdin or the parent ends.\n"
    "\n"
    "      --memory FD   shared memory (a memfd that may be sealed) that `shared` blobs lie in\n"
    "      --film FD     another that receives the picture\n"
    "  -h, --help\n";

int cli_serve(int argc, char **argv)
{
    static const struct option options[] = {{"memory", required_argument, NULL, 'm'},
                                            {"film", required_argument, NULL, 'f'},
                                            {"help", no_argument, NULL, 'h'},
                                            {0}};
    int64_t memory = -1, film = -1;
    int option;
    while ((option = getopt_long(argc, argv, "h", options, NULL)) != -1) {
        if (option == 'h') {
            fputs(help, stdout);
            return 0;
        }
        if (option == '?')
            return cli_usage("serve", "'%s' is no option, or lacks its argument", argv[optind - 1]);
        if (!cli_whole(optarg, 3, 1 << 20, option == 'm' ? &memory : &film))
            return cli_usage("serve", "'%s' is no file descriptor", optarg);
    }
    if (optind != argc)
        return cli_usage("serve", "'%s' is too much", argv[optind]);
    return stokes_serve(STDIN_FILENO, STDOUT_FILENO, (int)memory, (int)film);
}
