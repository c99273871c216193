/* What the clamp of P_F is for: without it, a run's elastic vertices are never drawn at wavelengths that a dye absorbs whole, and all that
   a path brings at others is missing. That the clamped one is right is test_integrator.c's. */
#include "boxes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

/* The two files that know the clamp, compiled without it; they take the place of the library's. */
#undef FLUORESCENT_CHANCE_MAX
#define FLUORESCENT_CHANCE_MAX 1.0f
#include "material/matte.c"
#include "material/surface.c"

static const struct range whole = {300, 830};

static void unclamped_chances_lose_light(void **state)
{
    (void)state;
    struct scene *scene = saturated_box_scene(whole, 16);
    /* mbdpt evaluates no run again, and needs no clamp. */
    struct batches reference = box_mean_below(scene, whole, box_settings("mbdpt", 2), 18),
                   other = box_mean_below(scene, whole, box_settings("bdpt", 2), 18);
    struct finding found = batches_versus(&other, &reference, (struct power){.sees_error = 0.05}, 1);
    print_message("found %g, wanted %g, z %.1f\n", other.mean, reference.mean, found.z);
    assert_true(other.mean < reference.mean && !found.agrees);
    scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(unclamped_chances_lose_light)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
