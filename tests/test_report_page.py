"""Reports opened in a browser: no errors, nothing fetched, and what is drawn, pressed and pointed at."""

import re

import numpy as np
import pytest
from browser import Browser, needs_browser

import cadfit
from cadfit.fitting.judging import judged
from cadfit.report import Entry, write

from made import Made

pytestmark = [needs_browser, pytest.mark.slow]

BLUE, VERMILION, GREEN, GREY, PURPLE = "#0072b2", "#d55e00", "#009e73", "#7b8490", "#cc79a7"
X = np.linspace(0.0, 9.0, 200)
WAVE = np.column_stack([X, np.sin(X), np.cos(2 * X)]) + np.random.default_rng(2).normal(scale=0.01, size=(200, 3))
SQUARE = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1.0]])


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    found = Browser(tmp_path_factory.mktemp("browser"))
    yield found
    found.close()


@pytest.fixture
def opened(browser, tmp_path):
    """Open the page of a fit; at the end nothing has gone wrong, and nothing but the file was asked for."""

    def opened(*fits, **options):
        path = tmp_path / "page <&> 1.html"
        if len(fits) == 1:
            fits[0].report(path, **options)
        else:
            write([Entry(f"way {k}", fit) for k, fit in enumerate(fits)], path, "several")
        browser.open(path)
        return browser

    yield opened
    assert browser.wrong == []
    assert [url for url in browser.fetched if not url.startswith(("file:", "data:", "blob:"))] == []
    assert len(browser.fetched) <= 2  # the page, and its empty icon


def readout(browser):
    return browser.run("await frame(); return find('#readout').textContent")


FITS = Made(
    flat=lambda: cadfit.fit(WAVE[:, :2], 0.005, corners=None),
    space=lambda: cadfit.fit(WAVE, 0.08),
    cornered=lambda: cadfit.fit(SQUARE, 0.01, closed=True),
)


def test_each_toggle_draws_and_takes_away_its_own(opened):
    browser = opened(FITS["flat"], unit="mm")
    for name, colour, at_first in [("poles", GREY, True), ("points", VERMILION, True), ("curve", BLUE, True),
                                   ("comb", GREEN, False), ("deviation", PURPLE, False)]:  # fmt: skip
        before = browser.pixels("#view", colour)
        pressed = browser.run(f"return find('[data-show={name}]').getAttribute('aria-pressed')")
        assert pressed == str(at_first).lower()
        assert (before > 9) == at_first, name
        browser.click(f"[data-show={name}]")
        assert (browser.pixels("#view", colour) > 9) != at_first, name
        if name in ("comb", "deviation"):
            assert browser.run(f"return !find('[data-for={name}]').hidden")
            longer = browser.pixels("#view", colour)
            slider = "#comb-scale" if name == "comb" else "#times"
            browser.run(
                f"find('{slider}').value = find('{slider}').max; find('{slider}').dispatchEvent(new Event('input'))"
            )
            assert browser.pixels("#view", colour) != longer
            browser.click(f"[data-show={name}]")


def test_knots_corners_and_the_farthest_point_are_marked(opened):
    browser = opened(FITS["cornered"])
    for name in ("knots", "corners", "worst"):
        before = browser.run("await frame(); return find('#view').toDataURL()")
        browser.click(f"[data-show={name}]")
        assert browser.run("await frame(); return find('#view').toDataURL()") != before, name


def test_the_charts_show_deviation_tolerance_and_curvature(opened):
    browser = opened(FITS["flat"], unit="mm")
    assert browser.pixels("#deviation", VERMILION) > 100
    assert browser.pixels("#deviation", "#1d2430") > 30  # the tolerance's dashes and its name
    assert browser.pixels("#curvature", GREEN) > 100
    for chart, colour in [("deviation", VERMILION), ("curvature", GREEN)]:
        picture = f"return find('#{chart}').toDataURL()"
        linear = browser.run(picture)
        browser.click(f"[data-log={chart}]")
        assert browser.run(f"await frame(); {picture}") != linear
        assert browser.pixels(f"#{chart}", colour) > 50


