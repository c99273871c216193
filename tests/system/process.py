"""The executable as a process: run to its end, or served."""

import os
import pathlib
import select
import subprocess

import frames

BUILT = pathlib.Path(__file__).parents[2] / "build" / "stokes"
STOKES = pathlib.Path(os.environ.get("STOKES") or BUILT).resolve()
SECONDS = 60  # for a process that has nothing to wait for; only a hang needs it
SLOWER = float(os.environ.get("STOKES_SLOWER") or 1)  # than a release build, where the executable carries an instrument


def run(*arguments, **options):
    return subprocess.run(
        [str(STOKES), *map(str, arguments)], capture_output=True, timeout=SECONDS, **options
    )


class Server:
    """`stokes serve` and what it has said. `before` is a command that runs it, such as an instrument's."""

    def __init__(self, *arguments, fds=(), before=()):
        self.process = subprocess.Popen(
            [*before, STOKES, "serve", *map(str, arguments)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            bufsize=0,
            pass_fds=fds,
        )
        self.replies, self.rest = [], b""

    def send(self, data):
        self.process.stdin.write(data)

    def read(self):
        readable, _, _ = select.select([self.process.stdout], [], [], SECONDS)
        assert readable, "the core has nothing more to say"
        data = os.read(self.process.stdout.fileno(), 1 << 16)
        assert data, "the core has ended: %s" % self.process.stderr.read()
        replies, self.rest = frames.read(self.rest + data)
        self.replies += replies

    def wait(self, name, **members):
        """The first reply of that name with those members; all before it are dropped."""
        while True:
            for i, (said, told) in enumerate(self.replies):
                if said == name and all(told.get(key) == value for key, value in members.items()):
                    del self.replies[: i + 1]
                    return told
            self.read()

    def close(self):
        self.process.stdin.close()
        self.process.stdout.close()
        self.process.stderr.close()
        return self.process.wait(SECONDS)
