/* The working space: CIE tables against published sums, and OpenColorIO configs of every age: some written here,
   those inside OpenColorIO, and Blender's own where they are installed. */
#include "color/color.h"

#include <glob.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#define BPY_CONFIGS "build/*/*/lib/python*/site-packages/bpy/*/datafiles/colormanagement/config.ocio"
#define DEBIAN_CONFIG "/usr/share/blender/datafiles/colormanagement/config.ocio"

static void colour_matching_functions_sum_to_the_published(void **state)
{
    (void)state;
    double sum[3] = {0};
    for (int nm = 360; nm <= 830; nm++) {
        float xyz[3];
        cmf_eval((float)nm, xyz);
        for (int c = 0; c < 3; c++)
            sum[c] += xyz[c];
    }
    /* ISO/CIE 11664-1: table 1's columns sum to 106.865, 106.857, 106.892 */
    assert_float_equal(sum[0], 106.865, 1e-3);
    assert_float_equal(sum[1], 106.857, 1e-3);
    assert_float_equal(sum[2], 106.892, 1e-3);
}

static void tables_are_linear_between_and_zero_outside(void **state)
{
    (void)state;
    float low[3], middle[3], high[3];
    cmf_eval(450, low);
    cmf_eval(450.25f, middle);
    cmf_eval(451, high);
    for (int c = 0; c < 3; c++)
        assert_float_equal(middle[c], 0.75f * low[c] + 0.25f * high[c], 1e-6);
    cmf_eval(359.9f, low);
    cmf_eval(830.1f, high);
    for (int c = 0; c < 3; c++)
        assert_float_equal(low[c] + high[c], 0, 0);
    cmf_eval(830, high);
    assert_true(high[0] > 0);
    assert_float_equal(illuminant_d65(560), 100, 0);
    assert_float_equal(illuminant_d65(300), 0.0341, 1e-6);
    assert_float_equal(illuminant_d65(830), 60.3125, 1e-3);
    assert_float_equal(illuminant_d65(562), 0.6f * 100 + 0.4f * 98.1671f, 1e-3);
    assert_float_equal(illuminant_d65(299) + illuminant_d65(831) + illuminant_d65(NAN), 0, 0);
}

static double brute_luminance(double low, double high, double *power)
{
    enum { STEPS = 400000 };
    double luminance = 0, width = (high - low) / STEPS;
    *power = 0;
    for (int i = 0; i < STEPS; i++) {
        float xyz[3], l = (float)(low + (i + 0.5) * width);
        cmf_eval(l, xyz);
        *power += width * illuminant_d65(l);
        luminance += width * (double)illuminant_d65(l) * xyz[1];
    }
    return luminance;
}

static void d65_of_unit_power_has_unit_luminance(void **state)
{
    (void)state;
    static const double ranges[][2] = {{300, 830}, {360, 830}, {380.3, 779.9}, {500, 600.5}, {200, 1000}};
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++) {
        double power, luminance = brute_luminance(ranges[i][0], ranges[i][1], &power);
        double kappa = cmf_normalization(ranges[i][0], ranges[i][1]);
        assert_float_equal(kappa * luminance / power, 1, 1e-5);
    }
    assert_float_equal(cmf_normalization(300, 340), 0, 0); /* nothing there is seen */
}

static void rec709_is_the_matrix_of_the_standard(void **state)
{
    (void)state;
    /* IEC 61966-2-1, inverse of its XYZ to RGB matrix in four decimals, and D65 as white */
    static const double printed[9] = {0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505};
    struct working_space space;
    working_space_rec709(&space);
    for (int i = 0; i < 9; i++)
        assert_float_equal(space.rgb_to_xyz[i], printed[i], 6e-5);
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++) {
            double sum = 0;
            for (int k = 0; k < 3; k++)
                sum += space.rgb_to_xyz[3 * row + k] * space.xyz_to_rgb[3 * k + column];
            assert_float_equal(sum, row == column, 1e-12);
        }
    assert_float_equal(space.rgb_to_xyz[3] + space.rgb_to_xyz[4] + space.rgb_to_xyz[5], 1, 1e-12);
}

