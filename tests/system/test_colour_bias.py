"""Colour bias (algorithm.md §8, supplemental §4.4): what mollified (2,2)-paths show in a closed sphere is the exact
light of two bounces with the kernel between the first wall and the second: colours blur, and the ends of Λ lose
light."""

import numpy as np
import pytest

import exact
import scenes
import stats

BINS = (10, 330, 830)  # to the very end of Λ on one side
RENDERS, SAMPLES = 24, 300
SEES = 0.12  # of a bin without bias; what the kernels do is up to 0.8
D = 100  # half-width, nm


def spread(values, d, kernel):
    """∫ k(λc|λl) values(λl) dλl, with nothing outside Λ."""
    before, after = {"constant": (d, d), "asymmetric": (2 * d, 0)}[kernel]
    edges = np.concatenate([[exact.RANGE[0]], exact.GRID + exact.STEP / 2])
    table = np.concatenate([[0], np.cumsum(values) * exact.STEP])
    return (np.interp(exact.GRID + after, edges, table) - np.interp(exact.GRID - before, edges, table)) / (2 * d)


def two_bounces(material, light, area, lit, d, side, kernel):
    """Radiance of the wall that light leaves after two reflections; d = 0 for the exact one. With the kernel at the
    first wall the second reflects at the camera's wavelength; at the second, f_mo reflects at the incident one."""
    reflectance, power = material.elastic(), np.pi * lit * scenes.emission(light)[1]
    if not d:
        return reflectance**2 * power / (np.pi * area)
    first = spread(reflectance * power, d, kernel) * reflectance
    second = spread(reflectance**2 * power, d, kernel)
    return {"light": first, "camera": second}[side] / (np.pi * area)


def measure(picture):
    return picture.bins()[1].mean(axis=(1, 2), dtype=np.float64)


def render(core, path, side, kernel):
    scenes.sphere_with_patch(path, scenes.MATERIALS["elastic"], scenes.LIGHTS["d65"], mollify_side=side, kernel=kernel)
    return core.batches(path, "mbdpt", RENDERS, SAMPLES, BINS, measure, techniques="2,2", d0=D, shrink=0)


def wanted(d, side, kernel):
    positions, triangles = scenes.icosphere(4)
    size = scenes.areas(positions, triangles)
    lit = size[positions[triangles].mean(axis=1)[:, 2] > 0.1].sum()
    radiance = two_bounces(scenes.MATERIALS["elastic"], scenes.LIGHTS["d65"], size.sum(), lit, d, side, kernel)
    return exact.per_bin(radiance, BINS)


CASES = [("light", "constant"), ("camera", "constant"), ("light", "asymmetric")]


@pytest.mark.parametrize("side, kernel", CASES)
def test_two_bounces_are_blurred_as_the_theory_says(core, tmp_path, side, kernel):
    found = render(core, tmp_path / "sphere.stokes", side, kernel)
    unbiased = wanted(0, side, kernel)
    stats.assert_unbiased("%s, %s" % (side, kernel), found, wanted(D, side, kernel), SEES, scale=unbiased)
    with pytest.raises(AssertionError, match="WRONG"):  # the bias is there to be seen
        stats.assert_unbiased(side, found, unbiased, SEES)
