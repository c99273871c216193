"""Where the instructions of a sample go, by callgrind: instructions.py SCENE CORE [CORE …] -- OPTIONS: `instructions.py spheres build/stokes
other/build/stokes -- --lanes 4`. Counts do not depend on what else the machine does; they need valgrind."""

import collections
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "figures"))

import bench_scenes  # noqa: E402
import kit  # noqa: E402

FOLDER = kit.ROOT / "build" / "bench"
RESOLUTION, SAMPLES = (48, 36), 4
PARTS = {  # of sources, first match
    r"integrator/(tally|mis|link)\.c": "weights",
    r"integrator/(relight|runs)\.c": "runs evaluated again",
    r"integrator/": "sub-paths and connections",
    r"csrc/(spectrum|color)/": "spectra looked up",
    r"csrc/material/": "surfaces",
    r"csrc/scene/": "hits",
    r"csrc/film/": "film",
    r"csrc/base/random": "random numbers",
    r"embree": "rays (Embree)",
}
LINE = re.compile(r"\s*([\d,]+) \([^)]*\)\s+(.*)")


def part_of(function):
    return next((part for pattern, part in PARTS.items() if re.search(pattern, function)), "libraries and the rest")


def counted(core, scene, samples, options):
    """Instructions by part."""
    out = FOLDER / "instructions.out"
    words = ["-i", "bdpt", "-t", 1, "-q", "-o", FOLDER / "instructions.exr", "--samples", samples, *options]
    tool = ["valgrind", "--tool=callgrind", "--callgrind-out-file=%s" % out, core, "render", scene]
    subprocess.run([*map(str, tool + words)], check=True, capture_output=True)
    text = subprocess.run(["callgrind_annotate", "--threshold=100", "--auto=no", out], check=True, capture_output=True, text=True)
    parts = collections.Counter()
    for line in text.stdout.splitlines():
        found = LINE.fullmatch(line)
        if found and ":" in found[2]:
            parts[part_of(found[2])] += int(found[1].replace(",", ""))
    return parts


def of_a_sample(core, scene, options):
    """What more samples add, behind all looks."""
    some, more = (counted(core, scene, "%d:%d" % (kit.LATE, kit.LATE + count), options) for count in (1, 1 + SAMPLES))
    more.subtract(some)
    return {part: count / (SAMPLES * RESOLUTION[0] * RESOLUTION[1]) for part, count in more.items()}


def main(name, *words):
    cores, options = words[: words.index("--")], words[words.index("--") + 1 :]
    scene = bench_scenes.write(name, FOLDER, RESOLUTION)
    found = [of_a_sample(core, scene, options) for core in cores]
    for part in sorted(found[0], key=found[0].get, reverse=True):
        kit.say("%-28s" % part, *("%8.0f" % parts.get(part, 0) for parts in found))
    kit.say("%-28s" % "in all", *("%8.0f" % sum(parts.values()) for parts in found))


if __name__ == "__main__":
    main(*sys.argv[1:])
