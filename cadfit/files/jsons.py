"""Points and curves as JSON; numbers by repr, so every float64 reads back bit for bit.

A curve file is {"cadfit": 1, "curves": [{"degree": 3, "poles": [[...], ...], "knots": [...]}, ...], "closed": ...,
"deviation": {"points": ..., "between": ..., "rms": ..., "worst": ...} or null}, where they have names with "names":
["...", ...]; a point file a list of rows, or {"points": [rows]}.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from cadfit.bezier import Array
from cadfit.bspline import DEGREE, BSpline
from cadfit.files.curves import Curves
from cadfit.files.table import as_table
from cadfit.fitting.deviation import Deviation

VERSION = 1


def read(path: Path, unit: str) -> Array | Curves:
    """Return the points (n, d) or the `Curves` of a JSON file.

    Raises ValueError naming what is wrong: no JSON, neither of the two, a row that is not numbers.
    """
    try:
        # Whole numbers become floats at once, so one too large for a float is infinite, and refused as that.
        content = json.loads(path.read_bytes(), parse_int=float)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path}: not a readable .json file: {error}") from error
    if isinstance(content, dict) and "cadfit" in content:
        try:
            return _curves(content)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error
    rows = content.get("points") if isinstance(content, dict) else content
    if not isinstance(rows, list):
        raise ValueError(f'{path}: neither points (a list of rows, or "points") nor curves ("cadfit": {VERSION})')
    for k, row in enumerate(rows):
        if not isinstance(row, list) or not all(type(value) is float for value in row):
            raise ValueError(f"{path}: row {k} of the points is not a row of numbers: {_short(row)}")
    return as_table(rows, str(path))


def write(path: Path, result: Array | Curves, unit: str) -> None:
    """Write points as {"points": rows}, curves as the curve file above."""
    content: dict[str, Any]
    if isinstance(result, Curves):
        curves = [{"degree": DEGREE, "poles": c.poles.tolist(), "knots": c.knots.tolist()} for c in result.curves]
        content = {"cadfit": VERSION, "curves": curves, "closed": result.closed, "deviation": None}
        if (d := result.deviation) is not None:
            numbers = {"points": float(d.points), "between": float(d.between), "rms": float(d.rms)}
            content["deviation"] = {**numbers, "worst": int(d.worst)}
        if result.names:
            content["names"] = list(result.names)
    else:
        content = {"points": result.tolist()}
    path.write_text(json.dumps(content, allow_nan=False) + "\n", encoding="utf-8")


def _curves(content: dict[str, Any]) -> Curves:
    if content["cadfit"] != VERSION:
        raise ValueError(f'"cadfit" is {_short(content["cadfit"])}; this program reads {VERSION}')
    curves, closed = content.get("curves"), content.get("closed")
    if not isinstance(curves, list) or not all(isinstance(curve, dict) for curve in curves):
        raise ValueError(f'"curves" must be a list of curves, not {_short(curves)}')
    if not isinstance(closed, bool):
        raise ValueError(f'"closed" must be true or false, not {_short(closed)}')
    names = content.get("names", [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ValueError(f'"names" must be a list of strings, not {_short(names)}')
    splines = tuple(_curve(k, each) for k, each in enumerate(curves))
    return Curves(splines, closed, _deviation(content.get("deviation")), tuple(names))


def _curve(k: int, content: dict[str, Any]) -> BSpline:
    if content.get("degree") != DEGREE:
        raise ValueError(f"curve {k}: the degree must be {DEGREE}, not {_short(content.get('degree'))}")
    poles, knots = content.get("poles"), content.get("knots")
    if not isinstance(poles, list) or not all(isinstance(pole, list) for pole in poles):
        raise ValueError(f'curve {k}: "poles" must be a list of rows, not {_short(poles)}')
    if not isinstance(knots, list):
        raise ValueError(f'curve {k}: "knots" must be a list of numbers, not {_short(knots)}')
    for value in (value for row in (*poles, knots) for value in row):
        if type(value) is not float:
            raise ValueError(f"curve {k}: {_short(value)} is not a number")
    try:
        return BSpline(poles, knots)  # type: ignore[arg-type]  # copied in and checked there
    except ValueError as error:
        raise ValueError(f"curve {k}: {error}") from error


def _deviation(content: Any) -> Deviation | None:
    if content is None:
        return None
    names = ("points", "between", "rms", "worst")
    if not isinstance(content, dict) or not all(_is_finite(content.get(name)) for name in names):
        raise ValueError(f'"deviation" must have the numbers {", ".join(names)}, not {_short(content)}')
    return Deviation(content["points"], content["between"], content["rms"], int(content["worst"]))


def _is_finite(value: Any) -> bool:
    return type(value) is float and math.isfinite(value)


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:60]}..."
