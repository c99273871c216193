"""Spectra for figures: the core's library, and upsampled colours [JH19], fitted here from the method's description to
check the core's. And the spectra that the scripts of test_scenes name."""

import ast
import functools

import numpy as np

import colour
import kit


@functools.lru_cache(maxsize=None)
def table_of(name):
    rows = kit.stokes("spectrum", "show", name, 300, 830, 1).split()
    return np.array(rows, dtype=float).reshape(-1, 2).T


def library(name, nm):
    """A spectrum of the core's library."""
    return np.interp(nm, *table_of(name))


def absorbed(dye, absorbance, nm):
    """Share of the light that a dye takes in, of this absorbance at its peak."""
    shape = table_of("dye/%s/absorption" % dye)[1]
    return 1 - 10 ** (-absorbance * library("dye/%s/absorption" % dye, nm) / shape.max())


def emitted(dye, nm):
    """The shape of a dye's emission, ∫ = 1."""
    values = library("dye/%s/emission" % dye, nm)
    return values / (values.sum() * (nm[1] - nm[0]))


@functools.lru_cache(maxsize=None)
def sigmoid_of(rgb):
    """Coefficients (of x = (λ − 360)/470) of the smooth reflectance whose colour under D65 is this linear sRGB
    [JH19]."""
    nm = np.arange(360.0, 831.0)
    x = (nm - 360) / 470
    white = np.interp(nm, *(lambda t: (t.nm, t.values))(colour.exact.d65()))
    weights = (colour.cmf(nm) * white[:, None]).T @ np.ones((len(nm), 1))
    matching = colour.SRGB @ (colour.cmf(nm) * white[:, None]).T / weights[1, 0]
    c = np.zeros(3)
    for _ in range(200):
        p = np.polyval(c, x)
        error = matching @ (0.5 + p / (2 * np.sqrt(1 + p * p))) - rgb
        slope = 0.5 * (1 + p * p) ** -1.5
        change = np.linalg.solve((matching * slope) @ np.stack([x * x, x, np.ones_like(x)], axis=1), error)
        c = c - change * min(1, 50 / np.abs(change).max())
        if np.abs(error).max() < 1e-10:
            break
    return c


def upsampled(rgb, nm):
    """Held below 360 nm, as the core does."""
    p = np.polyval(sigmoid_of(tuple(rgb)), (np.maximum(nm, 360.0) - 360) / 470)
    return 0.5 + p / (2 * np.sqrt(1 + p * p))


def measured_reflectance(surface, folder, bins=(47, 360, 830), samples=256):
    """What the core itself reflects: bins of a diffuse plane under an even sky over those of a white one, both with
    the same random numbers, so that their noise cancels. Wavelengths and reflectance."""
    means = []
    for name, reflectance in (("white", 1.0), ("surface", surface)):
        path = folder / ("plane-%s.stokes" % name)
        folder.mkdir(parents=True, exist_ok=True)
        with kit.stream.Recorder(path) as out:
            out.send("material", name="plane", surface={"bsdf": "diffuse", "reflectance": reflectance})
            corners = np.array([[x, y, -1.0] for x, y in ((-9, -9), (9, -9), (9, 9), (-9, 9))])
            kit.scenes.mesh(out, "plane", corners, np.array([[0, 1, 2], [0, 2, 3]]))
            kit.scenes.instance(out, "plane", ["plane"])
            sky = {"shape": 1.0, "scale": 1.0, "unit": "per_nm"}
            out.send("world", kind="constant", emission=sky)
            kit.scenes.camera(out, resolution=(16, 16), half=0.5)
            out.send("render", samples=[0, 1])
        picture = path.with_suffix(".exr")
        kit.render(path, picture, integrator="pt", spp=samples, spectral_bins="%d:%g:%g" % bins, max_path=2)
        nm, mean = kit.read_bins(picture)
        means.append(mean)
    return nm, means[1] / means[0]


# --- Of test_scenes --------------------------------------------------------------------------------


def constants(script):
    """The literals that test_scenes/SCRIPT.py gives names to."""
    found = {}
    for node in ast.parse((kit.ROOT / "test_scenes" / (script + ".py")).read_text()).body:
        if isinstance(node, ast.Assign):
            names = node.targets[0].elts if isinstance(node.targets[0], ast.Tuple) else node.targets[:1]
            try:
                value = ast.literal_eval(node.value)
            except ValueError:
                continue
            found.update(zip((n.id for n in names), value if len(names) > 1 else [value]))
    return found


def gaussian(members, nm):
    return members["Peak"] * np.exp(-0.5 * ((nm - members["Mean"]) / members["Sigma"]) ** 2)


def medium(nm):
    """Extinction (1/m) and albedo of the UFO scene's medium."""
    ufo = constants("ufo")
    scattering = ufo["SCATTERING"] * gaussian(ufo["SCATTERED"], nm)
    extinction = scattering + ufo["ABSORPTION"] * (1 - gaussian(ufo["PASSED"], nm))
    return extinction, scattering / extinction
