/* From a measurement to a reradiation matrix: missing bands, noise, grids. */
#include "spectrum/measured.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/error.h"
#include "spectrum/spectrum_text.h"

/* Of values and of their mean over three bands: what lies lower is noise, and what nowhere rises so high. */
#define NOISE_SUPPORT 1.0
#define NOISE_PEAK 4.0
/* Grids whose wavelengths are apart by less than this share of a step are even. */
#define EVEN 1e-3

struct measured *measured_create(int count_in, int count_out, const char *name, stokes_error *err)
{
    if (count_in < 2 || count_out < 2 || count_in > RERADIATION_BANDS_MAX ||
        count_out > RERADIATION_BANDS_MAX) {
        fail(err, name, "bands", "are %d incident and %d outgoing; 2 to %d are taken", count_in, count_out,
             RERADIATION_BANDS_MAX);
        return NULL;
    }
    struct measured *m = calloc(1, sizeof *m);
    if (m)
        *m = (struct measured){count_in, count_out, calloc((size_t)count_in, sizeof *m->in),
                               calloc((size_t)count_out, sizeof *m->out),
                               calloc((size_t)count_in * (size_t)count_out, sizeof *m->share)};
    if (!m || !m->in || !m->out || !m->share) {
        measured_destroy(m);
        fail(err, name, "bands", "out of memory");
        return NULL;
    }
    return m;
}

void measured_destroy(struct measured *m)
{
    if (!m)
        return;
    free(m->in);
    free(m->out);
    free(m->share);
    free(m);
}

/* --- Bands ------------------------------------------------------------------------------------------------- */

/* Band i lies between the midpoints to its neighbours; the outermost are as wide to both sides. */
static double band_low(const double *center, int i)
{
    return i > 0 ? 0.5 * (center[i - 1] + center[i]) : center[0] - 0.5 * (center[1] - center[0]);
}

static double band_high(const double *center, int count, int i)
{
    return i + 1 < count ? 0.5 * (center[i] + center[i + 1]) : center[i] + 0.5 * (center[i] - center[i - 1]);
}

/* Less than a millionth of a nanometre is rounding. */
static double overlap(double a0, double a1, double b0, double b1)
{
    double common = fmin(a1, b1) - fmax(a0, b0);
    return common > 1e-6 ? common : 0;
}

/* What is reflected from incident band `in` shows in outgoing band `out`. */
static bool is_diagonal(const struct measured *m, int out, int in)
{
    double low = band_low(m->in, in), high = band_high(m->in, m->count_in, in);
    return overlap(low, high, band_low(m->out, out), band_high(m->out, m->count_out, out)) >
           EVEN * (high - low);
}

static float *at(const struct measured *m, int out, int in)
{
    return &m->share[out * m->count_in + in];
}

static bool check_wavelengths(const double *center, int count, const char *which, const char *name,
                              stokes_error *err)
{
    if (center[count - 1] < TABLE_SHORTEST_NM)
        return fail(err, name, which, "wavelengths end at %g: they are wanted in nm, not in µm",
                    center[count - 1]);
    if (center[0] > MATRIX_FURTHEST_NM)
        return fail(err, name, which, "wavelengths begin at %g: they are wanted in nm, not in Å", center[0]);
    for (int i = 0; i < count; i++) {
        if (!(center[i] > 0 && isfinite(center[i])))
            return fail(err, name, which, "wavelength %d is %g nm", i + 1, center[i]);
        if (i > 0 && !(center[i] - center[i - 1] >= RERADIATION_STEP_MIN_NM))
            return fail(err, name, which, "%g nm comes after %g nm; steps of at least %g are wanted",
                        center[i], center[i - 1], RERADIATION_STEP_MIN_NM);
    }
    return true;
}

static void tell(reradiation_note note, void *user, const char *name, const char *property,
                 const char *format, ...) __attribute__((format(printf, 5, 6)));
static void tell(reradiation_note note, void *user, const char *name, const char *property,
                 const char *format, ...)
{
    stokes_error what;
    char text[sizeof what.text];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    fail(&what, name, property, "%s", text);
    if (note)
        note(user, &what);
}

