"""Two pictures, each rendered twice: how far their block means lie apart, and how much of that noise alone can explain.
Run as a program it renders scenes in one Blender, prints the numbers and writes side-by-side PNGs: compare.py -h."""

import argparse
import json
import struct
import sys
import zlib
from pathlib import Path

import numpy

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import blenders  # noqa: E402
import catalogue  # noqa: E402

BLOCK = 16
LIMIT = 0.02  # of the mean, systematic
NOISE = 0.005  # what noise may add
REFERENCE, SUBJECT = ("cycles:1", "cycles:2"), ("stokes:3", "stokes:4")


class Difference:
    """`deviation` is the mean over blocks and channels of |subject − reference| over the mean of the reference;
    `noise` is what it would be, were both the same picture: half the difference of two renders is the standard
    deviation of their mean, and E|x| of a normal x is √(2/π) of it. `ratios` are the means' ratios by channel."""

    def __init__(self, reference, subject):
        ours, theirs = [blocks(one) for one in subject], [blocks(one) for one in reference]
        mean = numpy.mean(theirs)
        self.deviation = numpy.mean(abs(numpy.mean(ours, 0) - numpy.mean(theirs, 0))) / mean
        half = [(one[0] - one[1]) / 2 for one in (ours, theirs)]
        self.noise = numpy.sqrt(2 / numpy.pi) * numpy.sqrt(sum(numpy.mean(one ** 2) for one in half)) / mean
        self.ratios = numpy.mean(ours, (0, 1)) / numpy.maximum(numpy.mean(theirs, (0, 1)), 1e-30)

    def __str__(self):
        return "deviation %.2f %%, noise %.2f %%, means' ratio %s" % (
            100 * self.deviation, 100 * self.noise, " ".join("%.4f" % ratio for ratio in self.ratios))


def blocks(picture):
    """Means of 16 × 16 pixels as (block, channel); an edge narrower than that is a block of its own."""
    rows = [picture[y:y + BLOCK] for y in range(0, picture.shape[0], BLOCK)]
    return numpy.array([row[:, x:x + BLOCK].mean((0, 1)) for row in rows for x in range(0, row.shape[1], BLOCK)])


def render(blender, name, folder, jobs, timeout=300, env=None):
    """Pictures by job: arrays (row from the bottom, column, channel) of float64."""
    folder.mkdir(parents=True, exist_ok=True)
    text = blender.run(HERE / "render.py", folder, name, *jobs, timeout=timeout, env=env)
    (folder / "output.txt").write_text(text)
    log = json.loads((folder / "log.json").read_text())
    width, height = log["size"]
    pictures = {}
    for job in jobs:
        picture = numpy.fromfile(folder / (job + ".f32"), "<f4").reshape(height, width, 4).astype(float)
        has_alpha = picture[..., 3].min() < 0.999
        pictures[job] = picture if has_alpha else picture[..., :3]
    return pictures, log


def difference(pictures, reference=REFERENCE, subject=SUBJECT):
    return Difference([pictures[job] for job in reference], [pictures[job] for job in subject])


# For people ------------------------------------------------------------------------------------------------------

def side_by_side(path, reference, subject):
    """Reference, subject, and 0.5 + five times their difference over the mean."""
    reference, subject = [numpy.mean(pair, 0)[::-1, :, :3] for pair in (reference, subject)]
    wrong = 0.5 + 5 * (subject - reference) / (2 * reference.mean())
    shown = numpy.concatenate([_display(reference), _display(subject), numpy.clip(wrong, 0, 1)], 1)
    _write_png(path, numpy.repeat(numpy.repeat(shown, 3, 0), 3, 1))


def _display(linear):
    linear = numpy.clip(linear, 0, 1)
    return numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def _write_png(path, shown):
    height, width, _ = shown.shape
    rows = (shown * 255 + 0.5).astype("u1").reshape(height, -1)
    data = b"".join(b"\0" + row.tobytes() for row in rows)

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    head = struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)
    Path(path).write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(data)) +
                           chunk(b"IEND", b""))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", help="all of them if none is named")
    parser.add_argument("-b", "--blender", default=blenders.SYSTEM, choices=blenders.NAMES)
    parser.add_argument("-o", "--output", type=Path, default=Path("parity"), help="folder for pictures")
    parser.add_argument("--cycles-only", action="store_true", help="compare Cycles with itself")
    arguments = parser.parse_args()
    host = blenders.blender(arguments.blender)
    subject = ("cycles:3", "cycles:4") if arguments.cycles_only else SUBJECT
    for name in arguments.scenes or catalogue.SCENES:
        folder = arguments.output / arguments.blender / name
        try:
            pictures, log = render(host, name, folder, REFERENCE + subject)
        except blenders.Died as error:
            print("%-28s %s" % (name, str(error)[-1500:]), flush=True)
            continue
        found = difference(pictures, REFERENCE, subject)
        seconds = " ".join("%.1f" % one for one in log["seconds"].values())
        verdict = "ok   " if found.deviation < LIMIT and found.noise < NOISE else "WRONG"
        print("%-28s %s %s (%s s)" % (name, verdict, found, seconds), flush=True)
        side_by_side(arguments.output / arguments.blender / (name + ".png"),
                     [pictures[job] for job in REFERENCE], [pictures[job] for job in subject])


if __name__ == "__main__":
    main()
