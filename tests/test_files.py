import json
import os
import zipfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from cadfit import BSpline, Deviation, cardinal_spline, local_spline
from cadfit.files import FORMATS, Curves, check, read, write
from cadfit.files import text as text_module
from cadfit.files.facts import facts

import corpus_data

POINT_SUFFIXES = [".csv", ".txt", ".xyz", ".npy", ".npz", ".json"]

finite = st.floats(allow_nan=False, allow_infinity=False)
point_arrays = arrays(np.float64, array_shapes(min_dims=2, max_dims=2, min_side=2, max_side=8), elements=finite)


@st.composite
def splines(draw, dimension=None):
    d = dimension or draw(st.integers(1, 5))
    n = draw(st.integers(2, 9))
    points = draw(arrays(np.float64, (n, d), elements=st.floats(-1e6, 1e6)))
    return cardinal_spline(points, draw(st.floats(0.1, 1.0)), draw(st.floats(0.0, 1.0)))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("files")


def write_read(path, result):
    write(path, result)
    return read(path)


def read_text(tmp_path, content, suffix=".csv"):
    path = tmp_path / f"in{suffix}"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read(path).tolist()


@pytest.mark.parametrize("suffix", POINT_SUFFIXES)
@given(points=point_arrays)
@settings(max_examples=40, deadline=None)
def test_points_read_back_bit_for_bit(folder, suffix, points):
    back = write_read(folder / f"points{suffix}", points)
    assert back.dtype == np.float64
    assert back.tobytes() == points.tobytes()  # the sign of a zero too


@pytest.mark.parametrize("suffix", POINT_SUFFIXES)
def test_suffixes_in_capitals_write_the_same(tmp_path, suffix):
    points = np.array([[0.0, 1.0], [2.0, 3.0]])
    assert np.array_equal(write_read(tmp_path / f"A{suffix.upper()}", points), points)
    assert [path.name for path in tmp_path.iterdir()] == [f"A{suffix.upper()}"]


@given(curves=st.lists(splines(dimension=3), min_size=1, max_size=3), closed=st.booleans(), away=st.none() | finite)
@settings(max_examples=60, deadline=None)
def test_curves_read_back_bit_for_bit_from_json(folder, curves, closed, away):
    deviation = None if away is None else Deviation(away, away / 3, 1 / 3, 7)
    back = write_read(folder / "curves.json", Curves(tuple(curves), closed, deviation))
    assert back.closed is closed
    for before, after in zip(curves, back.curves, strict=True):
        assert after.poles.tobytes() == before.poles.tobytes()
        assert after.knots.tobytes() == before.knots.tobytes()
    if deviation is None:
        assert back.deviation is None
    else:
        for name in ("points", "between", "rms", "worst"):
            assert getattr(back.deviation, name) == getattr(deviation, name)


def test_names_of_curves_read_back_from_json(tmp_path):
    curves = (cardinal_spline([[0, 0], [1, 2], [3, 3]]), cardinal_spline([[0, 0], [1, 2], [4, 3]]))
    assert write_read(tmp_path / "a.json", Curves(curves, False, names=("hölle", ""))).names == ("hölle", "")
    assert write_read(tmp_path / "a.json", Curves(curves, False)).names == ()
    assert "names" not in json.loads((tmp_path / "a.json").read_text()), "as files without names always were"
    content = json.loads((tmp_path / "a.json").read_text())
    for names, expected in (
        (["a"], "2 curves need as many names or none, not 1"),
        (["a", 3], '"names" must be a list'),
    ):
        (tmp_path / "a.json").write_text(json.dumps(content | {"names": names}))
        with pytest.raises(ValueError, match=expected):
            read(tmp_path / "a.json")


@given(curve=splines())
@settings(max_examples=30, deadline=None)
def test_one_curve_of_any_dimension_is_written_as_it_is(folder, curve):
    back = write_read(folder / "one.json", curve)
    assert back.closed == curve.closed
    assert back.curves[0].isclose(curve, 0.0)


