"""Statistics for whole renders: the twin of tests/core/statistics.h, with the same budget of false alarms and the same
meaning of power. Batches are rows, bins are columns."""

import functools
import math

import numpy as np

SUITE_FALSE_ALARM = 1e-6
SYSTEM_FAMILIES = 250
FALSE_ALARM = SUITE_FALSE_ALARM / 2 / SYSTEM_FAMILIES  # of one family (one call of an assert_… below)
DETECTION = 0.99  # chance with which an error is "seen"


def beta_lower(a, b, x):
    """Regularised incomplete beta function I_x(a, b), by its continued fraction (Abramowitz & Stegun 26.5.8)."""
    if x <= 0 or x >= 1:
        return float(x >= 1)
    if x >= (a + 1) / (a + b + 2):
        return 1 - beta_lower(b, a, 1 - x)
    front = math.exp(math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log1p(-x))
    tiny = 1e-300
    c, d = 1.0, 1 / (1 - (a + b) * x / (a + 1) or tiny)
    value = d
    for m in range(1, 10000):
        for term in (
            m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)),
        ):
            d = 1 / (1 + term * d or tiny)
            c = 1 + term / c or tiny
            value *= c * d
        if abs(c * d - 1) < 1e-15:
            break
    return front * value / a


def student_upper_tail(t, freedom):
    """P(T > t)."""
    tail = beta_lower(freedom / 2, 0.5, freedom / (freedom + t * t)) / 2
    return 1 - tail if t < 0 else tail


@functools.lru_cache(maxsize=None)
def student_critical(p, freedom):
    """t with P(T > t) = p, p < 1/2."""
    low, high = 0.0, 1.0
    while student_upper_tail(high, freedom) > p:
        high *= 2
    for _ in range(100):
        middle = (low + high) / 2
        if student_upper_tail(middle, freedom) > p:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def sidak(false_alarm, comparisons):
    """The share of a family's false-alarm rate that each comparison gets."""
    return -math.expm1(math.log1p(-false_alarm) / comparisons)


def means(batches):
    """Mean and standard error of every column."""
    batches = np.asarray(batches, dtype=float)
    return batches.mean(axis=0), batches.std(axis=0, ddof=1) / math.sqrt(len(batches))


class Family:
    """Comparisons that share one false-alarm rate. `sees` is the relative error that each promises to see, infinite where
    nothing is promised; `scale` is what errors are relative to."""

    def __init__(self, found, error, freedom, wanted, scale, sees, names, false_alarm=FALSE_ALARM):
        count = len(found)
        scale = np.broadcast_to(np.abs(np.asarray(scale, dtype=float)), (count,))
        self.names, self.found, self.wanted, self.error = names, found, np.broadcast_to(wanted, (count,)), error
        self.promised = np.broadcast_to(np.asarray(sees, dtype=float), (count,))
        share = sidak(false_alarm, count)
        critical = np.array([student_critical(share / 2, float(f)) for f in np.broadcast_to(freedom, (count,))])
        detection = np.array([student_critical(1 - DETECTION, float(f)) for f in np.broadcast_to(freedom, (count,))])
        difference = found - self.wanted
        # Nothing scattered: then it must be right to rounding (the file's values are 32-bit).
        exactly = (error == 0) & (np.abs(difference) <= 1e-6 * scale)
        with np.errstate(divide="ignore", invalid="ignore"):
            self.t = np.where(exactly, 0, difference / error)
            self.seen = np.where(exactly, 0, (critical + detection) * error / scale)
        self.alarms = ~(np.abs(self.t) <= critical)  # a NaN raises the alarm too
        self.blind = ~((self.seen <= self.promised) | np.isinf(self.promised))

    def samples_needed(self):
        """How many times the samples every promise takes to be kept, by the variance alone: what was found plays no part."""
        return max((self.seen / self.promised) ** 2)

    def lines(self):
        return [
            "%-14s found %.6g ± %.2g, wanted %.6g (%+.3f %%, t = %+.1f), sees %.3g %%%s%s"
            % (
                self.names[i],
                self.found[i],
                self.error[i],
                self.wanted[i],
                100 * (self.found[i] / self.wanted[i] - 1) if self.wanted[i] else math.inf,
                self.t[i],
                100 * self.seen[i],
                "  WRONG" if self.alarms[i] else "",
                "  TOO FEW SAMPLES: promises %.3g %%" % (100 * self.promised[i]) if self.blind[i] else "",
            )
            for i in range(len(self.found))
        ]

    def check(self, title):
        bad = self.alarms | self.blind
        text = "\n".join(self.lines())
        assert not bad.any(), "%s: %d of %d comparisons\n%s" % (title, bad.sum(), len(bad), text)


def against(batches, exact, sees, scale=None, names=None, false_alarm=FALSE_ALARM):
    """Is the batches' expectation `exact`, in every column?"""
    found, error = means(batches)
    names = names if names is not None else [str(i) for i in range(len(found))]
    exact = np.asarray(exact, dtype=float)
    return Family(found, error, len(batches) - 1, exact, exact if scale is None else scale, sees, names, false_alarm)


def versus(first, second, sees, scale=None, names=None, false_alarm=FALSE_ALARM):
    """Have both the same expectation, in every column (Welch's test)? `second` gives the scale unless told."""
    (a, ea), (b, eb) = means(first), means(second)
    va, vb = ea**2, eb**2
    with np.errstate(divide="ignore", invalid="ignore"):
        freedom = (va + vb) ** 2 / (va**2 / (len(first) - 1) + vb**2 / (len(second) - 1))
    freedom = np.where(np.isfinite(freedom), freedom, min(len(first), len(second)) - 1)
    names = names if names is not None else [str(i) for i in range(len(a))]
    return Family(a, np.sqrt(va + vb), freedom, b, b if scale is None else scale, sees, names, false_alarm)


def assert_unbiased(title, batches, exact, sees, **options):
    against(batches, exact, sees, **options).check(title)


def assert_same(title, first, second, sees, **options):
    versus(first, second, sees, **options).check(title)
