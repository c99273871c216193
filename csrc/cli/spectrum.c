/* `stokes spectrum`: what the library holds. */
#include <stdio.h>
#include <string.h>

#include "cli.h"

static const char help[] = "Usage: stokes spectrum list [PREFIX]\n"
                           "       stokes spectrum show NAME [FROM TO [STEP]]\n"
                           "\n"
                           "`list` prints the names of the library's spectra, as {\"library\": NAME} takes "
                           "them. `show` prints wavelength (nm) and\n"
                           "value, a line each, from 360 to 830 nm by 10 unless told otherwise.\n";

static int list(const char *prefix)
{
    const char *name;
    size_t printed = 0;
    for (size_t i = 0; (name = stokes_library_name(i)); i++)
        if (strncmp(name, prefix, strlen(prefix)) == 0) {
            puts(name);
            printed++;
        }
    if (printed == 0)
        return cli_usage("spectrum", "no name begins with '%s'", prefix);
    return 0;
}

static int show(int argc, char **argv)
{
    double from = 360, to = 830, step = 10, value;
    if ((argc != 1 && argc != 3 && argc != 4) ||
        (argc > 1 && (!cli_number(argv[1], 1, 1e6, &from) || !cli_number(argv[2], from, 1e6, &to))) ||
        (argc > 3 && !cli_number(argv[3], 1e-3, 1e6, &step)))
        return cli_usage("spectrum", "NAME, or NAME FROM TO, or NAME FROM TO STEP is wanted");
    for (int i = 0; from + i * step <= to; i++) {
        if (!stokes_library_value(argv[0], from + i * step, &value))
            return cli_usage("spectrum", "'%s' is not in the library", argv[0]);
        printf("%g %.6g\n", from + i * step, value);
    }
    return 0;
}

int cli_spectrum(int argc, char **argv)
{
    const char *what = argc > 1 ? argv[1] : "";
    if (strcmp(what, "--help") == 0 || strcmp(what, "-h") == 0) {
        fputs(help, stdout);
        return 0;
    }
    if (strcmp(what, "list") == 0 && argc <= 3)
        return list(argc > 2 ? argv[2] : "");
    if (strcmp(what, "show") == 0 && argc > 2)
        return show(argc - 2, argv + 2);
    return cli_usage("spectrum", "list or show is wanted");
}
