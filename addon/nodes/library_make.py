"""Writes library.json: the core's spectra on a coarse grid, for plots, colours and menus. Not part
of the add-on at run time. Needs the package `colour-science` (BSD 3-Clause).

    python3 addon/nodes/library_make.py build/stokes
"""

import json
import os
import subprocess
import sys

FIRST, LAST, STEP = 300, 830, 5
SOURCE = (
    "Made by library_make.py from csrc/spectrum/library (sources: its generate.py); "
    "the CIE observer from colour-science (BSD-3-Clause)"
)
GRID = str(FIRST), str(LAST), str(STEP)


def core_library(stokes):
    """{name: values on the grid}, without the glasses: they are an index, no light and no colour."""

    def run(*arguments):
        return subprocess.run(
            [stokes, "spectrum", *arguments], check=True, timeout=60, capture_output=True, text=True
        ).stdout

    return {
        name: [number(line.split()[1]) for line in run("show", name, *GRID).splitlines()]
        for name in run("list").splitlines()
        if not name.startswith("glass/")
    }


def number(value):
    return float("%.5g" % float(value))


def observer():
    import colour

    cmfs = (
        colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
        .copy()
        .align(
            colour.SpectralShape(FIRST, LAST, STEP),
            extrapolator_kwargs={"method": "Constant", "left": 0, "right": 0},
        )
        .values
    )
    return [[number(v) for v in cmfs[:, i]] for i in range(3)]


def write(entries, path):
    head = {
        "source": SOURCE,
        "first": FIRST,
        "step": STEP,
        "observer": observer(),
        "d65": entries["illuminant/D65"],
    }
    with open(path + ".new", "w", encoding="utf-8") as out:
        out.write(json.dumps(head, separators=(",", ":"))[:-1] + ',"entries":{\n')
        out.write(
            ",\n".join(
                json.dumps(name) + ":" + json.dumps(entries[name], separators=(",", ":"))
                for name in sorted(entries)
            )
        )
        out.write("\n}}\n")
    os.replace(path + ".new", path)


if __name__ == "__main__":
    write(
        core_library(sys.argv[1]),
        os.path.join(os.path.dirname(os.path.abspath(__file__)), "library.json"),
    )
