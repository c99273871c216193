"""Variance times cost of integrators in one scene, seed against seed: minutes less than bench_exact.py, and blind to bias.

variance.py SCENE OPTIONS [OPTIONS …]: `variance.py box "-i pt_nee" "-i bdpt --lanes 4"`, in a scene of bench_scenes.py or a .stokes file.
`bdpt` is measured behind its looks at the scene, as it would be after a while in a larger picture."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "figures"))

import bench_scenes  # noqa: E402
import kit  # noqa: E402
import numpy as np  # noqa: E402

FOLDER = kit.ROOT / "build" / "bench"
RESOLUTION, SAMPLES, SEEDS = (64, 48), 64, 3
WHITE = np.array([0.9505, 1.0, 1.089])
BRIGHT = 4  # times the median's mean: a lamp, whose noise would be all there is


def pictures(scene, options):
    """[seed, row, column, XYZ], and processor time in µs a sample."""
    first = kit.LATE if "bdpt" in options else 0
    made, seconds = [], 0
    for seed in range(1, SEEDS + 1):
        for count in (1, SAMPLES):  # the first is start-up, and looks
            begin = kit.cpu_seconds()
            words = ["--samples", "%d:%d" % (first, first + count), "--seed", seed, "-t", 1, *options]
            kit.stokes("render", scene, "-o", FOLDER / "variance.exr", "-q", *words)
            seconds += (kit.cpu_seconds() - begin) * (1 if count > 1 else -1)
        made.append(kit.read_xyz(FOLDER / "variance.exr"))
    made = np.array(made)
    return made, 1e6 * seconds / (SEEDS * (SAMPLES - 1) * made[0, ..., 0].size)


def measure(scene, options):
    """µs a sample; variance of one sample's luminance and chroma over (mean Y)²."""
    xyz, cost = pictures(scene, options)
    y = xyz[..., 1]
    chroma = np.stack([xyz[..., 0] / WHITE[0] - y, xyz[..., 2] / WHITE[2] - y], axis=-1)
    kept = np.median(y, axis=0) < BRIGHT * np.median(y.mean(axis=0))
    scale = SAMPLES / y[:, kept].mean() ** 2
    return cost, scale * y.var(axis=0, ddof=1)[kept].mean(), scale * chroma.var(axis=0, ddof=1)[kept].sum(axis=-1).mean()


def main(name, *configurations):
    FOLDER.mkdir(parents=True, exist_ok=True)
    scene = name if name.endswith(".stokes") else bench_scenes.write(name, FOLDER, RESOLUTION)
    for options in configurations:
        cost, luminance, chroma = measure(scene, options.split())
        kit.say(
            "%-44s %6.2f µs, variance of Y %.4g, of chroma %.4g; times cost %.4g and %.4g"
            % (options, cost, luminance, chroma, cost * luminance, cost * chroma)
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
