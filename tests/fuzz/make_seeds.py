"""Writes the fuzzer's seeds, one stream for each kind of message and expression, and its
dictionary: words of STREAM.md. Usage: make_seeds.py SEEDS_FOLDER DICTIONARY"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "system"))

import frames  # noqa: E402

TEXTURE = {
    "texture": {
        "image": "image",
        "uv": "",
        "transform": frames.IDENTITY,
        "interpolation": "closest",
        "extension": "clip",
        "channel": "r",
        "projection": "generated",
    }
}
SPECTRA = {
    "constant": 0.5,
    "rgb": {"rgb": [0.9, 0.1, 0.2]},
    "table": {"table": {"lambda": [300, 500, 500, 800], "value": [0, 1, 0.2, 0.3]}},
    "blackbody": {"blackbody": 3200},
    "illuminant": {"illuminant": "F11"},
    "daylight": {"daylight": 5000},
    "gaussian": {"gaussian": {"mean": 500, "sigma": 20, "peak": 0.5}},
    "line": {"line": {"center": 546, "width": 2}},
    "library": {"library": "colorchecker/cyan"},
    "moments": {"moments": {"c": [0.4, 0.1, -0.05], "min": 380, "max": 780}},
    "moments_of": {"moments": {"of": {"rgb": [0.2, 0.3, 0.4], "method": "moments"}, "count": 5}},
    "scale": {"scale": 0.5, "of": 0.3},
    "sum": {"sum": [0.1, 0.2, {"rgb": [0, 0, 1]}]},
    "product": {"product": [0.5, {"rgb": [1, 0, 0]}]},
    "texture": TEXTURE,
}
VALUES = {
    "texture": TEXTURE,
    "scale": {"scale": 0.5, "offset": 0.1, "of": TEXTURE},
    "fresnel": {"fresnel": 1.5},
    "facing": {"facing": 0.3},
    "backfacing": {"backfacing": 1},
    "product": {"product": [0.5, {"facing": 0.5}, 0.3]},
}
EMISSIONS = {
    "rgb": {"rgb": [1, 0.5, 0.2], "scale": 3},
    "total": {"shape": {"illuminant": "D65"}, "scale": 2, "unit": "total"},
    "per_nm": {"shape": {"blackbody": 4000}, "scale": 0.1, "unit": "per_nm"},
    "texture": {"texture": TEXTURE["texture"], "scale": 2},
    "sum": {"sum": [{"rgb": [1, 1, 1]}, {"shape": 1, "scale": 1, "unit": "per_nm"}]},
}
CLOSURES = {
    "matrix": {
        "bsdf": "reradiation_matrix",
        "matrix": {"incident": [380, 3], "outgoing": [400, 2], "step": 20, "share": [0.1, 0.5, 0, 0.2, 0.1, 0.4]},
        "diagonal": "elastic",
    },
    "matrix_library": {"bsdf": "reradiation_matrix", "matrix": {"library": "matrix/yellow_note"}},
    "fluorescent": {
        "bsdf": "fluorescent",
        "reflectance": 0.8,
        "absorption": {"gaussian": {"mean": 400, "sigma": 30, "peak": 0.9}},
        "emission": {"gaussian": {"mean": 550, "sigma": 30}},
        "concentration": 0.7,
        "yield": 0.9,
        "yield_kind": "energy",
    },
    "dielectric": {
        "bsdf": "dielectric",
        "ior": {"n_d": 1.5, "abbe": 60},
        "roughness": 0.1,
        "lobes": "refract",
    },
    "cauchy": {"bsdf": "dielectric", "ior": {"cauchy": [1.5, 0.004, 0]}},
    "sellmeier": {
        "bsdf": "dielectric",
        "ior": {"sellmeier": [[1.04, 0.006], [0.23, 0.02], [1.01, 103.5]]},
    },
    "glass": {"bsdf": "dielectric", "ior": {"library": "BK7"}},
    "conductor": {"bsdf": "conductor", "metal": "Ag", "roughness": 0.2},
    "eta": {
        "bsdf": "conductor",
        "eta": {"table": {"lambda": [400, 700], "value": [0.2, 0.3]}},
        "k": 3,
    },
    "glossy": {
        "bsdf": "glossy",
        "color": {"rgb": [1, 1, 1]},
        "roughness": 0.2,
        "normal": dict(TEXTURE, strength=0.5),
    },
    "transparent": {"bsdf": "transparent", "color": 0.9},
    "translucent": {"bsdf": "translucent", "reflectance": 0.4},
    "principled": {
        "bsdf": "principled",
        "model": 4,
        "base_color": {"rgb": [0.8, 0.2, 0.1]},
        "metallic": 0.2,
        "roughness": 0.3,
        "ior": 1.45,
        "specular": 0.5,
        "transmission": 0.1,
        "multi_scatter": True,
    },
    "emission": {"emission": {"rgb": [1, 1, 1], "scale": 2}, "two_sided": False},
    "mix": {
        "mix": [{"bsdf": "diffuse", "reflectance": 0.5}, {"add": [None, {"bsdf": "transparent"}]}],
        "factor": 0.3,
    },
}


def diffuse(**members):
    return frames.material(dict({"bsdf": "diffuse"}, **members))


def full_mesh():
    """Every optional member of a mesh."""

    def uv(area):
        return [{"name": "UVMap", "data": area.floats(*([0.5] * 8))}]

    return frames.mesh(
        corners=lambda area: area.whole(0, 1, 2, 0, 2, 3),
        uv=uv,
        corner_normals=lambda area: area.floats(*([0, 0, 1] * 4)),
        material_index=lambda area: area.whole(0, 0),
    )


SCATTER = {"volume": "scatter", "color": {"rgb": [0.8, 0.5, 0.2]}, "density": 3, "anisotropy": 0.4}
VOLUMES = {
    "scatter": SCATTER,
    "absorption": {"volume": "absorption", "color": 0.5, "density": 2},
    "principled": {"volume": "principled", "color": 0.5, "absorption_color": 0.2, "density": 1, "anisotropy": -0.4},
    "coefficients": {"volume": "coefficients", "scattering": SPECTRA["table"], "absorption": 0.1, "anisotropy": 0.9},
    "tree": {"mix": [{"add": [SCATTER, {"volume": "absorption"}]}, None], "factor": 0.25},
}


def filled(volume):
    """The scene's material as a boundary that refracts nothing."""
    surface = {"bsdf": "transparent", "color": 1}
    return frames.frame("material", {"name": "material", "surface": surface, "volume": volume})


