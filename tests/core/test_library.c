/* The spectrum library: complete, in range, and what its sources say. */
#include "spectrum/library/library.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static const struct range lambda_range = {300, 830};

static bool starts(const char *text, const char *prefix)
{
    return strncmp(text, prefix, strlen(prefix)) == 0;
}

static bool ends(const char *text, const char *suffix)
{
    return strlen(text) >= strlen(suffix) && strcmp(text + strlen(text) - strlen(suffix), suffix) == 0;
}

static struct spectrum *entry(const char *name)
{
    stokes_error err = {0};
    struct spectrum *s = spectrum_library(lambda_range, name, "test", &err);
    if (!s)
        print_message("%s: %s\n", name, err.text);
    assert_non_null(s);
    return s;
}

static double value(const char *name, double lambda_nm)
{
    double found = NAN;
    assert_true(library_value(name, lambda_nm, &found));
    return found;
}

static void the_library_holds_what_it_promises(void **state)
{
    (void)state;
    size_t patches = 0, dyes = 0, metals = 0, illuminants = 0;
    for (size_t i = 0; library_name(i); i++) {
        const char *name = library_name(i);
        patches += starts(name, "colorchecker/");
        dyes += starts(name, "dye/") && ends(name, "/emission");
        metals += starts(name, "metal/") && ends(name, "/eta");
        illuminants += starts(name, "illuminant/F");
        assert_ptr_equal(library_find(name), library_at(i)); /* a name stands for one entry */
    }
    assert_int_equal(patches, 24);
    assert_int_equal(dyes, 59);
    assert_int_equal(illuminants, 12);
    assert_true(metals >= 10);
    static const char *const wanted[] = {"colorchecker/cyan", "colorchecker/white",
                                         "metal/Ag/eta",      "metal/Au/k",
                                         "metal/Cu/eta",      "metal/Al/k",
                                         "illuminant/C",      "illuminant/F11",
                                         "lamp/HP1",          "dye/rhodamine-6g_ethanol/emission"};
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++)
        assert_non_null(library_find(wanted[i]));
    assert_null(library_find("colorchecker"));
    assert_null(library_find(""));
}

static void every_entry_is_a_sound_spectrum(void **state)
{
    (void)state;
    for (size_t i = 0; library_name(i); i++) {
        const char *name = library_name(i);
        struct spectrum *s = entry(name);
        assert_true(spectrum_min(s) >= 0);
        if (starts(name, "colorchecker/"))
            assert_true(spectrum_max(s) < 1);
        if (starts(name, "dye/") || starts(name, "lamp/"))
            assert_float_equal(spectrum_max(s), 1, 2e-3);
        for (float l = 300; l <= 830; l += 13) {
            double direct;
            assert_true(library_value(name, l, &direct));
            assert_float_equal(spectrum_eval(s, l), direct, 1e-5 * (1 + fabs(direct)));
        }
        spectrum_destroy(s);
    }
}

static void reflectances_hold_and_dyes_end_outside_their_range(void **state)
{
    (void)state;
    assert_float_equal(value("colorchecker/cyan", 310), value("colorchecker/cyan", 380), 0);
    assert_float_equal(value("colorchecker/cyan", 830), value("colorchecker/cyan", 780), 0);
    assert_float_equal(value("dye/egfp/emission", 300), 0, 0);
    assert_float_equal(value("dye/egfp/absorption", 830), 0, 0);
    assert_float_equal(value("illuminant/F2", 379), 0, 0);
}

/* Where each dye absorbs and emits most: the stains and proteins as their makers print it, GFP after R. Y. Tsien (Annu.
   Rev. Biochem. 67, 509, 1998); the laser dyes of the scene with spheres as the literature and dealers of laser dyes
   have them in that solvent or one like it, which differ by several nm. Coumarin 6: 2.713 eV in ethanol, 2.460 eV in
   methanol (Sci. Rep. 8, 2018, article 34813). */
