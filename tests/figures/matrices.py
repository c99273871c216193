"""Figures 1 to 3: a fluorescent material, its reradiation matrix, and what each kernel makes of it; column sums show
the energy."""

import bispectral
import plots
import spectra
from plots import plt

DYE, ABSORBANCE, PATCH, YIELD = "rhodamine-6g_ethanol", 1.5, "colorchecker/white", 0.95
WIDTH = 50.0  # d, nm
BIN = 5.0  # nm, in which the unmollified diagonal is shown


def material():
    nm = bispectral.GRID
    return bispectral.Material(
        spectra.library(PATCH, nm), spectra.absorbed(DYE, ABSORBANCE, nm), spectra.emitted(DYE, nm), 1.0, YIELD
    )


def figure_1():
    nm, m = bispectral.GRID, material()
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), width_ratios=(1, 1, 1.15))
    axes[0].plot(nm, m.r, color=plots.REFLECTANCE)
    axes[0].set_title("reflectance (ColorChecker white)")
    plots.spectrum_axes(axes[0], "reflectance", 1.05)
    axes[1].plot(nm, m.a, color=plots.ABSORPTION, label="absorption")
    plots.spectrum_axes(axes[1], "absorption", 1.05)
    right = axes[1].twinx()
    right.plot(nm, m.e, color=plots.EMISSION, label="emission")
    right.set_ylabel("emission (1/nm)")
    right.set_ylim(0, None)
    right.grid(False)
    right.spines["right"].set_visible(True)
    axes[1].set_title("rhodamine 6G, absorbance %g" % ABSORBANCE)
    figure.legend(*zip(*[(h, h.get_label()) for a in (axes[1], right) for h in a.get_lines()]), loc=(0.375, 0.72))
    image = plots.matrix(axes[2], m.matrix(bispectral.unmollified(m, BIN)), top=0.2)
    axes[2].set_title("reradiation matrix (diagonal: bins of %g nm)" % BIN)
    plots.scale(figure, image, axes[2], "share per nm")
    figure.tight_layout()
    plots.save(figure, "figure-01-material")


def columns(axes, m, kernels):
    """Column sums of energy, and of photons."""
    nm = bispectral.GRID
    for (label, kernel), color in zip(kernels, ("#444444", "#d95f02", "#7570b3", "#1b9e77", "#e7298a")):
        whole = m.matrix(kernel(m, WIDTH))
        axes[0].plot(nm, bispectral.energy(whole), color=color, label=label)
        axes[1].plot(nm, bispectral.photons(whole), color=color, label=label)
    for panel, what in zip(axes, ("energy", "photons")):
        panel.axhline(1, color="black", linewidth=0.8, linestyle=":")
        panel.set_xlabel("incident wavelength (nm)")
        panel.set_ylabel("%s out / in" % what)
        panel.set_xlim(300, 830)
        panel.set_ylim(0, 1.5)


def two(name, title, kernels):
    m = material()
    figure, axes = plt.subplots(2, 2, figsize=(9.2, 7.4), height_ratios=(1.7, 1))
    for panel, (label, kernel) in zip(axes[0], kernels):
        image = plots.matrix(panel, m.matrix(kernel(m, WIDTH)))
        panel.set_title(label)
        plots.scale(figure, image, panel, "share per nm")
    columns(axes[1], m, kernels)
    axes[1][0].legend(loc="lower right")
    figure.suptitle(title)
    figure.tight_layout()
    plots.save(figure, name)


def figure_2():
    kernels = [
        ("$r(\\lambda)$ mollified with $f_{mi}$", bispectral.incident_reflectance),
        ("$(1-ca(\\lambda))\\,r(\\lambda)$ mollified with $f_{mi}$", bispectral.incident_diagonal),
    ]
    two(
        "figure-02-incident",
        "Incident mollification, d = %g nm: on the whole diagonal it makes energy" % WIDTH,
        kernels,
    )


def figure_3():
    kernels = [
        ("$r(\\lambda)$ mollified with $f_{mo}$", bispectral.constant),
        ("$(1-ca(\\lambda))\\,r(\\lambda)$ mollified with $f_{mo}$", bispectral.constant),
    ]
    two("figure-03-constant", "Constant mollification, d = %g nm: both are the same and keep energy" % WIDTH, kernels)


def every_kernel():
    """Beyond the supplemental: all kernels, and the counterexample of eqs. 3 to 6."""
    m = material()
    kernels = list(bispectral.KERNELS.items())
    figure, axes = plt.subplots(2, 5, figsize=(17, 7), layout="constrained")
    for panel, (label, kernel) in zip(axes[0], kernels):
        image = plots.matrix(panel, m.matrix(kernel(m, WIDTH)))
        panel.set_title(label)
        panel.set_ylabel("leaving wavelength (nm)" if panel is axes[0][0] else "")
    figure.colorbar(image, ax=axes[0], label="share per nm", fraction=0.02, pad=0.01)
    columns(axes[1][:2], m, kernels)
    figure.legend(*axes[1][0].get_legend_handles_labels(), loc="outside lower center", ncols=len(kernels))
    example, nm = bispectral.counterexample(), bispectral.GRID
    top = 0
    for (_, kernel), color in zip(kernels, ("#444444", "#d95f02", "#7570b3", "#1b9e77", "#e7298a")):
        whole = example.matrix(kernel(example, WIDTH))
        for panel, sums in zip(axes[1][2:4], (bispectral.energy(whole), bispectral.photons(whole))):
            panel.plot(nm, sums, color=color)
            top = max(top, sums.max())
    for panel, what in zip(axes[1][2:4], ("energy", "photons")):
        panel.axhline(1, color="black", linewidth=0.8, linestyle=":")
        panel.set_xlim(400, 700)
        panel.set_ylim(0, 1.05 * top)
        panel.set_xlabel("incident wavelength (nm)")
        panel.set_ylabel("%s out / in, eqs. 3–5" % what)
    axes[1][2].plot([600], [1.5], "o", color="black", markersize=4)
    axes[1][2].annotate("eq. 6 at 600 nm: 3/2", (600, 1.5), (420, 1.62), arrowprops={"arrowstyle": "-", "lw": 0.6})
    axes[1][4].plot(nm, example.r, color=plots.REFLECTANCE, label="reflectance")
    axes[1][4].plot(nm, example.a, "--", color=plots.ABSORPTION, label="absorption")
    axes[1][4].plot(nm, example.e / example.e.max(), color=plots.EMISSION, label="emission, of its peak")
    axes[1][4].set_xlim(400, 700)
    axes[1][4].set_xlabel("wavelength (nm)")
    axes[1][4].set_ylabel("spectra of eqs. 3–5")
    axes[1][4].legend(
        loc="lower center", bbox_to_anchor=(0.5, 1), ncols=3, fontsize=7, handlelength=1.2, columnspacing=1
    )
    figure.suptitle("Every kernel, d = %g nm" % WIDTH)
    plots.save(figure, "figure-03b-every-kernel")


def draw():
    figure_1()
    figure_2()
    figure_3()
    every_kernel()
