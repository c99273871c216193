"""Figure 7: the lens scene at 4, 32, 256 and 1024 samples per pixel, unmollified and mollified with several (d0, s);
and whether what the supplemental says of it (§4.3) holds here."""

import numpy as np

import bench_exact
import bench_scenes
import colour
import kit
import plots
from plots import plt

RESOLUTION, REFERENCE = ((16, 16), 256) if kit.QUICK else ((80, 80), 4096)
ROWS = (4, 32, 256, 1024)
UNMOLLIFIED = "BDPT, unmollified"  # both sub-paths at one wavelength
PREVIEW = (100, 0)
KERNELS = ((25, 0.4), (50, 0.2), (100, 0.1), PREVIEW)


def columns():
    found = {}
    if kit.has_option("shared-wavelength"):
        found[UNMOLLIFIED] = ["--shared-wavelength"], {"integrator": "mbdpt", "lanes": 1}
    for d0, s in KERNELS:
        found[kernel_title(d0, s)] = [], {"integrator": "mbdpt", "d0": d0, "shrink": s}
    found["exact bdpt"] = [], {"integrator": "bdpt"}
    return found


def kernel_title(d0, s):
    return "$d_0$ = %g nm, s = %g" % (d0, s)


class Column:
    def __init__(self, scene, flags, options, reference):
        out = plots.WORK / "lens.exr"
        self.counts = [2**k for k in range(ROWS[-1].bit_length())]
        kit.render(scene, out, snapshots=True, flags=flags, spp=ROWS[-1], **options)
        self.pictures = {count: kit.read_xyz(kit.snapshot(out, count)) for count in self.counts}
        errors = np.array([reference.errors(self.pictures[count]) for count in self.counts])
        self.luminance, self.chroma = np.sqrt(np.clip(errors, 0, None)).T

    def at(self, count):
        index = self.counts.index(count)
        return self.luminance[index], self.chroma[index]


def pictures(shown, reference):
    figure, axes = plt.subplots(len(ROWS), len(shown) + 1, figsize=(2.1 * (len(shown) + 1), 2.35 * len(ROWS)))
    gain = colour.exposure(reference.picture, 95)
    for row, count in zip(axes, ROWS):
        for panel, (title, column) in zip(row, shown.items()):
            plots.picture(panel, column.pictures[count], gain, title if count == ROWS[0] else "")
            panel.set_xlabel("RMSE Y %.2f, chroma %.2f" % column.at(count), fontsize=7)
        plots.picture(row[-1], reference.picture, gain, "reference" if count == ROWS[0] else "")
        row[0].set_ylabel("%d spp" % count)
    figure.tight_layout()
    plots.save(figure, "figure-07-lens")


def errors(shown):
    figure, axes = plt.subplots(1, 2, figsize=(10, 4))
    for title, column in shown.items():
        line = {"exact bdpt": {"color": "black"}, UNMOLLIFIED: {"color": "#777777", "linestyle": "--"}}.get(title, {})
        for panel, values in zip(axes, (column.luminance, column.chroma)):
            panel.loglog(column.counts, values, marker="o", markersize=3, label=title, **line)
    for panel, what in zip(axes, ("luminance", "chroma")):
        panel.set_xlabel("samples per pixel")
        panel.set_ylabel("RMSE of %s / mean luminance" % what)
    axes[0].legend()
    figure.suptitle("Lens scene: error against a long reference")
    figure.tight_layout()
    plots.save(figure, "figure-07-lens-error")


def claim(text, first, second):
    """One line per channel: whether the first error is the lower one."""
    return [
        "- %s, %s: %s (%.3f against %.3f)" % (text, what, "holds" if a < b else "does NOT hold", a, b)
        for what, a, b in zip(("luminance", "chroma"), first, second)
    ]


def overtaking(preview, column, shrink):
    """When, in luminance, a kernel that shrinks overtakes one that does not: the error² of the latter is a bias² that
    stays and a variance ∝ 1/n, that of the former a variance ∝ n^(s−1), for a sample's variance goes with 1/d_n."""
    early, late = (preview.at(count)[0] ** 2 for count in (256, 1024))
    bias_squared = (4 * late - early) / 3
    if bias_squared <= 0:
        return "what the kernel that stays is off by is below its noise"
    samples = 1024 * (column.at(1024)[0] ** 2 / bias_squared) ** (1 / (1 - shrink))
    return "overtakes in luminance at about %.2g spp (what stays is off by %.3f)" % (samples, bias_squared**0.5)


def claims(shown):
    preview, exact = shown[kernel_title(*PREVIEW)], shown["exact bdpt"]
    shrinking = [shown[kernel_title(*kernel)] for kernel in KERNELS if kernel[1] > 0]
    best = np.min([column.at(1024) for column in shrinking], axis=0)
    lines = ["# What the supplemental says of the lens scene (§4.3, figure 7)", ""]
    if UNMOLLIFIED in shown:
        plain = shown[UNMOLLIFIED]
        lines += claim("at 4 spp d0 = 100 nm, s = 0 errs less than the unmollified BDPT", preview.at(4), plain.at(4))
        lines += claim("at 1024 spp a shrinking kernel errs less than the unmollified BDPT", best, plain.at(1024))
    else:
        lines += [
            "- this core has no `--shared-wavelength`: the unmollified BDPT is left out, and what compares with it"
        ]
    lines += claim("at 1024 spp a shrinking kernel errs less than d0 = 100 nm, s = 0", best, preview.at(1024))
    for (d0, s), column in zip([kernel for kernel in KERNELS if kernel[1] > 0], shrinking):
        lines.append("    - d0 = %g nm, s = %g: %s" % (d0, s, overtaking(preview, column, s)))
    rivals = np.min([best, preview.at(1024)], axis=0)
    return lines + claim("at 1024 spp the exact bdpt errs less than the best mollified one", exact.at(1024), rivals)


def draw():
    scene = bench_scenes.write("lens", plots.WORK, RESOLUTION)
    kit.say("  lens: reference")
    reference, shown = bench_exact.Reference(scene, REFERENCE, plots.WORK / "reference"), {}
    for title, (flags, options) in columns().items():
        kit.say("  lens: %s" % title.replace("$", ""))
        shown[title] = Column(scene, flags, options, reference)
    pictures(shown, reference)
    errors(shown)
    lines = claims(shown)
    (plots.FOLDER / "figure-07-claims.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    kit.say(*["  " + line for line in lines[2:]], sep="\n")
