"""`bdpt` against the others, scene by scene, in one run: mean squared error of luminance and of chroma against a long
reference, at equal samples and at equal processor time, and what each is off by. Writes a table and plots.

The reference is `bdpt` too (its agreement with `pt_nee` is what tests/system proves, and the table shows again), in
two halves A and B of other seeds: the mean of (x − A)(x − B) is the mean squared error of x without the reference's
own noise. Integrators take turns, so that a slow minute slows them all."""

import argparse
import hashlib
import pathlib
import statistics
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "figures"))

import bench_scenes  # noqa: E402  (found by the line above)
import kit  # noqa: E402

KERNELS = ((100, 0), (50, 0.2), (20, 0.2), (10, 0))  # d0 in nm and s of mbdpt
BIAS_LIMIT = 2.0  # %, of X, Y and Z: "low bias"
LAMP = 10.0  # times the median luminance: a pixel brighter than this shows a lamp, or its mirror image
MISSES = -20.0  # %, of Y: no comparison with a picture that lacks so much
WHITE = np.array([0.95047, 1.0, 1.08883])
SIZES = {  # resolution, samples of each half of the reference, seeds, samples
    False: ((48, 36), 2048, 3, 64),
    True: ((32, 24), 256, 2, 32),
}
SEEDS = {"spheres": 4}  # times as many: there a few bright caustics are most of the error


class Method:
    def __init__(self, integrator, kernel=None, lanes=None):
        self.integrator, self.kernel, self.lanes = integrator, kernel, lanes
        self.options = {"integrator": integrator}
        if kernel:
            self.options.update(d0=kernel[0], shrink=kernel[1])
        if lanes:
            self.options.update(lanes=lanes)

    def label(self):
        kernel = " d0=%g s=%g" % self.kernel if self.kernel else ""
        return self.integrator + kernel + (" N=%d" % self.lanes if self.lanes and self.lanes > 1 else "")

    def file(self):
        return self.label().replace(" ", "-").replace("=", "")


def methods(lanes, kernels=KERNELS):
    found = []
    for n in lanes if kit.has_option("lanes") else [None]:
        found += [Method(name, None, n) for name in ("pt_nee", "lt", "bdpt")]
        found += [Method("mbdpt", kernel, n) for kernel in kernels]
    return found


def channels(picture):
    """Luminance, and two opponent axes that grey noise leaves alone: X/Xn − Y and Z/Zn − Y."""
    scaled = picture / WHITE
    return scaled[..., 1:2], scaled[..., [0, 2]] - scaled[..., 1:2]


def widened(mask):
    """And the pixels around: a pixel's filter reaches into its neighbours."""
    padded = np.pad(mask, 1)
    rows, columns = mask.shape
    return np.any([padded[y : y + rows, x : x + columns] for y in range(3) for x in range(3)], axis=0)


class Reference:
    def __init__(self, scene, samples, folder):
        key = hashlib.sha256(scene.read_bytes()).hexdigest()[:16]
        self.halves = []
        for half in (1, 2):
            path = folder / ("%s-%s-%d-%d.exr" % (scene.stem, key, samples, half))
            if not path.exists():
                kit.render(scene, path.with_suffix(".part.exr"), integrator="bdpt", spp=samples, seed=1000 + half)
                path.with_suffix(".part.exr").rename(path)
            self.halves.append(kit.read_xyz(path))
        self.picture = sum(self.halves) / 2
        self.counted = ~widened(self.picture[..., 1] > LAMP * np.median(self.picture[..., 1]))
        self.mean = self.mean_of(self.picture)

    def mean_of(self, picture):
        return picture[self.counted].mean(axis=0)

    def errors(self, picture):
        """Mean squared error of luminance and of chroma over (mean Y)²."""
        a, b = (channels(half[self.counted]) for half in self.halves)
        x = channels(picture[self.counted])
        return np.array([((x[i] - a[i]) * (x[i] - b[i])).sum(axis=-1).mean() / self.mean[1] ** 2 for i in range(2)])

    def noise(self):
        """Of its mean X, Y, Z, %."""
        means = np.array([self.mean_of(half) for half in self.halves])
        return 100 * np.abs(means[0] - means[1]) / 2 / self.mean