def test_the_curve_file_is_as_documented(tmp_path):
    curve = cardinal_spline([[0, 0], [1, 2], [3, 3]])
    write(tmp_path / "a.json", Curves((curve,), False, Deviation(0.0, 0.5, 0.0, 2)))
    content = json.loads((tmp_path / "a.json").read_text())
    assert content == {
        "cadfit": 1,
        "curves": [{"degree": 3, "poles": curve.poles.tolist(), "knots": curve.knots.tolist()}],
        "closed": False,
        "deviation": {"points": 0.0, "between": 0.5, "rms": 0.0, "worst": 2},
    }


def test_csv_of_curves_holds_the_poles(tmp_path):
    curves = [cardinal_spline([[0, 0], [1, 2], [3, 3]]), cardinal_spline([[3, 3], [1, 0.1]])]
    back = write_read(tmp_path / "poles.csv", curves)
    assert np.array_equal(back, np.concatenate([curve.poles for curve in curves]))
    text = (tmp_path / "poles.csv").read_text()
    assert text.startswith("x,y\n0.0,0.0\n")
    assert "\n\n" in text


def test_a_sequence_of_curves_that_returns_is_closed(tmp_path):
    there, back = cardinal_spline([[0, 0], [1, 2], [3, 3]]), cardinal_spline([[3, 3], [0, 0]])
    assert write_read(tmp_path / "a.json", [there, back]).closed
    assert not write_read(tmp_path / "a.json", (there,)).closed


def test_whatever_has_curves_is_written(tmp_path):
    fit = SimpleNamespace(curves=[cardinal_spline([[0, 0], [1, 2], [3, 3]])], closed=False, deviation=None)
    assert len(write_read(tmp_path / "a.json", fit).curves) == 1


def test_curves_have_one_dimension():
    with pytest.raises(ValueError, match=r"one dimension, not \[1, 2\]"):
        Curves((cardinal_spline([[0], [1]]), cardinal_spline([[0, 0], [1, 1]])), False)
    with pytest.raises(ValueError, match="at least one curve"):
        Curves((), False)


