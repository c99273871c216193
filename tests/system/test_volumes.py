"""Volumes in whole renders: Beer and Lambert's law, light scattered once, and one picture from all integrators. Furnaces full of what only
scatters are in test_enclosures.py."""

import numpy as np
import pytest

import exact
import scenes
import stats
from scenes import stream

BINS = (8, 380, 780)
RAMP = exact.Table([300, 400, 700, 830], [3.0, 2.5, 0.5, 0.3])  # 1/m


def bins_of(picture):
    return picture.bins()[1].mean(axis=(1, 2), dtype=np.float64)


def spectrum_and_mean(picture):
    spectrum = bins_of(picture)
    return np.append(spectrum, spectrum.mean())


def before_a_wall(path, slab, inside=None, surface=scenes.CLEAR, **settings):
    """An orthographic camera at the origin looks down −z at a wall, 2 m away, that emits; between them, a slab from one z to another."""
    message, values = scenes.emission(scenes.LIGHTS["d65"])
    with stream.Recorder(path) as out:
        out.send("settings", **settings)
        out.send("material", name="wall", surface={"emission": message, "two_sided": True})
        wall = np.array([[x, y, -2.0] for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))])
        scenes.mesh(out, "wall", wall, np.array([[0, 1, 2], [0, 2, 3]]))
        scenes.instance(out, "wall", ["wall"])
        out.send("material", name="slab", surface=surface, volume=inside)
        scenes.mesh(out, "slab", *scenes.box_mesh((-5, -5, slab[0]), (5, 5, slab[1])))
        scenes.instance(out, "slab", ["slab"])
        out.send(
            "camera",
            kind="orthographic",
            transform=scenes.IDENTITY,
            frame=[-0.2, 0.2, -0.2, 0.2],
            resolution=[4, 4],
            clip=[0.001, 100],
        )
        out.send("render", samples=[0, 16])
    return values


# Before the camera, around it, and up to the wall; each with what lies in the volume.
SLABS = {"between": ((-1.5, -0.7), 0.8), "around the camera": ((-0.9, 0.4), 0.899), "into the wall": ((-3, -1.2), 0.8)}
ABSORBER = {"volume": "coefficients", "absorption": RAMP.message()}


@pytest.mark.parametrize("place", SLABS)
@pytest.mark.parametrize("integrator", ["pt", "pt_nee", "lt", "mbdpt", "bdpt"])
def test_what_absorbs_follows_beer_and_lambert(core, tmp_path, integrator, place):
    slab, length = SLABS[place]
    values = before_a_wall(tmp_path / "slab.stokes", slab, ABSORBER, max_path=4, d0=2, shrink=0)
    wanted = exact.per_bin(values * np.exp(-RAMP.on_grid() * length), BINS)
    samples = 1500 if integrator == "lt" else 300
    found = core.batches(tmp_path / "slab.stokes", integrator, 32, samples, BINS, bins_of, lanes=4)
    stats.assert_unbiased("%s, %s" % (integrator, place), found, wanted, 0.1 if integrator == "lt" else 0.05)


@pytest.mark.parametrize("integrator", ["pt", "mbdpt", "bdpt"])
def test_without_bounces_in_volumes_scattering_only_takes_away(core, tmp_path, integrator):
    mist = {"volume": "coefficients", "scattering": RAMP.message()}
    values = before_a_wall(tmp_path / "slab.stokes", (-1.5, -0.7), mist, max_volume=0, d0=2, shrink=0)
    wanted = exact.per_bin(values * np.exp(-RAMP.on_grid() * 0.8), BINS)
    found = core.batches(tmp_path / "slab.stokes", integrator, 32, 600, BINS, bins_of, lanes=4)
    stats.assert_unbiased(integrator, found, wanted, 0.1)


@pytest.mark.parametrize("integrator", ["pt", "pt_nee", "mbdpt", "bdpt"])
def test_glass_that_absorbs_inside_passes_a_geometric_series(core, tmp_path, integrator):
    """Across a smooth slab: each way through loses T, each end R, the camera's side is dark."""
    glass = {"bsdf": "dielectric", "ior": 1.5}
    values = before_a_wall(tmp_path / "glass.stokes", (-1.5, -0.7), ABSORBER, glass, max_path=12, d0=2, shrink=0)
    passed, lost = np.exp(-RAMP.on_grid() * 0.8), 0.2**2
    wanted = exact.per_bin(values * (1 - lost) ** 2 * passed / (1 - (lost * passed) ** 2), BINS)
    found = core.batches(tmp_path / "glass.stokes", integrator, 32, 150, BINS, bins_of, lanes=4)
    stats.assert_unbiased(integrator, found, wanted, 0.05)


