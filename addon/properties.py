"""The one list of Stokes' settings: each with its unit, range, default and tooltip.
`stream_settings` turns them into the `settings` message of csrc/stream/STREAM.md."""

import re

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

INTEGRATORS = (
    (
        'bdpt',
        "Bidirectional (Exact)",
        "Paths from the camera and from the lights, connected across wavelengths that are chosen "
        "to fit: no blur of colours, no width to set",
    ),
    (
        'mbdpt',
        "Bidirectional (Mollified)",
        "The published method: connects paths of different wavelengths through a kernel, which "
        "blurs colours the less the more samples there are",
    ),
    (
        'pt_nee',
        "Path Tracing",
        "Paths from the camera, with a look at a light at every bounce. Best for open scenes",
    ),
    (
        'lt',
        "Light Tracing",
        "Paths from the lights only. Sees caustics, but nothing behind glass or in mirrors",
    ),
    (
        'pt',
        "Plain Path Tracing",
        "Paths from the camera that must hit a light by chance. A slow reference",
    ),
)

KERNELS = (
    (
        'constant',
        "Constant",
        "The reflectance is taken where the light arrives, the wavelength is blurred by a box. "
        "Conserves energy and photons",
    ),
    (
        'incident_reflectance',
        "Incident Reflectance",
        "The reflectance is taken where the light leaves, the absorption where it arrives",
    ),
    (
        'incident',
        "Incident",
        "Reflectance and absorption are both taken where the light leaves. Can make energy that was "
        "not there",
    ),
    (
        'box',
        "Box in Both",
        "A box filter in the arriving and in the leaving wavelength. Can make energy where the "
        "reflectance has steep edges",
    ),
    (
        'asymmetric',
        "Asymmetric",
        "As Constant, but light leaves with longer wavelengths only, up to twice the width. Can make "
        "photons that were not there",
    ),
)

MOLLIFY_SIDES = (
    ('light', "Light Side", "The end of a connection nearer to the light takes the blur"),
    ('camera', "Camera Side", "The end of a connection nearer to the camera takes the blur"),
)

UV_RULES = (
    ('hold', "Hold", "An RGB colour reflects in the ultraviolet what it reflects at 360 nm"),
    (
        'extrapolate',
        "Extrapolate",
        "Continue the upsampled curve. May turn dark reds bright in the UV",
    ),
    ('zero', "Black", "RGB colours reflect no ultraviolet at all"),
)

LANES = (
    ('1', "1", "One wavelength a path"),
    ('4', "4", "Four wavelengths a path"),
    ('8', "8", "Eight wavelengths a path"),
)

MOST_EDGES = 32  # of a path; the core takes no longer ones (STREAM.md, `settings`)

# Operator presets: what a click on them sets. Members not named keep their value.
PRESETS = {
    'PREVIEW': (
        "Preview",
        "A quick look: few samples, short paths; wide mollification that does not shrink",
        dict(samples=16, d0=100.0, shrink=0.0, max_path=12),
    ),
    'DRAFT': (
        "Draft",
        "Clean enough to judge light and colour",
        dict(samples=64, d0=50.0, shrink=0.2, max_path=16),
    ),
    'FINAL': (
        "Final",
        "For the picture that you keep",
        dict(samples=1024, d0=50.0, shrink=0.2, max_path=MOST_EDGES),
    ),
    'CAUSTICS': (
        "Glass and Caustics",
        "Paths from both ends, many bounces and many samples",
        dict(
            integrator='bdpt',
            samples=2048,
            max_path=MOST_EDGES,
            max_transmission=MOST_EDGES,
            max_glossy=MOST_EDGES,
        ),
    ),
    'REFERENCE': (
        "Reference",
        "Nothing left out, at the price of time",
        dict(
            integrator='bdpt',
            samples=16384,
            max_path=MOST_EDGES,
            max_camera=MOST_EDGES,
            max_light=MOST_EDGES,
            max_diffuse=MOST_EDGES,
            max_glossy=MOST_EDGES,
            max_transmission=MOST_EDGES,
            max_volume=MOST_EDGES,
            max_transparent=MOST_EDGES,
        ),
    ),
}

