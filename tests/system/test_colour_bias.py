"""Colour bias (algorithm.md §8, supplemental §4.4): what mollified (2,2)-paths show in a closed sphere is the exact
light of two bounces with the kernel between the first wall and the second: colours blur, and the ends of Λ lose
light. With a dye only what both walls reflect is blurred; what one of them re-emits is exact."""

import functools

import numpy as np
import pytest

import exact
import scenes
import stats

BINS = (10, 330, 830)  # to the very end of Λ on one side
RENDERS = 24
SAMPLES = {"elastic": 300, "fluorescent": 210}
SEES = {"elastic": 0.12, "fluorescent": 0.175}  # of a bin without bias; what the kernels do is up to 0.8
D = 100  # half-width, nm
KERNELS = ["constant", "incident_reflectance", "incident", "box", "asymmetric"]


def accepted(d, shift=0):
    """1/(2d) where λo − λi is within d of `shift`, [λo, λi] on the grid; of a step at the edge the part that is within."""
    beyond = np.abs(exact.GRID[:, None] - exact.GRID - shift)
    return np.clip((d - beyond) / exact.STEP + 0.5, 0, 1) / (2 * d)


def box(values, d):
    """A square of side d in both wavelengths over a diagonal: ∫ values from max(λi, λo) − d/2 to min(λi, λo) + d/2 over
    d², with nothing outside Λ."""
    edges = np.concatenate([[exact.RANGE[0]], exact.GRID + exact.STEP / 2])
    table = np.concatenate([[0], np.cumsum(values) * exact.STEP])
    low = np.maximum(exact.GRID[:, None], exact.GRID) - d / 2
    high = np.minimum(exact.GRID[:, None], exact.GRID) + d / 2
    return np.where(high > low, np.interp(high, edges, table) - np.interp(low, edges, table), 0) / d**2


def mollified(material, kernel, d):
    """The elastic reflection with its kernel: reflected = mollified @ incident (supplemental §§1–3, eqs. 1, 7, 15, 16)."""
    diagonal, reflectance = material.elastic(), material.reflectance.on_grid()
    density = {
        "constant": lambda: accepted(d) * diagonal,
        "incident_reflectance": lambda: reflectance[:, None] * accepted(d) * (diagonal / reflectance),
        "incident": lambda: diagonal[:, None] * accepted(d),
        "box": lambda: box(diagonal, d),
        "asymmetric": lambda: accepted(d, d) * diagonal,
    }[kernel]()
    return density * exact.STEP


def two_bounces(material, power, area, d, side, kernel):
    """Radiance of the wall that light leaves after two reflections; d = 0 for the exact one."""
    sharp = np.diag(material.elastic())
    emitted = material.operator() - sharp
    blurred = mollified(material, kernel, d) if d else sharp
    first, second = {"light": (blurred, sharp), "camera": (sharp, blurred)}[side]
    elastic = second @ (first @ power)
    return (elastic + emitted @ (sharp @ power) + (sharp + emitted) @ (emitted @ power)) / (np.pi * area)


def measure(picture):
    return picture.bins()[1].mean(axis=(1, 2), dtype=np.float64)


def render(core, path, name, side, kernel):
    scenes.sphere_with_patch(path, scenes.MATERIALS[name], scenes.LIGHTS["d65"], mollify_side=side, kernel=kernel)
    return core.batches(path, "mbdpt", RENDERS, SAMPLES[name], BINS, measure, techniques="2,2", d0=D, shrink=0)


@functools.lru_cache
def sphere():
    """The area of the sphere, and the part of it that shines."""
    positions, triangles = scenes.icosphere(4)
    size = scenes.areas(positions, triangles)
    return size.sum(), size[positions[triangles].mean(axis=1)[:, 2] > 0.1].sum()


def wanted(name, d, side, kernel):
    area, lit = sphere()
    power = np.pi * lit * scenes.emission(scenes.LIGHTS["d65"])[1]
    return exact.per_bin(two_bounces(scenes.MATERIALS[name], power, area, d, side, kernel), BINS)


# The kernels of r and of the whole diagonal are one without a dye.
CASES = [
    ("elastic", "light", "constant"),
    ("elastic", "camera", "constant"),
    ("elastic", "light", "asymmetric"),
    ("fluorescent", "camera", "incident"),
    ("fluorescent", "light", "incident_reflectance"),
    ("fluorescent", "light", "box"),
]


@pytest.mark.parametrize("name, side, kernel", CASES)
def test_two_bounces_are_blurred_as_the_theory_says(core, tmp_path, name, side, kernel):
    found, sees = render(core, tmp_path / "sphere.stokes", name, side, kernel), SEES[name]
    unbiased, blurred = wanted(name, 0, side, kernel), wanted(name, D, side, kernel)
    stats.assert_unbiased("%s, %s, %s" % (name, side, kernel), found, blurred, sees, scale=unbiased)
    with pytest.raises(AssertionError, match="WRONG"):  # the bias is there to be seen
        stats.assert_unbiased(side, found, unbiased, sees)
    for other in KERNELS:  # and so is that of any other kernel
        if other != kernel:
            shift = np.abs(wanted(name, D, side, other) - blurred) / unbiased
            assert shift.max() > sees, (kernel, other)
