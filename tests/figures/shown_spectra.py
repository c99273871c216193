"""Figures 4 to 6: the spectra of the test scenes, read from the scripts that build them."""

import numpy as np

import colour
import plots
import spectra
from plots import plt
from spectra import constants, medium

NM = np.arange(300.0, 831.0)


def below(panel, columns):
    """A legend where no curve passes."""
    panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncol=columns)


def ground_where_hardly_seen(panel):
    """Beyond these wavelengths a colour says nothing of its curve: there a blue may be as bright as a red."""
    nm = np.arange(360.0, 831.0)
    seen = nm[colour.cmf(nm).max(axis=1) > 0.01 * colour.cmf(nm).max()]
    label = "hardly seen: under 1 % of the eye's peak"
    panel.axvspan(NM[0], seen[0], color="0.93", zorder=0, label=label)
    panel.axvspan(seen[-1], NM[-1], color="0.93", zorder=0)


def figure_4():
    bias = constants("bias")
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.2), sharey=True)
    for name, rgb in bias["RGB"].items():
        color = name if name != "grey" else "#777777"
        axes[0].plot(NM, spectra.upsampled(rgb, NM), color=color, label="%s (%g, %g, %g)" % (name, *rgb))
        nm, measured = spectra.measured_reflectance({"rgb": list(rgb)}, plots.WORK / "reflectance")
        axes[0].plot(nm, measured, "o", color=color, markersize=2.5)
    axes[0].plot([], [], "-", color="black", label="lines: fitted here, as [JH19]")
    axes[0].plot([], [], "o", color="black", markersize=2.5, label="dots: measured in the core's renders")
    ground_where_hardly_seen(axes[0])
    axes[0].set_title("upsampled from linear sRGB, held below 360 nm")
    for patch, color in zip(bias["PATCHES"].values(), ("#00a0c0", "green", "#c02020")):
        axes[1].plot(NM, spectra.library("colorchecker/" + patch, NM), color=color, label="ColorChecker " + patch)
    axes[1].set_title("measured patches, held constant beyond their tables")
    for panel, columns in zip(axes, (2, 2)):
        plots.spectrum_axes(panel, "reflectance", 1.02)
        below(panel, columns)
    figure.tight_layout()
    plots.save(figure, "figure-04-reflectances")


def painted(axes, paint, title):
    patch, dye, absorbance = paint
    axes.plot(NM, spectra.library("colorchecker/" + patch, NM), color=plots.REFLECTANCE, label="reflectance")
    axes.plot(NM, spectra.absorbed(dye, absorbance, NM), color=plots.ABSORPTION, label="absorption")
    emission = spectra.emitted(dye, NM)
    axes.plot(NM, emission / emission.max(), color=plots.EMISSION, label="emission (of its peak)")
    axes.set_title("%s: %s, %s" % (title, patch.replace("_", " "), dye.partition("_")[0]))
    plots.spectrum_axes(axes, "share", 1.05)


def figure_5():
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.4), sharey=True)
    for panel, (wall, paint) in zip(axes, constants("spheres")["PAINTS"].items()):
        painted(panel, paint, wall)
    axes[0].legend()
    figure.tight_layout()
    plots.save(figure, "figure-05-spheres")


def figure_6():
    figure, axes = plt.subplots(1, 2, figsize=(9.5, 3.6))
    extinction, albedo = medium(NM)
    axes[0].plot(NM, albedo, color=plots.EMISSION, label="albedo")
    plots.spectrum_axes(axes[0], "single-scattering albedo", 1)
    right = axes[0].twinx()
    right.plot(NM, extinction, color=plots.ABSORPTION, label="extinction")
    right.set_ylabel("extinction $\\mu_t$ (1/m)")
    right.set_ylim(0, None)
    right.grid(False)
    right.spines["right"].set_visible(True)
    axes[0].legend(handles=[*axes[0].get_lines(), *right.get_lines()], loc="lower left")
    axes[0].set_title("medium of the UFO scene")
    painted(axes[1], constants("ufo")["CORAL"], "coral")
    axes[1].legend()
    figure.tight_layout()
    plots.save(figure, "figure-06-ufo")


def draw():
    figure_4()
    figure_5()
    figure_6()
