"""One core process: starts `stokes serve`, sends it frames, reads its events with a time-out, and
ends with it. Every wait is a poll() that drops the GIL, so Blender's window stays alive. Not for
two threads at once."""

import collections
import os
import select
import signal
import subprocess
import tempfile
import time
import weakref

from . import shared, stream
from .find import find_core

MEMORY_BYTES = 256 << 20
SHARED_FROM = 4096  # smaller blobs are cheaper inside the frame
READ_BYTES = 1 << 16
END_SECONDS = 2.0
WAIT_SECONDS = 0.05  # between two calls of on_wait

Event = collections.namedtuple("Event", "name members")


class CoreError(Exception):
    """The core refused a frame, or is gone. The text is one line, fit to be shown."""


class Client:
    """A running core. `film_bytes` is the size of the picture it shall fill (see `film`)."""

    def __init__(self, preference="", film_bytes=0, low_priority=False, memory_bytes=MEMORY_BYTES):
        self.on_wait = None  # called while a busy core makes us wait; may raise to give up
        self._memory = self._film = self._process = None
        self._waiting = collections.deque()  # events that nobody has read yet
        self._received = bytearray()
        self._sent = 0  # frames sent
        self._done = 0  # frames that the core has answered: all with a number below
        self._next = 0  # first free byte of the shared memory
        self._touched = -1  # the last frame that names a region of it
        executable = find_core(preference)
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115  the core's stderr, closed by _end
        try:
            self._start(executable, film_bytes, memory_bytes, low_priority)
        except BaseException:
            _end(self._process, self._errors, self._memory, self._film)
            raise
        self._finalizer = weakref.finalize(
            self, _end, self._process, self._errors, self._memory, self._film
        )
        self.send("hello", version=stream.VERSION, client=stream.CLIENT)

    def _start(self, executable, film_bytes, memory_bytes, low_priority):
        arguments, descriptors = [executable, "serve"], []
        if shared.available():
            self._memory = shared.Memory(memory_bytes, "stokes-memory")
            arguments += ["--memory", str(self._memory.fd)]
            descriptors.append(self._memory.fd)
            if film_bytes:
                self._film = shared.Memory(film_bytes, "stokes-film")
                arguments += ["--film", str(self._film.fd)]
                descriptors.append(self._film.fd)
        try:
            self._process = subprocess.Popen(
                arguments,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                pass_fds=descriptors,
                bufsize=0,
                start_new_session=True,
                env=environment(executable),
            )
        except OSError as error:
            raise CoreError("The core does not start: %s" % error) from error
        self._in, self._out = self._process.stdin.fileno(), self._process.stdout.fileno()
        os.set_blocking(self._in, False)
        os.set_blocking(self._out, False)
        if low_priority:
            try:
                os.setpriority(os.PRIO_PROCESS, self._process.pid, 10)
            except OSError:
                pass  # gone already: the first frame will say so

    @property
    def pid(self):
        return self._process.pid

    @property
    def film(self):
        """The picture's bytes, shared with the core, or None."""
        return self._film.map if self._film else None

    @property
    def film_member(self):
        """The `film` of a `render` message."""
        return {"shared_fd": self._film.fd, "bytes": self._film.size} if self._film else None

    def send(self, message, /, **members):
        """Sends one frame and returns its number. Reads what the core says meanwhile, so that
        neither side blocks."""
        parts = stream.encode(message, members, self._place)
        for part in self._joined(parts):
            self._write(part)
        self._sent += 1
        return self._sent - 1

    def events(self, timeout=0.0):
        """What the core has said: waits up to `timeout` seconds for the first event. Raises
        CoreError if it is gone."""
        end = time.monotonic() + timeout
        while not self._waiting:
            left = end - time.monotonic()
            if not self._poll(self._out, None, max(left, 0)) and left <= 0:
                break
        if self._next and self._done > self._touched:  # the core has copied all that was shared
            self._memory.release_pages()
            self._next = 0
        events = list(self._waiting)
        self._waiting.clear()
        return events

    def cancel(self):
        self.send("cancel")

    def wait_done(self, number=None):
        """Until the core has applied frame `number` (default: all that were sent)."""
        number = self._sent - 1 if number is None else number
        while self._done <= number:
            self._poll(self._out, None, WAIT_SECONDS)
            for event in self._waiting:
                if event.name == "error":
                    raise CoreError(error_line(event.members))

    def close(self):
        """Asks the core to quit, and makes sure that it has."""
        if self._finalizer.alive:
            try:
                os.write(self._in, b"".join(stream.encode("quit", {})))
            except OSError:
                pass  # busy or gone: closing its stdin says the same
            self._finalizer()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _place(self, view):
        """A region of the shared memory for `view`, or None: the blob then goes inside its
        frame."""
        if not self._memory or len(view) < SHARED_FROM or len(view) > self._memory.size:
            return None
        if self._next + len(view) > self._memory.size:
            self._reuse_memory()
            if self._next + len(view) > self._memory.size:
                return None  # this very frame fills the memory
        at = self._next
        self._memory.map[at : at + len(view)] = view
        self._next = at + stream.padded(len(view))
        self._touched = self._sent
        return at

    def _reuse_memory(self):
        """Starts again at the front of the memory, once no frame on its way to the core names a
        region."""
        if self._touched == self._sent:
            return
        self.wait_done(self._touched)
        self._next = 0

    @staticmethod
    def _joined(parts):
        """Head, JSON and padding in one write; bulk blobs as they are, without a copy."""
        small = []
        for part in parts:
            if len(part) < READ_BYTES:
                small.append(part)
                continue
            yield b"".join(small)
            small = []
            yield part
        yield b"".join(small)

    def _write(self, data):
        view = memoryview(data)
        while len(view):
            ready = self._poll(self._out, self._in, WAIT_SECONDS)
            if self._in in ready:
                try:
                    view = view[os.write(self._in, view[: 1 << 20]) :]
                except BlockingIOError:
                    continue
                except OSError:
                    self._raise_gone()

    def _poll(self, readable, writable, seconds):
        """Waits, takes in what has come, and returns the descriptors that are ready."""
        poll = select.poll()
        poll.register(readable, select.POLLIN)
        if writable is not None:
            poll.register(writable, select.POLLOUT)
        ready = {fd for fd, _ in poll.poll(seconds * 1000)}
        if readable in ready:
            self._read()
        elif not ready and self.on_wait:
            self.on_wait()
        return ready

    def _read(self):
        try:
            data = os.read(self._out, READ_BYTES)
        except BlockingIOError:
            return
        if not data:
            self._raise_gone()
        self._received += data
        start = 0
        while True:
            try:
                frame = stream.decode(self._received, start)
            except (stream.StreamError, ValueError) as error:
                raise CoreError("The core does not speak the stream: %s" % error) from error
            if frame is None:
                break
            start = frame[3]
            if frame[0] == "done":
                self._done = max(self._done, frame[1]["of"] + 1)
            else:
                self._waiting.append(Event(frame[0], frame[1]))
        del self._received[:start]

    def _raise_gone(self):
        """The core has closed its end: one line that says how it ended and what it said last."""
        try:
            status = self._process.wait(END_SECONDS)
        except subprocess.TimeoutExpired:
            status = None
        for event in self._waiting:
            if event.name == "error":
                raise CoreError(error_line(event.members))
        if status is None:
            how = "closed its output"
        elif status < 0:
            how = "was killed by %s" % _signal_name(-status)
        else:
            how = "ended with status %d" % status
        said = self._last_error_line()
        raise CoreError("The core %s%s" % (how, ": " + said if said else " without a word"))

    def _last_error_line(self):
        size = self._errors.seek(0, os.SEEK_END)
        self._errors.seek(max(0, size - 4096))
        lines = self._errors.read().decode("utf-8", "replace").split("\n")
        return next((line.strip() for line in reversed(lines) if line.strip()), "")


def error_line(members):
    """An `error` or `warning` of the core as one line."""
    return ": ".join(
        part for part in (members.get(key) for key in ("object", "property", "text")) if part
    )


def environment(executable):
    """A packed core finds its libraries beside it; None is the environment as it is."""
    libraries = os.path.join(os.path.dirname(os.path.abspath(executable)), "lib")
    if not os.path.isdir(libraries):
        return None
    paths = [libraries, os.environ.get("LD_LIBRARY_PATH", "")]
    return dict(os.environ, LD_LIBRARY_PATH=os.pathsep.join(path for path in paths if path))


def _signal_name(number):
    try:
        return signal.Signals(number).name
    except ValueError:
        return "signal %d" % number


def _end(process, errors, *memories):
    """Leaves nothing behind: no process, no zombie, no descriptor. Also the last act of a forgotten
    Client."""
    if process:
        process.stdin.close()
        try:
            process.wait(END_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        process.stdout.close()
    errors.close()
    for memory in memories:
        if memory:
            memory.close()
