"""What is no number is refused by its name and, in a table, by its row: by every function that takes some."""

import numpy as np
import pytest

import cadfit

POINTS = [(0, 0), (1, 1), (2, 0), (3, 1)]
LINE = cadfit.BSpline([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], [0, 0, 0, 0, 1, 1, 1, 1])

NUMBERS = {
    "tolerance": [
        lambda x: cadfit.fit(POINTS, x),
        lambda x: cadfit.arcs(POINTS, x),
        lambda x: cadfit.find_corners(POINTS, x),
        lambda x: cadfit.tube(LINE, 0.1, tolerance=x),
    ],
    "largest radius": [lambda x: cadfit.arcs(POINTS, 0.1, max_radius=x)],
    "angle of corners": [lambda x: cadfit.fit(POINTS, 0.1, corners=x)],
    "tension": [lambda x: cadfit.cardinal_spline(POINTS, tension=x)],
    "curvature": [lambda x: cadfit.cardinal_spline(POINTS, curvature=x)],
    "fraction": [
        lambda x: cadfit.dominant_points(POINTS, fraction=x),
        lambda x: cadfit.fit_dominant(POINTS, fraction=x),
    ],
    "square error": [lambda x: cadfit.dominant_points(POINTS, square_error=x)],
    "radius": [lambda x: cadfit.tube(LINE, x)],
    "knot": [LINE.insert_knot],
    "parameter": [LINE.split],
    "accuracy": [LINE.length],
}

TABLES = {
    "points": [cadfit.polyline, LINE.nearest, lambda x: cadfit.fit(x, 0.1), cadfit.c2_spline],
    "poles": [lambda x: cadfit.periodic(x, [0, 1, 2, 3]), lambda x: cadfit.BSpline(x, LINE.knots)],
    "knots": [lambda x: cadfit.BSpline(LINE.poles, x)],
    "pieces": [cadfit.pieces_to_spline],
    "parameters": [LINE, lambda x: cadfit.frames(LINE, x)],
    "matrix": [LINE.transformed],
    "weights": [lambda x: cadfit.fit(POINTS, 0.1, weights=x)],
    "end tangents": [lambda x: cadfit.interpolate(POINTS, end_tangents=x)],
    "tolerances": [lambda x: cadfit.fit_many([POINTS, POINTS], x)],
}


def each(table):
    return [pytest.param(name, call, id=f"{name} {k}") for name, calls in table.items() for k, call in enumerate(calls)]


@pytest.mark.parametrize(
    "value", ["0.1", "big", {}, 1j, np.complex128(1j), object()], ids=lambda value: type(value).__name__
)
@pytest.mark.parametrize(("name", "call"), each(NUMBERS))
def test_what_is_no_number(name, call, value):
    if name != "angle of corners" or not isinstance(value, str):  # there text is a way to find them
        with pytest.raises(TypeError, match=f"the {name} must be a number, not"):
            call(value)


@pytest.mark.parametrize(("name", "call"), each(TABLES))
def test_what_is_no_table_of_numbers(name, call):
    name = "pieces" if call is cadfit.c2_spline else name
    with pytest.raises(ValueError, match=rf"row 1 of the {name} has 1 numbers, the rows before it 2: \[3\]"):
        call([[0, 1], [3], [4, 5]])
    with pytest.raises(ValueError, match=rf"row 2 of the {name} is not a row of numbers: \['x', 5\]"):
        call([[0, 1], [3, 4], ["x", 5]])


def test_polyline_names_the_row_that_is_not_finite():
    with pytest.raises(ValueError, match=r"row 1 of the points is not finite: \[1.0, inf\]"):
        cadfit.polyline([(0, 0), (1, np.inf), (2, 0)])
