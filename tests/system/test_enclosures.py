"""Furnace and integrating sphere: every integrator against the exact answer, in every wavelength bin.

Normal: 1 % of the whole energy and 3 % in bins of 20 nm that carry at least 1 % of it. Long: 0.2 % and 1 % in 10 nm."""

import numpy as np
import pytest

import exact
import scenes
import stats

INTEGRATORS = ["pt", "pt_nee", "lt", "mbdpt", "bdpt"]
# The kernel's half-width is constant: bins nearer than 2d to an end of Λ would lose energy, and no bin is. Walls reflect
# less than half, so what paths of more than 16 edges carry is below 1e-5.
SETTINGS = {"d0": 2, "shrink": 0, "max_path": 16, "max_camera": 16, "max_light": 16, "roulette_start": 3}
NORMAL = {"split": 1, "total": 0.01, "bin": 0.03}
LONG = {"split": 2, "total": 0.002, "bin": 0.01}
CARRIES = 0.01

SHAPES = {
    "furnace": scenes.furnace,
    "sphere_with_patch": scenes.sphere_with_patch,
    "sphere_with_lamp": scenes.sphere_with_lamp,
}
# Renders, and independent batches in each: splats tie the pixels of a picture together, camera paths do not.
BATCHES = {"pt": (4, 64), "pt_nee": (4, 64), "lt": (48, 1), "mbdpt": (48, 1), "bdpt": (48, 1)}
# Samples per pixel (of 16 × 16) of one render: a third more than what NORMAL's promises were measured to take.
SAMPLES = {
    ("elastic", "d65"): {"pt": 2600, "pt_nee": 300, "lt": 750, "mbdpt": 145, "bdpt": 90},
    ("elastic", "uv"): {"pt": 100, "pt_nee": 140, "lt": 270, "mbdpt": 60, "bdpt": 15},
    ("fluorescent", "d65"): {"pt": 8000, "pt_nee": 2400, "lt": 750, "mbdpt": 145, "bdpt": 90},
    ("fluorescent", "uv"): {"pt": 16000, "pt_nee": 10500, "lt": 420, "mbdpt": 145, "bdpt": 60},
}
LAMP_SAMPLES = 7500  # for the lamp in the sphere's middle


def measure(picture, rows):
    """Energy per nm, luminance, and every bin; `rows` groups of pixels."""
    _, bins = picture.bins()
    spectrum = bins.reshape(len(bins), rows, -1).mean(axis=2, dtype=np.float64).T
    weights = (("R", 0.2126390058715103), ("G", 0.7151686787677560), ("B", 0.0721923153607337))
    luminance = sum(
        weight * picture.channels[name].reshape(rows, -1).mean(axis=1, dtype=np.float64)
        for name, weight in weights
    )
    return np.column_stack([spectrum.mean(axis=1), luminance, spectrum])


def compare(core, path, case, precision, scale):
    shape, material, light, integrator = case
    radiance = SHAPES[shape](path, scenes.MATERIALS[material], scenes.LIGHTS[light], **SETTINGS)
    count, low, high = scenes.BINS[material, light]
    bins = (count * precision["split"], low, high)
    spectrum = exact.per_bin(radiance, bins)
    wanted = np.concatenate([[spectrum.mean(), exact.luminance(radiance)], spectrum])
    # Where next to nothing is, a batch holds a handful of events or none, and its mean is far from normal.
    kept = np.concatenate([[True, (material, light) != ("elastic", "uv")], spectrum > CARRIES * spectrum.sum()])
    sees = np.full(len(wanted), precision["bin"])
    sees[0] = precision["total"]
    renders, rows = BATCHES[integrator]
    samples = LAMP_SAMPLES if shape == "sphere_with_lamp" else SAMPLES[material, light][integrator]
    found = core.batches(path, integrator, renders, round(samples * scale), bins, lambda picture: measure(picture, rows))
    edges = np.linspace(low, high, bins[0] + 1)
    names = np.array(["energy", "luminance"] + ["%g–%g nm" % pair for pair in zip(edges, edges[1:])])
    stats.assert_unbiased(", ".join(case), found[:, kept], wanted[kept], sees[kept], names=names[kept])


# Each integrator meets each material under each light; a path tracer without next event estimation meets the UV lamp where
# every wall emits, as it would need minutes to find a patch by a shifted wavelength.
PLACES = {
    "pt": (("sphere_with_patch", "d65"), ("furnace", "uv")),
    "pt_nee": (("furnace", "d65"), ("sphere_with_patch", "uv")),
    "lt": (("furnace", "d65"), ("sphere_with_patch", "uv")),
    "mbdpt": (("furnace", "d65"), ("sphere_with_patch", "uv")),
    "bdpt": (("furnace", "d65"), ("sphere_with_patch", "uv")),
}
CASES = [
    (shape, material, light, integrator)
    for integrator in INTEGRATORS
    for shape, light in PLACES[integrator]
    for material in scenes.MATERIALS
] + [("sphere_with_lamp", "fluorescent", "d65", "pt_nee")]

LONG_CASES = [
    (shape, material, light, integrator)
    for shape in SHAPES
    for light in scenes.LIGHTS
    for material in scenes.MATERIALS
    for integrator in INTEGRATORS
]


@pytest.mark.parametrize("case", CASES, ids="-".join)
def test_enclosure_matches_the_operator_in_every_bin(core, tmp_path, case):
    compare(core, tmp_path / "scene.stokes", case, NORMAL, 1)


@pytest.mark.long
@pytest.mark.parametrize("case", LONG_CASES, ids="-".join)
def test_enclosure_matches_the_operator_closely(core, tmp_path, case):
    compare(core, tmp_path / "scene.stokes", case, LONG, 25)
