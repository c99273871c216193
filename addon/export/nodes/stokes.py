"""Stokes' own nodes: closures and spectra, by their tags. They say more than RGB can."""

from ... import nodes
from ...nodes import fluorescent as fluorescent_node
from ...nodes import library, reradiation_matrix, spectrum_file, spectrum_library
from .registry import evaluates, translates
from .textures import normal
from .values import Constant, Spectral, as_rgb


def table(wavelengths, values):
    return {"table": {"lambda": list(wavelengths), "value": list(values)}}


def absorbed(name, absorbance):
    """S of the share of light that a dye of this absorbance at its peak takes in."""
    return table(library.wavelengths(), library.absorbed(absorbance, library.values(name)))


@translates("stokes.fluorescent")
def fluorescent(node, graph):
    settings = nodes.settings_of(node)
    if settings.dye == fluorescent_node.CUSTOM:
        absorption, emission = graph.spectrum(node, "Absorption"), graph.shape(node, "Emission")
    else:
        for name in ("Absorption", "Emission"):
            if graph.is_linked(nodes.input_of(node, name)):
                graph.warn(
                    node,
                    "%s is linked, but the dye '%s' is used" % (name, library.pretty(settings.dye)),
                )
        absorption = absorbed("dye/%s/absorption" % settings.dye, settings.absorbance)
        emission = {"library": "dye/%s/emission" % settings.dye}
    return graph.bsdf(
        "fluorescent",
        reflectance=graph.color(node, "Reflectance"),
        absorption=absorption,
        emission=1.0 if emission is None else emission,
        concentration=graph.factor(node, "Concentration"),
        normal=normal(node, graph),
        **{
            "yield": 0.0 if emission is None else graph.number(node, "Yield", low=0.0),
            "yield_kind": settings.yield_kind,
        },
    )


@translates("stokes.reradiation_matrix")
def measured(node, graph):
    settings = nodes.settings_of(node)
    matrix = reradiation_matrix.matrix_of(settings)
    if matrix is None:
        graph.warn(node, "%s; a grey surface is used" % (settings.problem or "has no file"))
        return graph.bsdf("diffuse", reflectance=0.5, normal=normal(node, graph))
    return graph.bsdf(
        "reradiation_matrix",
        matrix=matrix,
        diagonal=settings.diagonal,
        normal=normal(node, graph),
    )


@translates("stokes.dispersive_glass")
def dispersive_glass(node, graph):
    settings = nodes.settings_of(node)
    if settings.model == 'ABBE':
        ior = {
            "n_d": graph.number(node, "IOR", low=1.0, high=5.0),
            "abbe": graph.number(node, "Abbe Number", low=5.0),
        }
    elif settings.model == 'PRESET':
        ior = {"library": settings.preset}
    elif settings.model == 'CAUCHY':
        ior = {"cauchy": [settings.cauchy_a, settings.cauchy_b, settings.cauchy_c]}
    else:
        ior = {
            "sellmeier": [
                [getattr(settings, "b%d" % i), getattr(settings, "c%d" % i)] for i in (1, 2, 3)
            ]
        }
    return graph.bsdf(
        "dielectric",
        ior=ior,
        roughness=graph.factor(node, "Roughness"),
        lobes="both",
        transmit_color=graph.color(node, "Color"),
        normal=normal(node, graph),
    )


@translates("stokes.conductor")
def conductor(node, graph):
    return graph.bsdf(
        "conductor",
        metal=nodes.settings_of(node).metal,
        roughness=graph.factor(node, "Roughness"),
        normal=normal(node, graph),
    )


@evaluates("stokes.spectrum_library")
def from_library(node, output, graph):
    settings = nodes.settings_of(node)
    name = spectrum_library.chosen(settings)
    spectrum = (
        absorbed(name, settings.absorbance)
        if spectrum_library.uses_absorbance(settings)
        else {"library": name}
    )
    return Spectral(spectrum, settings.unit)


@evaluates("stokes.spectrum_file")
def from_file(node, output, graph):
    settings = nodes.settings_of(node)
    rows = spectrum_file.table_of(settings)
    if not rows:
        graph.warn(node, "%s; a spectrum of 0.5 is used" % (settings.problem or "has no file"))
        return Spectral(0.5, settings.unit)
    for note in settings.notes.splitlines():
        graph.warn(node, note)
    if (
        settings.kind != 'REFLECTANCE'
    ):  # the stream holds ends where it takes a reflectance; these must end in zero
        rows = [(rows[0][0], 0.0)] + rows + [(rows[-1][0], 0.0)]
    return Spectral(table(*zip(*rows)), settings.unit)


@evaluates("stokes.spectrum_illuminant")
def illuminant(node, output, graph):
    settings = nodes.settings_of(node)
    return Spectral({"illuminant": settings.illuminant}, settings.unit)


@evaluates("stokes.spectrum_blackbody")
def blackbody(node, output, graph):
    return Spectral(
        {"blackbody": graph.number(node, "Temperature", low=100.0, high=1e6)},
        nodes.settings_of(node).unit,
    )


@evaluates("stokes.spectrum_gaussian")
def gaussian(node, output, graph):
    return Spectral(
        {
            "gaussian": {
                "mean": graph.number(node, "Mean", low=1.0, high=1e5),
                "sigma": graph.number(node, "Sigma", low=0.1, high=1e4),
                "peak": graph.number(node, "Peak", low=0.0, high=1e6),
            }
        },
        nodes.settings_of(node).unit,
    )


@evaluates("stokes.spectrum_line")
def line(node, output, graph):
    return Spectral(
        {
            "line": {
                "center": graph.number(node, "Center", low=1.0, high=1e5),
                "width": graph.number(node, "Width", low=1.0, high=1e4),
            }
        },
        nodes.settings_of(node).unit,
    )


@evaluates("stokes.spectrum_constant")
def constant(node, output, graph):
    return Spectral(graph.number(node, "Value", low=0.0), nodes.settings_of(node).unit)


@evaluates("stokes.spectrum_rgb")
def rgb(node, output, graph):
    value = graph.value(nodes.input_of(node, "Color"))
    if nodes.settings_of(node).method != 'moments':
        return value
    if not isinstance(value, Constant):
        graph.warn(node, "moments are for one colour; the sigmoid is used")
        return value
    return Spectral({"rgb": list(as_rgb(value.value)), "method": "moments"}, 'total')
