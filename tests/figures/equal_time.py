"""Equal-time comparison of the integrators on spheres, UFO and lens against a long reference: the benchmark's tables
and plots."""

import bench_exact as benchmark
import bench_plots
import kit
import plots

SCENES = ("spheres", "ufo", "lens")
KERNELS = ((100, 0), (50, 0.2), (20, 0.2))
SIZE = ((28, 21), 192, 2, 16) if kit.QUICK else ((64, 48), 1024, 3, 128)  # as in benchmark.SIZES


def draw():
    found = benchmark.methods([1], KERNELS)
    done, lines = {}, ["# Integrators at equal time", *(benchmark.HEAD % "").split("\n")[1:]]
    for name in SCENES:
        done[name] = benchmark.measure_scene(name, found, SIZE, plots.WORK, lambda text: None)
        lines += benchmark.table(name, *done[name])
    (plots.FOLDER / "equal-time.md").write_text("\n".join(lines), encoding="utf-8")
    bench_plots.error_over_time(done, SIZE, plots.FOLDER / "equal-time-error.png")
    bench_plots.side_by_side(done, plots.FOLDER / "equal-time-pictures.png")
    kit.say("  equal-time.md, equal-time-error.png, equal-time-pictures.png")
