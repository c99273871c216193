"""Integrators side by side on one recorded scene: CPU time of a sample, and mean squared error of luminance and of chroma.

Variance is measured between renders of different seeds, so it needs no reference; n·MSE/(mean Y)² is what one sample per pixel has, and times
the cost of a sample it compares at equal time. A mollified integrator's bias is no part of it."""

import os
import resource
import statistics
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "system"))
import exr  # noqa: E402

INTEGRATORS = ("pt_nee", "mbdpt", "bdpt")
SEEDS = 6
SAMPLES = 4


def render(core, scene, integrator, seed, out):
    """The picture, RGB of the working space, and CPU seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([core, "render", scene, "-o", out, "-q", "--integrator", integrator, "--seed", str(seed), "--spp", str(SAMPLES)],
                   check=True)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    channels = exr.read(out).channels
    return np.array([channels[name] for name in "RGB"], dtype=float), seconds


def chroma(rgb):
    """Opponent axes, which grey noise leaves alone."""
    return np.array([rgb[0] - rgb[1], rgb[2] - 0.5 * (rgb[0] + rgb[1])])


def main():
    core, scene = sys.argv[1:]
    weights = np.array([0.2126, 0.7152, 0.0722]).reshape(3, 1, 1)
    pictures, costs = {name: [] for name in INTEGRATORS}, {name: [] for name in INTEGRATORS}
    with tempfile.TemporaryDirectory() as directory:
        for seed in range(SEEDS):  # in turn, so that a slow minute slows them all
            for name in INTEGRATORS:
                picture, seconds = render(core, scene, name, seed, os.path.join(directory, "out.exr"))
                pictures[name].append(picture)
                costs[name].append(seconds / (picture.shape[1] * picture.shape[2] * SAMPLES))
    print("%-8s %14s %10s %12s %12s %18s" % ("", "µs a sample", "ratio", "luminance", "chroma", "at equal time"))
    first = None
    for name in INTEGRATORS:
        stack = np.array(pictures[name])
        mean = (stack * weights).sum(axis=1).mean()
        light = (stack * weights).sum(axis=1).var(axis=0, ddof=1).mean() * SAMPLES / mean**2
        color = np.array([chroma(p) for p in stack]).var(axis=0, ddof=1).mean() * SAMPLES / mean**2
        cost = statistics.median(costs[name])
        first = first or (cost, light, color)
        print("%-8s %14.2f %10.2f %12.3g %12.3g %9.2f %8.2f" % (name, 1e6 * cost, cost / first[0], light, color,
              first[0] * first[1] / (cost * light), first[0] * first[2] / (cost * color)))


main()
