"""What the theory says of colour bias (supplemental §4.4, §5.2): how much of a kernel lies within the wavelengths
that there are, and the colour that (2,2)-paths then have. Light and camera sub-path of such a path meet at two
diffuse walls: first the wall that the light reaches, where the kernel is, then the one that the camera sees."""

import numpy as np

import colour

STEP = 0.5
NOISES, UNSEEN = 4, 0.5  # times its error, and ΔE2000: what a measured difference is off by at most
KERNELS = ("constant", "asymmetric")  # their names in the stream


def light_window(kernel, camera_nm, d):
    """The light's wavelengths that the kernel joins to one of the camera."""
    return (camera_nm - d, camera_nm + d) if kernel == "constant" else (camera_nm - 2 * d, camera_nm)


def camera_window(kernel, light_nm, d):
    """The camera's wavelengths that the kernel joins to one of the light."""
    return (light_nm - d, light_nm + d) if kernel == "constant" else (light_nm, light_nm + 2 * d)


def share(window, low, high):
    """Of a window, what lies in [low, high]."""
    first, last = window
    return np.clip(np.minimum(last, high) - np.maximum(first, low), 0, None) / (last - first)


def given_camera(camera_nm, d, light, kernel="constant"):
    """Share of the energy that reaches a camera wavelength, when the light has [light[0], light[1]] evenly."""
    return share(light_window(kernel, np.asarray(camera_nm), d), *light)


def given_light(light_nm, d, camera, kernel="constant"):
    """Share of the energy of a light wavelength that stays within the camera's range."""
    return share(camera_window(kernel, np.asarray(light_nm), d), *camera)


def overall(shortest, longest, d, camera, kernel="constant"):
    """The same for a light that is even from its shortest wavelength λ_f to its longest."""
    nm = np.arange(shortest, longest, STEP) + STEP / 2
    return given_light(nm, d, camera, kernel).mean()


def spread(nm, values, d, kernel="constant"):
    """∫ k(λ|λl) values(λl) dλl on the grid `nm`; nothing is outside it and nothing renormalised."""
    step = nm[1] - nm[0]
    edges = np.concatenate([[nm[0] - step / 2], nm + step / 2])
    table = np.concatenate([[0], np.cumsum(values) * step])
    low, high = light_window(kernel, nm, d)
    return (np.interp(high, edges, table) - np.interp(low, edges, table)) / (2 * d)


def colours(nm, first_wall, second_wall, d, kernel="constant"):
    """XYZ of (2,2)-paths under an even light: as they are, and mollified."""
    exact = colour.xyz_of(nm, second_wall * first_wall)
    return exact, colour.xyz_of(nm, second_wall * spread(nm, first_wall, d, kernel))


def white(nm):
    """Of the even light."""
    return colour.xyz_of(nm, np.ones_like(nm))


def disagreements(figure, widths, patches):
    """A line for each ΔE2000 that was measured, but not as predicted. Were all noise along one axis of colour, its mean
    size would be 0.8 of its standard deviation, and 4 times that would be passed once in 700; the rest nobody sees."""
    return [
        "%s, %s, d = %g nm: ΔE2000 %.2f ± %.2f, predicted %.2f" % (figure, patch.name, d, found, error, wanted)
        for patch in patches
        for d, found, error, wanted in zip(widths, patch.measured, patch.noise, patch.predicted)
        if not abs(found - wanted) <= NOISES * error + UNSEEN
    ]
