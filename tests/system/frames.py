"""A writer of the stream that is as small as can be and shares no line with the add-on's, so that
the two check each other. Bytes are built by hand: a test may break any of them."""

import json
import struct

HEAD = struct.Struct("<4sI24sQQ")


def pad(data):
    return data + bytes(-len(data) % 16)


def frame(name, members=None, blobs=b"", mandatory=True):
    text = json.dumps(members or {}).encode()
    return (
        HEAD.pack(b"STKS", int(mandatory), name.encode(), len(text), len(blobs))
        + pad(text)
        + pad(blobs)
    )


class Area:
    """A frame's blob area while it is filled."""

    def __init__(self):
        self.data = b""

    def _add(self, data):
        at = len(self.data)
        self.data += pad(data)
        return {"at": at, "bytes": len(data)}

    def floats(self, *values):
        return self._add(struct.pack("<%df" % len(values), *values))

    def whole(self, *values):
        return self._add(struct.pack("<%dI" % len(values), *values))

    def raw(self, data):
        return self._add(data)


IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]
REC709 = [
    0.4124564,
    0.3575761,
    0.1804375,
    0.2126729,
    0.7151522,
    0.0721750,
    0.0193339,
    0.1191920,
    0.9503041,
]
SQUARE = [-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0]
TRIANGLES = [0, 1, 2, 0, 2, 3]


def hello():
    return frame("hello", {"version": 1, "client": "tests"})


def color(**members):
    return frame(
        "color",
        dict({"config": "", "working_space": "Linear Rec.709", "rgb_to_xyz": REC709}, **members),
    )


def settings(**members):
    return frame("settings", dict({"integrator": "pt", "max_path": 4, "threads": 2}, **members))


def camera(width=16, height=16, **members):
    """Four metres above the origin, looking down."""
    transform = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 4]
    return frame(
        "camera",
        dict(
            {
                "kind": "perspective",
                "transform": transform,
                "frame": [-0.3, 0.3, -0.3, 0.3],
                "resolution": [width, height],
                "clip": [0.1, 100],
            },
            **members,
        ),
    )


def mesh(name="square", positions=SQUARE, triangles=TRIANGLES, **blobs):
    area = Area()
    members = {
        "name": name,
        "positions": area.floats(*positions),
        "triangles": area.whole(*triangles),
    }
    for key, make in blobs.items():
        members[key] = make(area)
    return frame("mesh", members, area.data)


def material(surface, name="material"):
    return frame("material", {"name": name, "surface": surface})


def instances(
    name="instances", mesh="square", materials=("material",), transform=IDENTITY, **members
):
    area = Area()
    return frame(
        "instances",
        dict(
            {
                "name": name,
                "mesh": mesh,
                "materials": list(materials),
                "transforms": area.floats(*transform),
            },
            **members,
        ),
        area.data,
    )


def image(name="image", width=2, height=2, channels=4, **members):
    area = Area()
    pixels = area.floats(*([0.5] * (width * height * channels)))
    return frame(
        "image",
        dict(
            {
                "name": name,
                "width": width,
                "height": height,
                "channels": channels,
                "format": "f32",
                "colorspace": "",
                "pixels": pixels,
            },
            **members,
        ),
        area.data,
    )


def light(name="light", kind="rectangle", emission=None, **members):
    transform = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 3]
    shape = {
        "rectangle": {"size": [1, 1]},
        "sun": {"angle": 0.01},
        "sphere": {"radius": 0.5},
        "point": {},
        "ellipse": {"size": [1, 1]},
        "spot": {"radius": 0.1, "angle": 1, "blend": 0.1},
    }[kind]
    return frame(
        "light",
        {
            "name": name,
            "kind": kind,
            "transform": transform,
            "emission": emission or {"rgb": [1, 1, 1], "scale": 5},
            **shape,
            **members,
        },
    )


def world(emission):
    return frame("world", {"kind": "constant", "emission": emission})


def render(first=0, end=2, **members):
    return frame("render", dict({"samples": [first, end]}, **members))


def scene(*more, size=16, samples=2, **options):
    """A lit grey square, with what is to be put before the `render` message."""
    return b"".join(
        [
            hello(),
            color(),
            settings(**options),
            camera(size, size),
            mesh(),
            material({"bsdf": "diffuse", "reflectance": 0.5}),
            instances(),
            light(),
            *more,
            render(0, samples),
        ]
    )


def read(data):
    """Replies: [(name, members)] and what is left of the bytes."""
    replies = []
    while len(data) >= HEAD.size:
        magic, _, name, json_bytes, blob_bytes = HEAD.unpack_from(data)
        assert magic == b"STKS"
        end = HEAD.size + json_bytes + -json_bytes % 16 + blob_bytes + -blob_bytes % 16
        if len(data) < end:
            break
        replies.append(
            (name.rstrip(b"\0").decode(), json.loads(data[HEAD.size : HEAD.size + json_bytes]))
        )
        data = data[end:]
    return replies, data
