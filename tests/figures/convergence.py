"""Convergence animations (supplemental §5.1): all integrators side by side at 1, 2, 4, … samples per pixel, from one
render's snapshots each; as GIF and as PNG frames."""

from PIL import Image

import bench_scenes
import colour
import kit
import plots
from plots import plt

SCENES = ("spheres", "lens", "ufo")
RESOLUTION, SAMPLES = ((40, 30), 32) if kit.QUICK else ((160, 120), 256)
COLUMNS = {  # what is written above, and how it is rendered
    "pt": {"integrator": "pt"},
    "pt_nee": {"integrator": "pt_nee"},
    "lt": {"integrator": "lt"},
    "bdpt": {"integrator": "bdpt"},
    "mbdpt, $d_0$ = 100 nm, s = 0": {"integrator": "mbdpt", "d0": 100, "shrink": 0},
    "mbdpt, $d_0$ = 50 nm, s = 0.2": {"integrator": "mbdpt", "d0": 50, "shrink": 0.2},
}
FRAME_MS, LAST_MS = 900, 2700


def snapshots(name, scene):
    """Of each column, its pictures at 1, 2, 4, … samples."""
    counts = [2**k for k in range(SAMPLES.bit_length())]
    shown = {}
    for title, options in COLUMNS.items():
        kit.say("  %s: %s" % (name, title.replace("$", "")))
        out = plots.WORK / "convergence.exr"
        kit.render(scene, out, snapshots=True, spp=SAMPLES, **options)
        shown[title] = [kit.read_xyz(kit.snapshot(out, count)) for count in counts]
    return counts, shown


def frame(path, title, shown, index, gain):
    figure, axes = plt.subplots(1, len(shown), figsize=(2.5 * len(shown), 2.6))
    for panel, (name, pictures) in zip(axes, shown.items()):
        plots.picture(panel, pictures[index], gain, name)
    figure.suptitle(title)
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)


def animate(name):
    counts, shown = snapshots(name, bench_scenes.write(name, plots.WORK, RESOLUTION))
    folder = plots.FOLDER / "convergence"
    folder.mkdir(parents=True, exist_ok=True)
    gain = colour.exposure(shown["bdpt"][-1], 95)
    frames = []
    for index, count in enumerate(counts):
        path = folder / ("%s-%05d.png" % (name, count))
        title = "%s, %d sample%s per pixel" % (bench_scenes.TITLES[name], count, "s" * (count > 1))
        frame(path, title, shown, index, gain)
        frames.append(Image.open(path).convert("RGB").quantize(256))
    durations = [FRAME_MS] * (len(frames) - 1) + [LAST_MS]
    frames[0].save(
        plots.FOLDER / ("convergence-%s.gif" % name),
        save_all=True,
        append_images=frames[1:],
        duration=durations,
        loop=0,
    )
    kit.say("  convergence-%s.gif and %d frames" % (name, len(frames)))


def draw():
    for name in SCENES:
        animate(name)
