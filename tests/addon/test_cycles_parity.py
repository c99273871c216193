"""Pictures by Stokes against pictures by the Cycles of the same Blender: one scene for each light, closure, texture look-up,
world and camera (parity/scenes_*.py). A scene passes if blocks of 16 × 16 pixels differ by less than 2 % of the picture's
mean; noise is measured with them, from two renders of each engine, and must explain less than 0.5 %."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent / "parity"))

import blenders  # noqa: E402
import catalogue  # noqa: E402
import compare  # noqa: E402


def _cases():
    """(Blender, scene) pairs; the marker is `long` for what waits to be asked for."""
    for name in blenders.NAMES:
        is_system = name == blenders.SYSTEM
        for scene in catalogue.SCENES.values():
            if not is_system and scene.run not in {"always", "every"}:
                continue
            waits = scene.run == "long" or (not is_system and scene.run != "always")
            yield pytest.param(name, scene.name, marks=pytest.mark.long if waits else ())


def host(name):
    try:
        return blenders.blender(name)
    except blenders.Missing as missing:
        pytest.skip(str(missing))


@pytest.mark.parametrize("blender, scene", list(_cases()))
def test_stokes_and_cycles_see_the_same_scene(blender, scene, tmp_path):
    pictures, _ = compare.render(host(blender), scene, tmp_path, compare.REFERENCE + compare.SUBJECT)
    found = compare.difference(pictures)
    compare.side_by_side(tmp_path / "picture.png", [pictures[job] for job in compare.REFERENCE],
                         [pictures[job] for job in compare.SUBJECT])
    assert found.noise < compare.NOISE, "too noisy to tell: %s" % found
    assert found.deviation < compare.LIMIT, "%s, see %s" % (found, tmp_path / "picture.png")


def test_the_comparison_passes_other_noise_and_sees_three_percent(tmp_path):
    jobs = ("cycles:1", "cycles:2", "cycles:3", "cycles:4", "cycles:3:1.03", "cycles:4:1.03")
    pictures, _ = compare.render(host(blenders.SYSTEM), "glass_smooth", tmp_path, jobs)
    same = compare.difference(pictures, jobs[:2], jobs[2:4])
    brighter = compare.difference(pictures, jobs[:2], jobs[4:])
    assert same.deviation < compare.NOISE and same.noise < compare.NOISE, same
    assert brighter.deviation > compare.LIMIT, brighter
