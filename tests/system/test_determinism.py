"""The image is a function of scene, seed and sample range: threads, vectors, parts and borders change no bit."""

import re

import numpy as np
import pytest

import exr
import scenes
from process import SLOWER

INTEGRATORS = ["pt", "pt_nee", "lt", "mbdpt", "bdpt"]
RESOLUTION = (40, 30)
BINS = {"bins": (8, 380, 780)}
PASSES = 16 if SLOWER == 1 else 8  # all are made alike: what an instrument finds, it finds in few


@pytest.fixture(params=INTEGRATORS)
def integrator(request):
    return request.param


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("determinism") / "box.stokes"
    scenes.box(path, resolution=RESOLUTION)
    return path


@pytest.fixture(scope="module")
def small_scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("determinism") / "box.stokes"
    scenes.box(path, resolution=(16, 12))
    return path


def test_every_integrator_is_among_these(core):
    listed = re.search(r"--integrator NAME +(.*)", core.run("render", "--help").stdout)[1]
    assert re.split(", | or ", listed) == INTEGRATORS


def assert_same_bits(first, second):
    assert first.samples() == second.samples()
    assert np.array_equal(first.sums(), second.sums())
    for name in "RGBA":
        assert np.array_equal(first.channels[name], second.channels[name])


@pytest.mark.parametrize("lanes", [1, 4, 8])
def test_threads_change_no_bit(core, scene, integrator, lanes):
    pictures = [
        core.render(scene, integrator=integrator, seed=3, samples=PASSES, threads=threads, lanes=lanes, **BINS)
        for threads in (1, 2, 5)
    ]
    assert pictures[0].sums().any()
    assert_same_bits(pictures[0], pictures[1])
    assert_same_bits(pictures[0], pictures[2])


@pytest.mark.parametrize("lanes", [1, 4, 8])
@pytest.mark.parametrize("integrator", ["mbdpt", "bdpt"])
@pytest.mark.parametrize("vectors", ["avx2"])
def test_vectors_change_no_bit(core, scene, integrator, lanes, vectors, monkeypatch):
    if vectors not in re.search("Vectors on this machine: ([^;]*);", core.run("--help").stdout)[1].split(", "):
        pytest.skip("%s: not on this machine, or not in this build" % vectors)
    pictures = []
    for name in ("baseline", vectors):
        monkeypatch.setenv("STOKES_VECTORS", name)
        assert "; now %s." % name in core.run("--help").stdout
        pictures.append(core.render(scene, integrator=integrator, seed=3, samples=16, lanes=lanes, **BINS))
    assert pictures[0].sums().any()
    assert_same_bits(*pictures)


def test_vectors_that_no_machine_has_are_refused_in_one_line(core, monkeypatch):
    monkeypatch.setenv("STOKES_VECTORS", "avx1024")
    result = core.run("--version", check=False)
    assert result.returncode == 2
    assert result.stderr == "stokes: STOKES_VECTORS: 'avx1024' is not on this machine; see `stokes --help`\n"


def test_seeds_change_the_picture(core, scene, integrator):
    first, second = (core.render(scene, integrator=integrator, seed=seed, samples=4, **BINS) for seed in (3, 4))
    assert not np.array_equal(first.sums(), second.sums())


@pytest.mark.parametrize("lanes", [1, 4])
def test_merged_sample_ranges_equal_one_render(core, small_scene, integrator, lanes, tmp_path):
    """Whatever the order of merging; mbdpt's kernel width depends on the global sample index."""
    same = dict(integrator=integrator, seed=3, lanes=lanes, **BINS)
    whole = core.render(small_scene, samples="0:128", **same)
    for name, samples in (("a", "0:64"), ("b", "64:100"), ("c", "100:128"), ("d", "64:128")):
        core.render(small_scene, name=name + ".exr", keep=True, samples=samples, **same)
    for number, order in enumerate(["ad", "abc", "cba"]):
        out = tmp_path / ("merged%d.exr" % number)
        core.run("merge", "-o", out, *[core.directory / (name + ".exr") for name in order])
        assert_same_bits(whole, exr.read(out))


def test_border_equals_crop(core, scene, integrator, tmp_path):
    x0, y0, x1, y1 = 7, 4, 29, 21
    bordered = tmp_path / "border.stokes"
    scenes.box(bordered, resolution=RESOLUTION, border=[x0, y0, x1, y1])
    whole = core.render(scene, integrator=integrator, seed=3, samples=16, **BINS)
    part = core.render(bordered, integrator=integrator, seed=3, samples=16, **BINS)
    assert part.data_window == (x0, RESOLUTION[1] - y1, x1 - 1, RESOLUTION[1] - 1 - y0)
    assert np.array_equal(whole.sums()[:, y0:y1, x0:x1], part.sums())


def test_looks_at_the_scene_change_no_bit(core, tmp_path, monkeypatch):
    """What `bdpt` decides by looking at the scene it decides for the same samples whatever part of them is rendered, in whatever part of the
    frame, and whoever looks."""
    look = 400  # of 16 × 12 pixels
    box = dict(resolution=(16, 12), view="wall", specular=False)  # in the open, where fewer light sub-paths pay
    path = tmp_path / "box.stokes"
    scenes.box(path, **box)
    same = dict(integrator="bdpt", seed=3, lanes=4, **BINS)
    said = core.run(
        "render", path, "-o", tmp_path / "said.exr", "-i", "bdpt", "--lanes", 4, "--samples", "396:404"
    ).stderr
    light_paths, begins = re.search(r"paths: (\S+) light sub-paths.*, from sample (\d+) on", said).groups()
    assert (float(light_paths) < 1, int(begins)) == (True, look), said
    whole = core.render(path, samples="396:404", threads=1, **same)
    assert_same_bits(whole, core.render(path, samples="396:404", threads=5, **same))
    for name, samples in (("a", "396:400"), ("b", "400:404"), ("c", "396:398"), ("d", "398:402"), ("e", "402:404")):
        core.render(path, name=name + ".exr", keep=True, samples=samples, **same)
    for order in ("ab", "edc"):
        out = tmp_path / (order + ".exr")
        core.run("merge", "-o", out, *[core.directory / (name + ".exr") for name in order])
        assert_same_bits(whole, exr.read(out))
    bordered = tmp_path / "border.stokes"
    scenes.box(bordered, border=[3, 2, 11, 9], **box)
    part = core.render(bordered, samples="396:404", **same)
    assert np.array_equal(whole.sums()[:, 2:9, 3:11], part.sums())
    monkeypatch.setenv("STOKES_VECTORS", "baseline")
    assert_same_bits(whole, core.render(path, samples="396:404", **same))


def test_parts_that_overlap_or_differ_are_refused(core, scene, tmp_path):
    for name, seed, samples in (("one", 3, "0:8"), ("over", 3, "4:12"), ("other", 4, "8:16")):
        core.render(scene, name=name + ".exr", keep=True, integrator="pt", seed=seed, samples=samples, **BINS)
    out = tmp_path / "merged.exr"
    for name in ("over", "other"):
        result = core.run(
            "merge", "-o", out, core.directory / "one.exr", core.directory / (name + ".exr"), check=False
        )
        assert result.returncode != 0
        assert len(result.stderr.strip().splitlines()) == 1
        assert not out.exists()
