/* Text files that the outside names. */
#include <errno.h>
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
    if (!why) {
        text[bytes] = 0;
        why = strlen(text) < bytes ? "is no text" : NULL;
    }
    if (why) {
        fail(err, path, "open", "%s", why);
        free(text);
        return NULL;
    }
    return text;
}
