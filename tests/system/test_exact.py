"""The exact answers, checked against closed forms, balances and a simulation of their own."""

import numpy as np
import pytest

import exact
import scenes

UV = scenes.LIGHTS["uv"]
PAINT = scenes.MATERIALS["fluorescent"]


def test_operator_agrees_with_the_closed_form_of_one_dye():
    """With one dye the fluorescent part has rank one, so L follows from one number, the power that the dye absorbs."""
    elastic, emitted, converted = PAINT.elastic(), PAINT.emitted(), PAINT.converted()
    source = UV.on_grid()
    absorbed = exact.integral(converted * source / (1 - elastic))
    absorbed /= 1 - exact.integral(converted * emitted / (1 - elastic))
    closed_form = (source + emitted * absorbed) / (1 - elastic)
    assert exact.furnace(PAINT, source) == pytest.approx(closed_form, rel=1e-9)


def test_furnace_without_reflection_shows_the_source():
    black = exact.Material(exact.Table([300, 830], [0, 0]))
    source = UV.on_grid()
    assert exact.furnace(black, source) == pytest.approx(source)


def test_grey_furnace_is_brighter_by_the_geometric_series():
    grey = exact.Material(exact.Table([300, 830], [0.6, 0.6]))
    source = exact.d65().on_grid()
    assert exact.furnace(grey, source) == pytest.approx(source / 0.4)


def test_no_material_here_makes_energy_or_photons():
    for material in scenes.MATERIALS.values():
        matrix = material.operator()
        assert (matrix.sum(axis=0) <= 1).all()
        assert ((matrix / exact.GRID[None, :] * exact.GRID[:, None]).sum(axis=0) <= 1).all()


def test_walls_absorb_what_the_lamp_emits():
    power = UV.on_grid()
    radiance = exact.wall(PAINT, power, 7.0)
    leaving = radiance * np.pi * 7.0
    incident = power + leaving
    assert exact.integral(incident - PAINT.operator() @ incident) == pytest.approx(exact.integral(power))


def test_wall_is_what_a_random_walk_of_photons_finds():
    """Energy packets in a closed enclosure never miss a wall, so no geometry is needed."""
    random = np.random.default_rng(1)
    count = 400000
    source = UV.on_grid()
    wavelength = random.choice(len(exact.GRID), count, p=source / source.sum())
    elastic, converted = PAINT.elastic(), PAINT.converted()
    emitted = PAINT.emitted() * exact.STEP
    power = exact.integral(source) / count
    leaving = np.zeros(len(exact.GRID))
    while len(wavelength):
        chance = random.random(len(wavelength))
        reflected = chance < elastic[wavelength]
        shifted = ~reflected & (chance < elastic[wavelength] + converted[wavelength])
        wavelength[shifted] = random.choice(len(exact.GRID), shifted.sum(), p=emitted / emitted.sum())
        wavelength = wavelength[reflected | shifted]
        np.add.at(leaving, wavelength, power / exact.STEP)
    bins = (5, 330, 630)
    expected = exact.per_bin(exact.wall(PAINT, source, 1.0), bins)
    assert exact.per_bin(leaving / np.pi, bins) == pytest.approx(expected, rel=0.02, abs=0.002 * expected.max())


def test_bins_hold_the_integral():
    values = exact.d65().on_grid()
    assert exact.per_bin(values, (53, 300, 830)).sum() * 10 == pytest.approx(exact.integral(values))
    assert exact.per_bin(values, (1, 400, 500))[0] * 100 == pytest.approx(
        exact.integral(values * (exact.GRID > 400) * (exact.GRID < 500)), rel=1e-3
    )


def test_white_has_unit_luminance():
    white = exact.d65().on_grid()
    assert exact.luminance(white / exact.integral(white)) == pytest.approx(1)


def test_sphere_is_closed_faces_inward_and_nears_the_sphere():
    positions, triangles = scenes.icosphere(3)
    assert len(triangles) == 20 * 4**3
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    corners = positions[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", normals, corners.mean(axis=1)) < 0).all()
    assert scenes.areas(positions, triangles).sum() == pytest.approx(4 * np.pi, rel=0.01)
