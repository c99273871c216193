"""The Rendered viewport, which comes with a later version: one line says so."""

import blf
import gpu

TEXT = "Stokes renders the viewport in a later version: press F12, or use Material Preview"
MARGIN = 20
SIZE = 14
COLOR = (0.9, 0.9, 0.9, 1.0)


def update(_engine, _context, _depsgraph):
    """Nothing is kept of the scene yet."""


def draw(_engine, context, _depsgraph):
    scale = context.preferences.system.ui_scale
    gpu.state.blend_set('ALPHA')
    try:
        blf.size(0, SIZE * scale)
        blf.color(0, *COLOR)
        blf.position(0, MARGIN * scale, MARGIN * scale, 0)
        blf.draw(0, TEXT)
    finally:
        gpu.state.blend_set('NONE')
