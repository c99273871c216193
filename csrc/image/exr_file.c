/* An open OpenEXR file. Reading and writing go through stdio, so that an error is known where it happens. */
#include "image/exr_file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"

static void remember_why(exr_const_context_t context, exr_result_t code, const char *message)
{
    void *user = NULL;
    (void)code;
    if (exr_get_user_data(context, &user) == EXR_ERR_SUCCESS && user) {
        struct exr_file *file = user;
        snprintf(file->why, sizeof file->why, "%s", message);
    }
}

exr_context_initializer_t exr_file_initializer(struct exr_file *file)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = remember_why;
    init.user_data = file;
    return init;
}

bool exr_file_fail(struct exr_file *file, const char *property, stokes_error *err)
{
    if (file->error)
        return fail(err, file->path, property, "%s", strerror(file->error));
    return fail(err, file->path, property, "%s", file->why[0] ? file->why : "OpenEXR gives no reason");
}

struct exr_file *exr_file_create(const char *path, const char *mode)
{
    struct exr_file *file = calloc(1, sizeof *file);
    if (!file)
        return NULL;
    file->path = strdup(path);
    file->stream = file->path ? fopen(path, mode) : NULL;
    file->error = file->stream ? 0 : errno;
    return file;
}

void exr_close(struct exr_file *file)
{
    if (!file)
        return;
    if (file->context)
        exr_finish(&file->context);
    if (file->stream)
        fclose(file->stream);
    free(file->path);
    free(file);
}

size_t exr_channel_index(const struct exr_channel *channels, size_t count, const char *name, size_t *last)
{
    for (size_t i = 0; i < count; i++) {
        size_t at = (*last + 1 + i) % count;
        if (strcmp(channels[at].name, name) == 0)
            return *last = at;
    }
    return count;
}
