"""Figures 4 to 6: the spectra of the test scenes, read from the scripts that build them."""

import numpy as np

import plots
import spectra
from plots import plt
from spectra import constants, medium

NM = np.arange(300.0, 831.0)


def figure_4():
    bias = constants("bias")
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.6), sharey=True)
    for name, rgb in bias["RGB"].items():
        (line,) = axes[0].plot(NM, spectra.upsampled(rgb, NM), color=name if name != "grey" else "#777777", label=name)
        nm, measured = spectra.measured_reflectance({"rgb": list(rgb)}, plots.WORK / "reflectance")
        axes[0].plot(nm, measured, "o", color=line.get_color(), markersize=2.5)
    axes[0].set_title("upsampled from RGB; dots: measured in the core's renders")
    for patch, color in zip(bias["PATCHES"].values(), ("#00a0c0", "green", "#c02020")):
        axes[1].plot(NM, spectra.library("colorchecker/" + patch, NM), color=color, label="ColorChecker " + patch)
    axes[1].set_title("measured patches, held constant beyond their tables")
    for panel in axes:
        plots.spectrum_axes(panel, "reflectance", 1.02)
        panel.legend(loc="center right")
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
