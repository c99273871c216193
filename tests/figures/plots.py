"""What all plots share: their look, and where they go."""

import pathlib

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

import colour  # noqa: E402
import kit  # noqa: E402

FOLDER = pathlib.Path(kit.ROOT / "build" / "figures")
WORK = FOLDER / "work"  # scenes, renders, references
REFLECTANCE, ABSORPTION, EMISSION = "#2a9d3a", "#2458c5", "#c8202a"

plt.rcParams.update(
    {
        "font.size": 9,
        "axes.titlesize": 9.5,
        "axes.grid": True,
        "grid.alpha": 0.25,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "legend.frameon": False,
        "legend.fontsize": 8,
        "figure.dpi": 110,
    }
)


def save(figure, name):
    FOLDER.mkdir(parents=True, exist_ok=True)
    figure.savefig(FOLDER / (name + ".png"), bbox_inches="tight")
    plt.close(figure)
    kit.say("  %s.png" % name)


def spectrum_axes(axes, quantity, top=None):
    axes.set_xlabel("wavelength (nm)")
    axes.set_ylabel(quantity)
    axes.set_xlim(300, 830)
    axes.set_ylim(0, top)


def picture(axes, xyz, gain, title=""):
    axes.imshow(colour.srgb(xyz, gain), interpolation="nearest")
    axes.set_title(title)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def matrix(axes, values, low=300, high=830, floor=2e-4, top=0.02):
    """A reradiation matrix: incident wavelengths to the right, leaving ones upward; logarithmic."""
    image = axes.imshow(
        np.maximum(values, floor / 10),
        origin="lower",
        extent=(low, high, low, high),
        norm=matplotlib.colors.LogNorm(floor, top),
        cmap="magma",
        interpolation="nearest",
    )
    axes.set_xlabel("incident wavelength (nm)")
    axes.set_ylabel("leaving wavelength (nm)")
    axes.grid(False)
    return image


def scale(figure, image, axes, label):
    """The colour scale of a matrix, as high as it is."""
    figure.colorbar(image, ax=axes, label=label, fraction=0.046, pad=0.04)
