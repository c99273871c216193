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
    fclose(file);
    if (picture)
        return bispectral_read(path, pixel, note, user, err);
    char *text = session_read_text(path, err);
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
