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
SEES = 0.12  # of a bin; what the kernel does is up to 0.4
D = 100  # half-width, nm


def spread(values, d):
    """∫ k(λc|λl) values(λl) dλl for the box kernel, with nothing outside Λ."""
    edges = np.concatenate([[exact.RANGE[0]], exact.GRID + exact.STEP / 2])
    table = np.concatenate([[0], np.cumsum(values) * exact.STEP])
    return (np.interp(exact.GRID + d, edges, table) - np.interp(exact.GRID - d, edges, table)) / (2 * d)


def two_bounces(material, light, area, lit, d, side):
    """Radiance of the wall that light leaves after two reflections; d = 0 for the exact one. With the kernel at the
    first wall the second reflects at the camera's wavelength; at the second, f_mo reflects at the incident one."""
    reflectance, power = material.elastic(), np.pi * lit * scenes.emission(light)[1]
    if not d:
        return reflectance**2 * power / (np.pi * area)
    first = spread(reflectance * power, d) * reflectance
    second = spread(reflectance**2 * power, d)
    return {"light": first, "camera": second}[side] / (np.pi * area)


def measure(picture):
    return picture.bins()[1].mean(axis=(1, 2), dtype=np.float64)


def render(core, path, side, d):
    scenes.sphere_with_patch(path, scenes.MATERIALS["elastic"], scenes.LIGHTS["d65"], mollify_side=side)
    return core.batches(path, "mbdpt", RENDERS, SAMPLES, BINS, measure, techniques="2,2", d0=d, shrink=0)


def wanted(d, side):
    positions, triangles = scenes.icosphere(4)
    size = scenes.areas(positions, triangles)
    lit = size[positions[triangles].mean(axis=1)[:, 2] > 0.1].sum()
    radiance = two_bounces(scenes.MATERIALS["elastic"], scenes.LIGHTS["d65"], size.sum(), lit, d, side)
    return exact.per_bin(radiance, BINS)


@pytest.mark.parametrize("side", ["light", "camera"])
def test_two_bounces_are_blurred_as_the_theory_says(core, tmp_path, side):
    found = render(core, tmp_path / "sphere.stokes", side, D)
    stats.assert_unbiased(side, found, wanted(D, side), SEES)
    with pytest.raises(AssertionError, match="WRONG"):  # the bias is there to be seen
        stats.assert_unbiased(side, found, wanted(0, side), SEES)
