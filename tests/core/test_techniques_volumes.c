/* Scattering inside of volumes keeps what techniques promise (algorithm.md §13): in a mist that camera and lamp are in, with a cloud of another colour in it,
   and inside of dispersive glass. */
#include "boxes.h"
#include "ledger.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

int main(void)
{
    static struct subject
        mist_mbdpt = {"mbdpt", 1, false, false, 4, 28, KERNEL_CONSTANT, false, misty_box_scene, 0.04},
        mist_mbdpt_4 = {"mbdpt", 4, false, false, 4, 12, KERNEL_CONSTANT, false, misty_box_scene, 0.04},
        mist_bdpt = {"bdpt", 1, false, false, 5, 24, KERNEL_CONSTANT, false, misty_box_scene, 0.04},
        mist_bdpt_4 = {"bdpt", 4, false, false, 4, 12, KERNEL_CONSTANT, false, misty_box_scene, 0.04},
        bottle_mbdpt_4 = {"mbdpt", 4, false, false, 5, 24, KERNEL_CONSTANT, false, bottle_box_scene, 0.06},
        bottle_bdpt = {"bdpt", 1, false, false, 5, 28, KERNEL_CONSTANT, false, bottle_box_scene, 0.06},
        bottle_bdpt_4 = {"bdpt", 4, false, false, 5, 24, KERNEL_CONSTANT, false, bottle_box_scene, 0.06};
    const struct CMUnitTest tests[] = {TEST_OF(mist_mbdpt),   TEST_OF(mist_mbdpt_4),   TEST_OF(mist_bdpt),
                                       TEST_OF(mist_bdpt_4),  TEST_OF(bottle_mbdpt_4), TEST_OF(bottle_bdpt),
                                       TEST_OF(bottle_bdpt_4)};
    if (getenv("STOKES_TEST_ONLY"))
        cmocka_set_test_filter(getenv("STOKES_TEST_ONLY"));
    return cmocka_run_group_tests(tests, NULL, NULL);
}
