"""What the kernel and the hosts make tells how far it is, from 0 to 1 and never back, and stops where it is told to."""

import numpy as np
import pytest

pytest.importorskip("OCP", reason="needs OCP: install cadfit[build123d] or cadfit[cadquery]")

import cadfit
from cadfit import occt

T = np.linspace(0.0, 6.0, 40)
PATH = np.column_stack([10 * np.cos(T), 10 * np.sin(T), T])
RING = np.column_stack([5 * np.cos(T), 5 * np.sin(T)])
SQUARE = [[-1, -1], [1, -1], [1, 1], [-1, 1]]


def with_build123d():
    host = pytest.importorskip("build123d")
    from cadfit import build123d as ours

    return {
        "FitSpline": lambda told: ours.FitSpline(PATH, 0.01, progress=told),
        "FitProfile": lambda told: ours.FitProfile(RING, 0.05, [0.3 * RING, 0.1 * RING + [3, 0]], progress=told),
        "FitTube": lambda told: ours.FitTube(PATH, 0.5, 0.01, progress=told),
        "simplify": lambda told: ours.simplify(host.Edge.make_circle(5), 0.01, "fast", told),
    }


def with_cadquery():
    cq = pytest.importorskip("cadquery")
    from cadfit import cadquery as ours

    plane = ours.Workplane
    return {
        "fit_edge": lambda told: ours.fit_edge(PATH, 0.01, progress=told),
        "fit_face": lambda told: ours.fit_face(RING, 0.05, [0.3 * RING], progress=told),
        "fit_tube": lambda told: ours.fit_tube(PATH, 0.5, 0.01, progress=told),
        "fit_spline": lambda told: ours.fit_spline(PATH, 0.01, progress=told),
        "fit_profile": lambda told: ours.fit_profile(RING, 0.05, progress=told),
        "simplify": lambda told: ours.simplify(cq.Edge.makeCircle(5), 0.01, "fast", told),
        "Workplane.fitSpline": lambda told: plane().fitSpline(PATH, 0.01, progress=told),
        "Workplane.fitProfile": lambda told: plane().fitProfile(RING, 0.05, [0.3 * RING], progress=told),
        "Workplane.fitTube": lambda told: plane().fitTube(PATH, 0.5, 0.01, progress=told),
        "Sketch.fitSpline": lambda told: ours.Sketch().fitSpline(RING, 0.05, closed=True, progress=told),
        "Sketch.fitProfile": lambda told: ours.Sketch().fitProfile(RING, 0.05, progress=told),
    }


def with_occt():
    path = cadfit.fit(PATH, 0.01, effort="fast")
    edge = occt.to_edge(path.spline)
    return {
        "tube_solid": lambda told: occt.tube_solid(path, 0.5, thickness=0.1, progress=told),
        "sweep_solid": lambda told: occt.sweep_solid(path, SQUARE, 0.01, progress=told),
        "simplify": lambda told: occt.simplify(edge, 0.1, effort="fast", progress=told),
    }


@pytest.mark.parametrize("those", [with_occt, with_build123d, with_cadquery])
def test_progress_rises_from_0_to_1_and_stops_the_work(those):
    for name, work in those().items():
        seen = []
        work(seen.append)
        assert seen == sorted(seen), name
        assert 0.0 <= seen[0] < seen[-1] == 1.0, name

        class Enough(Exception):
            pass

        def stop(part, error=Enough):
            raise error

        with pytest.raises(Enough):
            work(stop)
