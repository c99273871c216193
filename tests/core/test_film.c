/* The film in memory: sums that no order of threads can change, the overflow rule, resolving, and the pixel
   filter. */
#include "film_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "base/thread.h"
#include "statistics.h"

#include <cmocka.h>

#define UNITS ((double)((int64_t)1 << FILM_FRACTION_BITS))
#define KAPPA 0.01

/* --- Sums ------------------------------------------------------------------------------------------ */

struct crowd {
    struct film *film;
    size_t step; /* the order in which the work is met */
    double strength;
};

static void add_some(void *context, size_t index, int worker)
{
    const struct crowd *crowd = context;
    (void)worker;
    uint64_t at = index * crowd->step % 20011 * 16;
    double u[16];
    for (uint64_t i = 0; i < 16; i++)
        u[i] = independent(1, at + i);
    int x = (int)(u[0] * 4), y = (int)(u[1] * 3); /* few pixels, much contention */
    double bin[8];
    struct film_sample sample = {.bin = bin};
    film_sample_clear(crowd->film, &sample);
    for (int i = 0; i < 3; i++)
        film_sample_add(crowd->film, &sample, crowd->strength * u[2 + i], (float)(360 + 470 * u[5 + i]),
                        KAPPA);
    sample.alpha = u[8];
    film_add(crowd->film, x, y, &sample);
    film_splat(crowd->film, y, x, crowd->strength * u[9], (float)(350 + 400 * u[10]), KAPPA);
    if (index % 1000 == 0)
        film_splat(crowd->film, x, y, index % 2000 ? (double)NAN : -1, 500, KAPPA);
}

static void sums_are_the_same_bits_in_any_order_of_threads(void **state)
{
    (void)state;
    const double strengths[2] = {2, 0x1p28}; /* the second drives many sums into the limit */
    for (int s = 0; s < 2; s++) {
        struct film *one = kit_film(kit_whole, 8), *many = kit_film(kit_whole, 8);
        struct crowd forward = {one, 1, strengths[s]}, jumping = {many, 7919, strengths[s]};
        thread_run(1, 20011, add_some, NULL, &forward);
        thread_run(4, 20011, add_some, NULL, &jumping);
        assert_true(one->rejected > 0);
        assert_true((one->saturated > 0) == (s == 1));
        /* The rejected ones sit at fixed indices of the loop, so both see the same number of them. */
        assert_true(kit_same(one, many));
        film_destroy(one);
        film_destroy(many);
    }
}

static void a_sample_lands_rounded_once_in_its_pixel_and_bin(void **state)
{
    (void)state;
    struct film *film = kit_film(kit_corner, 4); /* bins of 100 nm */
    double bin[4];
    struct film_sample sample = {.bin = bin};
    film_sample_clear(film, &sample);
    float cmf[3];
    cmf_eval(512, cmf);
    for (int i = 0; i < 3; i++)
        film_sample_add(film, &sample, 1e-9, 512, KAPPA); /* each alone would round to nothing */
    film_sample_add(film, &sample, 0.5, 780, KAPPA);
    film_sample_add(film, &sample, 0.5, 379.9f, KAPPA); /* in no bin */
    sample.alpha = 1;
    film_add(film, 8 + 3, 10 + 2, &sample);
    film_add(film, 7, 10, &sample); /* outside the border */
    film_add(film, 37, 10, &sample);
    film_add(film, 8, 28, &sample);
    const int64_t *sum = film->sum + (2 * 29 + 3) * film->channels;
    assert_int_equal(sum[3], (int64_t)UNITS);
    assert_int_equal(sum[4], 0);
    assert_int_equal(sum[5], 1); /* 3e-9 · 2^28 = 0.8 */
    assert_int_equal(sum[6], 0);
    assert_int_equal(sum[7], (int64_t)(UNITS / 2));
    int64_t total = 0;
    for (int i = 0; i < film->width * film->height * film->channels; i++)
        total += i % film->channels >= 3 ? film->sum[i] : 0;
    assert_int_equal(total, (int64_t)(UNITS * 1.5) + 1);
    film_clear(film);
    assert_int_equal(sum[3], 0);
    film_destroy(film);
}

