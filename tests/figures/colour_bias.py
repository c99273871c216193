"""Figures 8 to 13: colour bias of mollified (2,2)-paths in empty boxes, measured beside predicted."""

import functools

import numpy as np

import acceptance
import colour
import kit
import plots
import spectra
from plots import plt
from spectra import constants

LAMBDA = (380.0, 780.0)  # Λ of these scenes: light has no more than the eye sees, so that its ends show (§5.2)
NM = np.arange(LAMBDA[0], LAMBDA[1], 0.5) + 0.25
WIDTHS = (10, 20, 50, 100)  # d, nm
PIXELS, SAMPLES = (8, 128) if kit.QUICK else (12, 4096)
MORE = {10: 8, 20: 4, 50: 2, 100: 1}  # times SAMPLES: a narrow kernel joins few paths
ZOOM = 0.25  # of the whole view: the middle of the back wall
BINS = (20, *LAMBDA)
LIGHT_IS_WHITE = (
    colour.WHITE / acceptance.white(NM) * acceptance.white(NM)[1]
)  # pictures are shown adapted to the even light


def reflectance(name):
    """As the stream says it, and on the grid."""
    bias = constants("bias")
    if name in bias["RGB"]:
        rgb = bias["RGB"][name]
        return {"rgb": list(rgb)}, spectra.upsampled(rgb, NM)
    patch = "colorchecker/" + bias["PATCHES"][name]
    return {"library": patch}, spectra.library(patch, NM)


def names():
    bias = constants("bias")
    return [*bias["RGB"], *bias["PATCHES"]]


def zoomed(members):
    frame = [ZOOM * edge for edge in members["frame"]]
    return dict(members, frame=frame, resolution=[PIXELS, PIXELS], border=[0, 0, PIXELS, PIXELS])


def even(low, high):
    """The shape of a light that is even between two wavelengths."""
    edge = 1e-3
    return {"table": {"lambda": [low, low + edge, high - edge, high], "value": [0, 1, 1, 0]}}


def scene(name, walls, kernel="constant", close=True, light=None, low=LAMBDA[0]):
    """The box of test_scenes/bias.py whose `walls` have the reflectance `name`, with Λ from `low`. `light`: a shape
    instead of the even one of all of Λ."""
    recording = kit.recorded(plots.WORK, "bias", (160, 160), "--walls", walls, name="bias-green-" + walls)
    settings = {"lambda_min": low, "lambda_max": LAMBDA[1], "kernel": kernel, "mollify_side": "light"}

    def change(message, members):
        if message == "settings":
            return dict(members, **settings)
        if message == "camera" and close:
            return zoomed(members)
        if message == "material" and members["name"] == "green":
            return dict(members, surface={"bsdf": "diffuse", "reflectance": reflectance(name)[0]})
        if message == "light" and light:
            return dict(members, emission={"shape": light, "scale": 40.0, "unit": "total"})
        return members

    return kit.edited(recording, plots.WORK / "bias.stokes", change)