class Result:
    """What one integrator gave in one scene, over its seeds."""

    def __init__(self, method, counts, scene, out):
        self.method, self.counts = method, counts
        self.light_paths, self.first = "", 0
        if method.integrator == "bdpt":
            self.light_paths = " L=%g" % kit.light_paths(scene, out, method.lanes or 1)
            self.first = kit.LATE
        self.errors, self.means, self.costs = [], [], []
        self.picture = None

    def options(self, count, seed):
        """Of so many samples."""
        return dict(self.method.options, seed=seed, samples="%d:%d" % (self.first, self.first + count))

    def cost(self):
        """Processor seconds of a sample."""
        return statistics.median(self.costs)

    def noise(self):
        """n·MSE/(mean Y)² of luminance and chroma with all samples, and their standard errors."""
        last = np.array(self.errors)[:, -1] * self.counts[-1]
        return last.mean(axis=0), last.std(axis=0, ddof=1) / np.sqrt(len(last))

    def bias(self, reference):
        """Off by, %, and its standard error."""
        means = 100 * (np.array(self.means) / reference.mean - 1)
        error = means.std(axis=0, ddof=1) / np.sqrt(len(means))
        return means.mean(axis=0), np.hypot(error, reference.noise())

    def misses(self, reference):
        """Whether it surely lacks so much light that its error says nothing."""
        bias, error = self.bias(reference)
        return bias[1] < MISSES and bias[1] < -3 * error[1]


def measure_scene(name, found, size, folder, progress):
    resolution, reference_samples, seeds, samples = size
    scene = bench_scenes.write(name, folder / "scenes", resolution)
    progress("reference")
    reference = Reference(scene, reference_samples, folder / "reference")
    counts = [2**k for k in range(samples.bit_length())]
    pixels, out = resolution[0] * resolution[1], folder / "out" / "out.exr"
    out.parent.mkdir(parents=True, exist_ok=True)
    results = [Result(method, counts, scene, out) for method in found]
    for seed in range(seeds):
        for result in results:
            progress("seed %d of %d, %s" % (seed + 1, seeds, result.method.label()))
            start = kit.render(scene, out, **result.options(1, seed + 1))
            whole = kit.render(scene, out, snapshots=True, **result.options(samples, seed + 1))
            result.costs.append(max(whole - start, 1e-9) / (pixels * (samples - 1)))
            shots = [kit.read_xyz(kit.snapshot(out, count)) for count in counts]
            result.errors.append([reference.errors(shot) for shot in shots])
            result.means.append(reference.mean_of(shots[-1]))
    equal_time(scene, results, samples, out, progress)
    return reference, results


def equal_time(scene, results, samples, out, progress):
    """Pictures that took each as long as `bdpt` takes for its samples."""
    budget = samples * next(r.cost() for r in results if r.method.integrator == "bdpt")
    for result in results:
        progress("at equal time, %s" % result.method.label())
        result.spp = max(1, round(budget / result.cost()))
        result.picture = kit.picture_of(scene, out, **result.options(result.spp, 77))


# --- What it says ------------------------------------------------------------------------------------