static void whatever_is_not_finite_or_negative_is_rejected_and_counted(void **state)
{
    (void)state;
    struct film *film = kit_film(kit_whole, 4), *empty = kit_film(kit_whole, 4);
    const double bad[4] = {NAN, INFINITY, -INFINITY, -1};
    double bin[4];
    for (int i = 0; i < 4; i++) {
        struct film_sample sample = {.bin = bin};
        film_sample_clear(film, &sample);
        film_sample_add(film, &sample, bad[i], 310, KAPPA); /* where no cmf and no bin is */
        film_sample_add(film, &sample, bad[i], 500, KAPPA);
        film_add(film, 1, 1, &sample);
        film_splat(film, 1, 1, bad[i], 500, KAPPA);
    }
    assert_int_equal(film->rejected, 8);
    film->rejected = 0;
    assert_true(kit_same(film, empty));
    film_destroy(film);
    film_destroy(empty);
}

static void an_undershoot_that_rounds_to_zero_is_no_reason_to_reject(void **state)
{
    (void)state;
    struct film *film = kit_film(kit_whole, 0);
    film_add(film, 0, 0, &(struct film_sample){.xyz = {0.5, 0.25, -1e-21}, .alpha = 1});
    assert_int_equal(film->rejected, 0);
    assert_int_equal(film->sum[0], (int64_t)(UNITS / 2));
    assert_int_equal(film->sum[2], 0);
    film_destroy(film);
}

static void a_sum_that_reaches_the_limit_stays_there_and_is_counted_once(void **state)
{
    (void)state;
    struct film *film = kit_film(kit_whole, 1);
    for (int i = 0; i < 5; i++)
        film_splat(film, 2, 2, 0x1p33, 500, KAPPA);
    film_splat(film, 2, 2, 1e300, 500, KAPPA);
    const int64_t *sum = film->sum + (2 * 40 + 2) * film->channels;
    assert_true(sum[4] == FILM_SUM_MAX);
    uint64_t expected = 0;
    for (int i = 0; i < film->channels; i++)
        expected += sum[i] == FILM_SUM_MAX;
    assert_true(film->saturated == expected && expected >= 1);
    assert_int_equal(film->rejected, 0);
    film_destroy(film);
}

static void resolving_gives_the_mean_in_the_working_space(void **state)
{
    (void)state;
    struct film *film = kit_film(kit_whole, 0);
    struct working_space space;
    working_space_rec709(&space);
    int64_t *sum = film->sum + (29 * 40 + 39) * film->channels;
    for (int i = 0; i < 3; i++) /* XYZ of the white */
        sum[i] =
            (int64_t)(UNITS * 64 *
                      (space.rgb_to_xyz[3 * i] + space.rgb_to_xyz[3 * i + 1] + space.rgb_to_xyz[3 * i + 2]));
    sum[3] = (int64_t)(UNITS * 32);
    float *rgba = calloc(40 * 30 * 4, sizeof *rgba);
    film_resolve(film, &space, 64, rgba);
    const float *pixel = rgba + (29 * 40 + 39) * 4;
    for (int i = 0; i < 3; i++)
        assert_true(fabsf(pixel[i] - 1) < 1e-6f);
    assert_true(pixel[3] == 0.5f && rgba[0] == 0);
    film_resolve(film, &space, 0, rgba);
    assert_true(pixel[0] == 0 && pixel[3] == 0);
    free(rgba);
    film_destroy(film);
}

