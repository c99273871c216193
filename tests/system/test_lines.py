"""Lamps of lines 1 nm wide, a black light's and sodium's, in a sphere whose walls fluoresce: every integrator finds the exact answer, and in no more samples than these."""

import numpy as np
import pytest

import exact
import scenes
import stats

BINS = (106, 300, 830)
GROUPS = {"365 nm": (360, 370), "dye": (500, 580), "589 nm": (585, 595)}
RENDERS = 32
# Of 16 × 16 pixels, by integrator and lanes. mbdpt's kernel has to be narrow beside the lines.
SAMPLES = {("pt", 1): 128, ("pt_nee", 1): 32, ("pt_nee", 4): 20, ("lt", 1): 40, ("mbdpt", 1): 16, ("bdpt", 1): 12, ("bdpt", 4): 8}
SEES = (0.12, 0.08, 0.14)
SETTINGS = {"d0": 0.25, "shrink": 0, "max_path": 16, "roulette_start": 3}


class Lines:
    """Lines of 1 nm at whole nm, which the grid's cells fill."""

    powers = {365: 1.0, 589: 0.5}

    def on_grid(self):
        return sum(power * (np.abs(exact.GRID - nm) < 0.5) for nm, power in self.powers.items())

    def message(self):
        return {
            "sum": [{"scale": power, "of": {"line": {"center": nm, "width": 1}}} for nm, power in self.powers.items()]
        }


def grouped(spectrum):
    """Sums over groups of bins of [bin, …]."""
    centres = np.linspace(BINS[1], BINS[2], 2 * BINS[0] + 1)[1::2]
    return [spectrum[(centres > low) & (centres < high)].sum(axis=0) for low, high in GROUPS.values()]


def measure(picture):
    return np.array(grouped(picture.bins()[1].mean(axis=(1, 2), dtype=np.float64)))


@pytest.mark.parametrize("integrator, lanes", SAMPLES)
def test_lines_are_found_by_every_integrator(core, tmp_path, integrator, lanes):
    path = tmp_path / "sphere.stokes"
    radiance = scenes.sphere_with_patch(path, scenes.MATERIALS["fluorescent"], Lines(), **SETTINGS)
    wanted = np.array(grouped(exact.per_bin(radiance, BINS)))
    found = core.batches(path, integrator, RENDERS, SAMPLES[integrator, lanes], BINS, measure, lanes=lanes)
    stats.assert_unbiased("%s, %d lanes" % (integrator, lanes), found, wanted, SEES, names=list(GROUPS))