READABLE = {
    "commas and names": (".csv", "x,y,z\n1,2,3\n4,5,6\n", [[1, 2, 3], [4, 5, 6]]),
    "commas and blanks": (".csv", "1, 2\n 3 ,\t4\n", [[1, 2], [3, 4]]),
    "semicolons": (".csv", "x;y\n1.5;2\n3;4\n", [[1.5, 2], [3, 4]]),
    "decimal commas": (".csv", '"x";"y"\n1,5;-2,5e1\n3;4\n', [[1.5, -25], [3, 4]]),
    "decimal commas from the second row": (".csv", "1;2\n1,5;2,5\n", [[1, 2], [1.5, 2.5]]),
    "decimal commas and tabs": (".txt", "1,5\t2,5\n3,25\t4\n", [[1.5, 2.5], [3.25, 4]]),
    "tabs": (".txt", "1\t2\n3\t4\n", [[1, 2], [3, 4]]),
    "blanks": (".txt", "   1.0   2.0\n  -3.0  +4.\n", [[1, 2], [-3, 4]]),
    "byte order mark, CRLF": (".csv", b"\xef\xbb\xbfx,y\r\n1,2\r\n3,4\r\n", [[1, 2], [3, 4]]),
    "CR alone": (".csv", b"1,2\r3,4\r", [[1, 2], [3, 4]]),
    "UTF-16 of a spreadsheet": (".txt", "x\ty\n1\t2\n".encode("utf-16"), [[1, 2]]),
    "latin-1 names": (".csv", "Länge,Höhe\n1,2\n".encode("latin-1"), [[1, 2]]),
    "end-of-file mark": (".dat", b"1 2\n3 4\n\x1a", [[1, 2], [3, 4]]),
    "comments": (".txt", "# a\n% b\n// c\n1 2 # first\n\n#\n3 4\n", [[1, 2], [3, 4]]),
    "separators at the end": (".csv", "x,y,\n1,2,\n3,4,\n", [[1, 2], [3, 4]]),
    "one separator at the end": (".csv", "1,2\n3,4,,\n", [[1, 2], [3, 4]]),
    "Fortran exponents": (".txt", "1.0D-03 2.0d+1\n1 2E2\n", [[1e-3, 20], [1, 200]]),
    "quoted": (".csv", '"1.5","2"\n"3","4"\n', [[1.5, 2], [3, 4]]),
    "quoted decimal commas": (".csv", 'x,y\n"1,5","-2,5"\n"3",4\n', [[1.5, -2.5], [3, 4]]),
    "rows a spreadsheet leaves": (".csv", ",,\nx,y,\n1,2,\n,,\n3,4,\n;\n", [[1, 2], [3, 4]]),
    "date above": (".txt", "2024-01-31\n1 2\n", [[1, 2]]),
    "count and a time": (".xyz", "1\n0.5 7\n0 1 2\n", [[0, 1, 2]]),
    "title, names, units": (".csv", "Log of flight 7\nx,y\nmm,mm\n1,2\n", [[1, 2]]),
    "eight columns": (".csv", "1,2,3,4,5,6,7,8\n", [[1, 2, 3, 4, 5, 6, 7, 8]]),
    "Selig airfoil": (".dat", "NACA 2412\n 1.0 0.1\n 0.0 0.0\n 1.0 -0.1\n", [[1, 0.1], [0, 0], [1, -0.1]]),
    "airfoil in per cent": (".dat", "E 1\n 100 20\n 0 0\n 100 -20\n", [[100, 20], [0, 0], [100, -20]]),
    "molecule": (".xyz", "2\nwater -0.5 1.0 3.0\nO 0.0 1.0 2.0\nH1 3.0 4.0 5.0\n", [[0, 1, 2], [3, 4, 5]]),
    "molecule, empty comment": (".xyz", "2\n\nC 0.0 1.0 2.0\nH 3.0 4.0 5.0\n", [[0, 1, 2], [3, 4, 5]]),
    "count and numbers": (".xyz", "2\n0 1 2\n3 4 5\n", [[0, 1, 2], [3, 4, 5]]),
    "names above blanks": (".txt", "x [m] y [m]\n1 2\n", [[1, 2]]),
    "scan without count": (".xyz", "0 1 2\n3 4 5\n", [[0, 1, 2], [3, 4, 5]]),
}


@pytest.mark.parametrize("case", READABLE)
def test_text_as_people_have_it(tmp_path, case):
    suffix, content, rows = READABLE[case]
    assert read_text(tmp_path, content, suffix) == rows


LEDNICER = "Some airfoil 12\n  3.  4.\n\n 0.0 0.0\n 0.5 0.1\n 1.0 0.01\n\n 0.0 0.0\n 0.2 -0.1\n 0.5 -0.1\n 1.0 -0.01\n"


def test_lednicer_airfoil_becomes_one_contour(tmp_path):
    contour = [[1, 0.01], [0.5, 0.1], [0, 0], [0.2, -0.1], [0.5, -0.1], [1, -0.01]]
    assert read_text(tmp_path, LEDNICER, ".dat") == contour
    assert read_text(tmp_path, LEDNICER.replace("\n\n", "\n"), ".dat") == contour
    assert read_text(tmp_path, LEDNICER, ".txt") == contour


def test_lednicer_sides_that_start_apart_keep_both_points(tmp_path):
    apart = LEDNICER.replace("0.0 0.0\n 0.2", "0.0 -0.001\n 0.2")
    assert len(read_text(tmp_path, apart, ".dat")) == 7