static void a_useless_matrix_is_refused(void **state)
{
    (void)state;
    double singular[9] = {1, 2, 3, 2, 4, 6, 1, 1, 1}, infinite[9] = {1, 0, 0, 0, INFINITY, 0, 0, 0, 1};
    double dark[9] = {1, 0, 0, 0, -1, 0, 0, 0, 1};
    struct working_space space;
    stokes_error err;
    working_space_rec709(&space);
    double before = space.rgb_to_xyz[0];
    assert_false(working_space_set(&space, singular, &err));
    assert_non_null(strstr(err.text, "singular"));
    assert_false(working_space_set(&space, infinite, &err));
    assert_non_null(strstr(err.text, "entry 4"));
    assert_false(working_space_set(&space, dark, &err));
    assert_non_null(strstr(err.text, "no positive Y"));
    assert_float_equal(space.rgb_to_xyz[0], before, 0);
}

/* Three ways in which configs say what XYZ is, and one that says nothing. The reference space is Rec.709. */
#define TO_XYZ                                                                                               \
    "[0.4123908, 0.3575843, 0.1804808, 0, 0.2126390, 0.7151687, 0.0721923, 0, 0.0193308, 0.1191948, "        \
    "0.9505322, 0, 0, 0, 0, 1]"
#define TO_ACES                                                                                              \
    "!<GroupTransform> {children: [!<MatrixTransform> {matrix: " TO_XYZ "}, "                                \
    "!<BuiltinTransform> {style: \"UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD\", direction: inverse}]}"
#define COMMON                                                                                               \
    "file_rules:\n  - !<Rule> {name: Default, colorspace: lin}\n"                                            \
    "displays:\n  screen:\n    - !<View> {name: plain, colorspace: coded}\n"                                 \
    "    - !<View> {name: with look, colorspace: coded, looks: darker}\n"                                    \
    "looks:\n  - !<Look> {name: darker, process_space: lin, transform: !<MatrixTransform> {matrix: [0.5, "   \
    "0, 0, 0, 0, "                                                                                           \
    "0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}}\n"                                                               \
    "colorspaces:\n"                                                                                         \
    "  - !<ColorSpace> {name: lin}\n"                                                                        \
    "  - !<ColorSpace> {name: wide, from_scene_reference: !<MatrixTransform> {matrix: [0.5, 0.3, 0.2, 0, "   \
    "0.1, 0.8, "                                                                                             \
    "0.1, 0, 0, 0.2, 0.8, 0, 0, 0, 0, 1]}}\n"                                                                \
    "  - !<ColorSpace> {name: coded, from_scene_reference: !<ExponentTransform> {value: [2, 2, 2, 1], "      \
    "direction: "                                                                                            \
    "inverse}}\n"                                                                                            \
    "  - !<ColorSpace> {name: raw, isdata: true}\n"

static const char with_role[] =
    "ocio_profile_version: 2.5\nenvironment: {}\nname: test\n"
    "roles: {scene_linear: lin, data: raw, cie_xyz_d65_interchange: xyz, aces_interchange: aces, "
    "color_timing: lin, "
    "compositing_log: coded, default: lin}\n" COMMON
    "  - !<ColorSpace> {name: xyz, from_scene_reference: !<MatrixTransform> {matrix: " TO_XYZ "}}\n"
    "  - !<ColorSpace> {name: aces, from_scene_reference: " TO_ACES "}\n";
static const char with_aces[] =
    "ocio_profile_version: 2\nenvironment: {}\n"
    "roles: {scene_linear: lin, data: raw, aces_interchange: aces, default: lin}\n" COMMON
    "  - !<ColorSpace> {name: aces, from_scene_reference: " TO_ACES "}\n";
