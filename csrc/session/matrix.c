/* Reradiation matrices for those outside: files of any kind, and materials of a scene. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/error.h"
#include "material/bispectral.h"
#include "material/photometer.h"
#include "session/session.h"
#include "spectrum/library/library.h"

/* A matrix of 640 × 640 bands as text is a tenth of this. */
#define TEXT_MAX ((size_t)64 << 20)

static char *read_text(FILE *file, const char *path, stokes_error *err)
{
    size_t bytes = 0, room = 1 << 16;
    char *text = malloc(room);
    while (text && bytes < TEXT_MAX) {
        size_t got = fread(text + bytes, 1, room - 1 - bytes, file);
        bytes += got;
        if (bytes < room - 1)
            break;
        char *more = realloc(text, room *= 2);
        if (!more)
            free(text);
        text = more;
    }
    if (!text || bytes >= TEXT_MAX || ferror(file)) {
        fail(err, path, "open", "%s",
             !text          ? "out of memory"
             : ferror(file) ? strerror(errno)
                            : "is too long");
        free(text);
        return NULL;
    }
    text[bytes] = 0;
    if (strlen(text) < bytes) {
        fail(err, path, "open", "is neither text nor an OpenEXR");
        free(text);
        return NULL;
    }
    return text;
}

stokes_matrix *stokes_matrix_read(const char *path, const int *pixel, reradiation_note note, void *user,
                                  stokes_error *err)
{
    static const unsigned char exr_magic[4] = {0x76, 0x2f, 0x31, 0x01};
    unsigned char magic[4] = {0};
    if (library_matrix_find(path))
        return reradiation_library(path, path, note, user, err);
    FILE *file = fopen(path, "rbe");
    if (!file) {
        fail(err, path, "open", "%s", strerror(errno));
        return NULL;
    }
    bool picture = fread(magic, 1, 4, file) == 4 && memcmp(magic, exr_magic, 4) == 0;
    rewind(file);
    char *text = picture ? NULL : read_text(file, path, err);
    fclose(file);
    if (picture)
        return bispectral_read(path, pixel, note, user, err);
    stokes_matrix *m = text ? reradiation_from_text(text, path, note, user, err) : NULL;
    free(text);
    return m;
}

stokes_matrix *stokes_session_matrix(stokes_session *session, const char *name, double first_nm, int count,
                                     double step_nm, stokes_error *err)
{
    if (!session_commit(session, &session->settings, err))
        return NULL;
    const struct material *material = scene_find_material(session->scene, name);
    if (!material) {
        fail(err, name, "material", "is not in the scene");
        return NULL;
    }
    return material_measure(material, name, first_nm, count, step_nm, err);
}

bool stokes_matrix_write(const stokes_matrix *m, const char *path, stokes_error *err)
{
    size_t length = strlen(path);
    bool picture = length > 4 && strcasecmp(path + length - 4, ".exr") == 0;
    return (picture ? bispectral_write : reradiation_write_csv)(m, path, err);
}

void stokes_matrix_destroy(stokes_matrix *m)
{
    reradiation_destroy(m);
}

const char *stokes_matrix_name(size_t index)
{
    const struct library_matrix *m = library_matrix_at(index);
    return m ? m->name : NULL;
}
