"""Furnace and integrating sphere: every integrator against the exact answer, in every wavelength bin.

Normal: 1 % of the whole energy and 3 % in bins of 20 nm that carry at least 1 % of it. Long: 0.2 % and 1 % in 10 nm."""

import math

import numpy as np
import pytest

import exact
import scenes
import stats

INTEGRATORS = ["pt", "pt_nee", "lt", "mbdpt", "bdpt"]
# The kernel's half-width is constant: bins nearer than 2d to an end of Λ would lose energy, and no bin is. Walls reflect
# less than half, so what paths of more than 16 edges carry is below 1e-5.
SETTINGS = {"d0": 2, "shrink": 0, "max_path": 16, "max_camera": 16, "max_light": 16, "roulette_start": 3}
# What is promised, in bins of 20 nm over `split`; from how many renders, for splats tie the pixels of a picture together; how
# much dearer than a first look (below) it may be.
NORMAL = {"split": 1, "total": 0.01, "bin": 0.03, "renders": 96, "pilot": 1, "most": 60}
LONG = {"split": 2, "total": 0.002, "bin": 0.01, "renders": 144, "pilot": 4, "most": 400}
CARRIES = 0.01

SHAPES = {
    "furnace": scenes.furnace,
    "misty_furnace": scenes.misty_furnace,
    "cloudy_furnace": scenes.cloudy_furnace,
    "thick_furnace": scenes.thick_furnace,
    "sphere_with_patch": scenes.sphere_with_patch,
    "sphere_with_lamp": scenes.sphere_with_lamp,
}
# Camera paths do not: groups of pixels are batches of their own.
GROUPS = {"pt": (4, 64), "pt_nee": (4, 64)}
# Wavelengths per pixel (of 16 × 16) of a first look, which tells how many more samples the promise takes.
PILOT = {
    ("elastic", "d65"): {"pt": 600, "pt_nee": 75, "lt": 100, "mbdpt": 20, "bdpt": 10},
    ("elastic", "uv"): {"pt": 25, "pt_nee": 35, "lt": 35, "mbdpt": 8, "bdpt": 3},
    ("fluorescent", "d65"): {"pt": 2000, "pt_nee": 600, "lt": 100, "mbdpt": 20, "bdpt": 10},
    ("fluorescent", "uv"): {"pt": 4000, "pt_nee": 2500, "lt": 50, "mbdpt": 20, "bdpt": 8},
}
MARGIN = 1.1  # on that number, as a variance is not well known
ROUNDS = 5


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


def name(case):
    return "-".join(map(str, case))


def compare(core, path, case, precision):
    shape, material, light, integrator, lanes = case
    radiance = SHAPES[shape](path, scenes.MATERIALS[material], scenes.LIGHTS[light], **SETTINGS)
    count, low, high = scenes.BINS[material, light]
    bins = (count * precision["split"], low, high)
    spectrum = exact.per_bin(radiance, bins)
    wanted = np.concatenate([[spectrum.mean(), exact.luminance(radiance)], spectrum])
    # Where next to nothing is, a batch holds a handful of events or none, and its mean is far from normal.
    kept = np.concatenate([[True, (material, light) != ("elastic", "uv")], spectrum > CARRIES * spectrum.sum()])
    sees = np.full(len(wanted), precision["bin"])
    sees[0] = precision["total"]
    edges = np.linspace(low, high, bins[0] + 1)
    names = np.array(["energy", "luminance"] + ["%g–%g nm" % pair for pair in zip(edges, edges[1:])])
    renders, rows = GROUPS.get(integrator, (precision["renders"], 1))

    def batches(samples, round):
        return core.batches(
            path,
            integrator,
            renders,
            samples,
            bins,
            lambda picture: measure(picture, rows)[:, kept],
            10000 * round + 1,
            lanes=lanes,
        )

    # As many samples as the promises take. Only variances are asked, so that what was found plays no part in it.
    pilot = samples = math.ceil(PILOT[material, light][integrator] * precision["pilot"] / lanes)
    found = batches(samples, 0)
    for round in range(1, ROUNDS):
        needed = stats.against(found, wanted[kept], sees[kept]).samples_needed()
        if needed <= 1:
            break
        more = math.ceil(samples * (MARGIN * needed - 1))
        assert samples + more < precision["most"] * pilot, "the promises take %.0f times the pilot" % (
            (samples + more) / pilot
        )
        found = (samples * found + more * batches(more, round)) / (samples + more)
        samples += more
    stats.assert_unbiased(name(case), found, wanted[kept], sees[kept], names=names[kept])


# Each integrator meets each material under each light.
PLACES = {"d65": "furnace", "uv": "sphere_with_patch"}


def lanes_of(material, light):
    """With one wavelength a path and with many. Through a dye, most of a bundle misses a lamp of a few nanometres."""
    if material == "elastic":
        return 4
    return 1 if light == "uv" else 8


CASES = [
    (PLACES[light], material, light, integrator, lanes_of(material, light))
    for integrator in INTEGRATORS
    for light in PLACES
    for material in scenes.MATERIALS
] + [("sphere_with_lamp", "elastic", "d65", "pt_nee", 4)]
# What scatters without loss changes nothing. `lt` has no finite variance where the camera itself is in the mist.
CASES += [
    ({"pt": "thick_furnace", "lt": "cloudy_furnace"}.get(integrator, "misty_furnace"), "elastic", "d65", integrator, 4)
    for integrator in INTEGRATORS
]

LONG_CASES = [
    (shape, material, light, integrator, lanes_of(material, light))
    for shape in ("furnace", "sphere_with_patch")
    for light in scenes.LIGHTS
    for material in scenes.MATERIALS
    for integrator in INTEGRATORS
] + [("sphere_with_lamp", "elastic", "d65", integrator, 4) for integrator in INTEGRATORS]


@pytest.mark.parametrize("case", CASES, ids=name)
def test_enclosure_matches_the_operator_in_every_bin(core, tmp_path, case):
    compare(core, tmp_path / "scene.stokes", case, NORMAL)


@pytest.mark.long
@pytest.mark.parametrize("case", LONG_CASES, ids=name)
def test_enclosure_matches_the_operator_closely(core, tmp_path, case):
    compare(core, tmp_path / "scene.stokes", case, LONG)