/* Splats that are kept apart are merged into the bits that they have together. */
static void splats_apart_and_together_have_the_same_bits(void **state)
{
    (void)state;
    struct film *together = kit_film(kit_whole, 8), *apart = kit_film(kit_whole, 8),
                *splats = kit_film(kit_whole, 8);
    struct crowd one = {together, 1, 0x1p28}, two = {apart, 1, 0x1p28};
    apart->splats = splats;
    thread_run(2, 20011, add_some, NULL, &one);
    thread_run(2, 20011, add_some, NULL, &two);
    apart->splats = NULL;
    apart->end_sample = together->end_sample = 1;
    assert_true(film_merge(splats, apart, NULL));
    assert_true(kit_same(splats, together));
    film_destroy(together);
    film_destroy(apart);
    film_destroy(splats);
}

/* A pass that was broken off: its pixels, and splats of a quarter of the light paths. */
static void a_part_of_a_pass_shows_its_pixels_and_is_not_merged(void **state)
{
    (void)state;
    struct film *part = kit_film(kit_whole, 2), *splats = kit_film(kit_whole, 2);
    uint8_t done[40 * 30] = {[41] = 1};
    size_t at = 41 * (size_t)part->channels;
    stokes_error err;
    part->splats = splats;
    for (int c = 0; c < part->channels; c++) {
        part->sum[at + (size_t)c] = 1000 + c;
        splats->sum[at + (size_t)c] = 10;
        splats->sum[c] = 7; /* of pixel 0, which was not done */
    }
    splats->sum[at] = FILM_SUM_MAX / 2;
    film_close_part(part, done, 0.25);
    assert_true(part->sum[at] == FILM_SUM_MAX && part->sum[at + 1] == 1041 && part->sum[at + 5] == 1045);
    assert_true(part->sum[0] == 0 && part->sum[3] == 0);
    assert_int_equal(film_divisor(part), 1);
    splats->first_sample = 0;
    splats->end_sample = 1;
    assert_false(film_merge(splats, part, &err));
    assert_non_null(strstr(err.text, "broken off"));
    film_destroy(part);
    film_destroy(splats);
}

static void what_is_no_picture_is_refused(void **state)
{
    (void)state;
    const int bad[5][4] = {{-1, 0, 4, 4}, {0, 0, 41, 4}, {5, 0, 5, 4}, {0, 9, 4, 8}, {0, 0, 4, 31}};
    stokes_error err;
    for (int i = 0; i < 5; i++)
        assert_null(film_create(40, 30, bad[i], 0, kit_range, &err));
    assert_string_equal(err.property, "border");
    assert_null(film_create(0, 30, kit_whole, 0, kit_range, &err));
    assert_null(film_create(1 << 20, 1 << 20, kit_whole, 0, kit_range, &err));
    assert_null(film_create(40, 30, kit_whole, -1, kit_range, &err));
    assert_null(film_create(40, 30, kit_whole, FILM_BINS_MAX + 1, kit_range, &err));
    assert_null(film_create(40, 30, kit_whole, 4, (struct range){500, 500}, &err));
    assert_null(film_create(40, 30, kit_whole, 4, (struct range){NAN, 500}, &err));
}

/* --- The filter ------------------------------------------------------------------------------------ */

/* Harris 1978, integrated: written apart from filter.c. */
static double window_cdf(double x)
{
    const double pi = acos(-1), a[4] = {0.35875, -0.48829, 0.14128, -0.01168};
    double sum = a[0] * x;
    for (int k = 1; k < 4; k++)
        sum += a[k] * sin(2 * pi * k * x) / (2 * pi * k);
    return sum / a[0]; /* x from 0 to 1 */
}

