"""The page of a report: its words and figures around what `view.js` and its neighbours draw."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Sequence
from datetime import datetime
from html import escape
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from cadfit.report.data import Entry, page_data
from cadfit.stages import Progress, unheard

_SCRIPTS = ["geometry.js", "camera.js", "ground.js", "layers.js", "scene.js", "chart.js", "page.js"]
_IDLE = "Point at the view or a chart; a click keeps the place, a click in a chart goes there, Esc lets go."

_SWATCHES = {  # drawn as the view draws them
    "points": '<circle cx="6.5" cy="6.5" r="3.4" fill="{0}"/>',
    "curve": '<path d="M1 10C4 0 8 12 12 3" fill="none" stroke="{0}" stroke-width="2"/>',
    "poles": '<path d="M1 10L6.5 3 12 9" fill="none" stroke="#7b8490"/>'
    '<path d="M4.5 1h4v4h-4z" fill="none" stroke="#7b8490"/>',
    "knots": '<path d="M1 6.5h11M4 2.5v8M9 2.5v8" stroke="{0}" stroke-width="1.5"/>',
    "comb": '<path d="M1 12V5M4 11V2M7 11V1M10 12V4M12 12V6" stroke="#009E73"/>',
    "corners": '<path d="M6.5 1L12 6.5 6.5 12 1 6.5z" fill="none" stroke="currentColor" stroke-width="1.4"/>',
    "worst": '<circle cx="6.5" cy="6.5" r="5" fill="none" stroke="currentColor" stroke-width="1.6"/>',
    "deviation": '<path d="M2 11V7M6 11V1M10 11V4" stroke="#CC79A7" stroke-width="1.8"/>',
    "tolerance": '<path d="M0 6.5h5M8 6.5h5" stroke="currentColor" stroke-width="1.5"/>',
    "line": '<path d="M0 6.5h13" stroke="{0}" stroke-width="2"/>',
}


def page(
    entries: Sequence[Entry],
    title: str,
    unit: str = "",
    calls: Sequence[str] = (),
    source: Path | None = None,
    without: Sequence[str] = (),
    progress: Progress = unheard,
) -> str:
    """Return the page of one fit or several: see `cadfit.report.write`; the digest of `source` is given."""
    data = page_data(entries, unit, progress)
    here = files("cadfit.report")
    asset = {name: here.joinpath(name).read_text(encoding="utf-8") for name in ["page.html", "style.css", *_SCRIPTS]}
    several = len(entries) > 1
    made = datetime.now().astimezone().strftime("%Y-%m-%d %H:%M")
    # What is not ours is escaped here, or in JSON: names, titles, units, commands.
    return Template(asset["page.html"]).substitute(
        title=escape(title),
        version=version("cadfit"),
        style=asset["style.css"],
        side=f"{min(220 + 130 * len(entries), 620)}px" if several else "330px",
        verdict="" if several else _verdict(data["entries"][0]["figures"], unit),
        made=f"cadfit {version('cadfit')}, {made}",
        toggles=_toggles(data, several),
        views=_views(data),
        idle=_IDLE,
        unit=f" ({escape(unit)})" if unit else "",
        deviation_legend=_deviation_legend(data, several),
        curvature=_curvature(unit) if data["entries"][0]["along"]["bend"] is not None else "",
        table=_table(data, unit) + _without(without),
        notes=_notes(data),
        calls="".join(f"<pre>{escape(call)}</pre>" for call in calls) + _digest(source),
        versions=escape(_versions()),
        data=_json(data),
        script="\n".join(asset[name] for name in _SCRIPTS),
    )


def _json(data: dict[str, Any]) -> str:
    """Return JSON that can stand inside a script element: no tag, no comment can begin or end in it."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False, ensure_ascii=True)
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _swatch(kind: str, colour: str = "") -> str:
    return f'<svg class="swatch" viewBox="0 0 13 13" aria-hidden="true">{_SWATCHES[kind].format(colour)}</svg>'


def _toggle(name: str, said: str, on: bool, colour: str = "", title: str = "") -> str:
    state = f'aria-pressed="{"true" if on else "false"}" title="{escape(title)}"'
    return f'<button data-show="{name}" {state}>{_swatch(name, colour)}{said}</button>'