@pytest.mark.parametrize("volume", [{"volume": "absorption", "color": 0, "density": 1.5}, {"volume": "scatter", "color": 1, "density": 1.5}])
def test_a_volume_before_the_void_covers_what_it_extinguishes(core, tmp_path, volume):
    """Alpha is 1 − T where nothing else is."""
    with stream.Recorder(tmp_path / "void.stokes") as out:
        out.send("settings", film_transparent=True)
        out.send("material", name="slab", surface=scenes.CLEAR, volume=volume)
        scenes.mesh(out, "slab", *scenes.box_mesh((-1, -1, -1.5), (1, 1, -0.7)))
        scenes.instance(out, "slab", ["slab"])
        scenes.camera(out, scenes.IDENTITY, (8, 8), 1e-4)
        out.send("render", samples=[0, 16])
    alpha = core.batches(
        tmp_path / "void.stokes", "pt", 32, 256, None, lambda picture: picture.channels["A"].mean(dtype=np.float64)
    )
    wanted = 1 - np.exp(-1.5 * 0.8)
    if volume["volume"] == "absorption":  # no chance in it; rays leave surfaces by a bound of rounding errors
        assert alpha == pytest.approx(wanted, rel=1e-5)
    else:
        stats.assert_unbiased("alpha", alpha, [wanted], 0.02)


def test_the_report_names_light_that_no_fog_lets_through(core, tmp_path):
    """Then only the spot is drawn; where the fog is clear at some wavelengths all three lights are."""
    message, _ = scenes.emission(scenes.LIGHTS["d65"])
    reports = []
    for thickness in (0.1, 0):
        fog = {"volume": "coefficients", "scattering": exact.Table([300, 500, 510, 830], [0.1, 0.1, thickness, thickness]).message()}
        with stream.Recorder(tmp_path / "fog.stokes") as out:
            out.send("world", kind="constant", emission=message, volume=fog)
            for kind, angle in (("spot", 1), ("sun", 0.01)):
                out.send("light", name=kind, kind=kind, transform=scenes.IDENTITY, angle=angle, blend=0.1, emission=message)
            scenes.camera(out)
            out.send("render", samples=[0, 1])
        reports.append(core.run("render", tmp_path / "fog.stokes", "-o", tmp_path / "fog.exr").stderr)
    assert "1 lights" in reports[0] and "lights: 2 at infinity" in reports[0], reports[0]
    assert "3 lights" in reports[1] and "at infinity" not in reports[1], reports[1]


# --- Light scattered once -----------------------------------------------------------------------------------

SCATTERING, ABSORPTION, ANISOTROPY = exact.Table([300, 830], [0.6, 0.2]), exact.Table([300, 830], [0.1, 0.5]), 0.5
LAMP, RADIUS = np.array([0.8, 0.3, -1.5]), 0.05
FRONT, HALF = 0.6, 0.25


def scattered_once(path, **settings):
    """A small sphere that shines in a mist, beside what a pinhole at the origin sees down −z. The mist begins some way before the pinhole: else
    splats would have no finite variance."""
    message, values = scenes.emission(scenes.LIGHTS["d65"])
    mist = {
        "volume": "coefficients",
        "scattering": SCATTERING.message(),
        "absorption": ABSORPTION.message(),
        "anisotropy": ANISOTROPY,
    }
    with stream.Recorder(path) as out:
        out.send("settings", **settings)
        out.send("material", name="mist", surface=scenes.CLEAR, volume=mist)
        scenes.mesh(out, "mist", *scenes.box_mesh((-30, -30, -60), (30, 30, -FRONT)))
        scenes.instance(out, "mist", ["mist"])
        x, y, z = LAMP
        out.send(
            "light", name="lamp", kind="sphere", transform=scenes.translation(x, y, z), radius=RADIUS, emission=message
        )
        scenes.camera(out, scenes.IDENTITY, (8, 8), HALF)
        out.send("render", samples=[0, 16])
    return values


def single_scattering(values):
    """L = ∫ σs p e^(−σt (t + r)) π R² E/r² dt, the mean over the picture, on the grid of wavelengths. The lamp is small: a point to 0.3 %, but
    for its light that begins at its surface."""
    side = (np.arange(24) + 0.5) / 24 * 2 * HALF - HALF
    x, y = np.meshgrid(side, side)
    d = np.stack([x, y, -np.ones_like(x)], axis=-1)
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    # Distances denser where the lamp is near: t = t0 + h tan.
    t0 = d @ LAMP
    h = np.sqrt(LAMP @ LAMP - t0**2)
    enter = -FRONT / d[..., 2]
    first, last = np.arctan((enter - t0) / h), np.arctan((50 - t0) / h)
    steps = 400
    angle = first + (last - first) * ((np.arange(steps) + 0.5) / steps)[:, None, None]
    t, dt = t0 + h * np.tan(angle), h / np.cos(angle) ** 2 * (last - first) / steps
    r = h / np.cos(angle)
    toward = (t0 - t) / r  # cosine of the lamp's light with the way to the camera
    g = ANISOTROPY
    phase = (1 - g * g) / (4 * np.pi * (1 + g * g - 2 * g * toward) ** 1.5)
    kernel, depth = (phase * dt / r**2).ravel() / d[..., 0].size, (t - enter + r).ravel()
    coarse = slice(None, None, 20)
    scattering, extinction = SCATTERING.on_grid()[coarse], (SCATTERING.on_grid() + ABSORPTION.on_grid())[coarse]
    front = [2 / (e * RADIUS) ** 2 * (1 + (e * RADIUS - 1) * np.exp(e * RADIUS)) for e in extinction]
    sums = np.array([s * (kernel * np.exp(-e * depth)).sum() for s, e in zip(scattering, extinction)])
    return values * np.pi * RADIUS**2 * np.interp(exact.GRID, exact.GRID[coarse], sums * front)


