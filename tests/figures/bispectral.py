"""The supplemental's model on a grid of wavelengths: the fluorescent material, and its elastic term spread by each
kernel. A matrix M[o, i] is a density per nm of leaving wavelength o, for light that comes in at wavelength i. Nothing
here is shared with the core."""

import numpy as np

STEP = 1.0
GRID = np.arange(300.0, 830.0, STEP) + STEP / 2  # midpoints, nm
INCIDENT, LEAVING = GRID[None, :], GRID[:, None]


def integral(values, axis=0):
    return values.sum(axis=axis) * STEP


class Material:
    """[JHD18]: reflectance r, absorption a, emission e (∫e = 1), concentration c, quantum yield q. On the grid."""

    def __init__(self, reflectance, absorption, emission, concentration=1.0, quantum_yield=1.0):
        self.r, self.a, self.c = reflectance, absorption, concentration
        self.e = emission / integral(emission)
        mean = integral(self.e * GRID)
        self.energy_yield = np.minimum(quantum_yield, 1) * np.minimum(1, GRID / mean)

    def diagonal(self):
        """(1 − c a) r, the share that is reflected elastically (eq. 2)."""
        return (1 - self.c * self.a) * self.r

    def fluorescent(self):
        """c a(λi) Q(λi) e(λo)."""
        return self.e[:, None] * (self.c * self.a * self.energy_yield)[None, :]

    def matrix(self, elastic):
        return elastic + self.fluorescent()


def unmollified(material, width):
    """The diagonal in bins of `width` nm, to have something to show of a δ."""
    same = np.floor(INCIDENT / width) == np.floor(LEAVING / width)
    return same * material.diagonal()[None, :] / width


def window(d):
    return (np.abs(LEAVING - INCIDENT) < d) / (2 * d)


def constant(material, d):
    """f_mo (eq. 16): the whole elastic term at the incident wavelength."""
    return window(d) * material.diagonal()[None, :]


def incident_reflectance(material, d):
    """f_mi of r alone (eq. 7): 1 − c a stays at the incident wavelength."""
    return window(d) * (1 - material.c * material.a)[None, :] * material.r[:, None]


def incident_diagonal(material, d):
    """f_mi of the whole diagonal (eqs. 1, 2, 6): what can break energy."""
    return window(d) * material.diagonal()[:, None]


def box(material, d):
    """f_mb: the diagonal under a 2D box of half-width d/2 in each variable, from its cumulative table."""
    edges = np.concatenate([[GRID[0] - STEP / 2], GRID + STEP / 2])
    table = np.concatenate([[0], np.cumsum(material.diagonal()) * STEP])
    low = np.maximum(LEAVING, INCIDENT) - d / 2
    high = np.minimum(LEAVING, INCIDENT) + d / 2
    area = np.interp(high, edges, table) - np.interp(low, edges, table)
    return np.where(high > low, area, 0) / d**2


def asymmetric(material, d):
    """Toward longer wavelengths only (§4.4, normalised: eq. 15 is not)."""
    shift = LEAVING - INCIDENT
    return ((shift >= 0) & (shift < 2 * d)) / (2 * d) * material.diagonal()[None, :]


KERNELS = {
    "constant, $f_{mo}$": constant,
    "incident, $f_{mi}$, of r": incident_reflectance,
    "incident, $f_{mi}$, of the diagonal": incident_diagonal,
    "2D box, $f_{mb}$": box,
    "asymmetric": asymmetric,
}


def energy(matrix):
    """What leaves for one unit that comes in, by incident wavelength: the column sums."""
    return integral(matrix)


def photons(matrix):
    """Photons that leave for one that comes in: N is in proportion to E λ (eq. 12)."""
    return integral(matrix * LEAVING) / GRID


def counterexample():
    """Eqs. 3 to 5: c = Q = 1, absorption a box over [500, 600] nm, r = 1 − a. Emission in the same place."""
    absorption = ((GRID > 500) & (GRID < 600)).astype(float)
    emission = ((GRID > 590) & (GRID < 610)).astype(float)
    material = Material(1 - absorption, absorption, emission)
    material.energy_yield = np.ones_like(GRID)  # Q = 1 of eq. 3 is an energy yield
    return material