MALFORMED = {
    "text in a number column": (".csv", "x,y\n1,2\n3,abc\n", "line 3: 'abc' is not a number in '3,abc'"),
    "text in the first row": (".csv", "x,y\n1,abc\n3,4\n", "line 2: 'abc' is not a number"),
    "text in the first row of .txt": (".txt", "1.0 abc\n3 4\n", "line 1: 'abc' is not a number"),
    "text below": (".txt", "1 2\nend of part\n", "line 2: 'end' is not a number"),
    "ragged": (".csv", "x,y,z\n1,2,3\n\n4,5\n", "line 4: 2 numbers, not 3 as in the first row, in '4,5'"),
    "too long": (".txt", "1 2\n4 5 6\n", "line 2: 3 numbers, not 2"),
    "not a number": (".csv", "1,2\n# c\n3,nan\n", "line 3: a number that is not finite in '3,nan'"),
    "not a number first": (".csv", "nan,nan\n1,2\n", "line 1: a number that is not finite"),
    "infinite": (".txt", "1 2\n-inf 3\n", "line 2: a number that is not finite"),
    "too large": (".txt", "1 2\n1e999 3\n", "line 2: a number that is not finite"),
    "missing words": (".csv", "N/A,N/A\n1,2\n", "line 1: 'N/A' is not a number"),
    "empty cell": (".csv", "1,2,3\n1,,3\n", "line 2: an empty cell in '1,,3'"),
    "empty last cell": (".csv", "1,2,3\n1,2,\n", "line 2: 2 numbers, not 3"),
    "row numbers": (".csv", ",x,y\n0,1.5,2\n", "line 1: the first column has no name"),
    "underscore": (".csv", "1,2\n1_000,2\n", "line 2: '1_000' is not a number"),
    "other digits": (".txt", "1 2\n\u0663 4\n", "line 2: '\u0663' is not a number"),
    "other digits first": (".csv", "\u0663,\u0664\n3,4\n", "line 1: '\u0663' is not a number"),
    "thousands first": (".csv", "x;y\n1.234,5;2.345,6\n999,5;3\n", "line 2: '1.234.5' is not a number"),
    "minus signs first": (".csv", "\u22121,\u22122\n3,4\n", "line 1: '\u22121' is not a number"),
    "quoted thousands": (".csv", '"1,234.5","2"\n3,4\n', "line 1: '1.234.5' is not a number"),
    "below empty rows": (".csv", "1,2\n,\n3,4\nnan,3\n", "line 4: a number that is not finite"),
    "names of rows": (".csv", "id,x,y\nA,1,2\n", "no rows of numbers in it: line 2 is 'A,1,2'"),
    "count below the rows": (".xyz", "2\n0 1 2\n3 4 5\n6 7 8\n", "line 1: a count that is not the number of rows"),
    "hexadecimal": (".txt", "1 2\n0x10 4\n", "line 2: '0x10' is not a number"),
    "thousands": (".csv", "1;2\n1,000.5;4\n", "line 2: '1.000.5' is not a number"),
    "one column": (".csv", "x\n1\n2\n", "line 2: a single number, where points have 2 to 8, in '1'"),
    "whole numbers alone": (".txt", "2\n3\n4\n", "line 1: a single number"),
    "nine columns": (".csv", "1,2,3,4,5,6,7,8,9\n", "points have 2 to 8 coordinates, not 9"),
    "empty": (".csv", "", "no rows of numbers"),
    "names alone": (".csv", "x,y\n", "no rows of numbers"),
    "binary": (".csv", bytes(range(256)), "not a text file"),
    "binary without zeros": (".csv", b"\x89PNG\r\n\x1a\n\x05" * 9, "not a text file"),
    "bad count": (".xyz", "3\nc\nC 1 2 3\nH 1 2 3\n", "line 1: a count that is not the number of rows below, in '3'"),
    "several frames": (".xyz", "1\nc\nC 1 2 3\n1\nc\nC 1 2 4\n", "line 1: a count that is not the number of rows"),
    "symbol missing": (".xyz", "C 1 2 3\n1 2 3\n", "line 2: no element symbol and numbers"),
    "Lednicer counts": (
        ".dat",
        LEDNICER.replace("3. ", "5. "),
        "line 2: counts 5 and 4 of two sides, but 7 rows below",
    ),
    "flaps": (".dat", "A\n1 0\n0 0\n999.0 999.0\n1 0\n", "line 4: 999 999 parts the elements"),
    "no JSON": (".json", "{'a': 1}", "not a readable .json file: Expecting property name"),
    "deep JSON": (".json", "[" * 100_000, "not a readable .json file"),
    "JSON of something": (".json", '{"a": 1}', "neither points"),
    "JSON word": (".json", "[[1, 2], [3, true]]", "row 1 of the points is not a row of numbers: [3.0, True]"),
    "JSON text": (".json", '[[1, 2], [3, "4"]]', "row 1 of the points is not a row of numbers: [3.0, '4']"),
    "JSON ragged": (".json", "[[1, 2], [3]]", "row 1 of the points has 1 numbers"),
    "JSON NaN": (".json", "[[1, 2], [3, NaN]]", "row 1 of the points is not finite"),
    "JSON huge": (".json", f"[[1, 2], [3, {10**400}]]", "row 1 of the points is not finite"),
    "JSON empty": (".json", "[]", "(n, d)"),
    "JSON not UTF-8": (".json", b"\xff\xff\xff\xff", "not a readable .json file"),
    "newer curves": (".json", '{"cadfit": 2}', '"cadfit" is 2.0; this program reads 1'),
    "no curves": (".json", '{"cadfit": 1, "curves": [], "closed": true}', "at least one curve"),
    "curves of something": (".json", '{"cadfit": 1, "curves": 3, "closed": true}', '"curves" must be a list'),
    "closed of something": (".json", '{"cadfit": 1, "curves": [], "closed": 3}', '"closed" must be true or false'),
    "NPY of nothing": (".npy", b"", "not a readable .npy file"),
    "NPY garbage": (".npy", b"\x93NUMPY garbage", "not a readable .npy file"),
    "NPZ garbage": (".npz", b"PK\x03\x04 garbage", "not a readable .npz file"),
    **{f"{s} garbage": (s, b"\x00\xff\x01 garbage" * 20, f"in{s}: ") for s in (".stl", ".3mf", ".ply", ".glb", ".obj")},
    "STL of nothing": (".stl", b"", "no faces in it"),
}


