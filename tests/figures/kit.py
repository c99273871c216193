"""What figures and benchmarks share: running the core, the pictures it makes as XYZ, and scenes recorded by Blender."""

import functools
import os
import pathlib
import re
import resource
import subprocess
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / room) for room in ("system", "bench")]

import exr  # noqa: E402  (found by the line above)
import scenes  # noqa: E402

CORE = pathlib.Path(os.environ.get("STOKES") or ROOT / "build" / "stokes")
BLENDER = os.environ.get("BLENDER", "blender")
QUICK = os.environ.get("QUICK", "") not in ("", "0")
UNIT = 2.0**-28  # of the film's sums (csrc/film/film.h)
stream = scenes.stream


def say(*words, **how):
    print(*words, flush=True, **how)


# --- The core --------------------------------------------------------------------------------------


def _run(arguments):
    result = subprocess.run([CORE, *map(str, arguments)], capture_output=True, text=True)
    if result.returncode:
        sys.exit("stokes %s: %s" % (" ".join(map(str, arguments)), result.stderr.strip()))
    return result


def stokes(*arguments):
    return _run(arguments).stdout


LATE = 1 << 17  # a sample behind all looks (algorithm.md §15), which come late in pictures as small as those of benchmarks


def light_paths(scene, out, lanes=1):
    """As many light sub-paths of a sample as `bdpt` finds to pay in `scene`."""
    words = ["render", scene, "-o", out, "-i", "bdpt", "--lanes", lanes, "--samples", "%d:%d" % (LATE, LATE + 1)]
    return float(re.search(r"paths: (\S+) light sub-paths", _run(words).stderr)[1])


@functools.lru_cache(maxsize=None)
def has_option(name):
    """Whether `stokes render` knows it."""
    return "--" + name in stokes("render", "--help")


def cpu_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def render(scene, out, snapshots=False, flags=(), **options):
    """Renders to `out` (EXR); returns processor seconds. Options are those of `stokes render`, with _ for -; `flags`
    those that take no value."""
    out = pathlib.Path(out)
    out.parent.mkdir(parents=True, exist_ok=True)
    words = ["render", scene, "-o", out, "--quiet", *["--snapshots"] * snapshots, *flags]
    words += [word for key, value in options.items() for word in ("--" + key.replace("_", "-"), value)]
    before = cpu_seconds()
    stokes(*words)
    return cpu_seconds() - before


def snapshot(out, samples):
    out = pathlib.Path(out)
    return out.with_name("%s-%05d%s" % (out.stem, samples, out.suffix))


def read_xyz(path):
    """[row, column, XYZ], first row at the top."""
    picture = exr.read(path)
    first, end = picture.samples()
    return np.moveaxis(picture.sums()[:3, ::-1], 0, -1) * (UNIT / (end - first))


def read_bins(path):
    """Wavelengths (nm) and the picture's mean radiance per nm in each bin."""
    nm, bins = exr.read(path).bins()
    return nm, bins.mean(axis=(1, 2))


def picture_of(scene, out, snapshots=False, **options):
    """The rendered picture as XYZ."""
    render(scene, out, snapshots, **options)
    return read_xyz(out)


def cached(path, newer_than, make):
    """`path`, made anew by make(path) unless it is newer than all of `newer_than`."""
    path = pathlib.Path(path)
    if not path.exists() or any(path.stat().st_mtime < pathlib.Path(other).stat().st_mtime for other in newer_than):
        path.parent.mkdir(parents=True, exist_ok=True)
        make(path)
    return path


# --- Scenes ------------------------------------------------------------------------------------------


def recorded(folder, script, resolution, *more, name=None):
    """The scene that test_scenes/SCRIPT.py builds in Blender, as a stream of this resolution."""
    name = name or script
    source = ROOT / "test_scenes" / (script + ".py")
    words = ["--output", folder, "--resolution", *resolution, "--samples", 1, *more]
    kept = pathlib.Path(folder) / ("%s-%dx%d.stokes" % (name, *resolution))

    def make(path):
        command = [BLENDER, "-b", "--factory-startup", "--python-exit-code", 1, "--python", source, "--", *words]
        result = subprocess.run([*map(str, command)], capture_output=True, text=True)
        if result.returncode:
            sys.exit("%s: %s" % (source.name, (result.stderr or result.stdout)[-2000:]))
        (pathlib.Path(folder) / (name + ".stokes")).rename(path)

    return cached(kept, [source, source.with_name("build.py"), CORE], make)


def edited(source, out, change):
    """A recorded scene with other members: change(message, members) returns the new ones, or None to leave it out."""
    with stream.Recorder(out) as recorder:
        for message, members, blobs in stream.read(source):
            members = change(message, members)
            if members is not None and message != "hello":
                recorder.send(message, **with_blobs(members, blobs))
    return pathlib.Path(out)


def with_blobs(value, area):
    """The members with their blobs in them again."""
    if isinstance(value, dict):
        if set(value) == {"at", "bytes"}:
            return stream.Blob(bytes(area[value["at"] : value["at"] + value["bytes"]]))
        return {key: with_blobs(inner, area) for key, inner in value.items()}
    if isinstance(value, list):
        return [with_blobs(inner, area) for inner in value]
    return value
