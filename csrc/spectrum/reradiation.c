/* Reradiation matrices as such. */
#include "spectrum/reradiation.h"

#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "spectrum/library/library.h"
#include "spectrum/measured.h"

#define LAMBDA_MAX_NM 1e5
/* Bands of the two sides that are apart by less than this share of a step are the same. */
#define SAME_BAND 1e-3

static bool check_bands(double first_in, int count_in, double first_out, int count_out, double step,
                        const char *name, stokes_error *err)
{
    if (!(step >= RERADIATION_STEP_MIN_NM && step <= LAMBDA_MAX_NM))
        return fail(err, name, "bands", "are %g nm apart; at least %g are wanted", step,
                    RERADIATION_STEP_MIN_NM);
    if (count_in < 1 || count_in > RERADIATION_BANDS_MAX || count_out < 1 ||
        count_out > RERADIATION_BANDS_MAX)
        return fail(err, name, "bands", "are %d incident and %d outgoing; 1 to %d are taken", count_in,
                    count_out, RERADIATION_BANDS_MAX);
    if (!(first_in > 0 && first_in <= LAMBDA_MAX_NM && first_out > 0 && first_out <= LAMBDA_MAX_NM))
        return fail(err, name, "bands", "begin at %g and %g nm", first_in, first_out);
    double shift = (first_in - first_out) / step;
    return fabs(shift - round(shift)) < SAME_BAND ||
           fail(err, name, "bands", "of %g nm that begin at %g and %g nm do not lie on one grid", step,
                first_in, first_out);
}

stokes_matrix *reradiation_create(double first_in, int count_in, double first_out, int count_out, double step,
                                  const char *name, stokes_error *err)
{
    if (!check_bands(first_in, count_in, first_out, count_out, step, name, err))
        return NULL;
    stokes_matrix *m = calloc(1, sizeof *m);
    if (m)
        *m = (stokes_matrix){step,      first_in,
                             first_out, count_in,
                             count_out, calloc((size_t)count_in * (size_t)count_out, sizeof *m->share)};
    if (!m || !m->share) {
        reradiation_destroy(m);
        fail(err, name, "bands", "out of memory");
        return NULL;
    }
    return m;
}

void reradiation_destroy(stokes_matrix *m)
{
    if (!m)
        return;
    free(m->share);
    free(m);
}

stokes_matrix *reradiation_copy(const stokes_matrix *m)
{
    stokes_matrix *copy = reradiation_create(m->first_in_nm, m->count_in, m->first_out_nm, m->count_out,
                                             m->step_nm, "copy", NULL);
    if (copy)
        memcpy(copy->share, m->share, (size_t)m->count_in * (size_t)m->count_out * sizeof *m->share);
    return copy;
}

bool reradiation_check(const stokes_matrix *m, const char *name, stokes_error *err)
{
    for (int out = 0; out < m->count_out; out++)
        for (int in = 0; in < m->count_in; in++) {
            float share = m->share[out * m->count_in + in];
            if (!(share >= 0 && isfinite(share)))
                return fail(err, name, "share", "is %g from %g to %g nm; it must not be negative",
                            (double)share, m->first_in_nm + in * m->step_nm,
                            m->first_out_nm + out * m->step_nm);
        }
    return true;
}

stokes_matrix *reradiation_library(const char *entry, const char *name, reradiation_note note, void *user,
                                   stokes_error *err)
{
    const struct library_matrix *found = library_matrix_find(entry);
    if (!found) {
        fail(err, name, "library", "there is no matrix named %.64s", entry);
        return NULL;
    }
    struct measured *raw = measured_create(found->count_in, found->count_out, name, err);
    if (!raw)
        return NULL;
    for (int in = 0; in < raw->count_in; in++)
        raw->in[in] = found->first_in + in * found->step;
    for (int out = 0; out < raw->count_out; out++)
        raw->out[out] = found->first_out + out * found->step;
    for (int i = 0; i < raw->count_in * raw->count_out; i++)
        raw->share[i] = found->share[i];
    return measured_finish(raw, name, note, user, err);
}
