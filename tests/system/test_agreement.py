"""All integrators give the same picture: by blocks of 16 × 16 pixels and by wavelength, in a box with a fluorescent wall, a
dispersive glass ball and a metal one.

`lt` cannot make a path that ends on a mirror or glass seen by the pinhole: it is compared where only the fluorescent wall is
seen (with every path to it, caustics too), and in the box without specular balls."""

import re

import numpy as np
import pytest

import scenes
import stats

BATCHES = 32
BLOCK = 16
BINS = (8, 380, 780)
KERNEL = {"d0": 2, "shrink": 0}
# Relative errors that a block, a bin and the whole picture would show.
SEES = {"block": 0.15, "bin": 0.15, "whole": 0.03}


def measure(picture):
    """Mean radiance of every block, spectrum of the whole picture, and the whole."""
    _, bins = picture.bins()
    bins = bins.astype(np.float64)
    energy = bins.mean(axis=0)
    rows, columns = energy.shape
    blocks = energy.reshape(rows // BLOCK, BLOCK, columns // BLOCK, BLOCK).mean(axis=(1, 3))
    return np.concatenate([blocks.ravel(), bins.mean(axis=(1, 2)), [energy.mean()]])


def names_and_promises(resolution):
    columns, rows = resolution[0] // BLOCK, resolution[1] // BLOCK
    edges = np.linspace(BINS[1], BINS[2], BINS[0] + 1)
    names = ["block %d,%d" % (x, y) for y in range(rows) for x in range(columns)]
    names += ["%g–%g nm" % pair for pair in zip(edges, edges[1:])] + ["whole"]
    sees = [SEES["block"]] * (columns * rows) + [SEES["bin"]] * BINS[0] + [SEES["whole"]]
    return names, np.array(sees)


RESOLUTION = (64, 48)
# Samples of each integrator, and of the path tracing that all are held against.
FEW = {"pt_nee": 12, "lt": 8, "mbdpt": 4, "bdpt": 4}
VIEWS = {
    "specular balls seen": ({"view": "front"}, {"pt_nee": 24, "mbdpt": 12, "bdpt": 12}),
    "caustics on the wall": ({"view": "wall"}, FEW),
    "diffuse balls": ({"view": "front", "specular": False}, FEW),
}
PATHS = 40


@pytest.fixture(scope="module")
def reference(core, tmp_path_factory):
    """Scene and path-traced batches of a view, rendered once."""
    made = {}

    def get(view):
        if view not in made:
            path = tmp_path_factory.mktemp("agreement") / "box.stokes"
            scenes.box(path, resolution=RESOLUTION, **VIEWS[view][0], **KERNEL)
            made[view] = path, core.batches(path, "pt", BATCHES, PATHS, BINS, measure)
        return made[view]

    return get


@pytest.mark.parametrize(
    "view, integrator", [(view, integrator) for view in VIEWS for integrator in VIEWS[view][1]]
)
def test_integrator_agrees_with_path_tracing(core, reference, view, integrator):
    path, wanted = reference(view)
    found = core.batches(path, integrator, BATCHES, VIEWS[view][1][integrator], BINS, measure, first_seed=1000)
    names, sees = names_and_promises(RESOLUTION)
    stats.assert_same("%s, %s" % (view, integrator), found, wanted, sees, names=names)


@pytest.mark.parametrize("light_paths, lanes", [(0.25, 4), (3, 1)])
def test_any_number_of_light_paths_gives_that_picture(core, reference, light_paths, lanes):
    path, wanted = reference("caustics on the wall")
    samples = 6 if light_paths < 1 else 2
    found = core.batches(
        path, "bdpt", BATCHES, samples, BINS, measure, first_seed=1000, lanes=lanes, light_paths=light_paths
    )
    names, sees = names_and_promises(RESOLUTION)
    stats.assert_same("%g light paths" % light_paths, found, wanted, sees, names=names)


def test_as_many_light_paths_are_traced_as_pay(core, tmp_path):
    """In the open next event estimation does well without them; through glass about a small lamp next to nothing else comes."""
    scenes.box(tmp_path / "open.stokes", resolution=(32, 24), view="wall", specular=False)
    scenes.glass_box(tmp_path / "glass.stokes", "lamp", lamp=0.03, looks_down=True)
    paths = {}
    for name in ("open", "glass"):
        said = core.run(
            "render", tmp_path / (name + ".stokes"), "-o", tmp_path / "out.exr", "-i", "bdpt", "--samples", "999:1000", "--lanes", 4
        ).stderr
        paths[name] = float(re.search(r"paths: (\S+) light sub-paths", said)[1])
    assert paths["open"] < 1 < paths["glass"], paths


# Places of the glass in which connections once were biased: a low Fresnel term beside total reflection, and ends of the path within.
GLASS_SAMPLES = {"pt": 32, "mbdpt": 12, "bdpt": 8}
KEPT = np.arange(13) != 11


@pytest.fixture(scope="module")
def in_glass(core, tmp_path_factory):
    """As `reference`, of the box with a piece of glass."""
    made = {}

    def get(where):
        if where not in made:
            path = tmp_path_factory.mktemp("glass") / "box.stokes"
            # With glass at both ends, a lamp so small that paths which meet it by themselves leave something to the connections in between.
            scenes.glass_box(path, where, lamp=0.2 if where == "both" else 0.3, **KERNEL)
            made[where] = path, core.batches(path, "pt", BATCHES, GLASS_SAMPLES["pt"], BINS, measure)
        return made[where]

    return get


@pytest.mark.parametrize(
    "where, integrator, lanes",
    [(where, *how) for where in ("block", "lamp", "camera") for how in (("mbdpt", 1), ("bdpt", 1), ("bdpt", 4))]
    + [("both", "bdpt", 4)],
)
def test_integrator_agrees_with_path_tracing_about_glass(core, in_glass, where, integrator, lanes):
    path, wanted = in_glass(where)
    samples = GLASS_SAMPLES[integrator] // (2 if lanes > 1 and where != "both" else 1)
    found = core.batches(path, integrator, BATCHES, samples, BINS, measure, first_seed=1000, lanes=lanes)
    names, sees = names_and_promises((32, 32))
    # A few bright caustic samples rule the last bin of 50 nm, where Y is next to nothing.
    stats.assert_same(
        "%s, %s" % (where, integrator), found[:, KEPT], wanted[:, KEPT], 1.6 * sees[KEPT], names=np.array(names)[KEPT]
    )


def lamp_pixels(picture):
    return picture.bins()[1].mean(axis=0, dtype=np.float64)[4:10, 3:9].ravel()


@pytest.fixture(scope="module")
def small_lamp(core, tmp_path_factory):
    """A lamp smaller than a pixel, and what camera samples make of it: two pixels each way see it."""
    path = tmp_path_factory.mktemp("lamp") / "lamp.stokes"
    scenes.lamp_in_the_dark(path)
    return path, core.batches(path, "pt", BATCHES, 1600, BINS, lamp_pixels)


@pytest.mark.parametrize("integrator, samples", [("pt_nee", 800), ("lt", 300), ("mbdpt", 300), ("bdpt", 300)])
def test_every_pixel_sees_a_small_lamp_through_the_same_filter(core, small_lamp, integrator, samples):
    """Splats and camera samples spread a lamp smaller than a pixel over the same pixels in the same shares."""
    path, wanted = small_lamp
    found = core.batches(path, integrator, BATCHES, samples, BINS, lamp_pixels, first_seed=1000)
    brightest = wanted.mean(axis=0).max()
    seen = wanted.mean(axis=0) > 0.02 * brightest
    names = np.array(["pixel %d,%d" % (x, y) for y in range(4, 10) for x in range(3, 9)])
    stats.assert_same(
        integrator, found[:, seen], wanted[:, seen], 0.1, scale=brightest, names=names[seen]
    )


# What of rays does not see the plate, and how much of it is clear.
PLATES = {
    "casts no shadow": ("shadow", 0),
    "casts no shadow, half clear": ("shadow", 0.7),
    "no diffuse rays": ("diffuse", 0),
    "no diffuse rays, half clear": ("diffuse", 0.7),
}


@pytest.fixture(scope="module")
def plate(core, tmp_path_factory):
    """A grey box and a point of light, with a plate between that some rays do not see; and what next event estimation makes of it."""
    made = {}

    def get(name):
        if name in made:
            return made[name]
        path = tmp_path_factory.mktemp("plate") / "box.stokes"
        message, _ = scenes.emission(scenes.LIGHTS["d65"])
        blind, clear = PLATES[name]
        grey = scenes.MATERIALS["elastic"].message()
        with scenes.stream.Recorder(path) as out:
            out.send("settings", max_path=6, **KERNEL)
            out.send("material", name="grey", surface=grey)
            out.send("material", name="plate", surface={"mix": [grey, scenes.CLEAR], "factor": clear} if clear else grey)
            scenes.mesh(out, "box", *scenes.cube())
            scenes.instance(out, "box", ["grey"])
            corners = np.array([[x, y, -0.1] for x, y in ((-0.8, -0.8), (0.8, -0.8), (0.8, 0.8), (-0.8, 0.8))])
            scenes.mesh(out, "plate", corners, np.array([[0, 1, 2], [0, 2, 3]]))
            scenes.instance(out, "plate", ["plate"], visible={blind: False})
            out.send("light", name="lamp", kind="point", transform=scenes.translation(0.1, 0, 0.7), emission=message)
            scenes.camera(out, [1, 0, 0, 0, 0, 0, -1, -0.95, 0, 1, 0, 0], (16, 16), 0.75)
            out.send("render", samples=[0, 16])
        made[name] = path, core.batches(path, "pt_nee", BATCHES, 48, BINS, measure, lanes=4)
        return made[name]

    return get


@pytest.mark.parametrize("name", PLATES)
@pytest.mark.parametrize("integrator", ["mbdpt", "bdpt"])
def test_what_some_rays_do_not_see_is_the_same_from_both_ends(core, plate, name, integrator):
    """Light sub-paths do not know yet which kind of ray their edges will be; where that matters, the camera's alone are made. (What is lit on its way through what
    casts no shadow is left to next event estimation; `lt`, which has none, lacks that.)"""
    path, wanted = plate(name)
    found = core.batches(path, integrator, BATCHES, 24, BINS, measure, first_seed=1000, lanes=4)
    names, sees = names_and_promises((16, 16))
    sees[-1] = 0.01
    stats.assert_same("%s, %s" % (name, integrator), found, wanted, sees, names=names)
