"""What the figures say of the supplemental's equations, without a render."""

import numpy as np
import pytest

import acceptance
import bispectral
import colour

D = 50.0
INSIDE = (bispectral.GRID > 300 + 2 * D) & (bispectral.GRID < 830 - 2 * D)  # where no end of Λ takes light away


def random_materials(count=20):
    """Any r, a, c in [0, 1] and e that integrates to 1; yields within the bounds of energy and photons."""
    chance = np.random.default_rng(7)
    knots = np.linspace(300, 830, 12)
    for _ in range(count):
        r, a = (np.interp(bispectral.GRID, knots, chance.random(12)) for _ in range(2))
        center, width = chance.uniform(400, 750), chance.uniform(10, 40)
        e = np.exp(-0.5 * ((bispectral.GRID - center) / width) ** 2)
        yield bispectral.Material(r, a, e, chance.random(), chance.random())


def test_equation_6_gives_three_halves():
    """At 600 nm, where the supplemental writes 1 + d/2."""
    example = bispectral.counterexample()
    energy = bispectral.energy(example.matrix(bispectral.incident_diagonal(example, D)))
    at_600 = np.argmin(np.abs(bispectral.GRID - 599.5))  # the last midpoint within [500, 600]
    assert energy[at_600] == pytest.approx(1.5, abs=bispectral.STEP / (2 * D) + 1e-9)


@pytest.mark.parametrize("kernel", [bispectral.constant, bispectral.incident_reflectance, bispectral.asymmetric])
def test_these_kernels_make_no_energy(kernel):
    """Eq. 7, and the constant kernel likewise."""
    for material in random_materials():
        assert bispectral.energy(material.matrix(kernel(material, D))).max() <= 1 + 1e-9


@pytest.mark.parametrize("kernel", [bispectral.incident_diagonal, bispectral.box])
def test_these_kernels_can_make_energy(kernel):
    example = bispectral.counterexample()
    assert bispectral.energy(example.matrix(kernel(example, D))).max() > 1.4


def test_the_constant_kernel_keeps_every_photon():
    """Eq. 13: a white elastic surface sends out as many as it gets, a symmetric kernel being the reason."""
    white = bispectral.Material(
        np.ones_like(bispectral.GRID), np.zeros_like(bispectral.GRID), np.ones_like(bispectral.GRID)
    )
    assert bispectral.photons(bispectral.constant(white, D))[INSIDE] == pytest.approx(1, abs=0.011)
    for material in random_materials():
        assert bispectral.photons(material.matrix(bispectral.constant(material, D))).max() <= 1 + 0.011


def test_the_asymmetric_kernel_makes_photons():
    """§2.2: the same energy at longer wavelengths is more of them, here by d over the wavelength."""
    white = bispectral.Material(
        np.ones_like(bispectral.GRID), np.zeros_like(bispectral.GRID), np.ones_like(bispectral.GRID)
    )
    made = bispectral.photons(bispectral.asymmetric(white, D))[INSIDE]
    assert made == pytest.approx(1 + D / bispectral.GRID[INSIDE], abs=0.01)


def test_a_box_in_both_variables_is_a_tent():
    """f_mb of an even diagonal: support |Δ| < d, peak 1/d (algorithm.md §3)."""
    white = bispectral.Material(
        np.ones_like(bispectral.GRID), np.zeros_like(bispectral.GRID), np.ones_like(bispectral.GRID)
    )
    middle = len(bispectral.GRID) // 2
    shift = bispectral.GRID - bispectral.GRID[middle]
    tent = np.clip(1 - np.abs(shift) / D, 0, None) / D
    assert bispectral.box(white, D)[:, middle] == pytest.approx(tent, abs=1e-9)


@pytest.mark.parametrize("kernel", acceptance.KERNELS)
def test_what_light_and_camera_lose_is_the_same_light(kernel):
    """∫ over camera wavelengths of what reaches them = ∫ over light wavelengths of what stays."""
    low, high, d = 380.0, 780.0, 60.0
    nm = np.arange(low, high, 0.1) + 0.05
    reach = acceptance.given_camera(nm, d, (low, high), kernel).mean()
    stay = acceptance.overall(low, high, d, (low, high), kernel)
    assert reach == pytest.approx(stay, rel=1e-4)
    assert acceptance.spread(nm, np.ones_like(nm), d, kernel) == pytest.approx(
        acceptance.given_camera(nm, d, (low, high), kernel), abs=1e-9
    )


