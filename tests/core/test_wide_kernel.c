/* Mollified connections where there is nothing to blur. */
#include "boxes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include "statistics.h"

#include <cmocka.h>

static const struct range range = {300, 830};

/* Paths of up to 6 edges: 94 % of the light, and every kind of connection. */
static struct batches mean_of(const struct scene *scene, const char *name, int lanes, bool shared,
                              int samples)
{
    struct integrator_settings settings = box_settings(name, 100);
    settings.lanes = lanes;
    settings.shared_wavelength = shared;
    settings.max_path = 6;
    return box_mean_below(scene, range, settings, samples);
}

/* Where nothing depends on the wavelength there is nothing to blur: even a wide kernel's connections, of which there are many then, come to what
   exact ones do. (It reaches over the ends of the range, but not from where Y is.) */
static void a_wide_kernel_is_exact_on_grey(void **state)
{
    (void)state;
    struct scene *scene = grey_box_scene(range, 16);
    struct batches exact = mean_of(scene, "pt_nee", 4, false, 40),
                   mollified = mean_of(scene, "mbdpt", 4, false, 24),
                   shared = mean_of(scene, "mbdpt", 1, true, 36);
    assert_same(&exact, &mollified, 1, (struct power){.sees_error = 0.011});
    assert_same(&exact, &shared, 1, (struct power){.sees_error = 0.015});
    scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_wide_kernel_is_exact_on_grey)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
