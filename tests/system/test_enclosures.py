"""Furnace and integrating sphere: every integrator against the exact answer, in every wavelength bin.

Normal: 1 % of the whole energy and 3 % in bins of 20 nm that carry at least 1 % of it. Long: 0.2 % and 1 % in 10 nm."""

import math

import numpy as np
import pytest

import exact
import scenes
import stats

BATCHES = 48
INTEGRATORS = ["pt", "pt_nee", "lt", "mbdpt"]
# Half-width of the kernel, constant: bins nearer than 2d to an end of Λ would lose energy, and no bin is.
KERNEL = {"d0": 2, "shrink": 0}
NORMAL = {"bins": (25, 320, 820), "total": 0.01, "bin": 0.03}
LONG = {"bins": (50, 320, 820), "total": 0.002, "bin": 0.01}
CARRIES = 0.01

SHAPES = {
    "furnace": scenes.furnace,
    "sphere_with_patch": scenes.sphere_with_patch,
    "sphere_with_lamp": scenes.sphere_with_lamp,
}
# Samples per pixel (16 × 16 pixels) of one batch, as measured to be enough for what NORMAL promises.
SAMPLES = {}
DEFAULT_SAMPLES = 64


def measure(picture):
    """The whole picture's mean energy, luminance and spectrum."""
    _, bins = picture.bins()
    spectrum = bins.mean(axis=(1, 2), dtype=np.float64)
    red, green, blue = (picture.channels[c].mean(dtype=np.float64) for c in "RGB")
    luminance = 0.2126390058715103 * red + 0.7151686787677560 * green + 0.0721923153607337 * blue
    return np.concatenate([[spectrum.mean(), luminance], spectrum])


def compare(core, path, shape, material, light, integrator, precision, scale):
    radiance = SHAPES[shape](path, scenes.MATERIALS[material], scenes.LIGHTS[light], **KERNEL)
    bins = precision["bins"]
    spectrum = exact.per_bin(radiance, bins)
    wanted = np.concatenate([[spectrum.mean(), exact.luminance(radiance)], spectrum])
    promised = np.where(spectrum > CARRIES * spectrum.sum(), precision["bin"], math.inf)
    # Luminance is promised where there is some: a UV lamp on plain walls has next to none.
    lit = wanted[1] > 1e-3 * exact.integral(radiance)
    sees = np.concatenate([[precision["total"], 3 * precision["total"] if lit else math.inf], promised])
    spp = math.ceil(SAMPLES.get((shape, material, light, integrator), DEFAULT_SAMPLES) * scale)
    found = core.batches(path, integrator, BATCHES, spp, bins, measure)
    edges = np.linspace(bins[1], bins[2], bins[0] + 1)
    names = ["energy", "luminance"] + ["%g–%g nm" % pair for pair in zip(edges, edges[1:])]
    # Bins that carry next to nothing are judged by their statistics alone, and need no scale.
    stats.assert_unbiased(
        "%s, %s, %s, %s" % (shape, material, light, integrator), found, wanted, sees, names=names
    )


CASES = [
    (shape, material, light, integrator)
    for shape, light in [
        ("furnace", "d65"),
        ("furnace", "uv"),
        ("sphere_with_patch", "d65"),
        ("sphere_with_lamp", "uv"),
    ]
    for material in scenes.MATERIALS
    for integrator in INTEGRATORS
]


@pytest.mark.parametrize("shape, material, light, integrator", CASES)
def test_enclosure_matches_the_operator_in_every_bin(core, tmp_path, shape, material, light, integrator):
    compare(core, tmp_path / "scene.stokes", shape, material, light, integrator, NORMAL, 1)


@pytest.mark.long
@pytest.mark.parametrize("shape, material, light, integrator", CASES)
def test_enclosure_matches_the_operator_closely(core, tmp_path, shape, material, light, integrator):
    compare(core, tmp_path / "scene.stokes", shape, material, light, integrator, LONG, 25)
