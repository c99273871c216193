"""Beyond the supplemental's figure 1: the measured sticky note, its matrix and column sums, and its picture under
daylight and under a black light."""

import numpy as np

import colour
import kit
import plots
from plots import plt

scenes = kit.scenes
NAME = "matrix/yellow_note"
LIGHTS = {
    "daylight (D65)": {"illuminant": "D65"},
    "black light (365 nm, 20 nm wide)": {"line": {"center": 365, "width": 20}},
}
RESOLUTION, SAMPLES = ((96, 72), 64) if kit.QUICK else ((240, 180), 128)


def matrix():
    path = plots.WORK / "note.csv"
    plots.WORK.mkdir(parents=True, exist_ok=True)
    kit.stokes("matrix", "import", NAME, "-o", path)
    return scenes.exact.Matrix.read(path)


def curled(half=0.38, lift=0.28, steps=24):
    """A square that lies on the ground and curls up toward the front."""
    across = np.linspace(-half, half, 2)
    along = np.linspace(half, -half, steps)
    rise = np.clip((0.5 * half - along) / (1.5 * half), 0, 1) ** 2 * lift + 0.004
    points = np.array([[x, y, z] for y, z in zip(along, rise) for x in across])
    faces = [(2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1) for i in range(steps - 1)]
    return points, np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])


def scene(light):
    """The note on grey ground, half of it in front of a white sheet without brighteners; a lamp above."""
    path = plots.WORK / "note.stokes"
    with kit.stream.Recorder(path) as out:
        for name, reflectance in (("ground", 0.2), ("sheet", 0.85)):
            out.send("material", name=name, surface={"bsdf": "diffuse", "reflectance": reflectance})
        out.send("material", name="note", surface={"bsdf": "reradiation_matrix", "matrix": {"library": NAME}})
        corners = np.array([[-3, -3, 0], [3, -3, 0], [3, 3, 0], [-3, 3, 0]], dtype=float)
        for name, positions in (("ground", corners), ("sheet", corners * [0.17, 0.1, 0] + [0.55, 0.25, 0.002])):
            scenes.mesh(out, name, positions, np.array([[0, 1, 2], [0, 2, 3]]))
            scenes.instance(out, name, [name])
        scenes.mesh(out, "note", *curled())
        scenes.instance(out, "note", ["note"])
        emission = {"shape": light, "scale": 30, "unit": "total"}
        place = scenes.translation(-0.7, -0.8, 1.8)
        out.send("light", name="lamp", kind="rectangle", transform=place, size=[0.5, 0.5], emission=emission)
        slope, height = np.radians(48), 1.45  # looks down at this angle from the front
        c, s = np.cos(slope), np.sin(slope)
        look = [1, 0, 0, 0.12, 0, s, -c, -height * c / s, 0, c, s, height]
        scenes.camera(out, look, RESOLUTION, 0.36)
        out.send("render", samples=[0, 16])
    return path


def draw():
    note = matrix()
    figure, axes = plt.subplots(2, 2, figsize=(10.5, 8), layout="constrained")
    axes = axes.flat
    density = note.share / note.step
    low, high = note.incident[[0, -1]] + [-note.step / 2, note.step / 2]
    image = axes[0].imshow(
        np.maximum(density, 1e-6),
        origin="lower",
        extent=(low, high, note.outgoing[0] - note.step / 2, note.outgoing[-1] + note.step / 2),
        norm=plots.matplotlib.colors.LogNorm(2e-5, 0.1),
        cmap="magma",
        interpolation="nearest",
    )
    axes[0].set_xlabel("incident wavelength (nm)")
    axes[0].set_ylabel("leaving wavelength (nm)")
    axes[0].set_title("yellow sticky note, measured")
    axes[0].grid(False)
    plots.scale(figure, image, axes[0], "share per nm")
    axes[1].plot(note.incident, note.share.sum(axis=0), color="#c1121f", label="energy")
    axes[1].plot(
        note.incident,
        (note.share * note.outgoing[:, None]).sum(axis=0) / note.incident,
        color="#2458c5",
        label="photons",
    )
    axes[1].axhline(1, color="black", linewidth=0.8, linestyle=":")
    axes[1].set_ylim(0, 1.1)
    axes[1].set_xlabel("incident wavelength (nm)")
    axes[1].set_ylabel("out / in (column sums)")
    axes[1].set_title("its diagonal is known from 380 nm on")
    axes[1].legend()
    for panel, (title, light) in zip(axes[2:], LIGHTS.items()):
        xyz = kit.picture_of(scene(light), plots.WORK / "note.exr", integrator="bdpt", spp=SAMPLES)
        plots.picture(panel, xyz, colour.exposure(xyz, 97), title)
    plots.save(figure, "figure-01b-measured-note")
