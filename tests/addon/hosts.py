"""Hosts for the tests of the add-on: Debian's Blender and bpy as a module, each in a process of its
own with a time-out. A host that is not installed is skipped by name."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import blenders

ROOT = Path(__file__).resolve().parents[2]
FAKE_CORE = ROOT / "tests" / "addon" / "fake_core.py"
INSIDE = ROOT / "tests" / "addon" / "inside.py"
SECONDS = 60
MARK = "TOLD "
NAMES = ["3.4", "4.2", "4.5", "5.0", "5.2"]
NEWEST = "newest"

sys.path.insert(0, str(ROOT))


class Host:
    """One Blender. `run(code)` executes it after inside.py and returns what it gave to tell()."""

    def __init__(self, name, command):
        self.name = name
        self.command = command

    @property
    def version(self):
        return tuple(int(part) for part in self.name.split("."))

    def start(self, code, tmp_path, env=None, seconds=SECONDS):
        script = tmp_path / "script.py"
        script.write_text(INSIDE.read_text() + "\n\n" + code)
        environment = dict(
            os.environ, STOKES_CORE=str(FAKE_CORE), TMP_PATH=str(tmp_path), ROOT=str(ROOT)
        )
        environment.update(env or {})
        return subprocess.run(
            [*self.command, str(script)],
            env=environment,
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
        assert "Traceback" not in done.stdout, done.stdout
        told = [
            json.loads(line[len(MARK) :])
            for line in done.stdout.splitlines()
            if line.startswith(MARK)
        ]
        assert told, done.stdout
        return told[0] if len(told) == 1 else told


def _command(name):
    """How to run a script in Blender `name`. Raises blenders.Missing."""
    if name == "3.4":
        return blenders.blender(blenders.SYSTEM).command
    return blenders.blender(name).command[:1]  # as plain Python: how a module leaves is tested too


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