@pytest.mark.parametrize("case", MALFORMED)
def test_what_cannot_be_read_is_named(tmp_path, case):
    suffix, content, expected = MALFORMED[case]
    with pytest.raises(ValueError, match=r"in\.") as caught:
        read_text(tmp_path, content, suffix)
    message = str(caught.value)
    assert message.startswith(f"{tmp_path / 'in'}{suffix}: ")
    assert expected in message


CURVE = {"degree": 3, "poles": [[0.0], [1.0], [2.0], [3.0]], "knots": [0.0, 0, 0, 0, 1, 1, 1, 1]}


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"degree": 5}, "curve 0: the degree must be 3, not 5.0"),
        ({"poles": None}, 'curve 0: "poles" must be a list of rows, not None'),
        ({"poles": [[0.0], [1.0], ["2"], [3.0]]}, "curve 0: '2' is not a number"),
        ({"poles": [[0.0], [1.0], [], [3.0]]}, "curve 0: row 2 of the poles has 0 numbers, the rows before it 1"),
        ({"poles": [[0.0], [1.0], [float("inf")], [3.0]]}, "curve 0: poles must be finite: entry (2, 0) is inf"),
        ({"knots": 4}, 'curve 0: "knots" must be a list of numbers, not 4.0'),
        ({"knots": [0.0] * 8}, "curve 0: the first and the last knot"),
    ],
)
def test_a_bad_curve_is_named(tmp_path, change, expected):
    content = {"cadfit": 1, "curves": [CURVE | change], "closed": False}
    (tmp_path / "a.json").write_text(json.dumps(content))
    with pytest.raises(ValueError, match=r"a\.json: curve 0") as caught:
        read(tmp_path / "a.json")
    assert expected in str(caught.value)