/* --- Missing bands ----------------------------------------------------------------------------------------- */

/* Between the nearest that were measured of one incident band, off the diagonal; beyond the last there is nothing. */
static float between_outgoing(const struct measured *m, int out, int in)
{
    int below = out - 1, above = out + 1;
    while (below >= 0 && (isnan(*at(m, below, in)) || is_diagonal(m, below, in)))
        below--;
    while (above < m->count_out && (isnan(*at(m, above, in)) || is_diagonal(m, above, in)))
        above++;
    if (below < 0 || above == m->count_out)
        return 0;
    double t = (m->out[out] - m->out[below]) / (m->out[above] - m->out[below]);
    return (float)((1 - t) * *at(m, below, in) + t * *at(m, above, in));
}

/* The diagonal's value of an incident band: what all outgoing bands that overlap it hold. NaN if none was measured. */
static double diagonal_of(const struct measured *m, int in)
{
    double sum = NAN;
    for (int out = 0; out < m->count_out; out++)
        if (is_diagonal(m, out, in) && !isnan(*at(m, out, in)))
            sum = (isnan(sum) ? 0 : sum) + *at(m, out, in);
    return sum;
}

static int parts_of_diagonal(const struct measured *m, int in)
{
    int count = 0;
    for (int out = 0; out < m->count_out; out++)
        count += is_diagonal(m, out, in);
    return count;
}

/* Between the nearest incident bands whose diagonal was measured; held beyond the last. False if there are none. */
static bool between_incident(const struct measured *m, const double *diagonal, int in, double *value)
{
    int below = in, above = in;
    while (below >= 0 && isnan(diagonal[below]))
        below--;
    while (above < m->count_in && isnan(diagonal[above]))
        above++;
    if (below < 0 && above == m->count_in)
        return false;
    if (below < 0 || above == m->count_in)
        *value = diagonal[below < 0 ? above : below];
    else
        *value = diagonal[below] + (diagonal[above] - diagonal[below]) * (m->in[in] - m->in[below]) /
                                       fmax(m->in[above] - m->in[below], 1e-9);
    return true;
}

static bool fill_diagonal(struct measured *m, int *filled, const char *name, stokes_error *err)
{
    double *diagonal = calloc((size_t)m->count_in, sizeof *diagonal), value = 0;
    bool any = false;
    if (!diagonal)
        return fail(err, name, "bands", "out of memory");
    for (int in = 0; in < m->count_in; in++)
        diagonal[in] = diagonal_of(m, in);
    for (int in = 0; in < m->count_in; in++) {
        any |= !isnan(diagonal[in]);
        int parts = parts_of_diagonal(m, in);
        for (int out = 0; out < m->count_out; out++)
            if (is_diagonal(m, out, in) && isnan(*at(m, out, in))) {
                bool known = isnan(diagonal[in]) && between_incident(m, diagonal, in, &value);
                *at(m, out, in) = known ? (float)(value / parts) : 0;
                ++*filled;
            }
    }
    free(diagonal);
    return any || fail(err, name, "diagonal", "no band was measured that holds its own light");
}

static bool fill_missing(struct measured *m, const char *name, reradiation_note note, void *user,
                         stokes_error *err)
{
    int beside = 0, on = 0;
    for (int in = 0; in < m->count_in; in++)
        for (int out = 0; out < m->count_out; out++)
            if (isnan(*at(m, out, in)) && !is_diagonal(m, out, in))
                beside++;
    /* What was filled before lies on the line between what was measured, so it may serve as an end of it. */
    for (int in = 0; in < m->count_in; in++)
        for (int out = 0; out < m->count_out; out++)
            if (isnan(*at(m, out, in)) && !is_diagonal(m, out, in))
                *at(m, out, in) = between_outgoing(m, out, in);
    if (!fill_diagonal(m, &on, name, err))
        return false;
    if (beside + on > 0)
        tell(note, user, name, "missing",
             "%d of %d bands were not measured (%d of them on the diagonal); filled from their neighbours",
             beside + on, m->count_in * m->count_out, on);
    if (m->out[0] > m->in[0] + EVEN || m->out[m->count_out - 1] < m->in[m->count_in - 1] - EVEN)
        tell(note, user, name, "range",
             "reflection was measured from %g to %g nm, light came in from %g to %g: its ends are held",
             fmax(m->out[0], m->in[0]), fmin(m->out[m->count_out - 1], m->in[m->count_in - 1]), m->in[0],
             m->in[m->count_in - 1]);
    return true;
}

