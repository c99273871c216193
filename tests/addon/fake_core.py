#!/usr/bin/env python3
"""A core of the tests' own: speaks the stream as STREAM.md says and "renders" a ramp, red = x,
green = y. $FAKE_CORE is a list of faults: die-at=NAME, kill-at=NAME, error-at=NAME, hang-at=NAME (a
message), deaf (ignores cancel), slow (0.02 s a sample).
$FAKE_CORE_LOG names a file that receives one JSON line per frame: {"name", "members", "crc", "at"},
crc being the sums of its blobs in the order of the message, wherever they lay."""

import json
import mmap
import os
import select
import struct
import sys
import time
import zlib

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))

from addon.core import stream  # noqa: E402

FAULTS = dict(
    part.partition("=")[::2] for part in os.environ.get("FAKE_CORE", "").split(",") if part
)


class FakeCore:
    def __init__(self, arguments):
        self.memory_fd = self._option(arguments, "--memory")
        self.film_fd = self._option(arguments, "--film")
        self.frames = 0
        self.resolution, self.border = [8, 8], None
        log = os.environ.get("FAKE_CORE_LOG")
        self.log = open(log, "a") if log else None  # noqa: SIM115  lives as long as the process

    @staticmethod
    def _option(arguments, name):
        return int(arguments[arguments.index(name) + 1]) if name in arguments else -1

    def say(self, message, **members):
        os.write(1, b"".join(stream.encode(message, members)))

    def run(self):
        while True:
            frame = self.read()
            if frame is None or frame[0] == "quit":
                return 0
            self.apply(*frame)

    def read(self):
        head = self.take(stream.HEAD.size)
        if head is None:
            return None
        _, _, name, json_bytes, blob_bytes = stream.HEAD.unpack(head)
        text = self.take(stream.padded(json_bytes))[:json_bytes]
        area = self.take(stream.padded(blob_bytes))
        return name.rstrip(b"\0").decode(), json.loads(text), area

    @staticmethod
    def take(count):
        parts = []
        while count:
            part = os.read(0, min(count, 1 << 20))
            if not part:
                return None
            parts.append(part)
            count -= len(part)
        return b"".join(parts)

    def sums(self, value, area):
        """CRC-32 of every blob that `value` names."""
        if isinstance(value, list):
            return [crc for item in value for crc in self.sums(item, area)]
        if not isinstance(value, dict):
            return []
        if "bytes" in value and "at" in value:
            return [zlib.crc32(area[value["at"] : value["at"] + value["bytes"]])]
        if "bytes" in value and "shared" in value:
            with mmap.mmap(self.memory_fd, 0) as memory:
                return [zlib.crc32(memory[value["shared"] : value["shared"] + value["bytes"]])]
        return [crc for item in value.values() for crc in self.sums(item, area)]

    def note(self, name, members, area):
        if self.log:
            line = {
                "name": name,
                "members": members,
                "crc": self.sums(members, area),
                "at": time.time(),
            }
            print(json.dumps(line), file=self.log, flush=True)

    def apply(self, name, members, area):
        number, self.frames = self.frames, self.frames + 1
        self.note(name, members, area)
        if FAULTS.get("die-at") == name:
            print("first line", "fake core: out of paper", sep="\n", file=sys.stderr, flush=True)
            os._exit(3)
        if FAULTS.get("kill-at") == name:
            os.kill(os.getpid(), 9)
        if FAULTS.get("hang-at") == name:
            time.sleep(60)
        if FAULTS.get("error-at") == name:
            self.say(
                "error",
                object=members.get("name", ""),
                property="index",
                text="entry 7 is 9 of 8 vertices",
            )
        if name == "camera":
            self.resolution, self.border = members["resolution"], members.get("border")
        self.say("done", of=number)
        if name == "render":
            self.render(*members["samples"])

    def render(self, first, end):
        x0, y0, x1, y1 = self.border or [0, 0, *self.resolution]
        width, height = self.resolution
        self.say("warning", object="Fake", property="core", text="renders a ramp")
        cancelled = False
        sample = first
        for sample in range(first + 1, end + 1):
            time.sleep(0.02 if "slow" in FAULTS else 0)
            if "deaf" not in FAULTS and select.select([0], [], [], 0)[0]:
                frame = self.read() or ("quit", {}, b"")
                self.note(*frame)
                cancelled = frame[0] in ("cancel", "quit")
                if cancelled:
                    break
            if sample in (first + 1, end):
                self.fill(x0, y0, x1, y1, width, height)
            self.say(
                "progress",
                sample=sample,
                samples=end - first,
                seconds=0.1,
                remaining=1.0,
                text="fake",
            )
            self.say("tile", rect=[0, 0, x1 - x0, y1 - y0], samples=sample)
        self.say("finished", samples=sample, cancelled=cancelled, report=["a ramp"])

    def fill(self, x0, y0, x1, y1, width, height):
        with mmap.mmap(self.film_fd, 16 * (x1 - x0) * (y1 - y0)) as film:
            for y in range(y0, y1):
                row = b"".join(
                    struct.pack("<4f", (x + 0.5) / width, (y + 0.5) / height, 0.25, 1)
                    for x in range(x0, x1)
                )
                film[(y - y0) * len(row) : (y - y0 + 1) * len(row)] = row


if __name__ == "__main__":
    sys.exit(FakeCore(sys.argv).run())
