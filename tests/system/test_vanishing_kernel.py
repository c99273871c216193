"""What the kernel of `mbdpt` does to a picture goes with it: with d → 0 it tends to that of `bdpt`, which has none. A blue lamp, glass and a dye in a box: a wide
kernel spreads the lamp's light over wavelengths at which nothing shines, and over others at which more of it reaches the dye."""

import numpy as np

import exact
import scenes
import stats

LAMP = exact.Table([440, 444, 456, 460], [0, 1, 1, 0])
BINS = (18, 340, 700)  # of 20 nm
NAMES = ["lamp's band", "dye's", "neither", "whole"]
WIDTHS = [100, 20, 5, 1]  # half-widths, nm
RENDERS, FEWER, SAMPLES = 32, 16, 48  # fewer where there is more to see
SEES = 0.02  # of the whole light, with the narrowest; the widest moves a third of it


def measure(picture):
    """Light by what shines there: 440–460 nm, 500–580 nm, no other."""
    bins = picture.bins()[1].mean(axis=(1, 2), dtype=np.float64)
    lamp, dye, whole = bins[5], bins[8:12].sum(), bins.sum()
    return np.array([lamp, dye, whole - lamp - dye, whole])


def biases(core, path):
    """By half-width: what `mbdpt` has more than `bdpt`, as a share of the whole light, with the same seeds: most of the noise is common to both."""

    def render(integrator, renders, **options):
        return core.batches(path, integrator, renders, SAMPLES, BINS, measure, lanes=4, **options)

    exactly = render("bdpt", RENDERS)
    found = [render("mbdpt", RENDERS if d == WIDTHS[-1] else FEWER, d0=d) for d in WIDTHS]
    return [(rows - exactly[: len(rows)]) / exactly[:, 3].mean() for rows in found]


def against_nothing(rows, sees=np.inf, columns=slice(None)):
    names = NAMES[columns]
    return stats.against(rows[:, columns], np.zeros(len(names)), sees, scale=1, names=names)


def test_mbdpt_tends_to_bdpt_as_its_kernel_narrows(core, tmp_path):
    path = tmp_path / "box.stokes"
    scenes.glass_box(path, "block", (16, 12), looks_down=True, light=LAMP, max_path=5, shrink=0)
    bias = biases(core, path)
    widest = against_nothing(bias[0])
    assert widest.alarms.all() and widest.found[0] < -10 * SEES, "\n".join(widest.lines())
    # Step by step, the lamp's band lacks less and less light goes where none should be.
    for wide, narrow in zip(bias, bias[1:]):
        less = against_nothing(wide - narrow[:FEWER], columns=slice(0, 3, 2))
        assert less.alarms.all() and less.found[0] < 0 < less.found[1], "\n".join(less.lines())
    against_nothing(bias[-1], SEES).check("%g nm" % WIDTHS[-1])