/* --- Noise ------------------------------------------------------------------------------------------------- */

/* What lies below zero is half of a noise about zero: σ² is its mean square. */
static double noise_of(const struct measured *m, int *count)
{
    double sum = 0;
    *count = 0;
    for (int out = 0; out < m->count_out; out++)
        for (int in = 0; in < m->count_in; in++)
            if (*at(m, out, in) < 0 && !is_diagonal(m, out, in)) {
                sum += (double)*at(m, out, in) * *at(m, out, in);
                ++*count;
            }
    return *count > 0 ? sqrt(sum / *count) : 0;
}

/* An instrument with noise that writes an exact 0 did not measure there. */
static void unmeasured_zeros(struct measured *m)
{
    int negative;
    if (noise_of(m, &negative) > 0)
        for (int i = 0; i < m->count_in * m->count_out; i++)
            if (m->share[i] == 0)
                m->share[i] = NAN;
}

/* The values of a run keep their sum where noise below zero is cut off. */
static void settle_run(float **run, int count)
{
    double sum = 0, positive = 0;
    for (int k = 0; k < count; k++) {
        sum += *run[k];
        positive += fmaxf(*run[k], 0);
    }
    float scale = sum > 0 && positive > 0 ? (float)(sum / positive) : 0;
    for (int k = 0; k < count; k++)
        *run[k] = fmaxf(*run[k], 0) * scale;
}

/* Keeps the runs of one incident band that stand out of the noise; the rest is zero. True if any does. */
static bool settle_column(float **value, int count, const double *smooth, double sigma)
{
    bool any = false;
    for (int k = 0; k < count;) {
        int end = k;
        double peak = 0;
        while (end < count && smooth[end] > NOISE_SUPPORT * sigma)
            peak = fmax(peak, smooth[end++]);
        if (peak > NOISE_PEAK * sigma) {
            settle_run(value + k, end - k);
            any = true;
        } else {
            for (int j = k; j < end; j++)
                *value[j] = 0;
        }
        if (end == k)
            *value[end++] = 0;
        k = end;
    }
    return any;
}

static bool remove_noise(struct measured *m, const char *name, reradiation_note note, void *user,
                         stokes_error *err)
{
    int negative, elastic = 0;
    double sigma = noise_of(m, &negative), *smooth = calloc((size_t)m->count_out, sizeof *smooth);
    float **value = calloc((size_t)m->count_out, sizeof *value);
    bool good = smooth && value;
    for (int in = 0; good && sigma > 0 && in < m->count_in; in++) {
        int count = 0;
        for (int out = 0; out < m->count_out; out++)
            if (!is_diagonal(m, out, in))
                value[count++] = at(m, out, in);
        for (int k = 0; k < count; k++) {
            int low = k > 0 ? k - 1 : 0, high = k + 1 < count ? k + 1 : k;
            smooth[k] = 0;
            for (int j = low; j <= high; j++)
                smooth[k] += (double)*value[j] / (high - low + 1);
        }
        elastic += !settle_column(value, count, smooth, sigma);
    }
    for (int i = 0; i < m->count_in * m->count_out; i++)
        m->share[i] = fmaxf(m->share[i], 0); /* of the diagonal */
    free(smooth);
    free(value);
    if (good && sigma > 0)
        tell(note, user, name, "noise",
             "%d values are below zero (σ ≈ %.2g): what does not stand out of that is taken as zero; %d of "
             "%d incident bands only reflect",
             negative, sigma, elastic, m->count_in);
    return good || fail(err, name, "bands", "out of memory");
}

/* --- One grid ---------------------------------------------------------------------------------------------- */

static double widest_step(const double *center, int count)
{
    double step = 0;
    for (int i = 1; i < count; i++)
        step = fmax(step, center[i] - center[i - 1]);
    return step;
}

