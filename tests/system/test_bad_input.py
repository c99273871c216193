"""Bad input, by the executable alone: each fault is one clear line that names message, object and
member, and nothing is left behind. Cancels and kills are in test_serving.py."""

import os
import resource
import signal
import struct
import subprocess

import exr
import frames
import pytest
from process import SECONDS, STOKES, run

START = frames.hello() + frames.color() + frames.settings()
NAN, INF = float("nan"), float("inf")


def render(folder, data, *arguments):
    """(exit status, stderr, was there an output) for a scene of these bytes."""
    scene, out = folder / "scene.stokes", folder / "out.exr"
    scene.write_bytes(data)
    result = run("render", scene, "-o", out, "-q", *arguments)
    left = sorted(path.name for path in folder.iterdir())
    assert left in (["scene.stokes"], ["out.exr", "scene.stokes"]), "left behind: %s" % left
    return result.returncode, result.stderr.decode(), out.exists()


def refused(folder, data, *words, arguments=()):
    """The scene must fail with one line that holds the words, and write nothing."""
    status, said, written = render(folder, data, *arguments)
    assert status == 1 and not written, (status, said)
    lines = said.splitlines()
    assert len(lines) == 1 and lines[0].startswith("stokes: "), said
    for word in words:
        assert word in lines[0], "'%s' is not in: %s" % (word, lines[0])


def test_a_sound_scene_renders(tmp_path):
    status, said, written = render(tmp_path, frames.scene())
    assert (status, said, written) == (0, "", True)


# --- Broken streams ------------------------------------------------------------------------------


def test_a_stream_cut_anywhere_is_an_error_or_a_shorter_stream(tmp_path):
    """Cut between frames it is a scene without its end; cut within one it is named."""
    whole = frames.scene()
    ends, at = set(), 0
    while at < len(whole):
        ends.add(at)
        json_bytes, blob_bytes = struct.unpack_from("<QQ", whole, at + 32)
        at += 48 + json_bytes + -json_bytes % 16 + blob_bytes + -blob_bytes % 16
    ends.add(at)
    for cut in sorted(
        ends
        | {end + offset for end in ends for offset in (1, 47, 48, 55) if end + offset < len(whole)}
    ):
        status, said, _ = render(tmp_path, whole[:cut])
        assert len(said.splitlines()) <= 1 and status in (0, 1), (cut, said)
        if cut not in ends:
            assert "the stream ends after" in said, (cut, said)
        (tmp_path / "out.exr").unlink(missing_ok=True)


def test_a_wrong_magic_is_named(tmp_path):
    refused(tmp_path, b"XXXX" + frames.scene()[4:], "magic")
    refused(tmp_path, b"", "empty")


def test_lengths_beyond_their_limit_are_refused_at_once(tmp_path):
    head = frames.HEAD.pack(b"STKS", 1, b"hello", (64 << 20) + 1, 0)
    refused(tmp_path, head, "hello", "json", "64 MiB")
    head = frames.HEAD.pack(b"STKS", 1, b"mesh", 2, (64 << 30) + 1)
    refused(tmp_path, frames.hello() + head, "mesh", "blob", "64 GiB")


def test_a_length_that_lies_takes_no_memory(tmp_path):
    """A head that claims 60 GiB, in an address space of 4."""
    if b"__asan_init" in STOKES.read_bytes():
        pytest.skip("the sanitizer needs all of the address space")
    scene = tmp_path / "scene.stokes"
    scene.write_bytes(
        START + frames.HEAD.pack(b"STKS", 1, b"mesh", 2, 60 << 30) + frames.pad(b"{}")
    )
    limit = 4 << 30
    result = subprocess.run(
        [STOKES, "render", scene, "-o", tmp_path / "out.exr"],
        capture_output=True,
        timeout=SECONDS,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
    )
    assert result.returncode == 1 and b"the stream ends after 0 of" in result.stderr, result.stderr


