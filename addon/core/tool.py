"""The core's other sub-commands, for what the add-on asks of it once: reading a file, say. No bpy."""

import os
import subprocess
import tempfile

from . import client, find


class ToolError(Exception):
    """The core could not do it. The text is one line, fit to be shown."""


def run(preference, arguments, seconds):
    """Runs `stokes ARGUMENTS` to its end; returns what it said on stderr, without its own name.
    `preference` is as in find_core."""
    try:
        executable = find.find_core(preference)
        done = subprocess.run(
            [executable, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            timeout=seconds,
            text=True,
            errors="replace",
            env=client.environment(executable),
        )
    except find.CoreNotFound as error:
        raise ToolError(str(error)) from error
    except (OSError, subprocess.TimeoutExpired) as error:
        raise ToolError("The core does not answer: %s" % error) from error
    said = [line.removeprefix("stokes: ") for line in done.stderr.splitlines()]
    if done.returncode != 0:
        raise ToolError(said[-1] if said else "The core failed")
    return "\n".join(said)


def imported(preference, kind, source, seconds, *options):
    """What `stokes KIND import` makes of a file or a library entry, as CSV, and what it says."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "imported.csv")
        notes = run(preference, [kind, "import", "-o", path, *options, "--", source], seconds)
        try:
            with open(path, encoding="utf-8") as file:
                return file.read(), notes
        except OSError as error:
            raise ToolError("The core wrote nothing: %s" % error.strerror) from error
