/* Filling a stokes_error. Names come from outside, so what goes in is made one line of valid UTF-8: a cut inside a
   character would make the reply to the parent unwritable as JSON. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"

/* Bytes of the UTF-8 character at `c`: 0 if it is none, −1 if the text ends within it. */
static int utf8_length(const unsigned char *c)
{
    int length = *c < 0x80                 ? 1
                 : *c >= 0xc2 && *c < 0xe0 ? 2
                 : (*c & 0xf0) == 0xe0     ? 3
                 : *c >= 0xf0 && *c < 0xf5 ? 4
                                           : 0;
    for (int i = 1; i < length; i++)
        if ((c[i] & 0xc0) != 0x80)
            return c[i] ? 0 : -1;
    bool overlong = (*c == 0xe0 && c[1] < 0xa0) || (*c == 0xf0 && c[1] < 0x90);
    bool surrogate = *c == 0xed && c[1] >= 0xa0, beyond = *c == 0xf4 && c[1] >= 0x90;
    return length > 2 && (overlong || surrogate || beyond) ? 0 : length;
}

/* Control characters become spaces, what is no UTF-8 question marks; a character that the buffer's end has cut goes. */
static void one_line(char *text)
{
    for (unsigned char *c = (unsigned char *)text; *c;) {
        int length = utf8_length(c);
        if (length < 0) {
            *c = '\0';
            return;
        }
        if (length == 0)
            *c = '?';
        else if (*c < 0x20 || *c == 0x7f)
            *c = ' ';
        c += length > 0 ? length : 1;
    }
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