@pytest.mark.parametrize(
    "integrator, samples, sees", [("pt_nee", 400, 0.1), ("lt", 1500, 0.5), ("mbdpt", 300, 0.1), ("bdpt", 300, 0.1)]
)
def test_light_scattered_once_is_the_integral_along_the_ray(core, tmp_path, integrator, samples, sees):
    settings = {"max_path": 2, "filter_width": 0.5, "d0": 2, "shrink": 0}
    values = scattered_once(tmp_path / "mist.stokes", **settings)
    wanted = exact.per_bin(single_scattering(values), BINS)
    found = core.batches(tmp_path / "mist.stokes", integrator, 32, samples, BINS, spectrum_and_mean, lanes=4)
    stats.assert_unbiased(integrator, found, np.append(wanted, wanted.mean()), np.append(np.full(BINS[0], sees), sees / 2))


# --- One picture ---------------------------------------------------------------------------------------------

BATCHES = 24


@pytest.fixture(scope="module")
def misty_box(core, tmp_path_factory):
    """Fluorescent walls in a coloured mist, and glass with a coloured volume in it: the picture by path tracing."""
    path = tmp_path_factory.mktemp("volumes") / "box.stokes"
    scenes.box(path, resolution=(16, 12), view="wall", mist=True, d0=2, shrink=0, max_path=12)
    return path, core.batches(path, "pt", BATCHES, 120, BINS, spectrum_and_mean, lanes=4)


@pytest.mark.parametrize("integrator, samples", [("pt_nee", 30), ("lt", 80), ("mbdpt", 12), ("bdpt", 12)])
def test_integrators_agree_in_a_misty_box(core, misty_box, integrator, samples):
    path, wanted = misty_box
    found = core.batches(path, integrator, BATCHES, samples, BINS, spectrum_and_mean, first_seed=1000, lanes=4)
    sees = np.array([0.5] * BINS[0] + [0.15])
    stats.assert_same(integrator, found, wanted, sees)


# --- What nobody should send ---------------------------------------------------------------------------------


@pytest.mark.parametrize("integrator", ["pt_nee", "lt", "mbdpt", "bdpt"])
def test_thick_open_and_many_volumes_make_a_finite_picture(core, tmp_path, integrator):
    """More overlapping bodies than a set of volumes holds, one of them a nanometre deep, peaked forward and backward, and a volume behind a
    surface that encloses nothing."""
    message, _ = scenes.emission(scenes.LIGHTS["d65"])
    with stream.Recorder(tmp_path / "mad.stokes") as out:
        out.send("settings", max_path=8)
        for i in range(16):
            name = "volume %d" % i
            density, g = (1e9, 0.999999) if i == 3 else (10.0 ** (i - 8), -0.999999 if i % 2 else 0.5)
            volume = {"volume": "principled", "color": 0.7, "density": density, "anisotropy": g}
            out.send("material", name=name, surface=scenes.CLEAR, volume=volume)
            scenes.mesh(out, name, *scenes.ball(1, 0.1 + 0.02 * i, (0.01 * i, 0, -1)))
            scenes.instance(out, name, [name])
        out.send("material", name="open", surface=scenes.CLEAR, volume=ABSORBER)
        corners = np.array([[x, y, -0.5] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        scenes.mesh(out, "open", corners, np.array([[0, 1, 2], [0, 2, 3]]))
        scenes.instance(out, "open", ["open"])
        out.send("material", name="wall", surface={"emission": message, "two_sided": True})
        scenes.mesh(out, "wall", *scenes.cube(3))
        scenes.instance(out, "wall", ["wall"])
        scenes.camera(out, scenes.IDENTITY, (16, 16), 0.5)
        out.send("render", samples=[0, 16])
    picture = core.render(tmp_path / "mad.stokes", integrator=integrator, samples=8, lanes=4)
    found = np.stack([picture.channels[name] for name in "RGB"])
    assert np.isfinite(found).all() and found.max() > 0
