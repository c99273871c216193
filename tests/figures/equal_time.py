"""Equal-time comparison of the integrators on spheres, UFO and lens against a long reference: the benchmark's tables
and plots."""

import bench_exact as benchmark
import bench_plots
import kit
import plots

SCENES = ("spheres", "ufo", "lens")
KERNELS = ((100, 0), (50, 0.2), (20, 0.2))
SIZE = ((20, 15), 128, 2, 16) if kit.QUICK else ((64, 48), 1024, 3, 128)  # as in benchmark.SIZES


def against_unidirectional(reference, results):
    """Their squared error over that of the best bidirectional integrator in the same time."""
    rate = {r.method.label(): r.cost() * r.noise()[0] for r in results}
    best = min(
        (r.method.label() for r in results if r.method.integrator in ("bdpt", "mbdpt")), key=lambda n: rate[n][0]
    )
    lines = []
    for result in results:
        name = result.method.label()
        if name in ("pt_nee", "lt") and result.misses(reference):
            lines.append("`%s` lacks %.0f %% of the light." % (name, -result.bias(reference)[0][1]))
        elif name in ("pt_nee", "lt"):
            words = (name, *(rate[name] / rate[best]), best)
            lines.append(
                "The squared error of `%s` is %.2g times (luminance) and %.2g times (chroma) that of `%s`." % words
            )
    return [" ".join(lines), ""]


def draw():
    found = benchmark.methods([1], KERNELS)
    done, lines = {}, ["# Integrators at equal time", *(benchmark.HEAD % "").split("\n")[1:]]
    for name in SCENES:
        done[name] = benchmark.measure_scene(
            name, found, SIZE, plots.WORK, lambda text: kit.say("  %s: %s" % (name, text))
        )
        lines += benchmark.table(name, *done[name]) + against_unidirectional(*done[name])
    (plots.FOLDER / "equal-time.md").write_text("\n".join(lines), encoding="utf-8")
    bench_plots.error_over_time(done, SIZE, plots.FOLDER / "equal-time-error.png")
    bench_plots.side_by_side(done, plots.FOLDER / "equal-time-pictures.png")
    kit.say("  equal-time.md, equal-time-error.png, equal-time-pictures.png")
