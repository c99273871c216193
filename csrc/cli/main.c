/* The entry: takes the program that was compiled for the widest vectors that this processor has (Makefile, WIDTHS). */
#include <stdlib.h>
#include <string.h>

#include "cli.h"

#ifdef WIDTH_avx2
int program_avx2(const struct width *widths, const struct width *own, int argc, char **argv);
#define HAS_AVX2                                                                                             \
    (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2"))
#endif

int main(int argc, char **argv)
{
    const struct width widths[] = {
        {"baseline", true, program},
#ifdef WIDTH_avx2
        {"avx2", HAS_AVX2, program_avx2},
#endif
        {0},
    };
    const char *wanted = getenv("STOKES_VECTORS");
    const struct width *own = NULL;
    for (const struct width *w = widths; w->name; w++)
        if (w->usable && (!wanted || !*wanted || strcmp(wanted, w->name) == 0))
            own = w;
    if (own)
        return own->program(widths, own, argc, argv);
    fprintf(stderr, "stokes: STOKES_VECTORS: '%s' is not on this machine; see `stokes --help`\n", wanted);
    return CLI_USAGE;
}
