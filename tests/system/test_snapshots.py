"""One render's snapshots are the pictures that separate renders of 1, 2, 4, … samples give."""

import pytest

import scenes

RESOLUTION = (24, 18)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("snapshots") / "box.stokes"
    scenes.box(path, resolution=RESOLUTION)
    return path


def render(core, scene, out, samples, *more):
    core.run("render", scene, "-o", out, "--quiet", "--seed", 3, "--samples", samples, *more)


def names(directory):
    return sorted(path.name for path in directory.iterdir())


@pytest.mark.parametrize("integrator", ["pt_nee", "lt", "mbdpt", "bdpt"])
def test_a_snapshot_has_the_bytes_of_a_render_of_its_samples(core, scene, tmp_path, integrator):
    """mbdpt's kernel shrinks with the sample's number, so a snapshot must hold the same samples, not as many."""
    render(core, scene, tmp_path / "out.exr", 21, "-i", integrator, "--snapshots")
    counts = [1, 2, 4, 8, 16]
    assert names(tmp_path) == ["out-%05d.exr" % count for count in counts] + ["out.exr"]
    for count in counts:
        alone = tmp_path / "alone.exr"
        render(core, scene, alone, count, "-i", integrator)
        assert alone.read_bytes() == (tmp_path / ("out-%05d.exr" % count)).read_bytes()


def test_taking_snapshots_changes_no_bit_of_the_picture(core, scene, tmp_path):
    for name, more in (("with.exr", ["--snapshots"]), ("without.exr", [])):
        render(core, scene, tmp_path / name, 21, *more)
    assert (tmp_path / "with.exr").read_bytes() == (tmp_path / "without.exr").read_bytes()


def test_snapshots_count_from_the_first_sample_and_come_in_every_format(core, scene, tmp_path):
    render(core, scene, tmp_path / "a.exr", "3:7", "-o", tmp_path / "b.png", "--snapshots")
    assert names(tmp_path) == [
        name + end
        for name, end in (("a", ".exr"), ("b", ".png"))
        for name in ["%s-%05d" % (name, count) for count in (1, 2, 4)] + [name]
    ]
    alone = tmp_path / "alone.exr"
    render(core, scene, alone, "3:5")
    assert alone.read_bytes() == (tmp_path / "a-00002.exr").read_bytes()


def test_a_snapshot_that_cannot_be_written_ends_the_render_with_one_line(core, scene, tmp_path):
    """The first one cannot, so nobody waits for a picture that has no place."""
    out = tmp_path / "missing" / "out.exr"
    result = core.run("render", scene, "-o", out, "--spp", 100000, "--snapshots", "--quiet", check=False)
    assert result.returncode == 1
    assert len(result.stderr.strip().splitlines()) == 1 and "out-00001.exr" in result.stderr
