"""Writes library.json: the core's spectrum library on a coarse grid, for plots, swatches and drop-downs.
Not part of the add-on at run time. Needs the package `colour-science` (BSD 3-Clause; CIE 1931 observer, D65):

    python3 addon/nodes/library_make.py build/stokes
"""

import json
import os
import subprocess
import sys

FIRST, LAST, STEP = 300, 830, 5


def core_library(stokes):
    """{name: values on the grid} from `stokes spectrum list` and `stokes spectrum NAME`."""
    def run(*arguments):
        return subprocess.run([stokes, "spectrum", *arguments], check=True, timeout=60,
                              capture_output=True, text=True).stdout
    return {name: on_grid(read_table(run("show", name))) for name in run("list").split("\n") if name}


def read_table(text):
    """[(nm, value)] of lines of two numbers; other lines are titles."""
    table = []
    for line in text.replace(",", " ").replace("\t", " ").split("\n"):
        try:
            nm, value = (float(word) for word in line.split()[:2])
        except ValueError:
            continue
        table.append((nm, value))
    return table


def on_grid(table):
    """Piecewise linear, ends held: what the core says outside Λ does not matter here."""
    values, at = [], 0
    for nm in range(FIRST, LAST + 1, STEP):
        while at + 2 < len(table) and table[at + 1][0] < nm:
            at += 1
        (x0, y0), (x1, y1) = table[at], table[min(at + 1, len(table) - 1)]
        share = 0.0 if x1 <= x0 else min(1.0, max(0.0, (nm - x0) / (x1 - x0)))
        values.append(float("%.5g" % (y0 + share * (y1 - y0))))
    return values


def observer_and_daylight():
    import colour
    shape = colour.SpectralShape(FIRST, LAST, STEP)
    cmfs = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(
        shape, extrapolator_kwargs={"method": "Constant", "left": 0, "right": 0}).values
    d65 = colour.SDS_ILLUMINANTS["D65"].copy().align(shape).values
    return [[float("%.5g" % v) for v in cmfs[:, i]] for i in range(3)], [float("%.5g" % v) for v in d65]


def write(entries, path):
    observer, d65 = observer_and_daylight()
    head = {"first": FIRST, "step": STEP, "observer": observer, "d65": d65}
    with open(path + ".new", "w", encoding="utf-8") as out:
        out.write(json.dumps(head, separators=(",", ":"))[:-1] + ',"entries":{\n')
        out.write(",\n".join(json.dumps(name) + ":" + json.dumps(entries[name], separators=(",", ":"))
                             for name in sorted(entries)))
        out.write("\n}}\n")
    os.replace(path + ".new", path)


if __name__ == "__main__":
    write(core_library(sys.argv[1]), os.path.join(os.path.dirname(os.path.abspath(__file__)), "library.json"))
