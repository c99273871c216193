"""Whole-image bias of `bdpt`, closely: a tenth of a percent against next event estimation in the open; against light tracing where all light comes by caustics. Path tracing's noise
allows nothing sharper where both ends are in glass than what test_agreement.py says."""

import numpy as np
import pytest

import scenes
import stats

BATCHES = 32
BINS = (4, 380, 780)
RESOLUTION = (48, 36)
SETTINGS = {"max_path": 8}


def measure(picture):
    """Radiance of the whole picture, and of each quarter of the spectrum."""
    spectrum = picture.bins()[1].mean(axis=(1, 2), dtype=np.float64)
    return np.concatenate([[spectrum.mean()], spectrum])


def in_the_open(path):
    scenes.box(path, RESOLUTION, specular=False, **SETTINGS)


def lamp_in_glass(path):
    scenes.glass_box(path, "lamp", RESOLUTION, looks_down=True, **SETTINGS)


# Scene, lanes of `bdpt`, who is to be trusted there, its samples and those of `bdpt`, and the errors that the whole and the bins would show. Light tracing sees a picture
# as a whole less well than `bdpt` does.
CASES = {
    "in the open": (in_the_open, 4, "pt_nee", 2048, 2048, 0.001, 0.005),
    "lamp in dispersive glass": (lamp_in_glass, 1, "lt", 2048, 512, 0.008, 0.02),
}


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_the_whole_image_is_unbiased(core, tmp_path, name):
    write, lanes, reference, many, samples, whole, each = CASES[name]
    path = tmp_path / "scene.stokes"
    write(path)
    wanted = core.batches(path, reference, BATCHES, many, BINS, measure, lanes=4)
    found = core.batches(path, "bdpt", BATCHES, samples, BINS, measure, first_seed=1000, lanes=lanes)
    stats.assert_same(name, found, wanted, [whole] + [each] * BINS[0])
