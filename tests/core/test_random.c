/* Sample points: uniform, stratified over the samples of a pixel, and independent between pixels, pairs and seeds. */
#include "base/random.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include "statistics.h"

#include <cmocka.h>

enum { LOG = 8, SAMPLES = 1 << LOG };

/* In a (0,2)-sequence every elementary interval of area 1/SAMPLES holds one of the first SAMPLES points. */
static void a_pair_of_dimensions_is_a_net(void **state)
{
    (void)state;
    for (uint32_t pixel = 0; pixel < 50; pixel++)
        for (int wide = 0; wide <= LOG; wide++) {
            unsigned char seen[SAMPLES] = {0};
            for (uint32_t sample = 0; sample < SAMPLES; sample++) {
                struct random_path path = random_path(3, pixel, sample);
                int x = (int)(random_at(path, 6) * (float)(1 << wide));
                int y = (int)(random_at(path, 7) * (float)(1 << (LOG - wide)));
                assert_int_equal(seen[(x << (LOG - wide)) + y]++, 0);
            }
        }
}

/* One sample each of many pixels: what a single path sees is uniform, and dimensions do not know of each other. */
static void assert_pairs_are_uniform(uint32_t a, uint32_t b, uint32_t sample)
{
    enum { SIDE = 16, COUNT = 1 << 20 };
    static double counts[SIDE * SIDE], expected[SIDE * SIDE];
    memset(counts, 0, sizeof counts);
    for (uint32_t pixel = 0; pixel < COUNT; pixel++) {
        struct random_path path = random_path(1, pixel, sample);
        counts[(int)(random_at(path, a) * SIDE) * SIDE + (int)(random_at(path, b) * SIDE)]++;
    }
    for (int i = 0; i < SIDE * SIDE; i++)
        expected[i] = (double)COUNT / (SIDE * SIDE);
    assert_distributed(counts, expected, SIDE * SIDE, (struct power){.sees_error = 0.02});
}

static void dimensions_are_independent_over_pixels(void **state)
{
    (void)state;
    assert_pairs_are_uniform(0, 1, 0);
    assert_pairs_are_uniform(0, 1, 77);
    assert_pairs_are_uniform(1, 2, 5);
    assert_pairs_are_uniform(4, 65536, 5);
}

static void seeds_and_samples_give_other_points(void **state)
{
    (void)state;
    int same = 0;
    for (uint32_t pixel = 0; pixel < 1000; pixel++) {
        same += random_at(random_path(1, pixel, 0), 0) == random_at(random_path(2, pixel, 0), 0);
        same += random_at(random_path(1, pixel, 0), 0) == random_at(random_path(1, pixel, 1), 0);
    }
    assert_int_equal(same, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pair_of_dimensions_is_a_net),
        cmocka_unit_test(dimensions_are_independent_over_pixels),
        cmocka_unit_test(seeds_and_samples_give_other_points),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
