"""Where the core's executable is: a preference, $STOKES_CORE, beside the add-on, the checkout's
build, $PATH."""

import os
import shutil
import stat

NAME = "stokes.exe" if os.name == "nt" else "stokes"
ADDON = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


class CoreNotFound(Exception):
    """No executable where one was named, or nowhere at all."""


def _named(path, where):
    """A path that somebody chose must be right: falling through to another core would hide the
    mistake."""
    if not os.path.isfile(path):
        raise CoreNotFound("%s names no file: %s" % (where, path))
    return path


def find_core(preference=""):
    """The path of the core, made executable if the zip lost its mode."""
    beside = os.path.join(ADDON, "bin", NAME)
    checkout = os.path.join(os.path.dirname(ADDON), "build", NAME)
    if preference:
        path = _named(preference, "The preference")
    elif os.environ.get("STOKES_CORE"):
        path = _named(os.environ["STOKES_CORE"], "$STOKES_CORE")
    else:
        found = [path for path in (beside, checkout) if os.path.isfile(path)]
        path = found[0] if found else shutil.which(NAME)
    if not path:
        raise CoreNotFound(
            "The core is missing: no %s beside the add-on, in the checkout's build or in PATH"
            % NAME
        )
    if not os.access(path, os.X_OK):
        try:
            os.chmod(path, os.stat(path).st_mode | stat.S_IXUSR | stat.S_IXGRP | stat.S_IXOTH)
        except OSError as error:
            raise CoreNotFound("The core cannot be made executable: %s" % error) from error
    return path
