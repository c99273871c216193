"""Hosts for the tests of the add-on: Debian's Blender and bpy as a module, each in a process of its
own with a time-out. A host that is not installed is skipped by name."""

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import blenders

ROOT = Path(__file__).resolve().parents[2]
FAKE_CORE = ROOT / "tests" / "addon" / "fake_core.py"
INSIDE = ROOT / "tests" / "addon" / "inside.py"
SECONDS = 60
WINDOW_SECONDS = 100
MARK = "TOLD "
NAMES = ["3.4", "4.2", "4.5", "5.0", "5.2"]
NEWEST = "newest"

sys.path.insert(0, str(ROOT))


def _script(code, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(INSIDE.read_text() + "\n\n" + code)
    return str(script)


def _environment(tmp_path, more):
    own = dict(STOKES_CORE=str(FAKE_CORE), TMP_PATH=str(tmp_path), ROOT=str(ROOT))
    return {**os.environ, **own, **(more or {})}


class Host:
    """One Blender. `run(code)` executes it after inside.py and returns what it gave to tell()."""

    def __init__(self, name, command):
        self.name = name
        self.command = command

    @property
    def version(self):
        return tuple(int(part) for part in self.name.split("."))

    def start(self, code, tmp_path, env=None, seconds=SECONDS):
        return subprocess.run(
            [*self.command, _script(code, tmp_path)],
            env=_environment(tmp_path, env),
            timeout=seconds,
            cwd=tmp_path,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        )

    def run(self, code, tmp_path, env=None, status=0, seconds=SECONDS):
        done = self.start(code, tmp_path, env, seconds)
        assert status is None or done.returncode == status, done.stdout
        told = told_in(done.stdout)
        return told[0] if len(told) == 1 else told


def told_in(output):
    """All that a script gave to tell()."""
    assert "Traceback" not in output, output
    told = [json.loads(line[len(MARK) :]) for line in output.splitlines() if line.startswith(MARK)]
    assert told, output
    return told


def _command(name):
    """How to run a script in Blender `name`. Raises blenders.Missing."""
    if name == "3.4":
        return blenders.blender(blenders.SYSTEM).command
    return blenders.blender(name).command[:1]  # as plain Python: how a module leaves is tested too


def output_in_window(code, tmp_path, size=(640, 480), env=None):
    """What Debian's Blender, in a window at the lower left of a virtual screen, printed. A window that hangs, as those
    of 3.4.1 under Xvfb do at times, is tried once more."""
    if not shutil.which("blender") or not shutil.which("xvfb-run"):
        pytest.skip("Blender 3.4 or xvfb-run is not installed")
    command = ["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24", "blender", "--factory-startup"]
    command += ["--window-geometry", "0", "0", *map(str, size), "--python", _script(code, tmp_path)]
    environment = _environment(tmp_path, dict(env or {}, LIBGL_ALWAYS_SOFTWARE="1"))
    for _ in range(2):
        for left in tmp_path.glob("log"):  # what the stand-in for the core wrote at the first try
            left.unlink()
        output, hung = _run_or_kill(command, environment, tmp_path)
        if not hung:
            return output
        print("Blender's window hung:", output)
    pytest.fail("Blender's window hung twice")


def _run_or_kill(command, environment, folder):
    """Output, and whether it had to be killed: with its group, for xvfb-run alone would leave Blender and its server."""
    process = subprocess.Popen(
        command,
        env=environment,
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=True,
    )
    try:
        return process.communicate(timeout=WINDOW_SECONDS)[0], False
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        return process.communicate()[0], True


def newest():
    """The newest that can be had; 5.1 and later need a Python that not every system has."""
    missing = []
    for name in reversed(NAMES):
        try:
            return Host(name, _command(name))
        except blenders.Missing as why:
            missing.append(str(why))
    pytest.skip("; ".join(missing))


def host_named(name):
    try:
        return Host(name, _command(name))
    except blenders.Missing as missing:
        pytest.skip(str(missing))


@pytest.fixture(params=NAMES)
def host(request):
    """Every Blender, each a test of its own: for what Blender's versions do differently."""
    return newest() if request.param == NEWEST else host_named(request.param)


# The oldest and the newest alone: for what is the add-on's own, where a Blender between the two can say no more.
oldest_and_newest = pytest.mark.parametrize("host", [NAMES[0], NEWEST], indirect=True)