def test_a_bad_deviation_is_named(tmp_path):
    content = {"cadfit": 1, "curves": [CURVE], "closed": False, "deviation": {"points": 1, "between": 2, "rms": 3}}
    (tmp_path / "a.json").write_text(json.dumps(content))
    with pytest.raises(ValueError, match='"deviation" must have the numbers points, between, rms, worst'):
        read(tmp_path / "a.json")


@given(
    content=st.binary(max_size=60),
    suffix=st.sampled_from([s for s, form in FORMATS.items() if form.module != "kernel"]),
)
@settings(max_examples=300, deadline=None)
def test_no_bytes_bring_anything_but_a_result_or_a_value_error(folder, content, suffix):
    path = folder / f"any{suffix}"
    path.write_bytes(content)
    said = ""
    try:
        read(path)
    except ValueError as error:
        said = str(error)
    assert said == "" or said.startswith(f"{path}: ")


def test_the_slow_and_the_fast_reading_agree(tmp_path, monkeypatch):
    points = np.random.default_rng(1).normal(size=(50, 3)) * 10.0 ** np.arange(-200, 300, 10)[:, None]
    write(tmp_path / "a.csv", points)

    def refuse(*_, **__):
        raise ValueError

    monkeypatch.setattr(text_module.np, "loadtxt", refuse)
    assert np.array_equal(read(tmp_path / "a.csv"), points)


def test_the_points_of_an_npz(tmp_path):
    table, other = np.arange(6).reshape(3, 2), np.zeros((2, 2))
    np.savez(tmp_path / "a.npz", name="a", table=table)
    assert np.array_equal(read(tmp_path / "a.npz"), table)
    np.savez(tmp_path / "b.npz", points=table, other=other)
    assert np.array_equal(read(tmp_path / "b.npz"), table)
    np.savez(tmp_path / "c.npz", table=table, other=other)
    with pytest.raises(ValueError, match=r'Call one "points"; there are: table \(3, 2\), other \(2, 2\)'):
        read(tmp_path / "c.npz")
    with zipfile.ZipFile(tmp_path / "d.npz", "w") as archive:
        archive.writestr("readme.txt", "no arrays")
    with pytest.raises(ValueError, match="which array"):
        read(tmp_path / "d.npz")


def test_broken_archives_are_named(tmp_path):
    rng = np.random.default_rng(1)
    np.savez_compressed(tmp_path / "a.npz", points=rng.normal(size=(200, 2)))
    np.save(tmp_path / "a.npy", rng.normal(size=(200, 2)))
    for suffix, places in ((".npz", range(60, 800, 20)), (".npy", range(128))):
        refused = 0
        whole = (tmp_path / f"a{suffix}").read_bytes()
        for k in places:
            (tmp_path / f"b{suffix}").write_bytes(whole[:k] + bytes(rng.integers(0, 256, 9, np.uint8)) + whole[k + 9 :])
            try:
                read(tmp_path / f"b{suffix}")
            except ValueError as error:
                assert f"b{suffix}: " in str(error)  # noqa: PT017  other bytes may well be read, as other numbers
                refused += 1
        assert refused > len(places) / 2


