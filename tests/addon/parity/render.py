"""Run inside Blender: `render.py -- FOLDER SCENE JOB…`, a job being ENGINE:SEED or ENGINE:SEED:BRIGHTER. Builds the scene
and writes FOLDER/JOB.f32 (RGBA floats, bottom row first) for each job, and FOLDER/log.json."""

import json
import os
import sys
import time
from array import array

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(os.path.dirname(os.path.dirname(HERE)))]
sys.dont_write_bytecode = True

import bpy  # noqa: E402

import catalogue  # noqa: E402
import stage  # noqa: E402

BOUNCES = 12  # of every kind; a path then has two edges more: the camera's and the lamp's


def main(folder, name, jobs):
    case = catalogue.SCENES[name]
    if name != "default_cube":  # which is Blender's own
        stage.clear()
    case.build()
    scene = bpy.context.scene
    render = scene.render
    render.resolution_x, render.resolution_y = case.size
    render.resolution_percentage = 100
    render.use_compositing = render.use_sequencer = False
    render.image_settings.file_format = 'OPEN_EXR'
    render.image_settings.color_mode = 'RGBA'
    render.image_settings.color_depth = '32'
    render.use_persistent_data = False
    log = {"blender": bpy.app.version_string, "seconds": {}}
    for job in jobs:
        engine, seed, brighter = (job.split(":") + ["1"])[:3]
        ENGINES[engine](scene, case, int(seed), float(brighter))
        start = time.monotonic()
        log["size"] = _render(scene, os.path.join(folder, job))
        log["seconds"][job] = time.monotonic() - start
    with open(os.path.join(folder, "log.json"), "w") as out:
        json.dump(log, out)


def _cycles(scene, case, seed, brighter):
    """Everything that makes Cycles quick or smooth at the price of the mean is off."""
    scene.render.engine = 'CYCLES'
    wanted = {
        "device": 'CPU', "samples": case.cycles_samples, "seed": seed, "film_exposure": brighter,
        "use_adaptive_sampling": False, "use_denoising": False, "use_animated_seed": False,
        "sample_clamp_direct": 0.0, "sample_clamp_indirect": 0.0, "blur_glossy": 0.0, "light_sampling_threshold": 0.0,
        "caustics_reflective": True, "caustics_refractive": True, "use_fast_gi": False, "use_guiding": False,
        "pixel_filter_type": 'BLACKMAN_HARRIS', "filter_width": scene.render.filter_size,
        "max_bounces": BOUNCES, "diffuse_bounces": BOUNCES, "glossy_bounces": BOUNCES, "transmission_bounces": BOUNCES,
        "volume_bounces": BOUNCES,
        "transparent_max_bounces": BOUNCES, "min_light_bounces": BOUNCES, "min_transparent_bounces": BOUNCES,
    }
    for name, value in wanted.items():
        if hasattr(scene.cycles, name):
            setattr(scene.cycles, name, value)


def _stokes(scene, case, seed, _brighter):
    if not hasattr(bpy.types.Scene, "stokes"):
        import addon
        addon.register()
    scene.render.engine = 'STOKES'
    stokes = scene.stokes
    stokes.samples, stokes.seed, stokes.time_limit = case.stokes_samples, seed, 0.0
    stokes.lanes = str(case.lanes)
    stokes.max_path = stokes.max_camera = stokes.max_light = BOUNCES + 2
    for kind in ("diffuse", "glossy", "transmission", "volume", "transparent"):
        setattr(stokes, "max_" + kind, BOUNCES)
    if case.name != "default_cube":
        # Light emits all of its power over Λ whatever Λ is; where the eye is blind it only adds noise.
        stokes.lambda_min, stokes.lambda_max = 380.0, 730.0
    if os.environ.get("PARITY_INTEGRATOR"):
        stokes.integrator = os.environ["PARITY_INTEGRATOR"]


ENGINES = {"cycles": _cycles, "stokes": _stokes}


def _render(scene, path):
    scene.render.filepath = path + ".exr"
    bpy.ops.render.render(write_still=True)
    if not os.path.exists(path + ".exr"):
        raise SystemExit("no picture of " + path)
    picture = bpy.data.images.load(path + ".exr")
    picture.colorspace_settings.name = "Non-Color"
    size = list(picture.size)
    pixels = array("f", bytes(16 * size[0] * size[1]))
    picture.pixels.foreach_get(pixels)
    with open(path + ".f32", "wb") as out:
        pixels.tofile(out)
    bpy.data.images.remove(picture)
    os.remove(path + ".exr")
    return size


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1:]
    main(arguments[0], arguments[1], arguments[2:])