def table(name, reference, results):
    lines = [
        "## %s" % bench_scenes.TITLES[name],
        "",
        "%.1f %% of the pixels show a lamp or lie beside one, and are left out."
        % (100 * (1 - reference.counted.mean())),
        "",
        "| integrator | µs a sample | n·MSE luminance | n·MSE chroma "
        "| at equal time: luminance | chroma | off by, %: X | Y | Z |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    base = next(r for r in results if r.method.integrator == "bdpt" and not (r.method.lanes or 1) > 1)
    base_rate = base.cost() * base.noise()[0]
    for result in results:
        noise, error = result.noise()
        bias, bias_error = result.bias(reference)
        gains = base_rate / (result.cost() * noise) * (not result.misses(reference))
        lines.append(
            "| %s | %.2f | %s | %s | %s | %s | %s | %s | %s |"
            % (
                result.method.label() + result.light_paths,
                1e6 * result.cost(),
                *("%.3g ± %.1g" % pair for pair in zip(noise, error)),
                *("%.2f×" % gain if gain > 0 else "–" for gain in gains),
                *("%+.2f ± %.2f" % pair for pair in zip(bias, bias_error)),
            )
        )
    return lines + ["", verdict(reference, results), ""]


def verdict(reference, results):
    exact = [r for r in results if r.method.integrator == "bdpt"]
    low = [r for r in results if r.method.kernel and (np.abs(r.bias(reference)[0]) < BIAS_LIMIT).all()]
    if not low:
        return "No `mbdpt` here is off by less than %g %% in X, Y and Z." % BIAS_LIMIT
    parts = []
    for channel, what in enumerate(("luminance", "chroma")):
        first, second = (min(group, key=lambda r: r.cost() * r.noise()[0][channel]) for group in (exact, low))
        ratio = second.cost() * second.noise()[0][channel] / (first.cost() * first.noise()[0][channel])
        parts.append(
            "in %s %.2f times that of `bdpt` (%s against %s)"
            % (what, ratio, second.method.label(), first.method.label())
        )
    return "At equal time the squared error of the best `mbdpt` that is off by less than %g %% is %s." % (
        BIAS_LIMIT,
        ", ".join(parts),
    )


HEAD = """# Exact connections against the rest

n·MSE is the mean squared error over (mean Y)² times the number of samples per pixel: what one sample has. "At equal
time" is how much less squared error a second of processor time leaves than `bdpt` (without lanes) does: above 1× is
better than it. Luminance is Y; chroma is (X/Xn − Y, Z/Zn − Y). ± is one standard error; – stands where a fifth of the
light or more is missing. `lt` leaves out what the camera sees in mirrors and glass. Pixels that show a lamp, directly
or in a mirror, do not count: every integrator but `lt` gets them in the same way, and they are so bright that their
noise would be all of the error. `bdpt` has as many light sub-paths a sample, L, as it finds to pay in this scene; a
picture of 512 × 512 pixels has them from its eighth sample on.
%s
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--output", type=pathlib.Path, default=kit.ROOT / "build" / "bench")
    parser.add_argument("--scenes", nargs="+", default=list(bench_scenes.FIVE), choices=list(bench_scenes.TITLES))
    parser.add_argument("--lanes", nargs="+", type=int, default=[1, 4, 8])
    options = parser.parse_args()
    found = methods(options.lanes)
    lanes = "" if kit.has_option("lanes") else "\nThis core has no `--lanes`: every path has one wavelength.\n"
    lines, done = (HEAD % lanes).split("\n"), {}
    for name in options.scenes:
        resolution, reference, seeds, samples = SIZES[kit.QUICK]
        size = resolution, reference, seeds * SEEDS.get(name, 1), samples
        done[name] = measure_scene(name, found, size, options.output, lambda text: kit.say("%s: %s" % (name, text)))
        lines += table(name, *done[name])
        kit.say("\n".join(table(name, *done[name])))
        (options.output / "exact.md").write_text("\n".join(lines), encoding="utf-8")
    import bench_plots

    bench_plots.error_over_time(done, SIZES[kit.QUICK], options.output / "exact-error.png")
    bench_plots.side_by_side(done, options.output / "exact-pictures.png")
    kit.say("wrote", *sorted(str(path) for path in options.output.glob("exact*")))


if __name__ == "__main__":
    main()