@functools.lru_cache(maxsize=None)
def reference(name, walls):
    """Path traced, paths of four vertices."""
    options = {"integrator": "pt_nee", "techniques": "1,3 0,4", "spp": SAMPLES // 2}
    return kit.picture_of(scene(name, walls), plots.WORK / "bias.exr", **options)


def mollified(name, walls, kernel, d):
    options = {"integrator": "mbdpt", "techniques": "2,2", "d0": d, "shrink": 0, "spp": SAMPLES * MORE[d]}
    return kit.picture_of(scene(name, walls, kernel), plots.WORK / "bias.exr", **options)


# --- Colours and their differences -------------------------------------------------------------------


def walls_of(name, walls):
    """Reflectances of the wall that the light reaches and of the one that the camera sees."""
    coloured, grey = reflectance(name)[1], reflectance("grey")[1]
    return {"all": (coloured, coloured), "others": (coloured, grey), "back": (grey, coloured)}[walls]


def difference(first, second, luminance):
    """CIEDE2000, where the first has this luminance relative to the white of the even light."""
    white = acceptance.white(NM)
    k = luminance * white[1] / first[1]
    return colour.delta_e(*(colour.lab(k * xyz, white) for xyz in (first, second)))


def luminance_of(name):
    """A patch is judged as light as its reflectance is under the even light."""
    return (acceptance.colours(NM, reflectance(name)[1], np.ones_like(NM), 1)[0] / acceptance.white(NM))[1]


def predicted(name, walls, kernel, d):
    return difference(*acceptance.colours(NM, *walls_of(name, walls), d, kernel), luminance_of(name))


def noise(picture, luminance):
    """What the noise of a picture's mean does to ΔE: half the difference between halves of its pixels, over many ways
    to halve it."""
    pixels, chance = picture.reshape(-1, 3), np.random.default_rng(1)
    halves = (chance.permutation(pixels).reshape(2, -1, 3).mean(axis=1) for _ in range(32))
    return float(np.mean([difference(a, b, luminance) / 2 for a, b in halves]))


class Patch:
    """One reflectance in one of the boxes: its reference, and a mollified picture and ΔE for each width."""

    def __init__(self, name, walls, kernel):
        self.name = name
        self.reference = reference(name, walls)
        self.pictures, self.measured, self.noise, self.predicted = [], [], [], []
        for d in WIDTHS:
            self.predicted.append(float(predicted(name, walls, kernel, d)))
            picture = mollified(name, walls, kernel, d)
            means = (image.mean(axis=(0, 1)) for image in (self.reference, picture))
            self.pictures.append(picture)
            self.measured.append(float(difference(*means, luminance_of(name))))
            self.noise.append(
                float(np.hypot(*(noise(image, luminance_of(name)) for image in (self.reference, picture))))
            )

    def image(self):
        """The reference on the left, the widths from top to bottom on the right."""
        rows = [picture[: PIXELS // 2] for picture in self.pictures]
        right = np.concatenate(rows)
        left = np.concatenate([self.reference, self.reference])[: len(right)]
        return np.concatenate([left, right], axis=1) * LIGHT_IS_WHITE


def strip(name, title, walls, kernel):
    patches = []
    for patch in names():
        kit.say("  %s: %s" % (name, patch))
        patches.append(Patch(patch, walls, kernel))
    figure, axes = plt.subplots(2, len(patches), figsize=(2.1 * len(patches), 4.6), height_ratios=(1.25, 1))
    bound = 1.15 * max(max(p.predicted + p.measured) for p in patches)
    for (above, below), patch in zip(axes.T, patches):
        plots.picture(above, patch.image(), colour.exposure(patch.reference, 50) * 0.6, patch.name)
        for row, d in enumerate(WIDTHS):
            y = (row + 0.5) * PIXELS / 2 - 0.5
            above.text(2 * PIXELS - 0.2, y, "%d" % d, ha="left", va="center", fontsize=7)
        below.plot(WIDTHS, patch.predicted, "-", color="#444444", label="predicted")
        below.errorbar(WIDTHS, patch.measured, patch.noise, fmt="o", color="#c1121f", markersize=4, label="measured")
        below.set_xscale("log")
        below.set_xticks(WIDTHS, [str(d) for d in WIDTHS])
        below.minorticks_off()
        below.set_ylim(0, bound)
        below.set_xlabel("d (nm)")
    axes[1][0].set_ylabel("ΔE2000 from the reference")
    axes[1][0].legend(loc="upper left")
    figure.suptitle(
        title + "\nleft half: path traced; right half: mollified with d = 10, 20, 50, 100 nm from top to bottom"
    )
    figure.tight_layout()
    plots.save(figure, name)
    return patches


def figure_8():
    figure, axes = plt.subplots(1, 3, figsize=(9, 3.4))
    titles = {"all": "(a) all walls", "others": "(b) all but the back wall", "back": "(c) the back wall alone"}
    for panel, (walls, title) in zip(axes, titles.items()):
        path = scene("green", walls, close=False)
        xyz = kit.picture_of(path, plots.WORK / "bias.exr", integrator="bdpt", spp=8 if kit.QUICK else 64)
        plots.picture(panel, xyz * LIGHT_IS_WHITE, colour.exposure(xyz, 95), title)
        half = ZOOM * len(xyz) / 2
        panel.add_patch(
            plt.Rectangle(
                (len(xyz) / 2 - half, len(xyz) / 2 - half), 2 * half, 2 * half, fill=False, color="white", lw=0.8
            )
        )
    figure.suptitle("The boxes of the colour bias tests, here in green; the square is what figures 9 to 13 show")
    figure.tight_layout()
    plots.save(figure, "figure-08-boxes")


def bins_of(path, integrator, d, samples):
    """Mean radiance of (2,2)-paths in bins over what the camera sees."""
    options = {"techniques": "2,2", "spectral_bins": "%d:%g:%g" % BINS, "d0": d, "shrink": 0, "spp": samples}
    kit.render(path, plots.WORK / "bias.exr", integrator=integrator, **options)
    return kit.read_bins(plots.WORK / "bias.exr")


def measured_shares(kernel, d):
    """By camera wavelength: radiance of mollified over that of exact (2,2)-paths in a grey box."""
    samples = SAMPLES * MORE[d]
    nm, mollified_bins = bins_of(scene("grey", "all", kernel), "mbdpt", d, samples)
    return nm, mollified_bins / bins_of(scene("grey", "all"), "bdpt", d, samples)[1]


@functools.lru_cache(maxsize=None)
def whole_light(low):
    """What the camera gets of a light of the same power that it sees all of."""
    return bins_of(scene("grey", "all", light=even(*LAMBDA), low=low), "bdpt", 100, 2 * SAMPLES)[1].sum()


def measured_whole(light, d, kernel="constant", low=LAMBDA[0]):
    """Of all the energy of a light (a shape), what mollified (2,2)-paths bring to the wavelengths that the camera
    sees."""
    path = scene("grey", "all", kernel, light=light, low=low)
    return bins_of(path, "mbdpt", d, SAMPLES * MORE[d])[1].sum() / whole_light(low)


def figure_9():
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.6), sharey=True)
    for panel, kernel in zip(axes, acceptance.KERNELS):
        for d, color in zip(WIDTHS, plt.cm.viridis(np.linspace(0.1, 0.85, 4))):
            panel.plot(NM, acceptance.given_camera(NM, d, LAMBDA, kernel), color=color, label="d = %d nm" % d)
            kit.say("  figure-09-boundary: %s kernel, d = %d nm" % (kernel, d))
            nm, ratio = measured_shares(kernel, d)
            panel.plot(nm, ratio, "o", color=color, markersize=2.5)
        panel.set_title("%s kernel; dots: rendered" % kernel)
        panel.set_xlabel("camera wavelength (nm)")
        panel.set_ylim(0, 1.2)
    axes[0].set_ylabel("mollified / exact radiance")
    axes[0].legend(loc="lower center")
    figure.suptitle("Boundary bias: (2,2)-paths in a grey box, light and camera within %g–%g nm" % LAMBDA)
    figure.tight_layout()
    plots.save(figure, "figure-09-boundary")


def draw():
    figure_8()
    figure_9()
    rows, wrong = [], []
    for number, walls, kernel, what in (
        (10, "back", "constant", "Coloured back wall, the others grey; centred kernel"),
        (11, "back", "asymmetric", "Coloured back wall, the others grey; asymmetric kernel"),
        (12, "others", "constant", "Grey back wall, the others coloured; centred kernel"),
        (13, "others", "asymmetric", "Grey back wall, the others coloured; asymmetric kernel"),
    ):
        patches = strip("figure-%d-bias" % number, "Figure %d. %s" % (number, what), walls, kernel)
        rows += table(number, patches)
        wrong += acceptance.disagreements("figure %d" % number, WIDTHS, patches)
    (plots.FOLDER / "colour-bias.md").write_text("\n".join(HEAD + rows) + "\n", encoding="utf-8")
    kit.say("  colour-bias.md")
    return wrong


HEAD = [
    "# ΔE2000 of mollified (2,2)-paths from path traced ones: measured / predicted",
    "",
    "± is what the noise of both pictures does; it adds to small differences. All widths of a patch share its reference.",
    "",
    "| figure | patch | %s |" % " | ".join("d = %d nm" % d for d in WIDTHS),
    "|---|---|%s" % ("---|" * len(WIDTHS)),
]


def table(number, patches):
    rows = []
    for patch in patches:
        measured = ["%.2f ± %.2f" % pair for pair in zip(patch.measured, patch.noise)]
        cells = " | ".join("%s / %.2f" % pair for pair in zip(measured, patch.predicted))
        rows.append("| %d | %s | %s |" % (number, patch.name, cells))
    return rows
