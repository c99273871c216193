"""All parity scenes, by name: what pytest lists and what render.py builds."""

import scenes_lights  # noqa: F401
import scenes_materials  # noqa: F401
import scenes_views  # noqa: F401
import scenes_volumes  # noqa: F401
from stage import SCENES  # noqa: F401
