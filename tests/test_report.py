"""The numbers and the words of a report's page, as a program reads them; what a person sees is in test_report_page."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import cadfit
from cadfit import BSpline
from cadfit.bezier import evaluate
from cadfit.fitting.along import allowed, trace
from cadfit.fitting.judging import judged
from cadfit.report import Entry, write
from cadfit.report.data import MOST_POINTS, page_data

from made import Made

T = np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False)
ELLIPSE = np.column_stack([3.0 * np.cos(T), 2.0 * np.sin(T)])
SQUARE = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [2, 2], [1, 2], [0, 2], [0, 1.0]])
WAVE = np.column_stack([t := np.linspace(0, 9, 200), np.sin(t), np.cos(2 * t)])
WAVE += np.random.default_rng(2).normal(scale=0.01, size=WAVE.shape)
FITS = Made(
    closed=lambda: cadfit.fit(ELLIPSE, 0.01, closed=True),
    cornered=lambda: cadfit.fit(SQUARE, 0.01, closed=True, between="polyline"),
    in_space=lambda: cadfit.fit(WAVE, 0.08),
    one_coordinate=lambda: cadfit.fit(WAVE[:, 1:2], 0.08),
    five_coordinates=lambda: cadfit.fit(WAVE @ np.random.default_rng(3).normal(size=(3, 5)), 0.3),
    far_away=lambda: cadfit.fit(1e-3 * WAVE[:, :2] + 6.4e6, 8e-5),
    dominant=lambda: cadfit.fit_dominant(WAVE, fraction=0.3),
)
EACH = pytest.mark.parametrize("fit", FITS, indirect=True)


@pytest.fixture
def fit(request):
    return FITS[request.param]


class Words(HTMLParser):
    """The data and the text of a page, its elements, and what stands in script elements."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.scripts, self.words, self._within = [], [], [], []
        self.feed(text)
        assert self._within == []

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        if tag in ("script", "style", "title", "table", "pre", "h1"):
            self._within.append(tag)

    def handle_endtag(self, tag):
        if self._within and tag == self._within[-1]:
            self._within.pop()

    def handle_data(self, data):
        (self.scripts if "script" in self._within else self.words).append(data)


def page_of(fit, path, **options):
    fit.report(path, **options)
    return Words(path.read_text(encoding="utf-8"))


@EACH
def test_the_data_are_those_of_the_fit(fit, tmp_path):
    data = json.loads(page_of(fit, tmp_path / "a.html").scripts[0])
    (entry,), (points,) = data["entries"], data["sets"]
    graph = fit.points.shape[1] == 1
    # The very poles and knots.
    for curve, poles, knots in zip(fit.curves, entry["exact_poles"], entry["knots"], strict=True):
        assert BSpline(poles, knots).isclose(curve, 0.0)
    # The points, to ten digits of their size, and how far they are.
    size = np.linalg.norm(np.ptp(fit.points, axis=0))
    centre = np.array(data["centre"])
    assert_allclose((np.array(points["at"]) + centre)[:, graph:], fit.points, atol=2e-9 * size, rtol=2e-16)
    joined = cadfit.join(fit.curves)
    away = fit.points - joined(fit.parameters)
    assert_allclose(entry["off"], np.linalg.norm(away, axis=1), rtol=1e-5)
    assert_allclose(np.array(entry["off_vectors"])[:, graph:], away, rtol=1e-4)
    assert_array_equal(points["corners"], fit.corners)
    # The figures.
    figures = entry["figures"]
    assert (figures["poles"], figures["points"], figures["repeats"]) == (fit.poles, len(fit.points), len(fit.cleaned))
    assert (figures["corners"], figures["curves"]) == (len(fit.corners), len(fit.curves))
    assert figures["deviation at points"] == fit.deviation.points
    assert figures["deviation between"] == fit.deviation.between
    assert figures["length"] == pytest.approx(sum(curve.length() for curve in fit.curves), rel=1e-7)
    assert figures["continuity"] in ("C2", "smooth")
    assert entry["worst"]["row"] == points["rows"][entry["worst"]["shown"]] == fit.deviation.worst
    assert entry["worst"]["off"] == pytest.approx(max(entry["off"]), rel=1e-5)
    # The curve as Bézier poles, the samples along it, what is between the points.
    chain, along = np.array(entry["chain"]), entry["along"]
    pieces = np.stack([chain[k : len(chain) - 3 + k : 3] for k in range(4)], axis=1)
    at = evaluate(pieces[along["span"]], np.array(along["t"]))
    _, distance = joined.nearest((at[::7] + centre)[:, graph:])
    assert distance.max() < 1e-8 * size + 2e-16 * np.abs(fit.points).max()
    assert (along["bend"] is None) == graph
    assert max(entry["between"]["off"]) <= fit.deviation.between * (1.0 + 5e-5)  # five digits are kept
    assert max(entry["between"]["off"]) >= 0.97 * fit.deviation.between - 1e-9 * size
    if fit.between == "curve":
        assert np.all(np.array(entry["between"]["off"]) <= np.array(entry["between"]["room"]) * 1.001)
        assert max(entry["between"]["room"]) <= allowed(fit).max() * 1.001


