"""Scenes of the whole-render tests, written as streams through the add-on's own writer (no bpy)."""

import importlib.util
import pathlib

import numpy as np

import exact

ROOT = pathlib.Path(__file__).parents[2]


def load_stream():
    spec = importlib.util.spec_from_file_location("stokes_stream", ROOT / "addon/core/stream.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


stream = load_stream()
IDENTITY = stream.IDENTITY

# --- Materials and lights ------------------------------------------------------------------------

# Dark enough for short paths. The spectra have no long tails: a bin carries much or nothing, so few samples say much.
MATERIALS = {
    "elastic": exact.Material(exact.Table([300, 450, 600, 830], [0.25, 0.45, 0.3, 0.5])),
    # Absorbs in the UV and the blue, emits green; its emission overlaps its absorption, so it absorbs its own light.
    "fluorescent": exact.Material(
        reflectance=exact.Table([300, 480, 560, 830], [0.25, 0.35, 0.5, 0.4]),
        absorption=exact.Table([300, 345, 390, 440, 520, 540], [0.2, 0.9, 0.85, 0.5, 0.15, 0]),
        emission=exact.Table([500, 515, 545, 580], [0, 0.9, 1, 0]),
        concentration=0.9,
        quantum_yield=0.85,
    ),
}
# Emission and absorption are zero outside their tables, which the stream and `Table` both say.
LIGHTS = {"d65": exact.d65(), "uv": exact.Table([344, 348, 392, 396], [0, 1, 1, 0])}
# Where each light, and what it makes the dye emit, is looked at: bins of 20 nm.
BINS = {
    ("elastic", "d65"): (14, 420, 700),
    ("elastic", "uv"): (3, 340, 400),
    ("fluorescent", "d65"): (14, 420, 700),
    ("fluorescent", "uv"): (13, 340, 600),
}


def emission(light, total=1.0):
    """L of the stream: ∫ over Λ is `total`. And the same on the grid."""
    values = light.on_grid()
    message = {"shape": light.message(), "scale": total, "unit": "total"}
    return message, total * values / exact.integral(values)


# --- Shapes ----------------------------------------------------------------------------------------


def cube(half=1.0):
    """Twelve triangles, wound so that they face inward."""
    positions = np.array([[x, y, z] for x in (-half, half) for y in (-half, half) for z in (-half, half)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    return positions, inward(positions, triangles)


def inward(positions, triangles):
    """Of a convex shape about the origin."""
    corners = positions[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = np.einsum("ij,ij->i", normals, corners.mean(axis=1)) > 0
    return np.where(outward[:, None], triangles[:, ::-1], triangles)


def icosphere(level, radius=1.0):
    golden = (1 + 5**0.5) / 2
    positions = [np.roll([0, a, b * golden], shift) for shift in range(3) for a in (-1, 1) for b in (-1, 1)]
    positions = np.array(positions) / np.linalg.norm([1, golden])
    distance = np.linalg.norm(positions[:, None] - positions[None], axis=-1)
    near = (distance > 0) & (distance < 1.2)
    triangles = np.array(
        [(a, b, c) for a in range(12) for b in range(a) for c in range(b) if near[a, b] and near[b, c] and near[a, c]]
    )
    for _ in range(level):
        positions, triangles = subdivide(positions, triangles)
    return positions * radius, inward(positions, triangles)


def subdivide(positions, triangles):
    """Every triangle into four, new vertices pushed out to the unit sphere."""
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, index = np.unique(edges, axis=0, return_inverse=True)
    middle = positions[unique].mean(axis=1)
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    ab, bc, ca = (index.reshape(-1, 3) + len(positions)).T
    a, b, c = triangles.T
    faces = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([positions, middle]), np.concatenate([np.stack(face, axis=1) for face in faces])


def ball(level, radius, center):
    """An icosphere that faces outward."""
    positions, triangles = icosphere(level, radius)
    return positions + np.asarray(center), triangles[:, ::-1]


def areas(positions, triangles):
    corners = positions[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.linalg.norm(normals, axis=1) / 2


# --- Writing ---------------------------------------------------------------------------------------


def mesh(out, name, positions, triangles, material_index=None):
    if material_index is None:
        material_index = np.zeros(len(triangles))
    out.send(
        "mesh",
        name=name,
        positions=stream.Blob(np.ascontiguousarray(positions, dtype="<f4")),
        triangles=stream.Blob(np.ascontiguousarray(triangles, dtype="<u4")),
        material_index=stream.Blob(np.ascontiguousarray(material_index, dtype="<u4")),
    )


def instance(out, name, materials, **members):
    out.send(
        "instances",
        name=name,
        mesh=name,
        materials=materials,
        transforms=stream.Blob(np.array(IDENTITY, dtype="<f4")),
        **members,
    )


def translation(x, y, z):
    return [1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z]


def camera(out, transform=IDENTITY, resolution=(16, 16), half=1.5, **members):
    """A pinhole that looks along −Z; `half` is the tangent of half its vertical angle."""
    wide = half * resolution[0] / resolution[1]
    out.send(
        "camera",
        kind="perspective",
        transform=transform,
        frame=[-wide, wide, -half, half],
        resolution=list(resolution),
        clip=[1e-4, 1e4],
        **members,
    )


def furnace(path, material, light, **settings):
    """A cube whose walls all emit and reflect; radiance is the same everywhere. Returns it, on the grid."""
    message, values = emission(light)
    with stream.Recorder(path) as out:
        out.send("settings", **settings)
        out.send(
            "material",
            name="wall",
            surface={"add": [material.message(), {"emission": message, "two_sided": False}]},
        )
        mesh(out, "box", *cube())
        instance(out, "box", ["wall"])
        camera(out, translation(0.1, 0.2, 0.3))
        out.send("render", samples=[0, 16])
    return exact.furnace(material, values)


def box_mesh(low, high):
    """A cuboid that faces outward."""
    positions, triangles = cube()
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    return low + (positions + 1) / 2 * (high - low), triangles[:, ::-1]


def black_world(out, volume):
    """No light from outside, and all of space full of a volume."""
    out.send("world", kind="constant", emission={"shape": 1, "scale": 0, "unit": "per_nm"}, volume=volume)


CLEAR = {"bsdf": "transparent", "color": 1}
# Thin enough for short paths: blue light is scattered eight times as much as red.
MIST = {
    "volume": "coefficients",
    "scattering": exact.Table([300, 420, 700, 830], [0.4, 0.4, 0.05, 0.05]).message(),
    "anisotropy": 0.3,
}


CLOUD = {
    "volume": "coefficients",
    "scattering": exact.Table([300, 420, 700, 830], [5, 5, 0.5, 0.5]).message(),
    "anisotropy": 0.3,
}


def cloudy_furnace(path, material, light, mist=None, cloud=MIST, clouds=((0.1, 0.2, -0.5), (-0.1, 0.1, -0.4)), **settings):
    """A furnace with two clouds, which overlap, of what scatters and does not absorb: radiance is that of the empty one."""
    message, values = emission(light)
    with stream.Recorder(path) as out:
        out.send("settings", **dict(settings, max_path=28, max_camera=28, max_light=28))
        out.send(
            "material",
            name="wall",
            surface={"add": [material.message(), {"emission": message, "two_sided": False}]},
        )
        mesh(out, "box", *cube())
        instance(out, "box", ["wall"])
        if mist:
            black_world(out, mist)
        backward = {"volume": "scatter", "color": 1, "density": 0.5, "anisotropy": -0.4}
        for name, centre, volume in zip(("first", "second"), clouds, (cloud, backward)):
            out.send("material", name=name, surface=CLEAR, volume=volume)
            mesh(out, name, *ball(2, 0.4, centre))
            instance(out, name, [name])
        camera(out, translation(0.1, 0.2, 0.3))
        out.send("render", samples=[0, 16])
    return exact.furnace(material, values)


def misty_furnace(path, material, light, **settings):
    """The same full of mist; and the camera is in one of the clouds."""
    return cloudy_furnace(path, material, light, MIST, MIST, ((0.1, 0.2, 0.2), (0, 0.3, -0.2)), **settings)


def thick_furnace(path, material, light, **settings):
    """The same where blue light is scattered several times and red light hardly ever."""
    return cloudy_furnace(path, material, light, MIST, CLOUD, ((0.1, 0.2, 0.2), (0, 0.3, -0.2)), **settings)


def sphere_with_patch(path, material, light, level=4, **settings):
    """A sphere whose cap behind the camera emits as well. Returns the walls' radiance on the grid."""
    positions, triangles = icosphere(level)
    cap = positions[triangles].mean(axis=1)[:, 2] > 0.1
    size = areas(positions, triangles)
    message, values = emission(light)
    with stream.Recorder(path) as out:
        out.send("settings", **settings)
        out.send("material", name="wall", surface=material.message())
        out.send(
            "material",
            name="lamp",
            surface={"add": [material.message(), {"emission": message, "two_sided": False}]},
        )
        mesh(out, "sphere", positions, triangles, cap)
        instance(out, "sphere", ["wall", "lamp"])
        camera(out)
        out.send("render", samples=[0, 16])
    return exact.wall(material, np.pi * size[cap].sum() * values, size.sum())


def sphere_with_lamp(path, material, light, level=4, radius=0.3, **settings):
    """A sphere with a spherical lamp, which rays pass, in its middle. Returns the walls' radiance on the grid."""
    positions, triangles = icosphere(level)
    message, values = emission(light)
    with stream.Recorder(path) as out:
        out.send("settings", **settings)
        out.send("material", name="wall", surface=material.message())
        mesh(out, "sphere", positions, triangles)
        instance(out, "sphere", ["wall"])
        out.send(
            "light", name="lamp", kind="sphere", transform=IDENTITY, radius=radius, emission=message
        )
        camera(out, translation(0, 0, -0.4))
        out.send("render", samples=[0, 16])
    power = 4 * np.pi**2 * radius**2 * values
    return exact.wall(material, power, areas(positions, triangles).sum())


# --- A box with dispersion -----------------------------------------------------------------------------


def box(path, resolution=(64, 48), border=None, specular=True, view="front", mist=False, **settings):
    """A box with a fluorescent wall, an area lamp, a dispersive glass ball and a metal one. `view` "wall" looks at the
    fluorescent wall alone, so that no specular surface is seen; without `specular` both balls are diffuse; with `mist` the box
    and its glass are full of volumes."""
    message, _ = emission(LIGHTS["d65"], 10)
    white = exact.Material(exact.Table([300, 830], [0.6, 0.6]))
    glass = {"bsdf": "dielectric", "ior": {"n_d": 1.6, "abbe": 25}}
    metal = {"bsdf": "conductor", "metal": "Au", "roughness": 0}
    with stream.Recorder(path) as out:
        out.send("settings", **settings)
        out.send("material", name="white", surface=white.message())
        out.send("material", name="red", surface=MATERIALS["elastic"].message())
        out.send("material", name="paint", surface=MATERIALS["fluorescent"].message())
        dim = {"volume": "principled", "color": {"rgb": [0.9, 0.5, 0.2]}, "density": 2, "anisotropy": -0.2}
        inside = {"volume": dim} if mist else {}
        out.send("material", name="glass", surface=glass if specular else MATERIALS["elastic"].message(), **inside)
        if mist:
            black_world(out, MIST)
        out.send("material", name="metal", surface=metal if specular else MATERIALS["fluorescent"].message())
        positions, triangles = cube()
        centre = positions[triangles].mean(axis=1)
        wall = np.where(centre[:, 0] < -0.9, 1, np.where(centre[:, 1] > 0.9, 2, 0))
        mesh(out, "box", positions, triangles, wall)
        instance(out, "box", ["white", "paint", "red"])
        mesh(out, "glass", *ball(3, 0.4, (0.4, 0.3, -0.55)))
        instance(out, "glass", ["glass"])
        mesh(out, "metal", *ball(3, 0.3, (0.3, -0.5, -0.65)))
        instance(out, "metal", ["metal"])
        out.send(
            "light",
            name="lamp",
            kind="rectangle",
            transform=translation(0.1, 0, 0.98),
            size=[0.8, 0.8],
            emission=message,
        )
        # Both look from the middle of the front, level: toward +y, or toward the fluorescent wall at −x.
        look = {
            "front": [1, 0, 0, 0, 0, 0, -1, -0.95, 0, 1, 0, 0],
            "wall": [0, 0, 1, -0.1, 1, 0, 0, 0, 0, 1, 0, 0.1],
        }[view]
        members = {} if border is None else {"border": border}
        camera(out, look, resolution, 0.75, **members)
        out.send("render", samples=[0, 16])


def turned(positions, angle):
    """About the Z axis."""
    c, s = np.cos(angle), np.sin(angle)
    return positions @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


def glass_box(path, where, resolution=(32, 32), lamp=0.3, looks_down=False, light=LIGHTS["d65"], **settings):
    """A box with a fluorescent back wall and strongly dispersive glass: a block that stands before the wall and reflects totally from within
    ("block"), a ball about the lamp ("lamp"), one about the camera ("camera"), or smaller ones about each ("both"). `lamp` is the lamp's radius; a camera that
    looks down sees the floor alone."""
    message, _ = emission(light, 10)
    grey = exact.Material(exact.Table([300, 830], [0.4, 0.4]))
    with stream.Recorder(path) as out:
        out.send("settings", **settings)
        out.send("material", name="grey", surface=grey.message())
        out.send("material", name="paint", surface=MATERIALS["fluorescent"].message())
        out.send("material", name="glass", surface={"bsdf": "dielectric", "ior": {"n_d": 1.8, "abbe": 20}})
        out.send("material", name="lamp", surface={"emission": message, "two_sided": False})
        positions, triangles = cube()
        back = positions[triangles].mean(axis=1)[:, 1] > 0.9
        mesh(out, "box", positions, triangles, back)
        instance(out, "box", ["grey", "paint"])
        glass = {}
        if where == "block":
            positions, triangles = cube(0.4)
            glass["block"] = turned(positions, 0.5) + [0.1, 0.2, -0.5], triangles[:, ::-1]
        if where in ("lamp", "both"):
            glass["bulb"] = ball(3, 0.5 if where == "lamp" else 0.4, (0, 0.1, 0.3))
        if where in ("camera", "both"):
            glass["lens"] = ball(3, 0.3 if where == "camera" else 0.25, (0.05, -0.5, 0))
        for name, piece in glass.items():
            mesh(out, name, *piece)
            instance(out, name, ["glass"])
        mesh(out, "lamp", *ball(2, lamp, (0, 0.1, 0.3)))
        instance(out, "lamp", ["lamp"])
        ahead = [1, 0, 0, 0, 0, 0, -1, -0.5 if where in ("camera", "both") else -0.95, 0, 1, 0, 0]
        camera(out, [1, 0, 0, 0, 0, 1, 0, -0.6, 0, 0, 1, -0.4] if looks_down else ahead, resolution, 0.75)
        out.send("render", samples=[0, 16])


def lamp_in_the_dark(path, resolution=(12, 12)):
    """A bright square, a fraction of a pixel wide, before a camera; nothing reflects."""
    message, _ = emission(LIGHTS["d65"])
    positions = np.array([[x, y, -2.0] for x, y in ((-0.1, 0.1), (0.15, 0.1), (0.15, 0.35), (-0.1, 0.35))])
    with stream.Recorder(path) as out:
        out.send("material", name="lamp", surface={"emission": message, "two_sided": True})
        mesh(out, "lamp", positions, np.array([[0, 1, 2], [0, 2, 3]]))
        instance(out, "lamp", ["lamp"])
        camera(out, IDENTITY, resolution, 1.0)
        out.send("render", samples=[0, 16])
