"""The writer of the Stokes stream: frames of a head, a JSON object and a blob area.
The contract is csrc/stream/STREAM.md; `Recorder` writes a scene file, `client.Client` speaks to a
core."""

import contextlib
import errno
import json
import os
import struct

VERSION = 1
CLIENT = "stokes add-on 0.1.0"
HEAD = struct.Struct("<4sI24sQQ")
MAGIC = b"STKS"
MANDATORY = 1
ALIGNMENT = 16
JSON_LIMIT = 64 << 20
BLOB_LIMIT = 64 << 30
IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]


class StreamError(Exception):
    """A message that the format cannot carry, or bytes that are no stream."""


class Blob:
    """Bulk data in a message: anything with contiguous memory (array.array, bytes, a
    memoryview)."""

    __slots__ = ("view",)

    def __init__(self, data):
        self.view = memoryview(data).cast("B")

    def __len__(self):
        return len(self.view)


def padded(size):
    return -(-size // ALIGNMENT) * ALIGNMENT


def encode(message, members, place=None, mandatory=True):
    """The frame as a list of bytes-like parts. `place(view)` may put a blob into shared memory and
    return its offset there; where it returns None, or is absent, the blob follows in the frame."""
    parts = []
    area = 0

    def blob(value):
        nonlocal area
        if not isinstance(value, Blob):
            raise TypeError("%s is not a value of the stream" % type(value).__name__)
        size = len(value)
        offset = place(value.view) if place and size else None
        if offset is not None:
            return {"shared": offset, "bytes": size}
        at, area = area, area + padded(size)
        parts.extend((value.view, bytes(padded(size) - size)))
        return {"at": at, "bytes": size}

    try:
        text = json.dumps(
            members, default=blob, allow_nan=False, ensure_ascii=False, separators=(",", ":")
        )
        text = text.encode("utf-8")
        name = message.encode("ascii")
    except (TypeError, ValueError) as error:
        why = "holds a number that is not finite" if type(error) is ValueError else str(error)
        raise StreamError(_line(message, members, why)) from error
    if len(name) >= 24 or len(text) > JSON_LIMIT or area > BLOB_LIMIT:
        raise StreamError(_line(message, members, "too large for a frame"))
    head = HEAD.pack(MAGIC, MANDATORY if mandatory else 0, name, len(text), area)
    return [head, text, bytes(padded(len(text)) - len(text))] + parts


def _line(message, members, text):
    return ": ".join(part for part in (message, members.get("name"), text) if part)


def decode(buffer, start=0):
    """The frame at `start`: (message, members, blob area, end of the frame), or None if it is not
    whole yet."""
    if len(buffer) - start < HEAD.size:
        return None
    magic, _, name, json_bytes, blob_bytes = HEAD.unpack_from(buffer, start)
    if magic != MAGIC or json_bytes > JSON_LIMIT or blob_bytes > BLOB_LIMIT:
        raise StreamError("these bytes are not a Stokes stream")
    text = start + HEAD.size
    blobs = text + padded(json_bytes)
    end = blobs + padded(blob_bytes)
    if len(buffer) < end:
        return None
    members = json.loads(bytes(buffer[text : text + json_bytes]).decode("utf-8"))
    return name.rstrip(b"\0").decode("ascii"), members, buffer[blobs : blobs + blob_bytes], end


def read(path):
    """All frames of a recorded stream: [(message, members, blob area)]."""
    with open(path, "rb") as file:
        data = memoryview(file.read())
    frames, start = [], 0
    while start < len(data):
        frame = decode(data, start)
        if frame is None:
            raise StreamError("%s: ends within a frame" % path)
        frames.append(frame[:3])
        start = frame[3]
    return frames


class Recorder:
    """Writes a scene file: under a temporary name, renamed when it is whole. An exception leaves
    nothing behind."""

    def __init__(self, path):
        self.path = os.fspath(path)
        if os.path.exists(self.path) and not os.path.isfile(self.path):  # a device, say
            raise FileExistsError(errno.EEXIST, "is no file", self.path)
        self.temporary = "%s.%d.part" % (self.path, os.getpid())
        self.file = open(self.temporary, "wb")
        self.send("hello", version=VERSION, client=CLIENT)

    def send(self, message, /, **members):
        if message == "render":
            members.pop("film", None)  # a live film is no part of a scene
        self.file.writelines(encode(message, members))

    def close(self):
        try:
            self.file.close()  # writes what is left
            os.replace(self.temporary, self.path)
        except OSError:
            self.abort()
            raise

    def abort(self):
        with contextlib.suppress(OSError):  # the disk is full: closing says it once more
            self.file.close()
        with contextlib.suppress(FileNotFoundError):
            os.remove(self.temporary)

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        if kind is None:
            self.close()
        else:
            self.abort()


class Tee:
    """One stream into several: a core that renders and a file that records."""

    def __init__(self, *streams):
        self.streams = streams

    def send(self, message, /, **members):
        for stream in self.streams:
            stream.send(message, **members)
