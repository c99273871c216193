"""Whole-image bias of `bdpt`, closely: X, Y and Z of the whole picture. In the open next event estimation allows a tenth of a percent;
where all light comes by caustics, light tracing a percent. Where both ends are in glass test_agreement.py is as sharp as path tracing's
noise allows."""

import numpy as np
import pytest

import scenes
import stats

BATCHES = 64
RESOLUTION = (48, 36)
SETTINGS = {"max_path": 8}


def measure(picture):
    """X, Y and Z of the whole picture, to one scale."""
    first, end = picture.samples()
    return picture.sums()[:3].mean(axis=(1, 2), dtype=np.float64) / (end - first)


def in_the_open(path):
    scenes.box(path, RESOLUTION, specular=False, **SETTINGS)


def lamp_in_glass(path):
    scenes.glass_box(path, "lamp", RESOLUTION, looks_down=True, **SETTINGS)


# Scene, options of `bdpt`, who is to be trusted there, its samples and those of `bdpt`, and the errors in X, Y and Z that would show. Light
# tracing sees a picture as a whole less well than `bdpt` does.
CASES = {
    "in the open": (in_the_open, {"lanes": 4}, "pt_nee", 640, 640, (0.001, 0.001, 0.0015)),
    "lamp in dispersive glass": (lamp_in_glass, {"light_paths": 16}, "lt", 1024, 24, (0.012, 0.01, 0.015)),
}


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_the_whole_image_is_unbiased(core, tmp_path, name):
    write, options, reference, many, samples, sees = CASES[name]
    path = tmp_path / "scene.stokes"
    write(path)
    wanted = core.batches(path, reference, BATCHES, many, None, measure, lanes=4)
    found = core.batches(path, "bdpt", BATCHES, samples, None, measure, first_seed=1000, **options)
    stats.assert_same(name, found, wanted, sees, names=["X", "Y", "Z"])