def test_pointing_at_a_chart_shows_the_place_in_the_view_and_back(opened):
    browser = opened(FITS["flat"], unit="mm")
    plain = browser.run("return find('#view').toDataURL()")
    x, y, width, height = browser.run(
        "const b = find('#curvature').getBoundingClientRect(); return [b.x, b.y, b.width, b.height]"
    )
    browser.mouse("mouseMoved", x + 66 + 0.5 * (width - 80), y + height / 2)
    s = float(re.search(r"([\d.e-]+) mm along the curve", readout(browser))[1])
    length = FITS["flat"].spline.length()
    assert s == pytest.approx(0.5 * length, rel=0.01)
    assert "curvature" in readout(browser)
    assert browser.run("return find('#view').toDataURL()") != plain
    # The other way: over the middle of the view, near the curve.
    chart = browser.run("return find('#deviation').toDataURL()")
    x, y, width, height = browser.run(
        "const b = find('#view').getBoundingClientRect(); return [b.x, b.y, b.width, b.height]"
    )
    for down in np.linspace(0.1, 0.9, 60):
        browser.mouse("mouseMoved", x + 0.4 * width, y + down * height)
        if "along the curve" in readout(browser):
            break
    assert "along the curve" in readout(browser)
    assert browser.run("return find('#deviation').toDataURL()") != chart


def test_the_farthest_point_is_gone_to_from_table_and_chart(opened):
    browser = opened(FITS["flat"], unit="mm")
    worst = FITS["flat"].deviation.worst
    browser.click("button.go")
    assert f"point {worst}: off by" in readout(browser)
    said = float(re.search(r"off by ([\d.e-]+) mm", readout(browser))[1])
    assert said == pytest.approx(FITS["flat"].deviation.points, rel=2e-3)
    near = browser.run("return find('#view').toDataURL()")
    browser.click("#whole")
    assert "Point at" in readout(browser)
    assert browser.run("return find('#view').toDataURL()") != near
    # In the chart the ring stands where the deviation is largest; a click on it is the same.
    (s,) = cadfit.fitting.along.trace(FITS["flat"].curves).at(FITS["flat"].parameters[[worst]])
    x, y, width = browser.run("const b = find('#deviation').getBoundingClientRect(); return [b.x, b.y, b.width]")
    across = x + 66 + (width - 80) * s / FITS["flat"].spline.length()
    for down in range(8, 120, 4):
        browser.mouse("mouseMoved", across, y + down)
        if f"point {worst}" in readout(browser):
            break
    browser.mouse("mousePressed", across, y + down)
    browser.mouse("mouseReleased", across, y + down)
    assert f"point {worst}: off by" in readout(browser)


def test_the_view_in_space_turns_zooms_and_comes_back(opened):
    browser = opened(FITS["space"])
    state = lambda: browser.run("await frame(); await frame(); return find('#view').toDataURL()")  # noqa: E731
    first = state()
    browser.drag((400, 300), (500, 340))
    turned = state()
    assert turned != first
    browser.mouse("mouseWheel", 500, 300, deltaX=0, deltaY=-400)
    zoomed = state()
    assert zoomed != turned
    browser.click("#whole")
    browser.click("[data-look=iso]")
    browser.mouse("mouseMoved", 5, 5)
    assert state() == first
    seen = set()
    for look in ("top", "front", "side"):
        browser.click(f"[data-look={look}]")
        browser.mouse("mouseMoved", 5, 5)
        seen.add(state())
    assert len(seen) == 3


def test_at_a_deep_zoom_the_curve_is_still_drawn(opened):
    browser = opened(FITS["flat"])
    browser.click("button.go")
    x, y, width, height = browser.run(
        "const b = find('#view').getBoundingClientRect(); return [b.x, b.y, b.width, b.height]"
    )
    for _ in range(6):
        browser.mouse("mouseWheel", x + width / 2, y + height / 2, deltaX=0, deltaY=-300)
    browser.run("document.dispatchEvent(new KeyboardEvent('keydown', {key: 'Escape'}))")  # the mark hides the point
    # The farthest point stands in the middle; 40 times nearer the curve's ends are far outside, and nothing has broken.
    assert browser.pixels("#view", VERMILION) > 5
    for _ in range(4):
        browser.mouse("mouseWheel", x + width / 2, y + height / 2, deltaX=0, deltaY=300)
    assert browser.run("await frame(); return find('html').dataset.ready") == "yes"