def test_the_smallest_radius_is_that_of_the_curve():
    figures = page_data([Entry("a", FITS["closed"])], "mm")["entries"][0]["figures"]
    spline = FITS["closed"].spline
    sharpest = np.linalg.norm(spline.curvature(np.linspace(*spline.domain, 200_001)), axis=1).max()
    assert figures["smallest radius"] == pytest.approx(1.0 / sharpest, rel=1e-6)
    assert page_data([Entry("a", FITS["one_coordinate"])], "")["entries"][0]["figures"]["smallest radius"] is None


def test_a_jump_of_the_curvature_is_kept_on_both_sides():
    pieces = cadfit.cardinal_pieces([[0, 0], [1, 1], [2, 0], [3, 1]])
    spline = cadfit.pieces_to_spline(pieces)
    entry = page_data([Entry("a", judged(spline, pieces[:, 0]))], "")["entries"][0]
    assert entry["figures"]["continuity"] == "C1"
    s, bend = (np.array(entry["along"][name]) for name in ("s", "bend"))
    (jumps,) = np.nonzero((np.diff(s) == 0.0) & (np.abs(np.diff(bend)) > 0.5))
    assert len(jumps) == 2
    assert_allclose(s[jumps], trace([spline]).at(spline.distinct_knots[1:-1]))


def test_many_points_are_thinned_and_it_is_said(tmp_path):
    t = np.linspace(0.0, 20.0, 30_000)
    points = np.column_stack([t, np.sin(t)]) + np.random.default_rng(4).normal(scale=1e-3, size=(30_000, 2))
    fit = cadfit.fit(points, 0.01, effort="fast")
    page = page_of(fit, tmp_path / "many.html")
    (found,) = (data := json.loads(page.scripts[0]))["sets"]
    assert len(found["rows"]) == len(found["at"]) <= MOST_POINTS
    assert found["total"] == 30_000
    assert {0, 29_999, fit.deviation.worst} <= set(found["rows"])
    assert any(f"{len(found['rows']):,} of 30,000 points are shown" in words for words in page.words)
    # Of each run of one or two points the farthest is kept, so of nearly every three the farthest.
    away = np.linalg.norm(fit.points - fit.spline(fit.parameters), axis=1)
    largest = away.reshape(-1, 3).max(axis=1)
    kept = np.zeros(30_000)
    kept[found["rows"]] = data["entries"][0]["off"]
    assert np.mean(kept.reshape(-1, 3).max(axis=1) >= largest * (1.0 - 1e-5)) > 0.9
    assert (tmp_path / "many.html").stat().st_size < 3_000_000


@pytest.mark.slow
def test_too_many_spans_and_poles_are_not_drawn_one_by_one(tmp_path):
    points = np.column_stack([np.arange(4000.0), np.random.default_rng(5).normal(size=4000)])
    spline = cadfit.local_spline(points)
    page = page_of(judged(spline, points), tmp_path / "heavy.html")
    entry = json.loads(page.scripts[0])["entries"][0]
    assert (entry["poles"], entry["exact_poles"]) == ([], [])
    assert "11,998 poles are too many to show." in "".join(page.words)
    assert any("spans: drawn as 10,00" in words for words in page.words)
    chain = np.array(entry["chain"]) + json.loads(page.scripts[0])["centre"]
    assert spline.nearest(chain[::99])[1].max() < 1e-6
    assert np.all(np.diff(entry["along"]["span"]) >= 0)


