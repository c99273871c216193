/* Filling a stokes_error. Names come from outside, so what goes in is made one line of valid UTF-8: a cut inside a
   character would make the reply to the parent unwritable as JSON. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"

/* Drops a character that the buffer's end has cut in two. */
static void trim_utf8(char *text)
{
    size_t end = strlen(text), start = end;
    while (start > 0 && ((unsigned char)text[start - 1] & 0xc0) == 0x80)
        start--;
    if (start == 0)
        return;
    unsigned char lead = (unsigned char)text[start - 1];
    size_t wants = lead >= 0xf0 ? 3 : lead >= 0xe0 ? 2 : lead >= 0xc0 ? 1 : 0;
    if (end - start < wants)
        text[start - 1] = '\0';
}

static void one_line(char *text)
{
    for (char *c = text; *c; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7f)
            *c = ' ';
    trim_utf8(text);
}

bool fail(stokes_error *err, const char *object, const char *property, const char *format, ...)
{
    if (!err)
        return false;
    /* The arguments may point into *err itself, when a caller adds to what it was told. */
    stokes_error filled;
    snprintf(filled.object, sizeof filled.object, "%s", object ? object : "");
    snprintf(filled.property, sizeof filled.property, "%s", property ? property : "");
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(filled.text, sizeof filled.text, format, arguments);
    va_end(arguments);
    one_line(filled.object);
    one_line(filled.property);
    one_line(filled.text);
    *err = filled;
    return false;
}
