"""Paths that no connection can make have no two neighbours that are not specular, as those of a lamp seen through a ball of glass: their share of the light
is reported, and the switch leaves out just that."""

import re

import numpy as np
import pytest

import exr
import scenes
import stats

SEEDS = 16


@pytest.fixture(scope="module")
def in_glass(tmp_path_factory):
    """A lamp in a ball of glass before the camera: with all paths, and without those."""
    folder = tmp_path_factory.mktemp("connectable")
    paths = folder / "all.stokes", folder / "connectable.stokes"
    for path, only in zip(paths, (False, True)):
        scenes.glass_box(path, "lamp", max_path=6, d0=2, shrink=0, connectable_only=only)
    return paths


def light(picture):
    """X+Y+Z of the whole film."""
    return picture.sums()[:3].sum(dtype=np.float64)


def share(core, scene, integrator, seed, samples):
    """As the report has it."""
    said = core.run(
        *("render", scene, "-o", core.directory / ("share-%d.exr" % seed), "--threads", 1),
        *("-i", integrator, "--seed", seed, "--spp", samples),
    ).stderr
    found = re.search(r"paths: (\S+) % of the light came over some that no connection makes", said)
    return float(found[1]) / 100 if found else 0.0


def test_the_switch_leaves_out_the_share_that_is_reported(core, in_glass):
    """By path tracing, whose other paths stay the same."""
    options = dict(integrator="pt", seed=5, samples=16)
    everything, kept = (light(core.render(path, **options)) for path in in_glass)
    left_out = share(core, in_glass[0], "pt", 5, 16)
    assert 0.2 < left_out < 0.95
    assert kept / everything == pytest.approx(1 - left_out, abs=2e-3)
    assert share(core, in_glass[1], "pt", 5, 16) == 0


def test_the_option_is_the_setting(core, in_glass):
    out = core.directory / "option.exr"
    core.run("render", in_glass[0], "-o", out, "-q", "-i", "bdpt", "--spp", 4, "--connectable-only")
    set_by_scene = core.render(in_glass[1], integrator="bdpt", spp=4)
    assert np.array_equal(exr.read(out).sums(), set_by_scene.sums())


@pytest.mark.parametrize("integrator", ["mbdpt", "bdpt"])
def test_all_integrators_report_the_same_share(core, in_glass, integrator):
    """Splats are light, too; and those paths have no other technique than to be met by the camera's."""
    wanted = np.array([[share(core, in_glass[0], "pt", seed, 32)] for seed in range(SEEDS)])
    found = np.array([[share(core, in_glass[0], integrator, seed, 8)] for seed in range(SEEDS)])
    stats.assert_same(integrator, found, wanted, 0.1)


def test_where_nothing_is_specular_nothing_is_left_out(core, tmp_path):
    paths = tmp_path / "all.stokes", tmp_path / "connectable.stokes"
    for path, only in zip(paths, (False, True)):
        scenes.box(path, resolution=(16, 12), specular=False, connectable_only=only)
    assert share(core, paths[0], "bdpt", 1, 4) == 0
    first, second = (core.render(path, integrator="bdpt", samples=4) for path in paths)
    assert np.array_equal(first.sums(), second.sums())
