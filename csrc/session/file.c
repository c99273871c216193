/* Text files that the outside names. */
#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "session/session.h"

#define TEXT_MAX ((size_t)64 << 20)

static char *read_stream(FILE *file, size_t *bytes)
{
    size_t room = 1 << 16;
    char *text = malloc(room);
    for (*bytes = 0; text && *bytes < TEXT_MAX;) {
        *bytes += fread(text + *bytes, 1, room - 1 - *bytes, file);
        if (*bytes < room - 1)
            break;
        char *more = realloc(text, room *= 2);
        if (!more)
            free(text);
        text = more;
    }
    return text;
}

/* --- UTF-16 -------------------------------------------------------------------------------------------------- */

/* Spreadsheets write "Unicode text" so, behind its mark. */
static bool is_utf16(const unsigned char *bytes, size_t count, bool *big)
{
    *big = count >= 2 && bytes[0] == 0xfe && bytes[1] == 0xff;
    return *big || (count >= 2 && bytes[0] == 0xff && bytes[1] == 0xfe);
}

static char *put_utf8(char *out, uint32_t c)
{
    int more = c < 0x80 ? 0 : c < 0x800 ? 1 : c < 0x10000 ? 2 : 3;
    static const unsigned char lead[] = {0, 0xc0, 0xe0, 0xf0};
    *out++ = (char)(lead[more] | c >> 6 * more);
    while (more-- > 0)
        *out++ = (char)(0x80 | (c >> 6 * more & 0x3f));
    return out;
}

/* Ended by NUL; NULL without memory. *good is false where a pair is broken. */
static char *utf8_of_utf16(const unsigned char *bytes, size_t *count, bool big, bool *good)
{
    char *text = malloc(*count / 2 * 3 + 1), *out = text;
    uint32_t high = 0;
    *good = *count % 2 == 0;
    for (size_t i = 2; text && i + 1 < *count; i += 2) {
        uint32_t unit = big ? bytes[i] * 256u + bytes[i + 1] : bytes[i + 1] * 256u + bytes[i];
        bool low = unit >> 10 == 0x37;
        *good = *good && low == (high != 0);
        if (unit >> 10 == 0x36) {
            high = unit;
            continue;
        }
        out = put_utf8(out, low ? 0x10000 + ((high & 0x3ff) << 10) + (unit & 0x3ff) : unit);
        high = 0;
    }
    *good = *good && high == 0;
    if (text)
        *out = 0;
    *count = text ? (size_t)(out - text) : 0;
    return text;
}

/* --- Files --------------------------------------------------------------------------------------------------- */

/* The text in UTF-8, or why there is none. */
static const char *settle_encoding(char **text, size_t bytes)
{
    bool big, good = true;
    if (is_utf16((unsigned char *)*text, bytes, &big)) {
        char *settled = utf8_of_utf16((unsigned char *)*text, &bytes, big, &good);
        free(*text);
        *text = settled;
        if (!settled || !good)
            return settled ? "is broken UTF-16" : "out of memory";
    }
    (*text)[bytes] = 0;
    return strlen(*text) < bytes ? "is no text, or UTF-16 without its mark" : NULL;
}

char *session_read_text(const char *path, stokes_error *err)
{
    FILE *file = fopen(path, "rbe");
    size_t bytes = 0;
    if (!file) {
        fail(err, path, "open", "%s", strerror(errno));
        return NULL;
    }
    char *text = read_stream(file, &bytes);
    const char *why = !text               ? "out of memory"
                      : ferror(file)      ? strerror(errno)
                      : bytes >= TEXT_MAX ? "is too long"
                                          : NULL;
    fclose(file);
    if (!why)
        why = settle_encoding(&text, bytes);
    if (why) {
        fail(err, path, "open", "%s", why);
        free(text);
        return NULL;
    }
    return text;
}