def _toggles(data: dict[str, Any], several: bool) -> str:
    sets, entries = data["sets"], data["entries"]
    curve = "currentColor" if several else entries[0]["colour"]
    total = sum(each["total"] for each in sets)
    poles = sum(entry["figures"]["poles"] for entry in entries)
    knots = sum(entry["figures"]["spans"] + entry["figures"]["curves"] for entry in entries)
    corners = sum(len(each["corners"]) for each in sets)

    def count(number: int) -> str:
        return "" if several else f' <span class="count">{number:,}</span>'

    found = [
        _toggle("points", f"points{count(total)}", True, "currentColor" if several else sets[0]["colour"]),
        _toggle("curve", "curve", True, curve),
        _toggle("poles", f"poles{count(poles)}", not several and poles <= 300, title="the control polygon"),
        _toggle("knots", f"knots{count(knots)}", False, curve),
    ]
    if entries[0]["along"]["bend"] is not None:
        found.append(_toggle("comb", "comb", False, title="the curvature, as teeth across the curve"))
        found.append(
            '<label data-for="comb" hidden>length <input type="range" id="comb-scale" min="-1.5" max="1.5" step="0.02" '
            'value="0" aria-label="length of the comb"></label>'
        )
    if corners:
        found.append(_toggle("corners", f"corners{count(corners)}", True))
    found.append(_toggle("worst", "farthest", True, title="the point farthest from the curve"))
    found.append(_toggle("deviation", "deviation", False, title="from the curve to each point, magnified"))
    found.append(
        '<label data-for="deviation" hidden><input type="range" id="times" min="0" max="1" step="0.01" value="0.8" '
        'aria-label="magnification"> <span id="times-said"></span></label>'
    )
    if several:
        for k, entry in enumerate(entries):
            named = _swatch("line", entry["colour"]) + escape(entry["name"])
            found.append(f'<button data-entry="{k}" aria-pressed="true">{named}</button>')
    return "".join(found)


def _views(data: dict[str, Any]) -> str:
    axes, found = data["axes"], []
    if len(axes) > 3:
        for k in range(3):
            options = "".join(
                f'<option value="{j}"{" selected" * (j == k)}>{name}</option>' for j, name in enumerate(axes)
            )
            found.append(f'<select data-axis="{k}" aria-label="coordinate {k + 1} of the view">{options}</select>')
    if len(axes) > 2:
        looks = [("iso", "3D"), ("top", "top"), ("front", "front"), ("side", "side")]
        found += [f'<button data-look="{look}">{said}</button>' for look, said in looks]
    found.append('<button id="whole" title="show all (double click)">show all</button>')
    found.append('<button id="save" title="save the view as a picture">PNG</button>')
    return "".join(found)


def _deviation_legend(data: dict[str, Any], several: bool) -> str:
    entry = data["entries"][0]
    dots, line = ("currentColor", "currentColor") if several else (data["sets"][0]["colour"], entry["colour"])
    said = [
        f"<span>{_swatch('points', dots)}at the points</span>",
        f"<span>{_swatch('line', line)}between them, from the chords</span>",
    ]
    if any(each["tolerance"] is not None for each in data["entries"]):
        said.append(f"<span>{_swatch('tolerance')}tolerance</span>")
    if entry["between"]["room"] and not several:
        said.append(f"<span>{_swatch('line', '#9aa4af')}allowed between</span>")
    return "".join(said)


def _curvature(unit: str) -> str:
    of = f" (1/{escape(unit)})" if unit else ""
    return (
        f'<section class="card chart"><h2>Curvature along the curve{of}'
        '<button data-log="curvature" aria-pressed="false" title="logarithmic, without sign">log</button></h2>'
        '<canvas id="curvature" aria-label="Curvature over the length along the curve"></canvas></section>'
    )


def _kept(figures: dict[str, Any]) -> bool | None:
    """Return whether the tolerance is kept where it is said to hold; None without one."""
    if figures["tolerance"] is None:
        return None
    polyline = figures["between"] == "polyline"
    largest = max(figures["deviation at points"], figures["deviation between"] if polyline else 0.0)
    return bool(largest <= figures["tolerance"]) and not figures["strays"]


def _verdict(figures: dict[str, Any], unit: str) -> str:
    kept, of = _kept(figures), f" {escape(unit)}" if unit else ""
    if kept is None:
        return f'<span class="verdict">no point farther than {figures["deviation at points"]:.3g}{of}: certified</span>'
    if kept:
        where = "everywhere" if figures["between"] == "polyline" else "at every point"
        return f'<span class="verdict kept">within {figures["tolerance"]:g}{of} {where}: certified</span>'
    return f'<span class="verdict broken">not within {figures["tolerance"]:g}{of}</span>'


def _table(data: dict[str, Any], unit: str) -> str:
    """Return the figures of all entries, a column each."""
    entries = data["entries"]
    several = len(entries) > 1
    of = f" {escape(unit)}" if unit else ""
    columns = [_column(k, entry["figures"], of, several) for k, entry in enumerate(entries)]
    head = ""
    if several:
        names = "".join(
            f'<th scope="col">{_swatch("line", entry["colour"])}{escape(entry["name"])}</th>' for entry in entries
        )
        head = f"<thead><tr><td></td>{names}</tr></thead>"
    rows = []
    for name in columns[0]:
        cells = "".join(column[name] for column in columns)
        if any(column[name] != "<td>–</td>" for column in columns):
            rows.append(f'<tr><th scope="row">{name}</th>{cells}</tr>')
    return (
        f'<h2>Figures</h2><table class="{"several" if several else "one"}">{head}<tbody>{"".join(rows)}</tbody></table>'
    )


