/* Scattering inside of volumes keeps what techniques promise (algorithm.md §13), inside of dispersive glass. */
#include "boxes.h"
#include "ledger.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

int main(void)
{
    static struct subject bottle_mbdpt_4 = {.name = "mbdpt",
                                            .lanes = 4,
                                            .edges = 5,
                                            .samples = 24,
                                            .place = bottle_box_scene,
                                            .sees_error = 0.06},
                          bottle_bdpt = {.name = "bdpt",
                                         .lanes = 1,
                                         .edges = 5,
                                         .samples = 28,
                                         .place = bottle_box_scene,
                                         .sees_error = 0.06},
                          bottle_bdpt_4 = {.name = "bdpt",
                                           .lanes = 4,
                                           .edges = 5,
                                           .samples = 24,
                                           .place = bottle_box_scene,
                                           .sees_error = 0.06};
    const struct CMUnitTest tests[] = {TEST_OF(bottle_mbdpt_4), TEST_OF(bottle_bdpt), TEST_OF(bottle_bdpt_4)};
    if (getenv("STOKES_TEST_ONLY"))
        cmocka_set_test_filter(getenv("STOKES_TEST_ONLY"));
    return cmocka_run_group_tests(tests, NULL, NULL);
}
