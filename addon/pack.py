"""Packs the add-on: python3 addon/pack.py CORE OCIO_FOLDER ZIP. Not part of the zip itself.
The core's libraries come along with their licences, but for those that every Linux desktop has in
one ABI."""

import os
import re
import subprocess
import sys
import zipfile

ADDON = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(ADDON)
TOP = "stokes"
LEFT_OUT = {"pack.py", "addon.mk"}
OF_THE_SYSTEM = re.compile(r"(linux-vdso|ld-linux|lib(c|m|dl|rt|pthread|gcc_s|stdc\+\+|z)\.)")


def addon_files():
    """Python and data; caches of tools stay at home."""
    for folder, folders, names in os.walk(ADDON):
        folders[:] = [
            name for name in folders if name != "__pycache__" and not name.startswith(".")
        ]
        for name in names:
            if name not in LEFT_OUT and not name.endswith(".pyc") and not name.startswith("."):
                path = os.path.join(folder, name)
                yield path, os.path.relpath(path, ADDON)


def shader_files():
    for folder, _, names in os.walk(os.path.join(ROOT, "shaders")):
        for name in names:
            yield os.path.join(folder, name), os.path.relpath(os.path.join(folder, name), ROOT)


def libraries(core):
    """Libraries of Debian that the core is linked with, and the licence of each one's package."""
    listed = subprocess.run(["ldd", core], check=True, capture_output=True, text=True).stdout
    for name, path in re.findall(r"(\S+) => (/\S+)", listed):
        if OF_THE_SYSTEM.match(name) or name.startswith("libOpenColorIO"):
            continue
        yield os.path.realpath(path), "bin/lib/" + name
        package = owner(path)
        licence = "/usr/share/doc/%s/copyright" % package
        if os.path.isfile(licence):
            yield licence, "licenses/%s.txt" % package


def owner(path):
    """The Debian package of a file, "" if none owns it."""
    for name in (path, os.path.realpath(path)):
        found = subprocess.run(["dpkg", "-S", name], capture_output=True, text=True)
        if found.returncode == 0:
            return found.stdout.partition(":")[0]
    return ""


def contents(core, ocio):
    yield from addon_files()
    yield from shader_files()
    yield core, "bin/stokes"
    yield os.path.join(ocio, "lib", "libOpenColorIO.so"), "bin/deps/ocio/lib/libOpenColorIO.so"
    yield os.path.join(ocio, "LICENSE"), "licenses/OpenColorIO.txt"
    yield from libraries(core)
    for name in ("LICENSE", "COPYING"):
        if os.path.isfile(os.path.join(ROOT, name)):
            yield os.path.join(ROOT, name), name


def pack(core, ocio, target):
    """Under a temporary name first: an interrupted build leaves no half zip."""
    temporary = target + ".part"
    with zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, name in sorted(set(contents(core, ocio)), key=lambda entry: entry[1]):
            archive.write(path, "%s/%s" % (TOP, name))
    os.replace(temporary, target)


if __name__ == "__main__":
    pack(*sys.argv[1:])