static const char with_name[] =
    "ocio_profile_version: 2\nenvironment: {}\n"
    "roles: {scene_linear: lin, data: raw, default: lin}\n" COMMON
    "  - !<ColorSpace> {name: XYZ, from_scene_reference: !<MatrixTransform> {matrix: " TO_XYZ "}}\n";
static const char with_nothing[] = "ocio_profile_version: 2\nenvironment: {}\n"
                                   "roles: {scene_linear: lin, data: raw, default: lin}\n" COMMON;

static struct color_config *open_text(const char *text)
{
    char path[] = "/tmp/stokes-test-XXXXXX";
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, text, strlen(text)), (ssize_t)strlen(text));
    close(fd);
    stokes_error err = {0};
    struct color_config *config = color_config_open(path, &err);
    if (!config)
        print_message("%s: %s\n", err.object, err.text);
    unlink(path);
    assert_non_null(config);
    return config;
}

static void assert_rec709(const struct working_space *space, double tolerance)
{
    struct working_space rec709;
    working_space_rec709(&rec709);
    for (int i = 0; i < 9; i++)
        assert_float_equal(space->rgb_to_xyz[i], rec709.rgb_to_xyz[i], tolerance);
}

static void xyz_is_found_by_role_by_aces_and_by_name(void **state)
{
    (void)state;
    const char *const texts[] = {with_role, with_aces, with_name};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        struct color_config *config = open_text(texts[i]);
        struct working_space space, wide;
        stokes_error err;
        assert_true(color_config_working_space(config, "", &space, &err));
        assert_rec709(&space, 2e-5);
        assert_true(
            color_config_working_space(config, "no such space", &space, &err)); /* then scene_linear */
        assert_rec709(&space, 2e-5);
        assert_true(color_config_working_space(config, "wide", &wide, &err));
        /* rows of wide_from_lin sum to 1: another basis with the same white */
        for (int row = 0; row < 3; row++)
            assert_float_equal(
                wide.rgb_to_xyz[3 * row] + wide.rgb_to_xyz[3 * row + 1] + wide.rgb_to_xyz[3 * row + 2],
                space.rgb_to_xyz[3 * row] + space.rgb_to_xyz[3 * row + 1] + space.rgb_to_xyz[3 * row + 2],
                2e-5);
        double first = 0; /* wide's matrix times lin → wide is lin's */
        for (int k = 0; k < 3; k++)
            first += wide.rgb_to_xyz[k] * (double[]){0.5, 0.1, 0}[k];
        assert_float_equal(first, space.rgb_to_xyz[0], 2e-5);
        color_config_close(config);
    }
}

static void what_has_no_xyz_or_is_not_linear_is_named(void **state)
{
    (void)state;
    struct working_space space;
    stokes_error err;
    struct color_config *config = open_text(with_nothing);
    assert_false(color_config_working_space(config, "lin", &space, &err));
    assert_non_null(strstr(err.text, "no CIE XYZ space"));
    assert_non_null(strstr(err.object, "stokes-test"));
    color_config_close(config);
    config = open_text(with_role);
    assert_false(color_config_working_space(config, "coded", &space, &err));
    assert_non_null(strstr(err.text, "coded is not linear"));
    color_config_close(config);
}

static void a_config_that_cannot_be_read_names_its_path(void **state)
{
    (void)state;
    stokes_error err;
    assert_null(color_config_open("/no/such/config.ocio", &err));
    assert_string_equal(err.object, "/no/such/config.ocio");
    assert_true(strlen(err.text) > 10);
    char path[] = "/tmp/stokes-test-XXXXXX";
    int fd = mkstemp(path);
    assert_int_equal(write(fd, "ocio_profile_version: 99\n", 25), 25);
    close(fd);
    assert_null(color_config_open(path, &err));
    assert_string_equal(err.object, path);
    unlink(path);
    assert_null(color_config_open("/tmp", &err));
    color_config_close(NULL);
}