def _without(lines: Sequence[str]) -> str:
    """Return what there is to say of ways that made no curve."""
    return "".join(f'<p class="broken">{escape(line)}</p>' for line in lines)


def _column(k: int, figures: dict[str, Any], unit: str, several: bool) -> dict[str, str]:
    """Return the cells of entry k, by the names of the rows."""
    tolerance = figures["tolerance"]
    near, between, radius = (figures[name] for name in ("deviation at points", "deviation between", "smallest radius"))

    def cell(text: str, small: str = "", kind: str = "") -> str:
        small = f"<small>{small}</small>" if small and not several else ""
        return f"<td{f' class={kind}' if kind else ''}>{text}{small}</td>"

    def against(value: float, holds: bool) -> tuple[str, str]:
        if tolerance is None or not holds:
            return "", ""
        return f"{100.0 * value / tolerance:.3g} % of the tolerance", "kept" if value <= tolerance else "broken"

    def go(said: str, at: str = "") -> str:
        return f'<button class="go" data-go="{k}"{at} title="show it">{said}</button>'

    share, kind = against(near, True)
    share_between, kind_between = against(between, figures["between"] == "polyline")
    if figures["strays"] is not None:
        kind_between = "broken" if figures["strays"] else "kept"
    inside = " within each curve" if figures["curves"] > 1 else ""
    at = f' data-at="{figures["smallest radius at"]!r}"'
    return {
        "points": cell(
            f"{figures['points']:,}", f"{figures['repeats']:,} repeats dropped" if figures["repeats"] else ""
        ),
        "dimension": cell(str(figures["dimension"])) if figures["dimension"] > 3 else "<td>–</td>",
        "poles": cell(f"{figures['poles']:,}", f"{figures['points'] / figures['poles']:,.1f} points a pole"),
        "spans": cell(f"{figures['spans']:,}"),
        "curves": cell(f"{figures['curves']:,}", "closed" if figures["closed"] else "open"),
        "corners": cell(f"{figures['corners']:,}"),
        "continuity": cell(f"{figures['continuity']}{inside}"),
        "tolerance": cell(f"{tolerance:g}{unit}") if tolerance is not None else "<td>–</td>",
        "off at points": cell(f"≤ {near:.4g}{unit}", " ".join([share, go(f"at point {figures['worst']}")]), kind),
        "off between points": cell(f"≤ {between:.4g}{unit}", share_between or "from their chords", kind_between),
        "no wiggle between": cell(_straying(figures["strays"])) if figures["strays"] is not None else "<td>–</td>",
        "root mean square": cell(f"{figures['rms']:.4g}{unit}"),
        "length": cell(f"{figures['length']:.7g}{unit}"),
        "smallest radius": cell(f"{radius:.4g}{unit}", go(f"at {figures['smallest radius at']:.4g}{unit}", at))
        if radius is not None
        else cell("straight")
        if figures["dimension"] > 1
        else "<td>–</td>",
        "time": cell(f"{figures['seconds']:.3g} s") if figures["seconds"] is not None else "<td>–</td>",
    }


def _straying(strays: int) -> str:
    return f"{strays:,} strays" if strays else "yes"


def _notes(data: dict[str, Any]) -> str:
    said = [
        f"Thinned for display: {len(each['rows']):,} of {each['total']:,} points are shown, of each stretch the "
        "farthest from the curve. All figures are those of all points."
        for each in data["sets"]
        if len(each["rows"]) < each["total"]
    ]
    for entry in data["entries"]:
        if not entry["poles"]:
            name = f"{escape(entry['name'])}: " if len(data["entries"]) > 1 else ""
            said.append(f"{name}{entry['figures']['poles']:,} poles are too many to show.")
        if len(entry["chain"]) < 3 * entry["figures"]["spans"]:
            said.append(f"{entry['figures']['spans']:,} spans: drawn as {len(entry['chain']) // 3:,} straight lines.")
    if data["graph"]:
        said.append(
            "One coordinate: drawn over the parameter, which follows the chords’ lengths; axes not to one scale."
        )
    d = len(data["axes"])
    if d > 3:
        said.append(
            f"{d} coordinates: the view shows three of them, chosen above it; length, deviation and curvature are "
            f"those in all {d}."
        )
    items = "".join(f"<li>{each}</li>" for each in said)
    return f'<section class="card"><h2>Shown</h2><ul class="notes">{items}</ul></section>' if said else ""


def _digest(source: Path | None) -> str:
    if source is None:
        return ""
    digest = hashlib.sha256(source.read_bytes()).hexdigest()
    return f'<p class="notes" style="padding:0">{escape(source.name)}<br><small>SHA-256 {digest}</small></p>'


def _versions() -> str:
    packages = [f"{name} {version(name)}" for name in ("cadfit", "numpy", "scipy")]
    return ", ".join([*packages, f"Python {platform.python_version()}", f"{platform.system()} {platform.machine()}"])