static bool is_even(const double *center, int count, double first, double step)
{
    for (int i = 0; i < count; i++) {
        double place = (center[i] - first) / step;
        if (fabs(place - round(place)) > EVEN || (i > 0 && center[i] - center[i - 1] > (1 + EVEN) * step))
            return false;
    }
    return true;
}

/* Energy is kept: an outgoing band hands on shares by overlap, an incident one is a mean of those that it covers. */
static void put_on_grid(const struct measured *m, stokes_matrix *grid)
{
    for (int i = 0; i < grid->count_in; i++) {
        double low = grid->first_in_nm + (i - 0.5) * grid->step_nm, high = low + grid->step_nm, covered = 0;
        for (int in = 0; in < m->count_in; in++)
            covered += overlap(low, high, band_low(m->in, in), band_high(m->in, m->count_in, in));
        for (int in = 0; in < m->count_in; in++) {
            double part = overlap(low, high, band_low(m->in, in), band_high(m->in, m->count_in, in));
            for (int out = 0; part > 0 && out < m->count_out; out++) {
                double from = band_low(m->out, out), to = band_high(m->out, m->count_out, out);
                double share = *at(m, out, in) * part / covered / (to - from);
                int first = (int)floor((from - grid->first_out_nm) / grid->step_nm + 0.5);
                for (int o = first > 0 ? first : 0; o < grid->count_out; o++) {
                    double edge = grid->first_out_nm + (o - 0.5) * grid->step_nm;
                    if (edge >= to)
                        break;
                    grid->share[o * grid->count_in + i] +=
                        (float)(share * overlap(from, to, edge, edge + grid->step_nm));
                }
            }
        }
    }
}

static stokes_matrix *regrid(const struct measured *m, const char *name, reradiation_note note, void *user,
                             stokes_error *err)
{
    double step = fmax(widest_step(m->in, m->count_in), widest_step(m->out, m->count_out));
    double first_in = m->in[0], last_in = m->in[m->count_in - 1], last_out = m->out[m->count_out - 1];
    bool even = is_even(m->in, m->count_in, first_in, step) && is_even(m->out, m->count_out, first_in, step);
    double first_out = first_in + step * (even ? round((m->out[0] - first_in) / step)
                                               : floor((m->out[0] - first_in) / step + EVEN));
    int count_in = (int)ceil((last_in - first_in) / step - EVEN) + 1,
        count_out = (int)ceil((last_out - first_out) / step - EVEN) + 1;
    stokes_matrix *grid = reradiation_create(first_in, count_in, first_out, count_out, step, name, err);
    if (!grid)
        return NULL;
    put_on_grid(m, grid);
    if (!even)
        tell(note, user, name, "bands",
             "of incident and outgoing light do not match: both are put on bands of %g nm", step);
    return grid;
}

/* Materials keep energy: more than arrives they cut. */
static void tell_excess(const stokes_matrix *m, const char *name, reradiation_note note, void *user)
{
    double most = 0;
    for (int in = 0; in < m->count_in; in++) {
        double sum = 0;
        for (int out = 0; out < m->count_out; out++)
            sum += (double)m->share[out * m->count_in + in];
        most = fmax(most, sum);
    }
    if (most > 1 + EVEN)
        tell(note, user, name, "energy", "up to %.4g of what arrives leaves; a material gives 1 at most%s",
             most, most > 10 ? " (are these percent?)" : "");
}

stokes_matrix *measured_finish(struct measured *m, const char *name, reradiation_note note, void *user,
                               stokes_error *err)
{
    stokes_matrix *matrix = NULL;
    if (check_wavelengths(m->in, m->count_in, "incident", name, err) &&
        check_wavelengths(m->out, m->count_out, "outgoing", name, err)) {
        unmeasured_zeros(m);
        if (fill_missing(m, name, note, user, err) && remove_noise(m, name, note, user, err))
            matrix = regrid(m, name, note, user, err);
    }
    measured_destroy(m);
    if (matrix && !reradiation_check(matrix, name, err)) {
        reradiation_destroy(matrix);
        return NULL;
    }
    if (matrix)
        tell_excess(matrix, name, note, user);
    return matrix;
}
