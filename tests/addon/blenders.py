"""The Blenders that the add-on is tested in, and how to run a script in each, in a process of its own with a time-out.
Run as a program it is the launcher of a script in bpy, the module, which dies at exit unless engines are unregistered; without
a script it installs what is missing, for tests to come."""

import fcntl
import functools
import glob
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HOME = ROOT / "build" / "bpy"  # one virtual environment for each module below

SYSTEM = "system"  # $BLENDER, or the one in $PATH
MODULES = {  # Blender as a Python module: the newest release of a series, and the only Python it loads in
    "4.2": "3.11",
    "4.5": "3.11",
    "5.0": "3.11",
    "5.2": "3.13",
}
NAMES = (SYSTEM, *MODULES)

BLENDERS_OWN = {None, 'CYCLES', 'HYDRA_STORM'}  # engines that Blender itself unregisters

SECONDS = 120
INSTALL_SECONDS = 900


class Missing(Exception):
    """This Blender cannot be had here, and why."""


class Died(Exception):
    """The script's process ran out of time, or ended by a signal or a status that is not 0."""


class Blender:
    def __init__(self, name, command, version):
        self.name = name
        self.command = command
        self.version = version

    def reads_files_of(self, other):
        """Blender before 4.1 crashes on any file that 4.1 or later wrote."""
        return self.version >= (4, 1, 0) or other.version < (4, 1, 0)

    def run(self, script, *arguments, timeout=SECONDS, env=None):
        """What the script wrote to stdout and stderr; `arguments` are what follows "--" in its sys.argv."""
        command = [*self.command, str(script), "--", *map(str, arguments)]
        status, text = _run(command, timeout, dict(os.environ, PYTHONDONTWRITEBYTECODE="1", **(env or {})))
        if status:
            raise Died("%s in Blender %s ended with %s:\n%s" % (Path(script).name, self.name, status, text))
        return text


@functools.lru_cache(maxsize=None)
def blender(name):
    """The Blender of that name, installed if need be. Raises Missing, in a second call as well."""
    found = _find(name)
    if isinstance(found, str):
        raise Missing("Blender %s is missing: %s" % (name, found))
    return found


def _run(command, timeout, env=None):
    """Status (0 is good) and output. The whole group is ended on a time-out: a core must not outlive its Blender."""
    process = subprocess.Popen(command, env=env, start_new_session=True, text=True, errors="replace",
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    try:
        text, _ = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        text, _ = process.communicate()
        return "a time-out of %d s" % timeout, text
    return process.returncode, text


@functools.lru_cache(maxsize=None)
def _find(name):
    """A Blender, or a text that says why there is none."""
    if name == SYSTEM:
        program = shutil.which(os.environ.get("BLENDER", "blender"))
        if not program:
            return "no blender in PATH"
        command = [program, "-b", "--factory-startup", "--python-exit-code", "3", "--python"]
        status, text = _run([program, "--version"], SECONDS)
    else:
        HOME.mkdir(parents=True, exist_ok=True)
        with open(HOME / (name + ".lock"), "w") as lock:  # two test runs must not install at once
            fcntl.flock(lock, fcntl.LOCK_EX)
            python, why = _install(name)
        if not python:
            return why
        command = [str(python), str(Path(__file__).resolve())]
        status, text = _run([str(python), "-c", "import bpy; print('Blender', bpy.app.version_string)"], SECONDS)
    numbers = [line.split()[1] for line in text.splitlines() if line.startswith("Blender ")]
    if status or not numbers:
        return text.strip()[-500:] or "it ends with %s" % status
    return Blender(name, command, tuple(int(part) for part in numbers[0].split(".")))


def _install(name):
    """(the Python that has this bpy, "") or (None, why not)."""
    home = HOME / name
    python = home / "bin" / "python"
    if (home / ".done").exists():
        return python, ""
    why = "there is no Python %s to load it" % MODULES[name]
    for candidate in _pythons(MODULES[name]):
        shutil.rmtree(home, ignore_errors=True)
        status, text = _run([candidate, "-m", "venv", str(home)], SECONDS)
        if not status:
            status, text = _run([str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check",
                                 "--retries", "1", "--no-compile", "--only-binary", ":all:", "bpy==%s.*" % name], INSTALL_SECONDS)
        if not status:  # Blender's own modules are compiled at their first import, a tenth of what there is; tests compile nothing
            compiling = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
            _run([str(python), "-c", "import bpy"], SECONDS, compiling)
            (home / ".done").touch()
            return python, ""
        why = text.strip().splitlines()[-1] if text.strip() else "pip ended with %s" % status
    return None, why


def _pythons(version):
    """Interpreters of that version, each once."""
    places = [sys.executable, shutil.which("python" + version), "/usr/bin/python3",
              *glob.glob(os.path.expanduser("~/.pyenv/versions/%s.*/bin/python" % version))]
    seen = set()
    for place in filter(None, places):
        status, text = _run([place, "-c", "import sys; print('%d.%d' % sys.version_info[:2], sys.base_prefix)"], SECONDS) \
            if os.path.exists(place) else (1, "")
        if not status and text.split()[0] == version and text not in seen:
            seen.add(text)
            yield place


def _launch(script, arguments):
    """Runs the script as Blender's --python does. What it registers with atexit comes before what is registered here."""
    import atexit
    import runpy

    import bpy

    atexit.register(_unregister_engines, bpy)
    sys.argv = [script, *arguments]
    runpy.run_path(script, run_name="__main__")


def _unregister_engines(bpy):
    """A registered engine makes bpy 4.2 crash and 4.5 hang at exit."""
    for engine in bpy.types.RenderEngine.__subclasses__():
        if getattr(engine, "bl_idname", None) not in BLENDERS_OWN and engine.is_registered:
            bpy.utils.unregister_class(engine)


def _install_all():
    for name in MODULES:
        try:
            blender(name)
        except Missing as why:
            print(why, file=sys.stderr)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        _launch(sys.argv[1], sys.argv[2:])
    else:
        _install_all()