@pytest.mark.parametrize(
    "name", ["<script>alert(1)</script>", "a & b", "</script><img src=x onerror=alert(1)>", '"><b>', "$unit"]
)
def test_names_are_words_and_nothing_else(name, tmp_path):
    plain = page_of(FITS["closed"], tmp_path / "a.html", title="plain", unit="mm")
    fits = [Entry(name, FITS["closed"]), Entry("other", FITS["closed"])]
    write(fits, tmp_path / "b.html", name, unit=name, calls=[name])
    page = page_of(FITS["closed"], tmp_path / "c.html", title=name, unit=name)
    both = Words((tmp_path / "b.html").read_text(encoding="utf-8"))
    for found in (page, both):
        assert len(found.scripts) == len(plain.scripts) == 2
        assert {tag for tag, _ in found.elements} <= {tag for tag, _ in plain.elements} | {"thead"}
        assert not [attributes for _, attributes in found.elements if "onerror" in attributes or "src" in attributes]
        assert name in found.words
        assert json.loads(found.scripts[0])["unit"] == name


def test_the_page_needs_nothing_else(tmp_path):
    page = page_of(FITS["in_space"], tmp_path / "a.html")
    assert not [each for _, each in page.elements if "src" in each or each.get("href", "data:,") != "data:,"]
    (policy,) = [each["content"] for _, each in page.elements if each.get("http-equiv")]
    assert policy.startswith("default-src 'none'")
    text = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert re.findall(r"https?://", text) == []
    assert len(text) - len(page.scripts[0]) < 100_000


@EACH
def test_the_table_says_it(fit, tmp_path):
    words = "".join(page_of(fit, tmp_path / "a.html", unit="mm").words)
    assert f"≤ {fit.deviation.points:.4g} mm" in words
    assert f"at point {fit.deviation.worst}" in words
    if fit.tolerance is None:
        assert "no point farther than" in words
    else:
        assert f"within {fit.tolerance:g} mm {'everywhere' if fit.between == 'polyline' else 'at every point'}" in words
    assert fit.call in words
    assert f"cadfit {cadfit.__version__}" in words


def test_a_broken_tolerance_is_said(tmp_path):
    fit = FITS["closed"]
    less = replace(fit, tolerance=0.5 * fit.deviation.points)
    page = page_of(less, tmp_path / "a.html")
    assert f"not within {less.tolerance:g}" in page.words
    assert not [words for words in page.words if "certified" in words]


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        (lambda: cadfit.fit(SQUARE, 0.5), "cadfit.fit(points, 0.5)"),
        (
            lambda: cadfit.fit(SQUARE, 0.1, closed=True, corners=np.array([2]), between="polyline", effort="fast"),
            "cadfit.fit(points, 0.1, closed=True, corners=[2], between='polyline', effort='fast')",
        ),
        (
            lambda: cadfit.fit(ELLIPSE, 0.1, weights=np.ones(90), end_tangents=[[1, 0], [0, 1]]),
            "cadfit.fit(points, 0.1, weights=weights, end_tangents=[[1, 0], [0, 1]])",
        ),
        (
            lambda: cadfit.fit_dominant(ELLIPSE, 30, curvature=0.0, method="paper"),
            "cadfit.fit_dominant(points, count=30, method='paper', curvature=0.0)",
        ),
    ],
)
def test_the_call_makes_the_fit_again(call, expected):
    fit = call()
    assert fit.call == expected
    points = ELLIPSE if len(fit.points) > 10 else SQUARE
    again = eval(fit.call, {"cadfit": cadfit, "points": points, "weights": np.ones(90)})
    assert all(a.isclose(b, 0.0) for a, b in zip(again.curves, fit.curves, strict=True))


def test_fits_of_other_points_and_dimensions_side_by_side():
    both = page_data([Entry("a", FITS["closed"]), Entry("b", FITS["cornered"]), Entry("c", FITS["closed"])], "")
    assert [entry["set"] for entry in both["entries"]] == [0, 1, 0]
    assert [each["total"] for each in both["sets"]] == [90, 8]
    with pytest.raises(ValueError, match=r"one dimension, not \[2, 3\]"):
        page_data([Entry("a", FITS["closed"]), Entry("b", FITS["in_space"])], "")


def test_an_old_page_stays_where_a_new_one_fails(tmp_path):
    (tmp_path / "a.html").write_text("old", encoding="utf-8")
    with pytest.raises(ValueError, match="one dimension"):
        write([Entry("a", FITS["closed"]), Entry("b", FITS["in_space"])], tmp_path / "a.html", "both")
    assert (tmp_path / "a.html").read_text(encoding="utf-8") == "old"
    with pytest.raises(OSError, match="none"):
        FITS["closed"].report(tmp_path / "none" / "a.html")
