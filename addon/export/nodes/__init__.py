"""Node trees as closures, emissions and worlds of csrc/stream/STREAM.md.
To add a Cycles node: one function with its decorator, in the file of its kind."""

from . import (  # noqa: F401  (they fill the registry)
    closures,
    colors,
    factors,
    maths,
    mixing,
    principled,
    stokes,
    textures,
    volumes,
)
from .outputs import light_emission, surface, volume, world  # noqa: F401
