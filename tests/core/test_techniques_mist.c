/* Scattering inside of volumes keeps what techniques promise (algorithm.md §13), in a mist that camera and lamp are in, with a cloud of another colour
   in it. */
#include "boxes.h"
#include "ledger.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

int main(void)
{
    static struct subject mist_mbdpt = {.name = "mbdpt",
                                        .lanes = 1,
                                        .edges = 4,
                                        .samples = 28,
                                        .place = misty_box_scene,
                                        .sees_error = 0.04},
                          mist_mbdpt_4 = {.name = "mbdpt",
                                          .lanes = 4,
                                          .edges = 4,
                                          .samples = 22,
                                          .place = misty_box_scene,
                                          .sees_error = 0.04},
                          mist_bdpt = {.name = "bdpt",
                                       .lanes = 1,
                                       .edges = 5,
                                       .samples = 8,
                                       .place = misty_box_scene,
                                       .sees_error = 0.04},
                          mist_bdpt_4 = {.name = "bdpt",
                                         .lanes = 4,
                                         .edges = 4,
                                         .samples = 32,
                                         .place = misty_box_scene,
                                         .sees_error = 0.04};
    const struct CMUnitTest tests[] = {TEST_OF(mist_mbdpt), TEST_OF(mist_mbdpt_4), TEST_OF(mist_bdpt),
                                       TEST_OF(mist_bdpt_4)};
    if (getenv("STOKES_TEST_ONLY"))
        cmocka_set_test_filter(getenv("STOKES_TEST_ONLY"));
    return cmocka_run_group_tests(tests, NULL, NULL);
}