static void filter_offsets_follow_the_blackman_harris_window(void **state)
{
    (void)state;
    enum { BINS = 30, DRAWS = 400000 };
    const float width = 1.5f; /* Blender's: the window spans twice that */
    double observed[BINS] = {0}, expected[BINS];
    for (int i = 0; i < BINS; i++)
        expected[i] = DRAWS * (window_cdf((i + 1.0) / BINS) - window_cdf((double)i / BINS));
    for (uint64_t i = 0; i < DRAWS; i++) {
        double offset = (double)film_filter_sample(width, (float)independent(3, i));
        assert_true(fabs(offset) <= (double)width);
        int bin = (int)((offset / (2 * (double)width) + 0.5) * BINS);
        observed[bin < BINS ? bin : BINS - 1]++;
    }
    assert_distributed(observed, expected, BINS, (struct power){.sees_error = 0.02});
}

static void filter_inverts_its_cdf_and_is_symmetric(void **state)
{
    (void)state;
    float last = -1;
    for (int i = 0; i <= 4096; i++) {
        float u = (float)i / 4096, offset = film_filter_sample(0.5f, u);
        assert_true(offset >= last || i == 0);
        last = offset;
        assert_true(fabs(window_cdf((double)offset + 0.5) - (double)u) < 2e-6);
        assert_true(fabsf(offset + film_filter_sample(0.5f, 1 - u)) < 1e-5f);
    }
}

/* One bright point seen by both: its share of each pixel must be the same from the camera and from the light. */
static void splats_reach_a_pixel_as_often_as_its_camera_samples_do(void **state)
{
    (void)state;
    enum { PIXELS = 9, BATCHES = 64, DRAWS = 20000 };
    const float widths[3] = {1.5f, 0.8f, 3.7f}, spot = 0.25f; /* the point is spread over ± spot/2 */
    for (int w = 0; w < 3; w++) {
        struct batches camera[PIXELS] = {0}, light[PIXELS] = {0};
        for (uint64_t batch = 0; batch < BATCHES; batch++) {
            double seen[PIXELS] = {0}, sent[PIXELS] = {0};
            for (uint64_t i = 0; i < DRAWS; i++) {
                uint64_t seed = (uint64_t)w * BATCHES + batch;
                float from = 4.3f + spot * ((float)independent(seed, 3 * i) - 0.5f), weight;
                int pixel = film_filter_pixel(widths[w], from, (float)independent(seed, 3 * i + 1), &weight);
                if (pixel >= 0 && pixel < PIXELS)
                    sent[pixel] += (double)weight / DRAWS;
                float offset = film_filter_sample(widths[w], (float)independent(seed, 3 * i + 2));
                for (int x = 0; x < PIXELS; x++)
                    seen[x] +=
                        fabsf((float)x + 0.5f + offset - 4.3f) < spot / 2 ? 1 / (double)spot / DRAWS : 0;
            }
            for (int x = 0; x < PIXELS; x++) {
                batches_add(&camera[x], seen[x]);
                batches_add(&light[x], sent[x]);
            }
        }
        assert_same(camera, light, PIXELS, (struct power){.sees_error = 0.05, .scale = 0.3});
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_are_the_same_bits_in_any_order_of_threads),
        cmocka_unit_test(a_sample_lands_rounded_once_in_its_pixel_and_bin),
        cmocka_unit_test(whatever_is_not_finite_or_negative_is_rejected_and_counted),
        cmocka_unit_test(an_undershoot_that_rounds_to_zero_is_no_reason_to_reject),
        cmocka_unit_test(a_sum_that_reaches_the_limit_stays_there_and_is_counted_once),
        cmocka_unit_test(resolving_gives_the_mean_in_the_working_space),
        cmocka_unit_test(splats_apart_and_together_have_the_same_bits),
        cmocka_unit_test(a_part_of_a_pass_shows_its_pixels_and_is_not_merged),
        cmocka_unit_test(what_is_no_picture_is_refused),
        cmocka_unit_test(filter_offsets_follow_the_blackman_harris_window),
        cmocka_unit_test(splats_reach_a_pixel_as_often_as_its_camera_samples_do),
        cmocka_unit_test(filter_inverts_its_cdf_and_is_symmetric),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
