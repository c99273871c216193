"""Exact answers on a fine grid of wavelengths: what a closed enclosure of one diffuse fluorescent material looks like
(algorithm.md §8). Nothing here is shared with the core."""

import functools
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


@functools.lru_cache
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


class Matrix:
    """A diffuse surface by its reradiation matrix: `share[out, in]` of bands of `step` nm about their centres."""

    def __init__(self, incident, outgoing, share):
        self.incident, self.outgoing = np.asarray(incident, dtype=float), np.asarray(outgoing, dtype=float)
        self.share = np.asarray(share, dtype=float)
        self.step = self.incident[1] - self.incident[0]

    @classmethod
    def read(cls, path):
        rows = np.genfromtxt(path, delimiter=",", skip_header=1)
        with open(path, encoding="utf-8") as file:
            return cls([float(cell) for cell in file.readline().split(",")[1:]], rows[:, 0], rows[:, 1:])

    def message(self):
        return {
            "bsdf": "reradiation_matrix",
            "matrix": {
                "incident": [self.incident[0], len(self.incident)],
                "outgoing": [self.outgoing[0], len(self.outgoing)],
                "step": self.step,
                "share": self.share.ravel().tolist(),
            },
        }

    def parts(self):
        """Reflectance by incident band (NaN where it was not measured), and the shares that are re-emitted: the diagonal's
        is the mean of its neighbours."""
        reflected, emitted = np.full(len(self.incident), np.nan), self.share.copy()
        padded = np.pad(self.share, 1, constant_values=np.nan)
        for i, nm in enumerate(self.incident):
            (found,) = np.nonzero(np.abs(self.outgoing - nm) < 0.01 * self.step)
            for o in found:
                beside = [padded[o, i + 1], padded[o + 2, i + 1], padded[o + 1, i], padded[o + 1, i + 2]]
                emitted[o, i] = min(np.nanmean(beside), self.share[o, i])
                reflected[i] = self.share[o, i] - emitted[o, i]
        return reflected, emitted

    def operator(self):
        """Reradiation on the grid: reflected = operator @ incident. Beyond what was measured reflectance is held."""
        reflected, emitted = self.parts()
        known = np.nonzero(~np.isnan(reflected))[0]
        band_in = np.floor((GRID - self.incident[0]) / self.step + 0.5).astype(int)
        band_out = np.floor((GRID - self.outgoing[0]) / self.step + 0.5).astype(int)
        matrix = np.diag(reflected[np.clip(band_in, known[0], known[-1])])
        inside = np.ix_(
            (band_out >= 0) & (band_out < len(self.outgoing)), (band_in >= 0) & (band_in < len(self.incident))
        )
        matrix[inside] += (
            emitted[band_out[inside[0][:, 0]][:, None], band_in[inside[1][0]][None, :]] * STEP / self.step
        )
        return matrix


def furnace(material, emission, edges=None):
    """Radiance inside a closed convex enclosure whose walls all emit `emission`: L = (1 − ρ)⁻¹ E; or what paths of at most
    `edges` edges carry of it."""
    matrix = material.operator()
    if edges is None:
        return np.linalg.solve(np.eye(len(GRID)) - matrix, emission)
    radiance = np.zeros_like(emission)
    for _ in range(edges):
        radiance = emission + matrix @ radiance
    return radiance


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
