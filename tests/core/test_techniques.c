/* Every technique delivers what its density claims, class by class of labelled paths, and its weights are those of the plain products
   (algorithm.md §8). STOKES_TEST_VERBOSE=1 prints every cell. */
#include "boxes.h"
#include "ledger.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

int main(void)
{
    static struct subject
        mbdpt = {.name = "mbdpt", .lanes = 1, .edges = 5, .samples = 20},
        mbdpt_4 = {.name = "mbdpt", .lanes = 4, .edges = 5, .samples = 16},
        mbdpt_inner = {.name = "mbdpt", .lanes = 8, .inner = true, .edges = 5, .samples = 20},
        mbdpt_shared = {.name = "mbdpt", .lanes = 1, .edges = 5, .samples = 12, .shared = true},
        mbdpt_box =
            {.name = "mbdpt", .lanes = 8, .inner = true, .edges = 5, .samples = 24, .kernel = KERNEL_BOX},
        mbdpt_asymmetric = {.name = "mbdpt",
                            .lanes = 8,
                            .inner = true,
                            .edges = 5,
                            .samples = 24,
                            .kernel = KERNEL_ASYMMETRIC},
        mbdpt_glass = {.name = "mbdpt", .lanes = 4, .lenses = true, .edges = 5, .samples = 72},
        bdpt = {.name = "bdpt", .lanes = 1, .edges = 5, .samples = 16},
        bdpt_4 = {.name = "bdpt", .lanes = 4, .edges = 5, .samples = 20},
        bdpt_8 = {.name = "bdpt", .lanes = 8, .edges = 5, .samples = 12},
        bdpt_glass = {.name = "bdpt", .lanes = 1, .lenses = true, .edges = 7, .samples = 64},
        bdpt_4_glass = {.name = "bdpt", .lanes = 4, .lenses = true, .edges = 7, .samples = 64},
        bdpt_4_few =
            {.name = "bdpt", .lanes = 4, .edges = 5, .samples = 16, .sees_error = 0.05, .light_paths = 0.25},
        bdpt_glass_many = {.name = "bdpt",
                           .lanes = 1,
                           .lenses = true,
                           .edges = 7,
                           .samples = 14,
                           .sees_error = 0.05,
                           .light_paths = 2.5},
        mbdpt_4_few = {
            .name = "mbdpt", .lanes = 4, .edges = 5, .samples = 10, .sees_error = 0.04, .light_paths = 0.5};
    const struct CMUnitTest tests[] = {
        TEST_OF(mbdpt),      TEST_OF(mbdpt_4),          TEST_OF(mbdpt_inner), TEST_OF(mbdpt_shared),
        TEST_OF(mbdpt_box),  TEST_OF(mbdpt_asymmetric), TEST_OF(mbdpt_glass), TEST_OF(bdpt),
        TEST_OF(bdpt_4),     TEST_OF(bdpt_8),           TEST_OF(bdpt_glass),  TEST_OF(bdpt_4_glass),
        TEST_OF(bdpt_4_few), TEST_OF(bdpt_glass_many),  TEST_OF(mbdpt_4_few)};
    if (getenv("STOKES_TEST_ONLY"))
        cmocka_set_test_filter(getenv("STOKES_TEST_ONLY"));
    return cmocka_run_group_tests(tests, NULL, NULL);
}
