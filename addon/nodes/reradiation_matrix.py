"""Reradiation Matrix: a diffuse surface that glows, as a bispectral photometer measured it. The
core reads the file; what it read stays in the .blend file."""

import bpy
from bpy.props import EnumProperty, StringProperty

from ..core import tool
from . import library
from .base import BSDF_OUT, NORMAL, NodeKind, on_change

FILE = 'FILE'
MEASUREMENTS = library.enum_items(
    (
        (FILE, "From File", "A measurement of your own"),
        (
            "matrix/yellow_note",
            "Yellow Note",
            "A fluorescent yellow sticky note, measured by Labsphere",
        ),
    )
)
DIAGONALS = (
    (
        'both',
        "Reflected and Glow",
        "A band's own light is reflected or glows in the same band, as instruments measure it. The "
        "two are told apart by the bands beside",
    ),
    ('elastic', "Reflected", "A band's own light is reflected light alone"),
)
SECONDS = 30


def parse(text):
    """(incident nm, outgoing nm, rows) of the core's CSV: a row of shares for each outgoing band."""
    lines = [line.split(",") for line in text.splitlines()]
    incident = [float(word) for word in lines[0][1:]]
    return incident, [float(line[0]) for line in lines[1:]], [
        [float(word) for word in line[1:]] for line in lines[1:]
    ]


def _import(source):
    from ..engine.session import core_preference

    return tool.imported(core_preference(), "matrix", source, SECONDS)


def _read(self, context):
    self.problem = self.notes = self.data = ""
    source = bpy.path.abspath(self.filepath) if self.measurement == FILE else self.measurement
    if source:
        try:
            self.data, self.notes = _import(source)
        except tool.ToolError as error:
            self.problem = str(error)
    on_change(self, context)


class StokesReradiationMatrixSettings(bpy.types.PropertyGroup):
    measurement: EnumProperty(
        name="Measurement",
        description="A measured material, or a file",
        items=MEASUREMENTS,
        default=FILE,
        update=_read,
    )
    filepath: StringProperty(
        name="File",
        subtype='FILE_PATH',
        update=_read,
        description="CSV (incident wavelengths across, a line for each outgoing one), the matrix "
        "text of a BFC-450, or a bispectral OpenEXR",
    )
    diagonal: EnumProperty(
        name="Diagonal",
        description="What light that leaves in the band where it came in is",
        items=DIAGONALS,
        default='both',
        update=on_change,
    )
    data: StringProperty(name="Data", options={'HIDDEN'}, description="What was read from the file")
    notes: StringProperty(
        name="Notes", options={'HIDDEN'}, description="What was done about noise and missing bands"
    )
    problem: StringProperty(
        name="Problem", options={'HIDDEN'}, description="Why the file could not be read"
    )


class ReradiationMatrix(NodeKind):
    name = "reradiation_matrix"
    label = "Reradiation Matrix"
    tooltip = "A measured fluorescent surface, by how much light of each band leaves in each"
    width = 220
    inputs = (NORMAL,)
    outputs = (BSDF_OUT,)
    Settings = StokesReradiationMatrixSettings

    def title(self, settings):
        if settings.measurement != FILE:
            return next(item[1] for item in MEASUREMENTS if item[0] == settings.measurement)
        if not settings.filepath:
            return self.label
        return bpy.path.display_name_from_filepath(settings.filepath)

    def build(self, inside, settings):
        """Diffuse, in the colour that daylight gives it, at most white."""
        color = tuple(min(1.0, channel) for channel in library.reflected(in_daylight(settings)))
        inside.surface("ShaderNodeBsdfDiffuse", Color=color)

    def draw(self, layout, settings, node):
        layout.prop(settings, "measurement")
        if settings.measurement == FILE:
            layout.prop(settings, "filepath")
        if settings.problem:
            layout.label(text=settings.problem, icon='ERROR')
        for note in settings.notes.splitlines():
            layout.label(text=note, icon='INFO')
        layout.prop(settings, "diagonal")


def in_daylight(settings):
    """What leaves under D65 over what arrives, on the library's grid; 0.5 if nothing was read."""
    if not settings.data:
        return [0.5] * len(library.wavelengths())
    incident, outgoing, rows = parse(settings.data)
    daylight = list(zip(library.wavelengths(), library.values("illuminant/D65")))
    light = dict(zip(library.wavelengths(), library.on_grid(daylight, True)))

    def power(nm):
        nearest = min(light, key=lambda at: abs(at - nm))
        return light[nearest]

    arriving = [power(nm) for nm in incident]
    table = [
        (nm, sum(s * p for s, p in zip(row, arriving)) / max(power(nm), 1e-6))
        for nm, row in zip(outgoing, rows)
    ]
    return library.on_grid(table, True)


def matrix_of(settings):
    """M of the stream, or None if nothing was read."""
    if settings.measurement != FILE:
        return {"library": settings.measurement}
    if not settings.data:
        return None
    incident, outgoing, rows = parse(settings.data)
    return {
        "incident": [incident[0], len(incident)],
        "outgoing": [outgoing[0], len(outgoing)],
        "step": incident[1] - incident[0],
        "share": [share for row in rows for share in row],
    }


KIND = ReradiationMatrix()
