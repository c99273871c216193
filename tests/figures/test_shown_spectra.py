"""Pictures that can be read: where matplotlib is installed, which `make figures` sees to."""

import numpy as np
import pytest

pytest.importorskip("matplotlib")

import kit
import plots
import shown_spectra
import spectra

pytestmark = pytest.mark.skipif(not kit.CORE.exists(), reason="the core is not built")


@pytest.fixture
def drawn(monkeypatch):
    """Figures instead of files; without the renders, whose dots lie on the lines."""
    figures = []
    monkeypatch.setattr(plots, "save", lambda figure, name: figures.append(figure))
    monkeypatch.setattr(spectra, "measured_reflectance", lambda surface, folder: ([], []))
    yield figures
    plots.plt.close("all")


@pytest.mark.parametrize("draw", [shown_spectra.figure_4, shown_spectra.figure_5, shown_spectra.figure_6])
def test_no_curve_passes_behind_a_legend(drawn, draw):
    draw()
    drawn[0].canvas.draw()
    for axes in drawn[0].axes:
        if axes.get_legend() is None:
            continue
        box = axes.get_legend().get_window_extent()
        for twin in drawn[0].axes:
            for line in twin.get_lines():
                points = twin.transData.transform(np.column_stack(line.get_data()))
                assert not any(box.contains(x, y) for x, y in points), line.get_label()


def test_the_ground_of_figure_4_tells_where_blue_may_be_bright(drawn):
    """Blue's curve comes up again in the far red, where its colour does not show it."""
    shown_spectra.figure_4()
    panel = drawn[0].axes[0]
    blue = next(line for line in panel.get_lines() if line.get_label().startswith("blue"))
    drawn[0].canvas.draw()
    begin = max(panel.transData.inverted().transform(patch.get_window_extent())[0][0] for patch in panel.patches)
    nm, values = blue.get_data()
    assert 680 < begin < 700 and values[(nm > 550) & (nm < begin)].max() < 0.15 < values[-1]
    assert any("hardly seen" in text.get_text() for text in panel.get_legend().get_texts())