static void pictures_become_the_working_space_and_keep_alpha(void **state)
{
    (void)state;
    struct color_config *config = open_text(with_role);
    stokes_error err;
    float rgba[8] = {0.5f, 0.25f, 1, 0.3f, 0, 2, 0.1f, 0.7f};
    assert_true(color_config_to_working(config, "coded", "lin", rgba, 2, 4, &err));
    const float squared[8] = {0.25f, 0.0625f, 1, 0.3f, 0, 4, 0.01f, 0.7f};
    for (int i = 0; i < 8; i++)
        assert_float_equal(rgba[i], squared[i], 2e-5);
    float rgb[6] = {0.5f, 0.25f, 1, 0, 2, 0.1f}, raw[3] = {0.1f, -2, 3};
    assert_true(color_config_to_working(config, "coded", "", rgb, 2, 3, &err));
    for (int i = 0; i < 6; i++)
        assert_float_equal(rgb[i], squared[i + i / 3], 2e-5);
    assert_true(color_config_to_working(config, "raw", "lin", raw, 1, 3, &err));
    assert_float_equal(raw[0] + raw[1] + raw[2], 1.1, 1e-6);
    assert_true(color_config_to_working(config, "lin", "lin", raw, 0, 3, &err));
    assert_false(color_config_to_working(config, "sRGB of the future", "lin", raw, 1, 3, &err));
    assert_non_null(strstr(err.text, "sRGB of the future"));
    color_config_close(config);
}

static void display_applies_exposure_look_view_and_gamma(void **state)
{
    (void)state;
    struct color_config *config = open_text(with_role);
    stokes_error err;
    float plain[4] = {0.25f, 0.0625f, -1, 0.4f}, exposed[3] = {0.25f, 0.0625f, 9},
          look[3] = {0.5f, 0.125f, 0};
    float gamma[3] = {0.25f, 0.0625f, 0}, of_view[3] = {0.5f, 0.125f, 0};
    assert_true(color_config_to_display(config, "lin", "screen", "plain", "", 0, 1, plain, 1, 4, &err));
    assert_float_equal(plain[0], 0.5, 1e-5);
    assert_float_equal(plain[2], 0, 0);
    assert_float_equal(plain[3], 0.4, 0);
    assert_true(color_config_to_display(config, "lin", "screen", "plain", "None", 2, 1, exposed, 1, 3, &err));
    assert_float_equal(exposed[1], 0.5, 1e-5);
    assert_float_equal(exposed[2], 1, 0);
    assert_true(color_config_to_display(config, "lin", "screen", "plain", "darker", 0, 1, look, 1, 3, &err));
    assert_float_equal(look[0], 0.5, 1e-5);
    assert_true(color_config_to_display(config, "lin", "screen", "with look", "", 0, 1, of_view, 1, 3, &err));
    assert_float_equal(of_view[0], 0.5, 1e-5);
    assert_true(color_config_to_display(config, "lin", "", "", "", 0, 2, gamma, 1, 3,
                                        &err)); /* the config's defaults */
    assert_float_equal(gamma[1], 0.5, 1e-5);
    assert_false(color_config_to_display(config, "lin", "no screen", "plain", "", 0, 1, gamma, 1, 3, &err));
    assert_false(
        color_config_to_display(config, "lin", "screen", "plain", "no look", 0, 1, gamma, 1, 3, &err));
    color_config_close(config);
}

