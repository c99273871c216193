"""Exact answers on a fine grid of wavelengths: what a closed enclosure of one diffuse fluorescent material looks like
(algorithm.md §8). Nothing here is shared with the core."""

import pathlib
import re

import numpy as np

RANGE = (300.0, 830.0)  # Λ, nm
STEP = 0.5
GRID = np.arange(RANGE[0], RANGE[1], STEP) + STEP / 2  # midpoints


def integral(values):
    return values.sum(axis=-1) * STEP


class Table:
    """A piecewise-linear spectrum, and the same as the stream says it. Outside it is zero; a reflectance has to cover Λ."""

    def __init__(self, nm, values):
        self.nm, self.values = np.asarray(nm, dtype=float), np.asarray(values, dtype=float)

    def on_grid(self):
        return np.interp(GRID, self.nm, self.values, left=0, right=0)

    def message(self):
        return {"table": {"lambda": self.nm.tolist(), "value": self.values.tolist()}}


def floats_of(name):
    """A table of the core's CIE data, by its C name."""
    source = pathlib.Path(__file__).parents[2] / "csrc/color/cie.inc"
    body = re.search(name + r"\[\](?:\[3\])? = \{(.*?)\};", source.read_text(), re.S).group(1)
    return np.array([float(number) for number in re.findall(r"([-+0-9.e]+)f\b", body)])


def d65():
    values = floats_of("cie_d65")
    return Table(np.linspace(300, 830, len(values)), values)


def luminous_efficiency():
    """ȳ on the grid; 0 below 360 nm."""
    values = floats_of("cie_cmf").reshape(-1, 3)[:, 1]
    return np.interp(GRID, np.arange(360, 831), values, left=0)


def luminance(radiance):
    """Y of a radiance on the grid: κ is such that D65 of unit integral over Λ has Y = 1."""
    white, efficiency = d65().on_grid(), luminous_efficiency()
    return integral(radiance * efficiency) / (integral(white * efficiency) / integral(white))


class Material:
    """The diffuse fluorescent material of algorithm.md §2, or the plain diffuse one without `absorption`."""

    def __init__(self, reflectance, absorption=None, emission=None, concentration=1.0, quantum_yield=1.0):
        self.reflectance, self.absorption, self.emission = reflectance, absorption, emission
        self.concentration, self.quantum_yield = concentration, quantum_yield

    def message(self):
        if self.absorption is None:
            return {"bsdf": "diffuse", "reflectance": self.reflectance.message()}
        return {
            "bsdf": "fluorescent",
            "reflectance": self.reflectance.message(),
            "absorption": self.absorption.message(),
            "emission": self.emission.message(),
            "concentration": self.concentration,
            "yield": self.quantum_yield,
            "yield_kind": "quantum",
        }

    def elastic(self):
        absorbed = 0 if self.absorption is None else self.concentration * self.absorption.on_grid()
        return (1 - absorbed) * self.reflectance.on_grid()

    def emitted(self):
        """The shape e, ∫e = 1."""
        shape = self.emission.on_grid()
        return shape / integral(shape)

    def converted(self):
        """c ã: the share of the incident energy that is absorbed and emitted again; Q(λi) = q λi / λ̄_e, at most the
        energy that there is and the photons that there are."""
        mean = integral(self.emitted() * GRID)
        energy = np.minimum(self.quantum_yield * GRID / mean, np.minimum(1, GRID / mean))
        return self.concentration * self.absorption.on_grid() * energy

    def operator(self):
        """Reradiation on the grid: reflected = operator @ incident."""
        matrix = np.diag(self.elastic())
        if self.absorption is not None:
            matrix = matrix + np.outer(self.emitted(), self.converted()) * STEP
        return matrix


def furnace(material, emission):
    """Radiance inside a closed convex enclosure whose walls all emit `emission`: L = (1 − ρ)⁻¹ E."""
    return np.linalg.solve(np.eye(len(GRID)) - material.operator(), emission)


def wall(material, power, area):
    """Mean radiance that the walls of a closed enclosure reflect. What is emitted inside (`power` per nm) and what is
    reflected all meets a wall again, so the flux solves Φ = P + ρΦ whatever the shape; ρΦ leaves the area evenly in
    the mean, and a Lambertian wall has radiance flux/(π area)."""
    matrix = material.operator()
    flux = np.linalg.solve(np.eye(len(GRID)) - matrix, power)
    return matrix @ flux / (np.pi * area)


def per_bin(radiance, bins):
    """Mean spectral radiance in `bins` = (count, min, max) equal bins."""
    count, low, high = bins
    edges = np.linspace(low, high, count + 1)
    cumulative = np.concatenate([[0], np.cumsum(radiance) * STEP])
    at = np.interp(edges, np.concatenate([[RANGE[0]], GRID + STEP / 2]), cumulative)
    return np.diff(at) / np.diff(edges)
