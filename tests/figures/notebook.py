"""Runs the colour bias notebook without a browser; what it becomes lies in build/figures."""

import nbclient
import nbformat

import kit
import plots

SECONDS = 1800  # for a cell


def draw():
    plots.FOLDER.mkdir(parents=True, exist_ok=True)
    here = kit.ROOT / "tests" / "figures"
    notebook = nbformat.read(here / "color_bias.ipynb", as_version=4)
    place = {"metadata": {"path": str(here)}}
    client = nbclient.NotebookClient(notebook, timeout=SECONDS, kernel_name="python3", resources=place)
    client.extra_arguments = ["--log-level=ERROR"]
    client.execute()
    nbformat.write(notebook, plots.FOLDER / "color_bias.ipynb")
    kit.say("  color_bias.ipynb and %d plots" % len(list(plots.FOLDER.glob("notebook-*.png"))))
