"""The statistics themselves: quiet on the truth, loud on the error they promise to see, and never satisfied by too little."""

import math

import numpy as np
import pytest

import stats

TRUTH = np.array([2.0, 3.0, 5.0])


def exponential_batches(seed, rows, samples):
    """Batch means of exponential variates; their relative error is 1/√samples."""
    return np.random.default_rng(seed).gamma(samples, 1 / samples, (rows, 3)) * TRUTH


def test_student_has_its_published_values():
    assert stats.student_critical(0.025, 10) == pytest.approx(2.228138851964939, rel=1e-10)
    assert stats.student_critical(0.0005, 31) == pytest.approx(3.633456, rel=1e-6)
    assert stats.student_upper_tail(3, 1) == pytest.approx(0.5 - math.atan(3) / math.pi, rel=1e-12)
    assert stats.student_upper_tail(40, 31) < 1e-25


def test_truth_is_left_alone_and_one_percent_is_not():
    fired = 0
    for seed in range(100):
        batches = exponential_batches(seed, 48, 60000)
        stats.assert_unbiased("truth", batches, TRUTH, 0.01)
        fired += stats.against(batches, TRUTH * 1.01, 0.01).alarms.all()
    assert fired > 85  # three columns, each seen with at least 99 %


def test_equal_means_agree_and_different_ones_do_not():
    for seed in range(20):
        first, second = exponential_batches(seed, 48, 90000), exponential_batches(seed + 1000, 64, 90000)
        stats.assert_same("same", first, second, 0.01)
        assert stats.versus(first * 1.015, second, 0.01).alarms.any()


def test_too_few_samples_fail_even_when_they_agree():
    batches = exponential_batches(1, 48, 100)
    assert not stats.against(batches, TRUTH, math.inf).alarms.any()
    with pytest.raises(AssertionError, match="TOO FEW SAMPLES"):
        stats.assert_unbiased("blind", batches, TRUTH, 0.01)


def test_a_pilot_tells_how_many_samples_a_promise_takes():
    few = stats.against(exponential_batches(1, 96, 600), TRUTH, 0.01).samples_needed()
    enough = stats.against(exponential_batches(2, 96, round(600 * few * 1.5)), TRUTH, 0.01)
    assert few > 10 and not enough.blind.any() and 0.4 < enough.samples_needed() <= 1


def test_what_is_not_finite_fails():
    batches = exponential_batches(1, 48, 30000)
    batches[3, 1] = math.nan
    with pytest.raises(AssertionError, match="WRONG"):
        stats.assert_unbiased("nan", batches, TRUTH, math.inf)


def test_false_alarms_come_as_often_as_stated():
    alarms = sum(
        stats.against(exponential_batches(seed, 24, 1000), TRUTH, math.inf, false_alarm=0.1).alarms.any()
        for seed in range(1000)
    )
    assert 50 < alarms < 160  # binomial: 100 ± 9.5
