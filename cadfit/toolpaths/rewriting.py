"""A program read line by line, its cutting moves refitted run by run, the rest written as it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import dist, hypot, inf, pi, radians
from os import PathLike
from pathlib import Path
from typing import IO, Literal, NamedTuple, get_args

from cadfit import bezier
from cadfit.fitting.approximate import Effort
from cadfit.replacing import replacing
from cadfit.stages import portion, stage
from cadfit.toolpaths.cuts import Cut, arcs, splines
from cadfit.toolpaths.klartext import Klartext
from cadfit.toolpaths.machine import PLANES, Machine, Move
from cadfit.toolpaths.pieces import Rules
from cadfit.toolpaths.reading import blocks
from cadfit.toolpaths.runs import Run, Toolpath
from cadfit.toolpaths.splines import control_points, ends, polynomials
from cadfit.toolpaths.words import Block
from cadfit.toolpaths.writing import State, Writer

_LARGEST_RADIUS = 1e4  # millimetres; what is flatter becomes a line
_REPORT_EVERY = 4096  # lines

Curves = Literal["arcs", "g5", "poly", "spl"]
_ROUNDING = {"g5": control_points, "poly": polynomials, "spl": ends}


@dataclass(slots=True)
class Summary:
    """What was done. Lengths in millimetres, whatever the program's unit; pairs are before and after.

    `moves`, `length`: cutting moves, and how long they are together. `runs`: stretches that may be refitted, and those
    that were. `deviation`: a bound on how far the new moves are from the old, both ways. `kept`: (line, word) of what
    was not understood and left as it was.
    """

    lines: list[int] = field(default_factory=lambda: [0, 0])
    bytes: list[int] = field(default_factory=lambda: [0, 0])
    moves: list[int] = field(default_factory=lambda: [0, 0])
    length: list[float] = field(default_factory=lambda: [0.0, 0.0])
    runs: list[int] = field(default_factory=lambda: [0, 0])
    deviation: float = 0.0
    arcs: int = 0
    splines: int = 0
    smallest_radius: float = inf
    kept: list[tuple[int, str]] = field(default_factory=list)


def refit(
    source: str | PathLike[str],
    target: str | PathLike[str],
    tolerance: float,
    *,
    corner: float = radians(35.0),
    decimals: int | None = None,
    curves: Curves = "arcs",
    effort: Effort = "fast",
    progress: Callable[[float], None] | None = None,
) -> Summary:
    """Write a program of G-code with its cutting moves refitted by lines and arcs within a tolerance.

    `tolerance`: a length in millimetres; the new path is within it of the old everywhere, and the old of the new, as
    written, rounding included. `corner`: turns of more than this (radians) are kept. `decimals` of coordinates: 4, or
    in inches 5. Lines of anything but plain cuts are written as they are, with the modes as they were before each.
    `curves`: "arcs" for G2 and G3 (and lines); "g5" for the cubic pieces of LinuxCNC, in the plane of X and Y; "poly"
    for those of Siemens; "spl" for those of Heidenhain, with the whole program in its
    plain language. `effort`: "best" for somewhat fewer moves in more time. `progress` is called with
    the part that is done, from 0 to 1; raising from it stops.

    Raises ValueError naming the line for a file that is no G-code, contradicts itself, or has macros; then, and when
    writing fails, what was at `target` is as it was.
    """
    if not 0.0 < tolerance < inf:
        raise ValueError(f"the tolerance must be a positive length, not {tolerance}")
    if not 0.0 < corner <= pi:
        raise ValueError(f"the angle of a corner must be above 0 and at most pi, not {corner}")
    if decimals is not None and not 1 <= decimals <= 9:
        raise ValueError(f"decimals must be 1 to 9, not {decimals}")
    if curves not in get_args(Curves):
        raise ValueError(f"curves must be one of {get_args(Curves)}, not {curves!r}")
    if effort not in get_args(Effort):
        raise ValueError(f"effort must be one of {get_args(Effort)}, not {effort!r}")
    path = Path(source)
    with path.open("rb") as program, replacing(Path(target)) as beside, beside.open("wb") as out:
        job = _Job(out, _How(tolerance, corner, decimals, curves, effort == "best"))
        size = max(path.stat().st_size, 1)
        for block in blocks(program):
            job.take(block)
            if progress is not None and block.line % _REPORT_EVERY == 0:
                progress(min(job.summary.bytes[0] / size, 1.0))
        job.flush()
        for line in job.writer.finished():
            job.write(line)
        job.summary.kept = job.machine.unknown
    portion(progress, 0.0, 1.0)(1.0)
    return job.summary


class _How(NamedTuple):
    """What was asked for."""

    tolerance: float
    corner: float
    decimals: int | None
    curves: Curves
    best: bool


class _Job:
    """One program being rewritten."""

    def __init__(self, out: IO[bytes], how: _How) -> None:
        self.out, self.how, self.machine, self.summary = out, how, Machine(), Summary()
        self.run: Run | None = None
        self.before: State = (None, 17)  # motion and plane before the run's first line
        self.writer = Klartext() if how.curves == "spl" else Writer("POLY" if how.curves == "poly" else 5)

    def take(self, block: Block) -> None:
        """Take one line: into a run, or to the output."""
        before = (self.machine.motion, self.machine.plane)
        move = None if self.machine.ended else self.machine.step(block)
        self.summary.lines[0] += 1
        self.summary.bytes[0] += len(_bytes(block.text))
        if move is not None and move.motion > 0:
            self.summary.moves[0] += 1
            self.summary.length[0] += move.length * self._unit
        if move is not None and self.run is not None and self.run.takes(block, move):
            self.run.add(block, move)
            return
        self.flush()
        run = self._begun(move) if move is not None else None
        if move is not None and run is not None and run.takes(block, move):
            run.add(block, move)
            self.run, self.before = run, before
        else:
            self._as_it_was(block, move, before, (self.machine.motion, self.machine.plane))

    def _begun(self, move: Move) -> Run:
        return Run(self.machine.modes, self.machine.position[3] - move.extruded, self.how.curves == "arcs")

    def flush(self) -> None:
        """Write what replaces the run, or its lines as they were."""
        run, self.run = self.run, None
        if run is None:
            return
        self.summary.runs[0] += 1
        path, cuts, far = self._fitted(run)
        if path is None:
            for block, move in zip(run.blocks, run.moves, strict=True):
                after = (move.motion, run.modes.plane)
                self._as_it_was(block, move, self.before, after)
                self.before = after
            return
        summary, inch = self.summary, 25.4 if run.modes.inches else 1.0
        summary.runs[1] += 1
        summary.deviation = max(summary.deviation, far * inch)
        summary.moves[1] += len(cuts)
        here = run.moves[0].start
        for cut in cuts:
            if cut.poles is not None:
                summary.splines += 1
                summary.length[1] += float(bezier.lengths(cut.poles[None])[0]) * inch
            elif cut.piece is not None and cut.piece.centre is not None:
                summary.arcs += 1
                summary.smallest_radius = min(summary.smallest_radius, cut.piece.radius * inch)
                rise = 3 - sum(PLANES[cut.plane])
                summary.length[1] += hypot(cut.piece.length, cut.end[rise] - here[rise]) * inch
            else:
                summary.length[1] += dist(here, cut.end) * inch
            here = cut.end
        for line in self.writer.lines(run, path, cuts, self._decimals(run)):
            self.write(line)

    @stage("fitting runs")
    def _fitted(self, run: Run) -> tuple[Toolpath | None, list[Cut], float]:
        """Return a run's path, moves for it, how far they are off; None where they are not fewer, or too far."""
        unit = 1 / 25.4 if run.modes.inches else 1.0
        decimals, tolerance = self._decimals(run), self.how.tolerance * unit
        tick = 10.0**-decimals
        if len(run.moves) < 2 or tolerance <= 2.0 * tick:
            return None, [], 0.0
        rules = Rules(tick, 2.0 * tolerance, _LARGEST_RADIUS * unit, unit, decimals)
        path = run.path(tolerance)
        if not len(path.begins):
            return None, [], 0.0
        if self.how.curves == "arcs":
            cuts, far = arcs(path, tolerance, self.how.corner, rules, self.how.best)
        elif run.extruded or not (run.modes.absolute or self.how.curves == "spl"):
            return None, [], 0.0  # what these words do then is not described
        else:
            written = _ROUNDING[self.how.curves](decimals)
            cuts, far = splines(path, tolerance, self.how.corner, rules, written, self.how.curves == "g5")
        return (path, cuts, far) if 0 < len(cuts) < len(run.moves) and far <= tolerance else (None, [], 0.0)

    def _decimals(self, run: Run) -> int:
        return self.how.decimals or (5 if run.modes.inches else 4)

    @property
    def _unit(self) -> float:
        return 25.4 if self.machine.inches else 1.0

    def _as_it_was(self, block: Block, move: Move | None, before: State, after: State) -> None:
        for line in self.writer.untouched(block, move, before, after):
            self.write(line)
        if move is not None and move.motion > 0:
            self.summary.moves[1] += 1
            self.summary.length[1] += move.length * self._unit

    def write(self, text: str) -> None:
        """Write a line."""
        data = _bytes(text)
        self.out.write(data)
        self.summary.lines[1] += 1
        self.summary.bytes[1] += len(data)


def _bytes(text: str) -> bytes:
    return text.encode("utf-8", "surrogateescape")
