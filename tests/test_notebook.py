import subprocess
import sys
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.testing import assert_allclose

import cadfit

from made import Made

X = np.linspace(0.0, 9.0, 120)
WAVE = np.column_stack([X, np.sin(X), np.cos(2 * X), X**2, -X])
SQUARE = [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1.0]]
SHOWN = Made(
    fit=lambda: cadfit.fit(WAVE[:, :2], 0.05),
    in_space=lambda: cadfit.fit(WAVE[:, :3], 0.05),
    five_coordinates=lambda: cadfit.fit(WAVE, 0.5),
    one_coordinate=lambda: cadfit.fit(WAVE[:, :1], 0.05),
    cornered=lambda: cadfit.fit(SQUARE, 0.01, closed=True),
    spline=lambda: cadfit.local_spline(WAVE[:, :2]),
    many_spans=lambda: cadfit.local_spline(np.random.default_rng(0).normal(size=(5000, 3)).cumsum(axis=0)),
    standstill=lambda: cadfit.BSpline(np.ones((4, 2)), [0, 0, 0, 0, 1, 1, 1, 1]),
)


class Text(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.words = []
        self.feed(text)

    def handle_data(self, data):
        self.words.append(data)


@pytest.mark.parametrize("name", SHOWN)
def test_it_is_small_and_whole(name):
    text = SHOWN[name]._repr_html_()
    ElementTree.fromstring(text)  # well-formed
    assert len(text) < 30_000
    assert "nan" not in text
    assert "<script" not in text
    assert ("<svg" in text) == (name != "one_coordinate")


def test_the_figures_are_those_of_the_fit():
    fit = SHOWN["fit"]
    words = Text(fit._repr_html_()).words
    assert f"≤ {fit.deviation.points:.4g}, at point {fit.deviation.worst}" in words
    assert words[words.index("poles") + 1] == str(fit.poles)
    assert words[words.index("tolerance") + 1] == "0.05"


def test_the_picture_is_to_one_scale_and_within_its_frame():
    svg = ElementTree.fromstring(SHOWN["fit"]._repr_html_()).find(".//{*}svg")
    dots = [
        step.split() for step in svg.findall("{*}path")[-1].get("d").removesuffix("h0").replace("M", "").split("h0")
    ]
    at = np.array(dots, dtype=float)
    points = SHOWN["fit"].points
    assert len(at) == len(points)
    scale = np.ptp(at[:, 0]) / np.ptp(points[:, 0])
    assert_allclose(at[:, 0] - at[0, 0], scale * (points[:, 0] - points[0, 0]), atol=0.2)
    assert_allclose(at[:, 1] - at[0, 1], -scale * (points[:, 1] - points[0, 1]), atol=0.2)
    assert np.all((at >= 0) & (at <= [300, 190]))


@pytest.mark.slow
def test_it_needs_nothing_heavy():
    code = "import sys, cadfit; cadfit.fit([[0, 0], [1, 1], [2, 0]], 0.1)._repr_html_(); "
    code += "sys.exit(any(name in sys.modules for name in ('matplotlib', 'trimesh', 'OCP', 'rich', 'typer')))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