# Settings whose name and value are the stream's own (STREAM.md, `settings`).
_SAME_IN_STREAM = (
    "integrator",
    "lanes",
    "seed",
    "d0",
    "shrink",
    "kernel",
    "mollify_side",
    "light_paths",
    "max_path",
    "max_camera",
    "max_light",
    "max_diffuse",
    "max_glossy",
    "max_transmission",
    "max_volume",
    "max_transparent",
    "lambda_min",
    "lambda_max",
    "uv_rule",
)

# Narrower than this there is nothing left to render, and the core refuses it.
_NARROWEST_RANGE_NM = 10.0


def _keep_range_open(self, _context):
    if self.lambda_max < self.lambda_min + _NARROWEST_RANGE_NM:
        self.lambda_max = self.lambda_min + _NARROWEST_RANGE_NM


def _bounces(name, tooltip):
    return IntProperty(name=name, description=tooltip, default=MOST_EDGES, min=0, max=MOST_EDGES)


class StokesSettings(bpy.types.PropertyGroup):
    """scene.stokes"""

    # Sampling
    integrator: EnumProperty(
        name="Integrator",
        description="How light paths are found",
        items=INTEGRATORS,
        default='bdpt',
    )
    lanes: EnumProperty(
        name="Wavelengths",
        description="How many wavelengths each path carries. More of them cost time and take away "
        "colour noise, most of all where nothing disperses",
        items=LANES,
        default='4',
    )
    samples: IntProperty(
        name="Samples",
        description="Paths per pixel of a final render",
        default=128,
        min=1,
        soft_max=16384,
        max=1 << 24,
    )
    preview_samples: IntProperty(
        name="Preview Samples",
        description="Paths per pixel of the little pictures of materials",
        default=32,
        min=1,
        soft_max=512,
        max=1 << 16,
    )
    time_limit: FloatProperty(
        name="Time Limit",
        subtype='TIME_ABSOLUTE',
        unit='TIME_ABSOLUTE',
        precision=1,
        step=100,
        description="Stop after this many seconds and keep the picture as it is. 0 means no limit",
        default=0.0,
        min=0.0,
        soft_max=3600.0,
        max=1e7,
    )
    seed: IntProperty(
        name="Seed",
        description="Another number gives other noise; the same number the same picture, "
        "bit by bit",
        default=0,
        min=0,
        max=(1 << 31) - 1,
    )
    animate_seed: BoolProperty(
        name="Animate Seed", description="Other noise in every frame", default=False
    )

    # Mollification
    d0: FloatProperty(
        name="Width",
        description="Half-width of the mollification kernel at the first sample, in nm: "
        "how far apart the wavelengths of two joined paths may be. Wider is less noisy and blurs "
        "colours more",
        default=50.0,
        min=0.1,
        soft_min=5.0,
        soft_max=100.0,
        max=500.0,
        precision=1,
        step=100,
    )
    shrink: FloatProperty(
        name="Shrink",
        description="Exponent s of the kernel's width d0 · n^(−s) at sample n. 0 keeps the "
        "width (quick, with a lasting blur of colours); above 0 the blur vanishes with time",
        default=0.2,
        min=0.0,
        max=0.99,
        precision=2,
        step=1,
    )
    kernel: EnumProperty(
        name="Kernel", description="Shape of the mollification", items=KERNELS, default='constant'
    )
    mollify_side: EnumProperty(
        name="Blur At",
        description="Which surface of a connection is mollified",
        items=MOLLIFY_SIDES,
        default='light',
    )

    # Light paths
    light_paths: FloatProperty(
        name="From the Lights",
        description="Paths traced from the lights for each one from the camera. 0: as many as pay in this scene "
        "with exact bidirectional path tracing, one with the mollified. Fewer suit open scenes, more suit "
        "caustics",
        default=0.0,
        min=0.0,
        soft_max=4.0,
        max=64.0,
        precision=2,
        step=25,
    )
    max_path: IntProperty(
        name="Total",
        description="Longest path from a light to the camera, in segments",
        default=MOST_EDGES,
        min=1,
        max=MOST_EDGES,
    )
    max_camera: IntProperty(
        name="Camera Part",
        description="Longest part of a path traced from the camera, in segments",
        default=MOST_EDGES,
        min=1,
        max=MOST_EDGES,
    )
    max_light: IntProperty(
        name="Light Part",
        description="Longest part of a path traced from a light, in segments",
        default=MOST_EDGES,
        min=0,
        max=MOST_EDGES,
    )
    max_diffuse: _bounces("Diffuse", "Most diffuse or fluorescent bounces on one path")
    max_glossy: _bounces("Glossy", "Most bounces by reflection on one path")
    max_transmission: _bounces("Transmission", "Most passages through glass on one path")
    max_volume: _bounces("Volume", "Most scatterings inside volumes on one path")
    max_transparent: _bounces(
        "Transparent", "Most passages through transparent surfaces on one path"
    )

    # Wavelengths
    lambda_min: FloatProperty(
        name="From",
        description="Shortest wavelength of light in the scene, in nm. The eye sees from "
        "about 380 nm; black lights and most dyes need the ultraviolet below it",
        default=300.0,
        min=100.0,
        max=2000.0,
        precision=0,
        step=1000,
        update=_keep_range_open,
    )
    lambda_max: FloatProperty(
        name="To",
        description="Longest wavelength of light in the scene, in nm. The eye sees up to "
        "about 780 nm",
        default=830.0,
        min=110.0,
        max=2500.0,
        precision=0,
        step=1000,
        update=_keep_range_open,
    )
    uv_rule: EnumProperty(
        name="RGB in the UV",
        description="What colours given as RGB reflect below 360 nm, where RGB says nothing",
        items=UV_RULES,
        default='hold',
    )

    # Output
    strict: BoolProperty(
        name="Strict",
        description="Stop with an error at anything that would not be rendered as in Cycles, "
        "instead of a warning",
        default=False,
    )
    use_record: BoolProperty(
        name="Record",
        description="Also write the scene as a file that `stokes render` can render "
        "without Blender",
        default=False,
    )
    record_path: StringProperty(
        name="Scene File",
        subtype='FILE_PATH',
        default="//scene.stokes",
        description="Where the recorded scene goes; # stand for the frame number",
    )