static void dyes_peak_where_they_are_known_to(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        float peak_nm, off_nm;
    } known[] = {{"dye/egfp/absorption", 488, 5},
                 {"dye/egfp/emission", 507, 5},
                 {"dye/wild-type-gfp/absorption", 396, 5},
                 {"dye/wild-type-gfp/emission", 508, 5},
                 {"dye/texas-red/emission", 615, 5},
                 {"dye/dapi_dna/absorption", 358, 5},
                 {"dye/dapi_dna/emission", 461, 5},
                 {"dye/cy3/absorption", 550, 5},
                 {"dye/coumarin-30_acetonitrile/absorption", 407, 10},
                 {"dye/coumarin-30_acetonitrile/emission", 482, 10},
                 {"dye/coumarin-6_ethanol/absorption", 457, 10},
                 {"dye/coumarin-6_ethanol/emission", 504, 10},
                 {"dye/dcm_ethanol/absorption", 468, 10},
                 {"dye/dcm_ethanol/emission", 627, 10}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        struct spectrum *s = entry(known[i].name);
        float peak = 300;
        for (float l = 300; l <= 830; l++)
            if (spectrum_eval(s, l) > spectrum_eval(s, peak))
                peak = l;
        if (fabsf(peak - known[i].peak_nm) > known[i].off_nm)
            print_message("%s peaks at %g nm\n", known[i].name, peak);
        assert_float_equal(peak, known[i].peak_nm, known[i].off_nm);
        spectrum_destroy(s);
    }
}

static double normal_reflectance(const char *metal, double lambda_nm)
{
    char name[64];
    double eta, k;
    strcat(strcat(strcpy(name, "metal/"), metal), "/eta");
    eta = value(name, lambda_nm);
    strcat(strcat(strcpy(name, "metal/"), metal), "/k");
    k = value(name, lambda_nm);
    return ((eta - 1) * (eta - 1) + k * k) / ((eta + 1) * (eta + 1) + k * k);
}

static void metals_cover_the_range_and_look_like_metals(void **state)
{
    (void)state;
    for (size_t i = 0; library_at(i); i++) {
        const struct library_entry *e = library_at(i);
        if (!starts(e->name, "metal/"))
            continue;
        assert_true(library_entry_lambda(e, 0) <= 300);
        assert_true(library_entry_lambda(e, e->count - 1u) >= 830);
    }
    assert_true(normal_reflectance("Ag", 550) > 0.95);
    assert_true(normal_reflectance("Ag", 320) < 0.15); /* silver's plasma edge */
    assert_true(normal_reflectance("Au", 650) > 0.93 && normal_reflectance("Au", 450) < 0.42);
    assert_true(normal_reflectance("Cu", 650) > 0.92 && normal_reflectance("Cu", 500) < 0.62);
    assert_float_equal(normal_reflectance("Al", 550), 0.915, 0.01);
}

static double index_of(const char *name, double lambda_nm)
{
    const struct glass *glass = glass_find(name);
    assert_non_null(glass);
    double l2 = lambda_nm * lambda_nm * 1e-6, n2 = 1;
    for (int i = 0; i < 6; i += 2)
        n2 += glass->term[i] * l2 / (l2 - glass->term[i + 1]);
    return sqrt(n2);
}

/* Indices at 587.56 nm as the makers' data sheets and handbooks print them. */
static void glasses_have_their_printed_index(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double n_d, tolerance;
    } printed[] = {{"BK7", 1.51680, 1e-5},    {"SF10", 1.72825, 1e-5},         {"SF11", 1.78472, 1e-5},
                   {"F2", 1.62004, 1e-5},     {"fused_silica", 1.45846, 1e-5}, {"sapphire", 1.76817, 1e-4},
                   {"diamond", 2.4175, 1e-3}, {"water", 1.3334, 2e-4},         {"CaF2", 1.43385, 2e-5}};
    for (size_t i = 0; i < sizeof printed / sizeof *printed; i++)
        assert_float_equal(index_of(printed[i].name, 587.5618), printed[i].n_d, printed[i].tolerance);
    assert_ptr_equal(glass_find("glass/BK7"), glass_find("BK7"));
    assert_null(glass_find("no such glass"));
    assert_null(glass_find("glass/"));
}

static void every_glass_disperses_normally_over_the_whole_range(void **state)
{
    (void)state;
    size_t count = 0;
    for (const struct glass *glass; (glass = glass_at(count)); count++)
        for (double l = 300; l < 830; l += 5) {
            double n = index_of(glass->name, l);
            assert_true(n > 1.3 && n < 2.8 && n > index_of(glass->name, l + 5));
        }
    assert_true(count >= 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_library_holds_what_it_promises),
        cmocka_unit_test(every_entry_is_a_sound_spectrum),
        cmocka_unit_test(reflectances_hold_and_dyes_end_outside_their_range),
        cmocka_unit_test(dyes_peak_where_they_are_known_to),
        cmocka_unit_test(metals_cover_the_range_and_look_like_metals),
        cmocka_unit_test(glasses_have_their_printed_index),
        cmocka_unit_test(every_glass_disperses_normally_over_the_whole_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
