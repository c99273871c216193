/* The working space: from an OpenColorIO config, with XYZ and the CIE 1931 colour-matching functions. */
#ifndef COLOR_COLOR_H
#define COLOR_COLOR_H

#include <stdbool.h>
#include <stddef.h>

#include "stokes.h"

#define CMF_MIN_NM 360.0f
#define CMF_MAX_NM 830.0f

/* CIE 1931 2° colour-matching functions, linear between the 1 nm values, 0 outside 360–830 nm. */
void cmf_eval(float lambda_nm, float xyz[3]);

/* κ·∫D65·cmf for D65 of unit integral over [lambda_min, lambda_max] has Y = 1: this κ (algorithm.md §10). */
double cmf_normalization(double lambda_min, double lambda_max);

/* CIE D65 at a wavelength, 300–830 nm, linear between the published values, 0 outside. */
float illuminant_d65(float lambda_nm);

/* Row-major matrices between the working space and XYZ relative to its own white as D65, Y of white = 1. */
struct working_space {
    double rgb_to_xyz[9], xyz_to_rgb[9];
};

/* False if the matrix is singular or not finite. */
bool working_space_set(struct working_space *, const double rgb_to_xyz[9], stokes_error *err);
void working_space_rec709(struct working_space *);

/* An opened config. One that cannot be read is an error that names its path. */
struct color_config;
struct color_config *color_config_open(const char *path, stokes_error *err);
void color_config_close(struct color_config *);

/* The config's scene_linear space (or `working_space` if it names one of the config's spaces). */
bool color_config_working_space(const struct color_config *, const char *working_space, struct working_space *,
                                stokes_error *err);

/* In place, `count` pixels of RGB or RGBA floats with `stride` floats each, from a named space to the working space. */
bool color_config_to_working(const struct color_config *, const char *colorspace, const char *working_space, float *pixels,
                             size_t count, int stride, stokes_error *err);

/* In place: from the working space to display values in [0,1]. */
bool color_config_to_display(const struct color_config *, const char *working_space, const char *display, const char *view,
                             const char *look, double exposure, double gamma, float *pixels, size_t count, int stride,
                             stokes_error *err);

#endif