def seeds():
    start = frames.hello() + frames.color()
    picture = start + frames.image()
    lit = (
        picture + full_mesh() + frames.instances() + frames.light()
    )  # so that TARGET=render sees the material
    yield "scene", frames.scene()
    yield "mesh", start + full_mesh()
    shared = {
        "name": "shared",
        "positions": {"shared": 0, "bytes": 96},
        "triangles": {"shared": 96, "bytes": 0},
    }
    yield "shared", start + frames.frame("mesh", shared)  # the target's shared memory is its input
    yield (
        "settings",
        start
        + frames.settings(
            integrator="mbdpt",
            seed=1,
            d0=50,
            shrink=0.2,
            kernel="constant",
            mollify_side="camera",
            max_camera=5,
            max_light=5,
            lambda_min=320,
            lambda_max=800,
            uv_rule="zero",
            filter_width=2,
            film_transparent=True,
            techniques=[[2, 2], [1, 3]],
            spectral_bins={"count": 8, "min": 400, "max": 700},
            time_limit=3,
        ),
    )
    yield (
        "image",
        start
        + frames.image(channels=3, colorspace="sRGB")
        + frames.image(channels=1, colorspace="data"),
    )
    yield (
        "world",
        picture
        + frames.frame(
            "world", {"kind": "image", "image": "image", "scale": 2, "transform": frames.IDENTITY}
        ),
    )
    yield "remove", frames.scene(frames.frame("remove", {"kind": "mesh", "name": "square"}))
    yield (
        "orthographic",
        start
        + frames.camera(
            kind="orthographic",
            border=[2, 2, 8, 8],
            lens_radius=0.1,
            focus_distance=3,
            blades=5,
            blade_rotation=1,
            aspect=2,
        ),
    )
    for kind in ("rectangle", "ellipse", "sphere", "point", "spot", "sun"):
        yield "light_" + kind, start + frames.light(kind=kind, visible={"camera": False})
    for name, spectrum in SPECTRA.items():
        yield "spectrum_" + name, lit + diffuse(reflectance=spectrum)
    for name, value in VALUES.items():
        yield "value_" + name, lit + diffuse(roughness=value)
    for name, emission in EMISSIONS.items():
        yield "emission_" + name, lit + frames.material({"emission": emission})
    for name, closure in CLOSURES.items():
        yield "closure_" + name, lit + frames.material(closure)
    for name, volume in VOLUMES.items():
        yield "volume_" + name, lit + filled(volume)
    yield "volume_world", picture + frames.frame(
        "world", {"kind": "constant", "emission": {"rgb": [1, 1, 1]}, "volume": VOLUMES["scatter"]}
    )


def main(folder, dictionary):
    for name, data in seeds():
        (pathlib.Path(folder) / name).write_bytes(data)
    page = (ROOT / "csrc" / "stream" / "STREAM.md").read_text(encoding="utf-8")
    words = sorted(set(re.findall(r'[`"]([A-Za-z_0-9/]{2,24})[`"]', page)))
    extra = ["null", "1e308", "-1e308", "1e-320", "{}", "[]", "18446744073709551615", "-1", "0"]
    lines = ['"\\"%s\\""' % word for word in words] + ['"%s"' % word for word in extra]
    pathlib.Path(dictionary).write_text("\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    main(*sys.argv[1:])
