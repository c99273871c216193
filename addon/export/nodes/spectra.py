"""Values of S on the library's grid: only to see whether a spectrum fits where it is to go."""

from ...nodes import library, spectrum_blackbody, spectrum_gaussian, spectrum_line


def on_grid(spectrum):
    """The values of S, or None if they cannot be known here (a texture)."""
    if isinstance(spectrum, (int, float)):
        return [float(spectrum)] * len(library.wavelengths())
    for form, evaluate in _FORMS.items():
        if form in spectrum:
            return evaluate(spectrum)
    return None


def _table(spectrum):
    table = spectrum["table"]
    return library.on_grid(list(zip(table["lambda"], table["value"])), True)


def _parts(spectra):
    values = [on_grid(part) for part in spectra]
    return None if None in values else list(zip(*values))


def _sum(spectrum):
    columns = _parts(spectrum["sum"])
    return columns and [sum(column) for column in columns]


def _product(spectrum):
    columns = _parts(spectrum["product"])
    if not columns:
        return None
    result = [1.0] * len(columns)
    for i, column in enumerate(columns):
        for value in column:
            result[i] *= value
    return result


def _scaled(spectrum):
    values = on_grid(spectrum["of"])
    return values and [spectrum["scale"] * value for value in values]


_FORMS = {
    # Upsampled colours lie within 0 and 1 by construction; their largest channel is near enough.
    "rgb": lambda s: [min(1.0, max(0.0, max(s["rgb"])))] * len(library.wavelengths()),
    "table": _table,
    "library": lambda s: library.values(s["library"]),
    "illuminant": lambda s: library.values("illuminant/" + s["illuminant"]),
    "blackbody": lambda s: spectrum_blackbody.curve(s["blackbody"]),
    "gaussian": lambda s: spectrum_gaussian.curve(
        s["gaussian"]["mean"], s["gaussian"]["sigma"], s["gaussian"]["peak"]
    ),
    "line": lambda s: spectrum_line.curve(s["line"]["center"], s["line"]["width"]),
    "sum": _sum,
    "product": _product,
    "scale": _scaled,
}
