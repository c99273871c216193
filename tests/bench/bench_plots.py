"""Plots of the benchmark: error over processor time, and pictures of equal time side by side."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

import bench_scenes  # noqa: E402
import colour  # noqa: E402

COLORS = {"pt_nee": "#777777", "lt": "#b8a400", "bdpt": "#c1121f"}
BLUES = ("#9ecae1", "#4292c6", "#08519c", "#08306b")
STYLES = {1: "-", 4: "--", 8: ":"}


def look(method, kernels):
    color = BLUES[kernels.index(method.kernel) % len(BLUES)] if method.kernel else COLORS[method.integrator]
    return {"color": color, "linestyle": STYLES.get(method.lanes or 1, "-."), "label": method.label()}


def error_over_time(done, size, path):
    """A column for each scene; luminance above, chroma below."""
    pixels = size[0][0] * size[0][1]
    figure, axes = plt.subplots(2, len(done), figsize=(3.7 * len(done) + 0.6, 8), squeeze=False)
    for column, (name, (_, results)) in enumerate(done.items()):
        kernels = list(dict.fromkeys(r.method.kernel for r in results if r.method.kernel))
        for row, what in enumerate(("luminance", "chroma")):
            panel = axes[row][column]
            for result in results:
                errors = np.array(result.errors).mean(axis=0)[:, row]
                seconds = np.array(result.counts) * result.cost() * pixels
                shown = errors > 0
                panel.loglog(seconds[shown], np.sqrt(errors[shown]), **look(result.method, kernels))
            panel.set_title(bench_scenes.TITLES[name] if row == 0 else "", fontsize=10)
            panel.set_xlabel("processor time (s)" if row else "")
            panel.set_ylabel("relative RMSE of %s" % what if column == 0 else "")
            panel.grid(True, which="major", alpha=0.3)
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=7, fontsize=9, frameon=False)
    figure.tight_layout(rect=(0, 0.03 + 0.025 * -(-len(labels) // 7), 1, 1))
    figure.savefig(path, dpi=110)
    plt.close(figure)


def is_shown(method):
    """Without bundles all of them; with bundles `bdpt` with four wavelengths stands for all."""
    return (method.lanes or 1) == 1 or (method.integrator == "bdpt" and method.lanes == 4)


def side_by_side(done, path):
    """A row for each scene: the reference, then each integrator with the samples that the same time allows."""
    columns = 1 + max(sum(is_shown(r.method) for r in results) for _, results in done.values())
    figure, axes = plt.subplots(len(done), columns, figsize=(2.3 * columns, 2.3 * len(done)), squeeze=False)
    for axis in axes.flat:
        axis.set_axis_off()
    for row, (name, (reference, results)) in enumerate(done.items()):
        gain = colour.exposure(reference.picture, 95)
        shown = [("reference\n%s" % bench_scenes.TITLES[name], reference.picture)]
        shown += [("%s\n%d spp" % (r.method.label(), r.spp), r.picture) for r in results if is_shown(r.method)]
        for axis, (title, picture) in zip(axes[row], shown):
            axis.imshow(colour.srgb(picture, gain), interpolation="nearest")
            axis.set_title(title, fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)
