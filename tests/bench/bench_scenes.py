"""The scenes of the benchmark: boxes written straight to the stream, and what test_scenes/ builds in Blender."""

import numpy as np

import kit

scenes = kit.scenes
DYES = {"floor": ("coumarin-6_ethanol", 1.2), "right": ("dcm_ethanol", 1.2)}  # name, absorbance at the peak
SIDES = ("grey", "floor", "right")
GLASS = {"bsdf": "dielectric", "ior": {"n_d": 1.5, "abbe": 20}}
LAMP = (0.0, -0.45, 0.68)
LINES = ((365, 4), (404.7, 2), (435.8, 3), (546.1, 3), (577.5, 4))  # mercury: nm, width


def daylight(scale):
    return {"shape": {"illuminant": "D65"}, "scale": scale, "unit": "total"}


def lines(scale):
    shape = {"sum": [{"line": {"center": center, "width": width}} for center, width in LINES]}
    return {"shape": shape, "scale": scale, "unit": "total"}


def paint(side):
    """A dye in a white paint. What is absorbed at absorbance A·a(λ) is 1 − 10^(−A a)."""
    dye, absorbance = DYES[side]
    rows = kit.stokes("spectrum", "show", "dye/%s/absorption" % dye, 300, 830, 5).split()
    nm, shape = np.array(rows, dtype=float).reshape(-1, 2).T
    absorbed = 1 - 10 ** (-absorbance * shape / shape.max())
    return {
        "bsdf": "fluorescent",
        "reflectance": 0.6,
        "absorption": {"table": {"lambda": nm.tolist(), "value": absorbed.round(5).tolist()}},
        "emission": {"library": "dye/%s/emission" % dye},
        "yield": 0.9,
        "yield_kind": "quantum",
    }


def room(out):
    """A closed box whose floor and right wall fluoresce."""
    out.send("material", name="grey", surface={"bsdf": "diffuse", "reflectance": 0.5})
    for side in DYES:
        out.send("material", name=side, surface=paint(side))
    positions, triangles = scenes.cube()
    middle = positions[triangles].mean(axis=1)
    scenes.mesh(out, "room", positions, triangles, np.where(middle[:, 2] < -0.9, 1, np.where(middle[:, 0] > 0.9, 2, 0)))
    scenes.instance(out, "room", list(SIDES))


def eye(out, resolution):
    """Level from the front; the lamps are above what it sees."""
    scenes.camera(out, [1, 0, 0, 0, 0, 0, -1, -0.95, 0, 1, 0, 0], resolution, 0.68)


def panel(out, emission):
    """Under the ceiling, in the open."""
    place = scenes.translation(0, -0.1, 0.98)
    out.send("light", name="lamp", kind="rectangle", transform=place, size=[0.5, 0.5], emission=emission)


def box(path, resolution, emission=None):
    with scenes.stream.Recorder(path) as out:
        room(out)
        panel(out, emission or daylight(40))
        eye(out, resolution)
        out.send("render", samples=[0, 16])


def mercury(path, resolution):
    box(path, resolution, lines(40))


def ball(path, resolution):
    """The lamp is a small ball of light within a ball of dispersive glass."""
    with scenes.stream.Recorder(path) as out:
        room(out)
        out.send("material", name="glass", surface=GLASS)
        scenes.mesh(out, "glass", *scenes.ball(4, 0.25, LAMP))
        scenes.instance(out, "glass", ["glass"])
        lamp = {"kind": "sphere", "transform": scenes.translation(*LAMP), "radius": 0.06}
        out.send("light", name="lamp", **lamp, emission=daylight(250))
        eye(out, resolution)
        out.send("render", samples=[0, 16])


WRITTEN = {"box": box, "ball": ball, "mercury": mercury}
BUILT = ("spheres", "lens", "ufo")  # by Blender
TITLES = {
    "box": "box, all in the open",
    "spheres": "spheres",
    "ball": "light in a dispersive ball",
    "lens": "lenses on both sides",
    "mercury": "box under mercury lines",
    "ufo": "UFO",
}
FIVE = ("box", "spheres", "ball", "lens", "mercury")  # of the benchmark


def write(name, folder, resolution):
    """The scene's stream, in the folder."""
    if name in BUILT:
        return kit.recorded(folder, name, resolution)
    path = folder / ("%s-%dx%d.stokes" % (name, *resolution))
    folder.mkdir(parents=True, exist_ok=True)
    WRITTEN[name](path, resolution)
    return path