@pytest.mark.parametrize(
    ("array", "expected"),
    [
        (np.array([[1, "a"]], dtype=object), "not a readable .npy file: Object arrays cannot be loaded"),
        (np.array([["1", "2"]]), "whole or real numbers, not <U1"),
        (np.ones((2, 2), dtype=complex), "whole or real numbers, not complex128"),
        (np.ones((2, 2, 2)), "not (2, 2, 2)"),
        (np.ones(4), "not (4,)"),
        (np.ones((2, 9)), "2 to 8 coordinates, not 9"),
        (np.array([[0, 1], [2, np.nan]]), "row 1 of the points is not finite: [2.0, nan]"),
    ],
)
def test_arrays_that_are_no_points(tmp_path, array, expected):
    np.save(tmp_path / "a.npy", array, allow_pickle=True)
    with pytest.raises(ValueError, match=r"a\.npy: ") as caught:
        read(tmp_path / "a.npy")
    assert expected in str(caught.value)


@pytest.fixture(scope="module")
def mesh():
    return trimesh.creation.cylinder(1.0, 3.0, sections=24)


@pytest.mark.parametrize("suffix", [".stl", ".3mf", ".ply", ".glb", ".obj"])
def test_meshes_come_back_watertight(tmp_path, mesh, suffix):
    back = write_read(tmp_path / f"m{suffix}", mesh)
    assert back.is_watertight
    assert len(back.faces) == len(mesh.faces)
    single = suffix in (".stl", ".ply", ".glb")
    assert back.volume == pytest.approx(mesh.volume, rel=1e-6 if single else 1e-14)
    assert list(tmp_path.iterdir()) == [tmp_path / f"m{suffix}"]  # nothing beside it: materials, textures


def test_a_mesh_that_is_cut_short_is_said_to_be(tmp_path, mesh):
    write(tmp_path / "m.stl", mesh)
    (tmp_path / "m.stl").write_bytes((tmp_path / "m.stl").read_bytes()[:-20])
    with pytest.raises(ValueError, match=r"m\.stl: not a readable \.stl file") as caught:
        read(tmp_path / "m.stl")
    assert "charset" not in str(caught.value)


def test_a_mesh_that_32_bits_cannot_hold_is_refused(tmp_path, mesh):
    far = mesh.copy()
    far.apply_translation([6.4e6 * 16, 0, 0])
    for suffix in (".stl", ".ply", ".glb"):
        with pytest.raises(ValueError, match=rf"m\{suffix}: \{suffix} holds 32-bit numbers, in which \d+ of 50"):
            write(tmp_path / f"m{suffix}", far)
    assert not list(tmp_path.iterdir())
    for suffix in (".3mf", ".obj"):
        assert write_read(tmp_path / f"m{suffix}", far).is_watertight


def test_a_tiny_mesh_keeps_its_shape_in_obj(tmp_path, mesh):
    tiny = mesh.copy()
    tiny.apply_scale(1e-7)
    assert np.allclose(write_read(tmp_path / "m.obj", tiny).bounds, tiny.bounds, rtol=1e-12, atol=0)


def test_suffixes_are_said(tmp_path):
    curve = cardinal_spline([[0, 0], [1, 2], [3, 3]])
    with pytest.raises(ValueError, match=r"a\.stl: \.stl does not hold curves; these do: \.csv \.json \.dxf"):
        write(tmp_path / "a.stl", curve)
    with pytest.raises(ValueError, match=r"\.dat does not hold points; these do: \.csv \.txt"):
        write(tmp_path / "a.dat", [[0, 0], [1, 1]])
    with pytest.raises(ValueError, match=r"unknown suffix '\.foo'; known are \.csv"):
        write(tmp_path / "a.foo", curve)
    with pytest.raises(ValueError, match="unknown suffix ''"):
        read(tmp_path / "a")
    with pytest.raises(ValueError, match=r"\.step holds curves of 2 to 3 coordinates, not 4; \.json does"):
        check("a.step", "curves", 4)
    with pytest.raises(ValueError, match=r"a\.csv: points must have the shape"):
        write(tmp_path / "a.csv", 3.0)
    assert write_read(tmp_path / "A.JSON", curve).curves[0].isclose(curve, 0.0)


