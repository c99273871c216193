/* Where a dye absorbs all of a band, c·a = 1, it reflects nothing there: what a run brings at other wavelengths hangs on the clamp of its labels'
   chances (algorithm.md §9). Techniques deliver what they promise. */
#include "boxes.h"
#include "ledger.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

int main(void)
{
    static struct subject saturated_bdpt = {.name = "bdpt",
                                            .lanes = 1,
                                            .edges = 5,
                                            .samples = 12,
                                            .place = saturated_box_scene},
                          saturated_bdpt_4 = {.name = "bdpt",
                                              .lanes = 4,
                                              .edges = 5,
                                              .samples = 16,
                                              .place = saturated_box_scene};
    const struct CMUnitTest tests[] = {TEST_OF(saturated_bdpt), TEST_OF(saturated_bdpt_4)};
    if (getenv("STOKES_TEST_ONLY"))
        cmocka_set_test_filter(getenv("STOKES_TEST_ONLY"));
    return cmocka_run_group_tests(tests, NULL, NULL);
}