/* In every Blender the working space is Rec.709 by default, and an sRGB picture of 0.5 is 0.2140. */
static void check_blender_config(const char *path)
{
    stokes_error err = {0};
    struct working_space space;
    struct color_config *config = color_config_open(path, &err);
    if (!config)
        print_message("%s: %s\n", err.object, err.text);
    assert_non_null(config);
    assert_true(color_config_working_space(config, "Linear Rec.709", &space, &err));
    assert_rec709(&space, 3e-4); /* up to 4.4 white is (0.95047, 1, 1.08883) */
    float rgb[3] = {0.5f, 0.5f, 0.5f}, shown[3] = {0.2140411f, 0.2140411f, 0.2140411f};
    assert_true(color_config_to_working(config, "sRGB", "", rgb, 1, 3, &err));
    assert_float_equal(rgb[0], 0.2140411, 1e-4);
    assert_true(color_config_to_display(config, "", "sRGB", "Standard", "None", 0, 1, shown, 1, 3, &err));
    assert_float_equal(shown[1], 0.5, 2e-3);
    const char *const wide[] = {"ACEScg", "Linear ACEScg", "Linear Rec.2020"};
    float pixel[3] = {0};
    for (size_t i = 0; i < sizeof wide / sizeof *wide; i++) {
        if (!color_config_to_working(config, wide[i], "", pixel, 1, 3, &err))
            continue; /* older configs lack it */
        assert_true(color_config_working_space(config, wide[i], &space, &err));
        assert_float_equal(space.rgb_to_xyz[0] + space.rgb_to_xyz[1] + space.rgb_to_xyz[2], 0.9505, 5e-4);
        assert_float_equal(space.rgb_to_xyz[6] + space.rgb_to_xyz[7] + space.rgb_to_xyz[8], 1.0890, 1e-3);
        assert_true(fabs(space.rgb_to_xyz[0] - 0.4124) > 0.1);
    }
    color_config_close(config);
}

static void the_config_of_debians_blender_works(void **state)
{
    (void)state;
    if (access(DEBIAN_CONFIG, R_OK) != 0) {
        print_message("skipped: no " DEBIAN_CONFIG "\n");
        skip();
    }
    check_blender_config(DEBIAN_CONFIG);
}

static void the_configs_of_installed_bpy_modules_work(void **state)
{
    (void)state;
    glob_t found;
    int status = glob(BPY_CONFIGS, 0, NULL, &found);
    if (status == GLOB_NOMATCH) {
        print_message("skipped: no bpy module (4.2 to 5.x) below build/, nothing like " BPY_CONFIGS "\n");
        skip();
    }
    assert_int_equal(status, 0);
    for (size_t i = 0; i < found.gl_pathc; i++) {
        print_message("%s\n", found.gl_pathv[i]);
        check_blender_config(found.gl_pathv[i]);
    }
    globfree(&found);
}

/* OpenColorIO carries configs of its own; their working space is ACEScg. */
static void the_configs_inside_opencolorio_work(void **state)
{
    (void)state;
    static const char *const uris[] = {"ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1",
                                       "ocio://studio-config-v2.1.0_aces-v1.3_ocio-v2.3",
                                       "ocio://studio-config-latest"};
    for (size_t i = 0; i < sizeof uris / sizeof *uris; i++) {
        stokes_error err = {0};
        struct working_space space;
        struct color_config *config = color_config_open(uris[i], &err);
        assert_non_null(config);
        assert_true(color_config_working_space(config, "", &space, &err));
        assert_float_equal(space.rgb_to_xyz[0], 0.6522, 1e-3);
        assert_float_equal(space.rgb_to_xyz[3] + space.rgb_to_xyz[4] + space.rgb_to_xyz[5], 1, 1e-5);
        color_config_close(config);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colour_matching_functions_sum_to_the_published),
        cmocka_unit_test(tables_are_linear_between_and_zero_outside),
        cmocka_unit_test(d65_of_unit_power_has_unit_luminance),
        cmocka_unit_test(rec709_is_the_matrix_of_the_standard),
        cmocka_unit_test(a_useless_matrix_is_refused),
        cmocka_unit_test(xyz_is_found_by_role_by_aces_and_by_name),
        cmocka_unit_test(what_has_no_xyz_or_is_not_linear_is_named),
        cmocka_unit_test(a_config_that_cannot_be_read_names_its_path),
        cmocka_unit_test(pictures_become_the_working_space_and_keep_alpha),
        cmocka_unit_test(display_applies_exposure_look_view_and_gamma),
        cmocka_unit_test(the_config_of_debians_blender_works),
        cmocka_unit_test(the_configs_of_installed_bpy_modules_work),
        cmocka_unit_test(the_configs_inside_opencolorio_work),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