def test_five_coordinates_three_at_a_time(opened):
    fit = cadfit.fit(WAVE @ np.random.default_rng(3).normal(size=(3, 5)), 0.3)
    browser = opened(fit)
    picture = browser.run("return find('#view').toDataURL()")
    browser.run("const c = find('[data-axis=\"0\"]'); c.value = 4; c.dispatchEvent(new Event('change')); await frame()")
    assert browser.run("await frame(); return find('#view').toDataURL()") != picture


def test_one_coordinate_is_a_graph(opened):
    browser = opened(cadfit.fit(WAVE[:, 1:2], 0.08), unit="V")
    assert browser.pixels("#view", BLUE) > 200
    assert browser.run("return find('#curvature')") is None


def test_several_on_one_page_are_hidden_one_by_one(opened):
    browser = opened(cadfit.fit(WAVE[:, :2], 0.1), cadfit.fit(WAVE[:, :2], 0.04))
    for k, colour in enumerate([BLUE, VERMILION]):
        browser.click(f'[data-entry="{k}"]')
        assert browser.pixels("#view", colour) < 5
        assert browser.pixels("#curvature", colour) < 5
        browser.click(f'[data-entry="{k}"]')
        assert browser.pixels("#curvature", colour) > 50
    browser.click('[data-entry="0"]')
    browser.click('[data-entry="1"]')  # the last one stays
    assert browser.pixels("#curvature", VERMILION) > 50


def test_on_dark_paper(opened, browser):
    paper = "return getComputedStyle(find('body')).backgroundColor"
    try:
        browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
        opened(FITS["flat"], unit="mm")
        assert browser.run(paper) == "rgb(18, 22, 28)"
        assert browser.pixels("#view", BLUE) == 0
        assert browser.pixels("#view", "#59a3cd") > 200  # lighter by a third
        browser.call("Emulation.setEmulatedMedia", features=[])
        painted = f"pixels('#view', '{BLUE}')"  # changed while it is open, when the browser comes to it
        assert browser.run(f"for (let k = 0; k < 200 && !{painted}; k++) await frame(); return {painted}") > 200
        assert browser.run(paper) == "rgb(245, 246, 248)"
    finally:
        browser.call("Emulation.setEmulatedMedia", features=[])


def test_in_a_narrow_window_nothing_sticks_out(opened, browser):
    size = {"height": 900, "deviceScaleFactor": 1, "mobile": False}
    try:
        for width in (360, 700, 1000):
            browser.call("Emulation.setDeviceMetricsOverride", width=width, **size)
            opened(FITS["space"], unit="mm")
            assert browser.run("return document.documentElement.scrollWidth <= window.innerWidth"), width
            assert browser.pixels("#view", VERMILION) > 100
    finally:
        browser.call("Emulation.setDeviceMetricsOverride", width=1440, **size)


def test_many_points_do_not_hide_the_curve(opened):
    t = np.linspace(0.0, 9.0, 50_000)
    noise = np.random.default_rng(0).normal(scale=0.01, size=(len(t), 2))
    browser = opened(cadfit.fit(np.column_stack([t, np.sin(t)]) + noise, 0.06, effort="fast"))
    assert browser.pixels("#view", BLUE) > 500
    assert browser.pixels("#view", VERMILION) > 500


def test_a_spike_of_the_curvature_is_shown_on_a_logarithmic_scale(opened):
    gentle = cadfit.BSpline([[0, 0], [1, 0.2], [2, 0.2], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    tight = cadfit.BSpline([[3, 0], [3 + 1e-6, 0], [3, 1e-6], [4, 1]], [1, 1, 1, 1, 2, 2, 2, 2])
    for curves, log in [((gentle,), "false"), ((gentle, tight), "true")]:
        browser = opened(judged(curves, [curves[0].poles[0], curves[-1].poles[-1]]))
        assert browser.run("return find('[data-log=curvature]').getAttribute('aria-pressed')") == log


def test_names_do_no_harm(opened):
    name = "</script><script>document.title='broken'</script>"
    browser = opened(FITS["flat"], title=name, unit="<b>mm</b>")
    assert browser.run("return [document.title, find('h1').textContent]") == [name, name]
    assert browser.run("return document.querySelectorAll('b').length") == 0
