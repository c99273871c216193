/* Runs through frosted glass are evaluated again at other wavelengths, whose refractions go elsewhere (algorithm.md §9): techniques still deliver what
   they promise. */
#include "boxes.h"
#include "ledger.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

int main(void)
{
    static struct subject frosted_bdpt = {.name = "bdpt",
                                          .lanes = 1,
                                          .edges = 5,
                                          .samples = 48,
                                          .place = frosted_box_scene,
                                          .sees_error = 0.05},
                          frosted_bdpt_4 = {.name = "bdpt",
                                            .lanes = 4,
                                            .edges = 5,
                                            .samples = 24,
                                            .place = frosted_box_scene,
                                            .sees_error = 0.05};
    const struct CMUnitTest tests[] = {TEST_OF(frosted_bdpt), TEST_OF(frosted_bdpt_4)};
    if (getenv("STOKES_TEST_ONLY"))
        cmocka_set_test_filter(getenv("STOKES_TEST_ONLY"));
    return cmocka_run_group_tests(tests, NULL, NULL);
}