@pytest.mark.parametrize(
    "first, second, wanted",
    [  # of the published test data for CIEDE2000
        ((50, 2.6772, -79.7751), (50, 0, -82.7485), 2.0425),
        ((50, 2.49, -0.001), (50, -2.49, 0.0009), 7.1792),
        ((22.7233, 20.0904, -46.694), (23.0331, 14.973, -42.5619), 2.0373),
        ((2.0776, 0.0795, -1.135), (0.9033, -0.0636, -0.5514), 0.9082),
        ((50, 2.5, 0), (73, 25, -18), 27.1492),
    ],
)
def test_differences_are_the_published_ones(first, second, wanted):
    found = colour.delta_e(np.array(first, dtype=float), np.array(second, dtype=float))
    assert found == pytest.approx(wanted, abs=5e-5)


@pytest.mark.parametrize("off, wrong", [(0, 0), (1.2, 0), (-1.2, 0), (1.4, 1), (-1.4, 1), (float("nan"), 1)])
def test_figures_10_to_13_fail_if_they_are_not_as_predicted(off, wrong):
    """Beyond 4 times the noise and half a ΔE; with the very names of the patches and widths that are off."""

    class Patch:
        name, noise, predicted = "red", [0.2] * 4, [1.0, 2.0, 5.0, 9.0]
        measured = [1.0, 2.0, 5.0 + off, 9.0]

    found = acceptance.disagreements("figure 12", (10, 20, 50, 100), [Patch])
    assert len(found) == wrong and all("figure 12, red, d = 50 nm" in line for line in found)


@pytest.mark.parametrize("kind, quantum", [("quantum", True), ("energy", False)])
def test_the_cores_matrix_of_a_dye_is_the_models(tmp_path, kind, quantum):
    """Eq. 2 and what is re-emitted, band by band: the core's export against the model on its grid."""
    import kit

    tables = {
        "reflectance": ([300, 500, 650, 830], [0.3, 0.9, 0.5, 0.8]),
        "absorption": ([320, 420, 480, 560], [0, 0.9, 0.7, 0]),
        "emission": ([480, 540, 640], [0, 1, 0]),
    }
    surface = {name: {"table": {"lambda": nm, "value": value}} for name, (nm, value) in tables.items()}
    with kit.stream.Recorder(tmp_path / "dye.stokes") as out:
        out.send(
            "material",
            name="dye",
            surface=dict(surface, bsdf="fluorescent", concentration=0.8, **{"yield": 0.6, "yield_kind": kind}),
        )
        kit.scenes.mesh(out, "dye", *kit.scenes.cube())
        kit.scenes.instance(out, "dye", ["dye"])
        kit.scenes.camera(out)
        out.send("render", samples=[0, 1])
    kit.stokes("matrix", "export", tmp_path / "dye.stokes", "dye", "-o", tmp_path / "dye.csv", "--bands", "305,825,10")
    found = kit.scenes.exact.Matrix.read(tmp_path / "dye.csv").share

    r, a, e = (
        np.interp(bispectral.GRID, *tables[name], **outside)
        for name, outside in (
            ("reflectance", {}),
            ("absorption", {"left": 0, "right": 0}),
            ("emission", {"left": 0, "right": 0}),
        )
    )
    model = bispectral.Material(r, a, e, 0.8, 0.6)
    if not quantum:
        model.energy_yield = np.minimum(0.6, bispectral.GRID / bispectral.integral(model.e * bispectral.GRID))
    fine = model.fluorescent() * bispectral.STEP + np.diag(model.diagonal())
    bands = (
        fine.reshape(53, 10, 53, 10).sum(axis=1).mean(axis=2)
    )  # shares add up over what leaves, and are means over what arrives
    assert found == pytest.approx(bands, abs=2e-3)
    assert found.sum(axis=0) == pytest.approx(bands.sum(axis=0), abs=2e-3)
