"""Colour for figures: colour-matching functions, CIE L*a*b*, CIEDE2000, and XYZ as sRGB for the screen."""

import numpy as np

from kit import scenes

exact = scenes.exact
WHITE = np.array([0.95047, 1.0, 1.08883])  # D65, Y = 1
SRGB = np.array(  # IEC 61966-2-1
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
)


def cmf(nm):
    """x̄, ȳ, z̄ (CIE 1931 2°) of the core's own table; 0 outside 360–830 nm."""
    table = exact.floats_of("cie_cmf").reshape(-1, 3)
    grid = np.arange(360, 831)
    return np.stack([np.interp(nm, grid, column, left=0, right=0) for column in table.T], axis=-1)


def xyz_of(nm, radiance):
    """Of a spectrum on an even grid, in any scale."""
    return (cmf(nm) * np.asarray(radiance)[..., None]).sum(axis=-2) * (nm[1] - nm[0])


def lab(xyz, white):
    """CIE 15:2018, section 8.2.1."""
    q = np.asarray(xyz) / white
    x, y, z = np.moveaxis(np.where(q > 216 / 24389, np.cbrt(q), 841 / 108 * q + 4 / 29), -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def delta_e(first, second):
    """CIEDE2000 of two L*a*b* colours (ISO/CIE 11664-6)."""
    (l1, a1, b1), (l2, a2, b2) = np.moveaxis(np.asarray(first), -1, 0), np.moveaxis(np.asarray(second), -1, 0)

    def share(chroma):
        return np.sqrt(chroma**7 / (chroma**7 + 25.0**7))

    grey = 0.5 * (1 - share((np.hypot(a1, b1) + np.hypot(a2, b2)) / 2))
    a1, a2 = a1 * (1 + grey), a2 * (1 + grey)
    c1, c2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = np.degrees(np.arctan2(b1, a1)) % 360, np.degrees(np.arctan2(b2, a2)) % 360
    colourless = c1 * c2 == 0
    turn = np.where(colourless, 0, (h2 - h1 + 180) % 360 - 180)
    lightness, chroma, hue = l2 - l1, c2 - c1, 2 * np.sqrt(c1 * c2) * np.sin(np.radians(turn / 2))
    mean_l, mean_c = (l1 + l2) / 2, (c1 + c2) / 2
    mean_h = np.where(colourless, h1 + h2, (h1 + turn / 2) % 360)
    angle = np.radians(mean_h)
    t = (
        1
        - 0.17 * np.cos(angle - np.radians(30))
        + 0.24 * np.cos(2 * angle)
        + 0.32 * np.cos(3 * angle + np.radians(6))
        - 0.20 * np.cos(4 * angle - np.radians(63))
    )
    s_l = 1 + 0.015 * (mean_l - 50) ** 2 / np.sqrt(20 + (mean_l - 50) ** 2)
    s_c, s_h = 1 + 0.045 * mean_c, 1 + 0.015 * mean_c * t
    rotation = -np.sin(np.radians(60 * np.exp(-(((mean_h - 275) / 25) ** 2)))) * 2 * share(mean_c)
    l, c, h = lightness / s_l, chroma / s_c, hue / s_h
    return np.sqrt(l * l + c * c + h * h + rotation * c * h)


def srgb(xyz, gain=1.0):
    """For the screen, [0, 1]; out of gamut is clipped."""
    linear = np.clip(np.asarray(xyz) @ SRGB.T * gain, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def exposure(xyz, percentile=98.0):
    """A gain that shows all but the brightest."""
    return 0.9 / max(np.percentile(np.asarray(xyz)[..., 1], percentile), 1e-12)
