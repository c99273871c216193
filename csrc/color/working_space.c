/* The working space as a pair of matrices. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "color/color.h"

static bool invert(const double m[9], double out[9])
{
    out[0] = m[4] * m[8] - m[5] * m[7];
    out[1] = m[2] * m[7] - m[1] * m[8];
    out[2] = m[1] * m[5] - m[2] * m[4];
    out[3] = m[5] * m[6] - m[3] * m[8];
    out[4] = m[0] * m[8] - m[2] * m[6];
    out[5] = m[2] * m[3] - m[0] * m[5];
    out[6] = m[3] * m[7] - m[4] * m[6];
    out[7] = m[1] * m[6] - m[0] * m[7];
    out[8] = m[0] * m[4] - m[1] * m[3];
    double determinant = m[0] * out[0] + m[1] * out[3] + m[2] * out[6];
    if (!(fabs(determinant) > 1e-9))
        return false;
    for (int i = 0; i < 9; i++)
        out[i] /= determinant;
    return true;
}

bool working_space_set(struct working_space *space, const double rgb_to_xyz[9], stokes_error *err)
{
    struct working_space made;
    for (int i = 0; i < 9; i++)
        if (!isfinite(rgb_to_xyz[i]) || fabs(rgb_to_xyz[i]) > 1e6)
            return fail(err, "working space", "rgb_to_xyz", "entry %d is %g", i, rgb_to_xyz[i]);
    for (int row = 0; row < 3; row++)
        if (!(rgb_to_xyz[3 * row] + rgb_to_xyz[3 * row + 1] + rgb_to_xyz[3 * row + 2] > 0))
            return fail(err, "working space", "rgb_to_xyz", "its white has no positive %c", "XYZ"[row]);
    memcpy(made.rgb_to_xyz, rgb_to_xyz, sizeof made.rgb_to_xyz);
    if (!invert(made.rgb_to_xyz, made.xyz_to_rgb))
        return fail(err, "working space", "rgb_to_xyz", "the matrix is singular");
    *space = made;
    return true;
}

/* Columns are the primaries' XYZ, scaled so that their sum is the white's. */
static void matrix_of_primaries(const double primaries_xy[3][2], const double white_xy[2], double matrix[9])
{
    double columns[9], inverse[9];
    for (int c = 0; c < 3; c++) {
        double x = primaries_xy[c][0], y = primaries_xy[c][1];
        columns[c] = x / y;
        columns[3 + c] = 1;
        columns[6 + c] = (1 - x - y) / y;
    }
    invert(columns, inverse);
    double white[3] = {white_xy[0] / white_xy[1], 1, (1 - white_xy[0] - white_xy[1]) / white_xy[1]};
    for (int c = 0; c < 3; c++) {
        double scale =
            inverse[3 * c] * white[0] + inverse[3 * c + 1] * white[1] + inverse[3 * c + 2] * white[2];
        for (int row = 0; row < 3; row++)
            matrix[3 * row + c] = columns[3 * row + c] * scale;
    }
}

void working_space_rec709(struct working_space *space)
{
    static const double primaries[3][2] = {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}};
    static const double d65[2] = {0.3127, 0.3290};
    matrix_of_primaries(primaries, d65, space->rgb_to_xyz);
    invert(space->rgb_to_xyz, space->xyz_to_rgb);
}
