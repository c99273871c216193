"""Measured Spectrum: a table from a CSV or SPD file. What was read stays in the .blend file."""

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

from . import library
from .base import COLOR_OUT, NodeKind, on_change, unit_property

KINDS = (
    ('REFLECTANCE', "Reflectance", "Held constant beyond the ends of the table"),
    ('ABSORPTION', "Absorption", "The share of light taken in; zero beyond the ends of the table"),
    ('EMISSION', "Emission", "A light or a glow; zero beyond the ends of the table"),
)


MOST_ROWS = 65534  # the stream takes 65 536, and lights end in two more
SHORTEST_NM = 50.0  # below that there is no light that a scene may carry


class SpectrumFileError(Exception):
    pass


def parse(text, column=1):
    """[(nm, value)] in ascending order from lines of numbers parted by commas, semicolons or
    blanks; beside semicolons a comma is a decimal mark. Lines that do not begin with a number are
    titles. `stokes spectrum` reads the same."""
    table = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.replace(",", "." if ";" in line else " ").replace(";", " ").split()
        try:
            nm = float(words[0])
        except (ValueError, IndexError):
            continue
        try:
            table.append((nm, float(words[column])))
        except (ValueError, IndexError):
            raise SpectrumFileError(
                "line %d: no number in column %d" % (number, column + 1)
            ) from None
    if len(table) < 2:
        raise SpectrumFileError("needs at least two lines of wavelength and value")
    if len(table) > MOST_ROWS:
        raise SpectrumFileError("has %d lines; at most %d are taken" % (len(table), MOST_ROWS))
    table.sort()
    for (x0, _y0), (x1, _y1) in zip(table, table[1:]):
        if x0 == x1:
            raise SpectrumFileError("wavelength %g stands twice" % x0)
    if table[0][0] <= 0:
        raise SpectrumFileError("wavelength %g is not above 0" % table[0][0])
    if table[-1][0] < SHORTEST_NM:
        raise SpectrumFileError(
            "wavelengths end at %g: they are wanted in nm, not in µm" % table[-1][0]
        )
    if not all(abs(number) < 1e30 for row in table for number in row):
        raise SpectrumFileError("a value is not finite")
    return table


def below_zero(table):
    """What is done about an instrument's noise about zero, in words; empty if there is none."""
    low = [value for _nm, value in table if value < 0.0]
    if not low:
        return ""
    counts = len(low), len(table), min(low)
    return "%d of %d values are below zero, down to %.3g: taken as 0" % counts


def _read(self, context):
    self.problem = self.notes = self.data = ""
    if self.filepath:
        try:
            with open(
                bpy.path.abspath(self.filepath), encoding="utf-8-sig", errors="replace"
            ) as source:
                table = parse(source.read(), self.column)
            self.data = " ".join("%.9g %.9g" % row for row in table)
            self.notes = below_zero(table)
        except (OSError, SpectrumFileError) as error:
            self.problem = getattr(error, "strerror", None) or str(error)
    on_change(self, context)


class StokesSpectrumFileSettings(bpy.types.PropertyGroup):
    filepath: StringProperty(
        name="File",
        subtype='FILE_PATH',
        update=_read,
        description="Lines of a wavelength in nm and a value, parted by commas or blanks",
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
        name="Notes", options={'HIDDEN'}, description="What was done about noise below zero"
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
        if settings.notes:
            layout.label(text=settings.notes, icon='INFO')
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
