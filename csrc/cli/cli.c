/* What the sub-commands share: errors in one line, and numbers. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "cli.h"

int cli_fail(const stokes_error *err)
{
    fputs("stokes: ", stderr);
    if (*err->object)
        fprintf(stderr, "%s: ", err->object);
    if (*err->property)
        fprintf(stderr, "%s: ", err->property);
    fprintf(stderr, "%s\n", err->text);
    return CLI_FAILED;
}

int cli_usage(const char *command, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "stokes: %s: ", command);
    vfprintf(stderr, format, arguments);
    fprintf(stderr, "; see `stokes %s --help`\n", command);
    va_end(arguments);
    return CLI_USAGE;
}

bool cli_number(const char *text, double low, double high, double *value)
{
    char *end;
    *value = strtod(text, &end);
    return end != text && !*end && *value >= low && *value <= high;
}

bool cli_whole(const char *text, double low, double high, int64_t *value)
{
    double number;
    if (!cli_number(text, low, high, &number) || number != floor(number))
        return false;
    *value = (int64_t)number;
    return true;
}