def _decimal(value):
    """Blender keeps single precision: 0.2 as it was typed, not 0.20000000298."""
    return float("%.7g" % value) if isinstance(value, float) else value


def stream_settings(scene, preview=False):
    """Members of the `settings` message for a final render or a material preview."""
    settings = scene.stokes
    message = {name: _decimal(getattr(settings, name)) for name in _SAME_IN_STREAM}
    message["lanes"] = int(message["lanes"])
    if settings.animate_seed:
        message["seed"] = (settings.seed + scene.frame_current) % (1 << 31)
    message["filter_width"] = min(99.0, max(0.02, _decimal(scene.render.filter_size)))
    message["film_transparent"] = scene.render.film_transparent
    fixed = scene.render.threads_mode == 'FIXED'
    message["threads"] = scene.render.threads if fixed else 0
    message["time_limit"] = 0.0 if preview else settings.time_limit
    return message


def sample_count(scene, preview=False):
    return scene.stokes.preview_samples if preview else scene.stokes.samples


def record_path(scene):
    """Absolute path of the scene file to record for the current frame, or "" if none is asked
    for."""
    settings = scene.stokes
    if not settings.use_record or not settings.record_path:
        return ""
    path = bpy.path.abspath(settings.record_path)
    return re.sub("#+", lambda run: str(scene.frame_current).zfill(len(run.group())), path)


def apply_preset(settings, name):
    for member, value in PRESETS[name][2].items():
        setattr(settings, member, value)


def register():
    bpy.utils.register_class(StokesSettings)
    bpy.types.Scene.stokes = PointerProperty(type=StokesSettings)


def unregister():
    del bpy.types.Scene.stokes
    bpy.utils.unregister_class(StokesSettings)