def test_files_that_are_not_there_or_folders(tmp_path):
    with pytest.raises(FileNotFoundError):
        read(tmp_path / "none.csv")
    with pytest.raises(FileNotFoundError):
        read(tmp_path / "none.stl")
    with pytest.raises(IsADirectoryError):
        read(tmp_path)
    with pytest.raises(FileNotFoundError) as caught:
        write(tmp_path / "none" / "a.csv", [[0, 0], [1, 1]])
    assert caught.value.filename == str(tmp_path / "none" / "a.csv")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(IsADirectoryError):
        write(tmp_path / "folder.csv", [[0, 0], [1, 1]])
    assert [path.name for path in tmp_path.iterdir()] == ["folder.csv"]


class Broken:
    """A mesh whose writer does half its work, then fails."""

    vertices = np.zeros((1, 3))
    faces = np.zeros((0, 3), dtype=int)

    def __init__(self, failure):
        self.failure = failure

    def export(self, path, **_):
        Path(path).write_bytes(b"half")
        raise self.failure


@pytest.mark.parametrize("failure", [RuntimeError("bug"), KeyboardInterrupt(), OSError(28, "No space left on device")])
@pytest.mark.parametrize("old", [None, b"old"])
def test_a_writer_that_fails_midway_leaves_the_old_file(tmp_path, failure, old):
    path = tmp_path / "m.stl"
    if old is not None:
        path.write_bytes(old)
    with pytest.raises(type(failure)) as caught:
        write(path, Broken(failure))
    assert [p.name for p in tmp_path.iterdir()] == (["m.stl"] if old else [])
    assert old is None or path.read_bytes() == old
    if isinstance(failure, OSError):
        assert caught.value.filename == str(path)
        assert caught.value.strerror == "No space left on device"


def test_a_number_json_has_no_word_for_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.json"
    path.write_text("old")
    curve = cardinal_spline([[0, 0], [1, 2], [3, 3]])
    with pytest.raises(ValueError, match=r"a\.json: Out of range float values"):
        write(path, Curves((curve,), False, Deviation(float("nan"), 0.0, 0.0, 0)))
    assert path.read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.skipif(os.name != "posix", reason="links and permissions of POSIX")
def test_links_and_permissions_stay(tmp_path):
    target, link = tmp_path / "target.csv", tmp_path / "link.csv"
    target.write_text("old")
    target.chmod(0o640)
    link.symlink_to(target.name)
    write(link, [[0, 0], [1, 1]])
    assert link.is_symlink()
    assert target.read_text().startswith("x,y\n")
    assert target.stat().st_mode & 0o777 == 0o640
    target.chmod(0o440)
    if not os.access(target, os.W_OK):  # the super-user may write all the same
        with pytest.raises(PermissionError):
            write(target, [[0, 0], [2, 2]])


def test_facts_box_is_that_of_the_curve():
    arch = BSpline([[0, 0], [0, 4], [4, 4], [4, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    said = facts(Curves((arch,), False))
    assert (said["from"], said["to"], said["continuity"]) == ("0 0", "4 3", "smooth")
    rng = np.random.default_rng(3)
    curve = local_spline(rng.normal(size=(30, 3)))
    said = facts(Curves((curve,), False))
    dense = curve(np.linspace(*curve.domain, 200_001))
    assert np.allclose([float(x) for x in said["from"].split()], dense.min(axis=0), atol=1e-6)
    assert np.allclose([float(x) for x in said["to"].split()], dense.max(axis=0), atol=1e-6)
    assert said["continuity"] == "C2"


@pytest.mark.parametrize("shape", corpus_data.shapes(per_family=1))
def test_real_points_go_and_come(tmp_path, shape):
    for suffix in POINT_SUFFIXES if shape.points.shape[1] > 1 else []:
        assert np.array_equal(write_read(tmp_path / f"points{suffix}", shape.points), shape.points)
    curve = local_spline(shape.points, shape.closed)
    assert write_read(tmp_path / "curve.json", curve).curves[0].isclose(curve, 0.0)
