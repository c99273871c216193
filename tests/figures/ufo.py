"""Beside figure 6: the UFO scene rendered with its medium, by the mollified method and by path tracing, and in clear air."""

import bench_scenes
import colour
import kit
import plots
from plots import plt

RESOLUTION, SAMPLES = ((48, 36), 16) if kit.QUICK else ((240, 180), 96)


def without_volumes(message, members):
    return dict(members, volume=None) if "volume" in members else members


def draw():
    scene = bench_scenes.write("ufo", plots.WORK, RESOLUTION)
    clear = plots.WORK / "ufo-clear.stokes"
    kit.edited(scene, clear, without_volumes)
    panels = {
        "mbdpt, %d samples" % SAMPLES: (scene, "mbdpt"),
        "pt_nee, %d samples" % SAMPLES: (scene, "pt_nee"),
        "mbdpt without the medium": (clear, "mbdpt"),
    }
    figure, axes = plt.subplots(1, len(panels), figsize=(5.2 * len(panels), 4.2))
    gain = None
    for panel, (title, (path, integrator)) in zip(axes, panels.items()):
        xyz = kit.picture_of(path, plots.WORK / "ufo.exr", integrator=integrator, spp=SAMPLES, lanes=4)
        gain = gain or colour.exposure(xyz, 95)
        plots.picture(panel, xyz, gain, title)
    figure.tight_layout()
    plots.save(figure, "figure-06b-ufo")
