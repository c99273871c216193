"""Measured Spectrum: a table from a CSV or SPD file. The core reads the file; what it read stays in
the .blend file."""

import os

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

from ..core import tool
from . import library
from .base import COLOR_OUT, NodeKind, on_change, unit_property

KINDS = (
    ('REFLECTANCE', "Reflectance", "Held constant beyond the ends of the table"),
    ('ABSORPTION', "Absorption", "The share of light taken in; zero beyond the ends of the table"),
    ('EMISSION', "Emission", "A light or a glow; zero beyond the ends of the table"),
)

SECONDS = 30


def _import(filepath, column):
    """"nm value nm value …" of a file, and what the core says about it, without the file's name."""
    from ..engine.session import core_preference

    # Whole, so that no file can be taken for an entry of the library.
    source = os.path.abspath(bpy.path.abspath(filepath))
    try:
        text, notes = tool.imported(
            core_preference(), "spectrum", source, SECONDS, "--column", str(column)
        )
    except tool.ToolError as error:
        raise tool.ToolError(str(error).removeprefix(source + ": ")) from error
    rows = text.splitlines()[1:]
    notes = [note.removeprefix(source + ": ") for note in notes.splitlines()]
    return " ".join(rows).replace(",", " "), "\n".join(notes)


def _read(self, context):
    self.problem = self.notes = self.data = ""
    if self.filepath:
        try:
            self.data, self.notes = _import(self.filepath, self.column)
        except tool.ToolError as error:
            self.problem = str(error)
    on_change(self, context)


class StokesSpectrumFileSettings(bpy.types.PropertyGroup):
    filepath: StringProperty(
        name="File",
        subtype='FILE_PATH',
        update=_read,
        description="Lines of a wavelength in nm and a value, parted by commas, semicolons, tabs or "
        "spaces. Wavelengths may be in Å if a title above them says so",
    )
    column: IntProperty(
        name="Column",
        description="Which column holds the values; the wavelengths are column 0",
        default=1,
        min=1,
        max=1000,
        update=_read,
    )
    kind: EnumProperty(
        name="Holds",
        description="What the numbers are",
        items=KINDS,
        default='REFLECTANCE',
        update=on_change,
    )
    percent: BoolProperty(
        name="Percent",
        description="100 in the file means all of the light",
        default=False,
        update=on_change,
    )
    data: StringProperty(name="Data", options={'HIDDEN'}, description="What was read from the file")
    notes: StringProperty(
        name="Notes",
        options={'HIDDEN'},
        description="What was done about noise, and what was taken for granted",
    )
    problem: StringProperty(
        name="Problem", options={'HIDDEN'}, description="Why the file could not be read"
    )
    unit: unit_property()


class SpectrumFile(NodeKind):
    name = "spectrum_file"
    label = "Measured Spectrum"
    tooltip = "A spectrum of your own, from a CSV or SPD file"
    category = 'SPECTRUM'
    outputs = (COLOR_OUT,)
    Settings = StokesSpectrumFileSettings

    def title(self, settings):
        if not settings.filepath:
            return self.label
        return bpy.path.display_name_from_filepath(settings.filepath)

    def build(self, inside, settings):
        values = curve(settings)
        color = (
            library.emitted(values) if settings.kind == 'EMISSION' else library.reflected(values)
        )
        inside.result(inside.rgb(color))

    def draw(self, layout, settings, node):
        layout.prop(settings, "filepath")
        if settings.problem:
            layout.label(text=settings.problem, icon='ERROR')
        for note in settings.notes.splitlines():
            layout.label(text=note, icon='INFO')
        layout.prop(settings, "column")
        layout.prop(settings, "kind")
        if settings.kind == 'EMISSION':
            layout.prop(settings, "unit")
        else:
            layout.prop(settings, "percent")


def table_of(settings):
    """[(nm, value)], empty if nothing was read."""
    numbers = [float(word) for word in settings.data.split()]
    scale = 0.01 if settings.percent and settings.kind != 'EMISSION' else 1.0
    return [(nm, max(0.0, scale * value)) for nm, value in zip(numbers[::2], numbers[1::2])]


def curve(settings):
    return library.on_grid(table_of(settings), settings.kind == 'REFLECTANCE')


KIND = SpectrumFile()