def test_corrupted_bytes_never_crash(tmp_path):
    """Bytes all over are inverted in turn: an error or a picture, never a signal, never a hang."""
    whole = frames.scene(size=4, samples=1)
    for at in range(3, len(whole), 7 * (1 + len(whole) // 1000)):
        data = bytearray(whole)
        data[at] ^= 0xFF
        status, said, _ = render(tmp_path, bytes(data), "-t", "1")
        assert status in (0, 1), (at, status, said)
        (tmp_path / "out.exr").unlink(missing_ok=True)


def test_text_that_is_no_json_is_named(tmp_path):
    for text in (
        b"{",
        b"[]",
        b'{"version": NaN}',
        b'{"version": 1, "version": 1}',
        b"\xff\xfe",
        b'{"version": 1e999}',
        b"",
    ):
        head = frames.HEAD.pack(b"STKS", 1, b"hello", len(text), 0)
        refused(tmp_path, head + frames.pad(text), "hello", "json")


def test_nesting_without_end_is_refused(tmp_path):
    for depth in (100, 100000):
        text = (
            '{"name": "deep", "surface": '
            + '{"mix": [null, ' * depth
            + "null"
            + '], "factor": 0}' * depth
            + "}"
        ).encode()
        head = frames.HEAD.pack(b"STKS", 1, b"material", len(text), 0)
        refused(tmp_path, START + head + frames.pad(text), "material")


def test_unknown_messages_count_only_if_mandatory(tmp_path):
    refused(tmp_path, frames.scene(frames.frame("hologram", {})), "hologram", "unknown")
    status, said, _ = render(tmp_path, frames.scene(frames.frame("hologram", {}, mandatory=False)))
    assert (status, said) == (0, "")


def test_hello_comes_first_and_has_our_version(tmp_path):
    refused(tmp_path, frames.color() + frames.hello(), "color", "hello")
    refused(tmp_path, frames.frame("hello", {"version": 2}), "hello", "version")


# --- Members -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "members, words",
    [
        ({"lambda_min": "x"}, ["settings", "lambda_min", "number"]),
        ({"lambda_min": 900}, ["settings", "lambda_m"]),
        ({"seed": -1}, ["settings", "seed"]),
        ({"seed": 1.5}, ["settings", "seed", "whole"]),
        ({"integrator": "magic"}, ["settings", "integrator", "magic"]),
        ({"techniques": [[1]]}, ["settings", "techniques[0]"]),
        ({"techniques": [[1, 99]]}, ["settings", "techniques[0][1]"]),
        ({"spectral_bins": {"count": 0, "min": 400}}, ["settings", "spectral_bins.max", "missing"]),
        (
            {"spectral_bins": {"count": 1000000, "min": 400, "max": 700}},
            ["settings", "spectral_bins.count"],
        ),
        ({"uv_rule": "guess"}, ["settings", "uv_rule", "guess"]),
        ({"max_path": 1000}, ["settings", "max_path"]),
        ({"threads": -2}, ["settings", "threads"]),
        ({"film_transparent": 1}, ["settings", "film_transparent", "true or false"]),
    ],
)
def test_a_wrong_setting_is_named(tmp_path, members, words):
    refused(tmp_path, frames.hello() + frames.settings(**members), *words)


@pytest.mark.parametrize(
    "surface, words",
    [
        ({"bsdf": "velvet"}, ["surface.bsdf", "velvet"]),
        (
            {"bsdf": "diffuse", "reflectance": {"library": "no such"}},
            ["surface.reflectance.library"],
        ),
        (
            {"bsdf": "diffuse", "reflectance": {"table": {"lambda": [400, 300], "value": [1, 1]}}},
            ["surface.reflectance.table"],
        ),
        (
            {"bsdf": "diffuse", "reflectance": {"table": {"lambda": [400], "value": [1, 1]}}},
            ["1 wavelengths and 2 values"],
        ),
        (
            {"bsdf": "diffuse", "reflectance": {"sum": [0.1, {"colour": 1}]}},
            ["surface.reflectance.sum[1]"],
        ),
        (
            {"bsdf": "diffuse", "reflectance": {"texture": {"image": "lost"}}},
            ["surface.reflectance.texture.image", "lost", "sent"],
        ),
        (
            {"bsdf": "diffuse", "roughness": {"texture": {"image": "lost"}}},
            ["surface.roughness.texture.image"],
        ),
        (
            {"bsdf": "diffuse", "normal": {"texture": {"image": "lost"}}},
            ["surface.normal.texture.image"],
        ),
        ({"bsdf": "conductor", "metal": "Unobtainium"}, ["surface.metal", "Unobtainium"]),
        ({"bsdf": "dielectric", "ior": {"library": "jelly"}}, ["surface.ior.library", "jelly"]),
        ({"bsdf": "dielectric", "lobes": "sideways"}, ["surface.lobes", "sideways", "refract"]),
        ({"mix": [None], "factor": 0.5}, ["surface.mix", "2 are wanted"]),
        ({"mix": [None, None]}, ["surface.factor", "missing"]),
        ({"emission": {"rgb": [1, -1, 1]}}, ["surface.emission.rgb", "negative"]),
        ({"emission": {"rgb": [1, 1, 1], "scale": -2}}, ["surface.emission.scale", "negative"]),
        (
            {"emission": {"shape": {"table": {"lambda": [400, 700], "value": [1, -1]}}}},
            ["surface.emission.shape", "negative"],
        ),
        (
            {"emission": {"shape": {"line": {"center": 5000, "width": 2}}}},
            ["surface.emission.shape", "no power"],
        ),
        ({"emission": {"rgb": [1, 1]}}, ["surface.emission.rgb", "3 are wanted"]),
    ],
)
def test_a_wrong_surface_is_named(tmp_path, surface, words):
    refused(
        tmp_path, START + frames.material(surface, "Paint"), "Paint", "material.surface", *words
    )


def test_negative_emission_of_a_lamp_is_named(tmp_path):
    refused(
        tmp_path,
        frames.scene(frames.light("Lamp", emission={"rgb": [1, 1, 1], "scale": -1})),
        "Lamp",
        "light.emission",
        "negative",
    )
    refused(
        tmp_path,
        frames.scene(frames.world({"rgb": [-1, 1, 1]})),
        "world",
        "emission.rgb",
        "negative",
    )


@pytest.mark.parametrize("value", [NAN, INF, -INF])
def test_positions_that_are_not_finite_are_named(tmp_path, value):
    positions = list(frames.SQUARE)
    positions[7] = value
    refused(tmp_path, START + frames.mesh("Cube", positions), "Cube", "mesh.positions", "2")


def test_transforms_that_are_not_finite_are_named(tmp_path):
    refused(
        tmp_path,
        frames.scene(frames.instances("Twin", transform=[NAN] + frames.IDENTITY[1:])),
        "Twin",
        "transforms",
    )


def test_indices_out_of_range_are_named(tmp_path):
    refused(
        tmp_path,
        START + frames.mesh("Cube", triangles=[0, 1, 2, 0, 2, 4]),
        "Cube",
        "mesh.triangles",
        "4",
    )
    refused(
        tmp_path,
        START + frames.mesh("Cube", triangles=[0, 1, 2, 0, 2, 0xFFFFFFFF]),
        "Cube",
        "mesh.triangles",
    )
    refused(
        tmp_path,
        START
        + frames.mesh(
            "Cube",
            corners=lambda area: area.whole(0, 1, 2, 0, 2, 4),
            corner_normals=lambda area: area.floats(*([0, 0, 1] * 4)),
        ),
        "Cube",
        "mesh.corners",
    )


def test_blobs_of_the_wrong_size_are_named(tmp_path):
    refused(
        tmp_path,
        START + frames.mesh("Cube", material_index=lambda area: area.whole(0)),
        "Cube",
        "mesh.material_index",
        "2 are wanted",
    )
    refused(
        tmp_path,
        START + frames.mesh("Cube", corner_normals=lambda area: area.floats(0, 0, 1)),
        "Cube",
        "mesh.corner_normals",
        "6 are wanted",
    )
    refused(
        tmp_path,
        START + frames.mesh("Cube", positions=[1, 2, 3, 4]),
        "Cube",
        "mesh.positions.bytes",
        "multiple of 12",
    )
    for size, word in (
        ({"width": 3}, "image."),
        ({"width": 2**40}, "image.width"),
        ({"channels": 2}, "image.channels"),
        ({"height": 0}, "image.height"),
    ):
        members = {"name": "Photo", "width": 2, "height": 2, "channels": 1, "format": "f32"}
        members.update(size, pixels={"at": 0, "bytes": 16})
        refused(tmp_path, START + frames.frame("image", members, bytes(16)), "Photo", word)


@pytest.mark.parametrize(
    "blob, words",
    [
        ({"at": 0, "bytes": 4800}, ["beyond"]),
        ({"at": 8, "bytes": 12}, ["multiple of 16"]),
        ({"at": -16, "bytes": 12}, ["at"]),
        ({"at": 1 << 60, "bytes": 12}, ["at"]),
        ({"at": 0, "bytes": 2**63 - 1}, ["bytes"]),
        ({"at": 0}, ["bytes", "missing"]),
        ({"shared": 0, "bytes": 12}, ["shared memory"]),
        ([0, 12], ["object"]),
    ],
)
def test_blobs_outside_their_area_are_named(tmp_path, blob, words):
    data = frames.frame(
        "mesh", {"name": "Cube", "positions": blob, "triangles": {"at": 0, "bytes": 0}}, bytes(48)
    )
    refused(tmp_path, START + data, "Cube", "mesh.positions", *words)


def test_images_with_texels_that_are_not_finite_are_named(tmp_path):
    area = frames.Area()
    pixels = area.floats(0, 0, NAN, 0)
    data = frames.frame(
        "image",
        {
            "name": "Photo",
            "width": 2,
            "height": 2,
            "channels": 1,
            "format": "f32",
            "pixels": pixels,
        },
        area.data,
    )
    refused(tmp_path, START + data, "Photo", "image.pixels")


def test_cameras_without_sense_are_named(tmp_path):
    refused(tmp_path, START + frames.camera(border=[0, 0, 17, 16]), "camera", "border")
    refused(tmp_path, START + frames.camera(border=[8, 8, 8, 16]), "camera", "border")
    refused(tmp_path, START + frames.camera(0, 16), "camera", "resolution")
    refused(
        tmp_path, START + frames.mesh() + frames.instances() + frames.render(), "scene", "camera"
    )
    refused(tmp_path, frames.scene() + frames.render(5, 5), "render", "samples")


def test_missing_things_are_named_before_rendering(tmp_path):
    refused(
        tmp_path, frames.scene(frames.instances("Twin", mesh="nothing")), "Twin", "mesh", "nothing"
    )
    refused(
        tmp_path,
        frames.scene(frames.frame("remove", {"kind": "mesh", "name": "nothing"})),
        "nothing",
        "remove",
    )
    refused(
        tmp_path,
        frames.scene(frames.frame("remove", {"kind": "planet", "name": "square"})),
        "square",
        "planet",
    )


def test_colours_fix_range_and_working_space(tmp_path):
    refused(tmp_path, frames.scene(frames.settings(lambda_min=350)), "settings", "range")
    refused(
        tmp_path,
        frames.scene(frames.color(rgb_to_xyz=[1, 0, 0, 0, 1, 0, 0, 0, 1])),
        "color",
        "working space",
    )
    refused(tmp_path, START + frames.color(rgb_to_xyz=[0] * 9), "color", "rgb_to_xyz")
    status, said, _ = render(tmp_path, frames.scene(frames.settings(), frames.color()))
    assert (status, said) == (0, "")


def test_a_config_that_cannot_be_read_is_a_warning_that_names_it(tmp_path):
    status, said, written = render(
        tmp_path, frames.hello() + frames.color(config="/no/such/config.ocio") + frames.scene()
    )
    assert status == 0 and written and "/no/such/config.ocio" in said and "warning" in said, said


# --- Files ---------------------------------------------------------------------------------------


def test_an_output_that_cannot_be_written_leaves_nothing(tmp_path):
    scene = tmp_path / "scene.stokes"
    scene.write_bytes(frames.scene())
    (tmp_path / "taken.exr").mkdir()
    os.mkfifo(tmp_path / "pipe.exr")
    for out in (
        tmp_path / "missing" / "out.exr",
        tmp_path / "taken.exr",
        tmp_path / "pipe.exr",
        tmp_path / "missing" / "out.png",
    ):
        result = run("render", scene, "-o", out, "-q")
        lines = [line for line in result.stderr.decode().splitlines() if "warning" not in line]
        assert result.returncode == 1 and len(lines) == 1 and str(out) in lines[0], lines
    left = sorted(path.name for path in tmp_path.iterdir())
    assert left == ["pipe.exr", "scene.stokes", "taken.exr"] and (tmp_path / "pipe.exr").is_fifo()
    assert not list((tmp_path / "taken.exr").iterdir())


def test_words_that_a_full_disk_swallows_are_an_error(tmp_path):
    """Nobody could tell a list that ends early from a short one."""
    scene = tmp_path / "scene.stokes"
    scene.write_bytes(frames.scene())
    for arguments in (["info", scene], ["spectrum", "list"], ["matrix", "list"], ["--help"], ["render", "--help"]):
        with open("/dev/full", "wb") as full:
            done = subprocess.run([STOKES, *arguments], stdout=full, stderr=subprocess.PIPE, timeout=SECONDS)
        assert done.returncode == 1 and len(done.stderr.splitlines()) == 1, (arguments, done.stderr)
        assert done.stderr.startswith(b"stokes: standard output: write: "), (arguments, done.stderr)


def test_a_file_size_limit_leaves_no_half_picture(tmp_path):
    """The disk is full: here, a limit of 4 KiB for each file."""
    scene = tmp_path / "scene.stokes"
    scene.write_bytes(frames.scene(size=128, samples=1))

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

    result = run("render", scene, "-o", tmp_path / "out.exr", "-q", preexec_fn=limit)
    assert result.returncode == 1 and b"out.exr" in result.stderr, result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["scene.stokes"]


def test_merging_what_does_not_fit_is_named(tmp_path):
    scene, other = tmp_path / "scene.stokes", tmp_path / "other.stokes"
    scene.write_bytes(frames.scene(samples=8))
    other.write_bytes(frames.scene(frames.light("second"), samples=8))

    def part(name, path, samples, *arguments):
        out = tmp_path / name
        assert run("render", path, "-o", out, "-q", "-s", samples, *arguments).returncode == 0
        return out

    first, second = part("a.exr", scene, "0:4"), part("b.exr", scene, "4:8", "-t", "1")
    cases = [
        ([first, first], "overlap"),
        ([first, part("c.exr", scene, "5:8")], "touch"),
        ([first, part("d.exr", other, "4:8")], "fingerprint"),
        ([first, part("e.exr", scene, "4:8", "--seed", "3")], "fingerprint"),
        ([first, scene], "scene.stokes"),
        ([tmp_path / "none.exr"], "none.exr"),
    ]
    for parts, word in cases:
        result = run("merge", *parts, "-o", tmp_path / "merged.exr")
        assert result.returncode == 1 and word in result.stderr.decode(), result.stderr
        assert len(result.stderr.splitlines()) == 1 and not (tmp_path / "merged.exr").exists()
    assert run("merge", second, first, "-o", tmp_path / "merged.exr").returncode == 0
    assert (tmp_path / "merged.exr").read_bytes() == part("whole.exr", scene, "8").read_bytes()


def test_wrong_usage_is_one_line_and_status_2(tmp_path):
    scene = tmp_path / "scene.stokes"
    scene.write_bytes(frames.scene())
    for arguments in (
        ["render"],
        ["render", scene],
        ["render", scene, "-o", "x.jpg"],
        ["render", scene, "-o"],
        ["paint"],
        ["render", scene, "-o", "x.exr", "--samples", "3:2"],
        ["render", scene, "-o", "x.exr", "-t", "many"],
        ["render", scene, "-o", "x.exr", "--unknown"],
        ["merge", "a.exr"],
        ["info"],
        ["spectrum"],
        ["serve", "--memory", "x"],
    ):
        result = run(*arguments, cwd=tmp_path)
        assert result.returncode == 2 and len(result.stderr.splitlines()) == 1, (
            arguments,
            result.stderr,
        )
        assert b"--help" in result.stderr, result.stderr
    for command in ("render", "merge", "info", "spectrum", "serve"):
        result = run(command, "--help")
        assert result.returncode == 0 and b"Usage: stokes " + command.encode() in result.stdout
    assert b"Usage" in run("--help").stdout


# --- One wavelength for both sub-paths -------------------------------------------------------------

DYE = {"bsdf": "fluorescent", "reflectance": 0.5, "absorption": 0.5, "emission": 1, "yield": 0.5}
SAYS = ["settings: shared_wavelength: is for mbdpt, one lane, one light path", "without fluorescence"]


@pytest.mark.parametrize(
    "more, arguments",
    [
        ([], ["--integrator", "bdpt"]),
        ([], ["--integrator", "mbdpt", "--lanes", "4"]),
        ([], ["--integrator", "mbdpt", "--light-paths", "2"]),
        ([frames.material(DYE)], ["--integrator", "mbdpt"]),
    ],
    ids=["exact", "lanes", "light paths", "fluorescence"],
)
def test_a_shared_wavelength_is_refused_where_it_would_be_wrong(tmp_path, more, arguments):
    refused(tmp_path, frames.scene(*more), *SAYS, arguments=[*arguments, "--shared-wavelength"])
    assert render(tmp_path, frames.scene(*more), *arguments) == (0, "", True)  # it is the flag that was refused


def test_a_shared_wavelength_is_taken_where_it_is_right(tmp_path):
    """Light from lights to the lens: the one technique of this scene whose sub-paths both have a wavelength of their own."""
    data, pixels = frames.scene(techniques=[[2, 1]]), []
    for arguments in ([], ["--shared-wavelength"]):
        assert render(tmp_path, data, "--integrator", "mbdpt", *arguments) == (0, "", True)
        pixels.append(exr.read(tmp_path / "out.exr").sums())
        (tmp_path / "out.exr").unlink()
    assert pixels[0].any() and pixels[1].any() and (pixels[0] != pixels[1]).any()
