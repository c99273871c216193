"""Draws the supplemental's figures into build/figures. QUICK=1 in the environment: fewer samples."""

import argparse
import importlib
import sys
import time

import kit

FIGURES = {  # module: what it draws; its draw() may return lines that say what in it is not as it should be
    "matrices": "figures 1 to 3: reradiation matrices under each kernel",
    "note": "the measured sticky note",
    "shown_spectra": "figures 4 to 6: the spectra used",
    "ufo": "the UFO scene, full of its medium",
    "lens": "figure 7: the lens scene over samples",
    "colour_bias": "figures 8 to 13: colour bias of (2,2)-paths",
    "notebook": "the colour bias notebook, run headless",
    "convergence": "convergence animations",
    "equal_time": "integrators at equal time",
}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", default=list(FIGURES), help="of %s" % ", ".join(FIGURES))
    begin, wrong = time.monotonic(), []
    for name in parser.parse_args().names:
        kit.say("%s (%s)" % (FIGURES[name], name))
        wrong += importlib.import_module(name).draw() or []
        kit.say("  %.0f s so far" % (time.monotonic() - begin))
    if wrong:
        sys.exit("\n".join(["Drawn, but not what was predicted:", *wrong]))


main()
