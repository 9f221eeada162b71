"""What commands say and show: mistakes, progress, the report; and the checks before and after the work."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cadfit.commands.options import Unit
    from cadfit.files import Kind


class Mistake(Exception):
    """A mistake of the user's, said in one line that begins with the file."""


def say(line: str) -> None:
    """Print one line to stderr."""
    print("cadfit:", " ".join(line.split()), file=sys.stderr)


def check(source: Path, outputs: list[Path], kind: Kind, dimension: int | None = None) -> None:
    """Refuse what cannot be written, before any work is done."""
    from cadfit.files import check

    for path in outputs:
        check(path, kind, dimension)
        if path.exists() and source.exists() and path.samefile(source):
            raise Mistake(f"{path}: the output would replace the input")


def check_places(outputs: list[Path]) -> None:
    """Refuse outputs that are folders, or whose folders are not there, before any work is done."""
    for path in outputs:
        if path.is_dir():
            raise Mistake(f"{path}: a folder, where a file is to be written")
        if not path.parent.is_dir():
            raise Mistake(f"{path}: no such folder: {path.parent}")


def check_page(page: Path | None, sources: list[Path]) -> None:
    """Refuse a page that is no .html, would replace an input, or has no folder, before any work is done."""
    if page is None:
        return
    if page.suffix.lower() not in (".html", ".htm"):
        raise Mistake(f"{page}: a report is a .html")
    if any(page.exists() and source.exists() and page.samefile(source) for source in sources):
        raise Mistake(f"{page}: the report would replace the input")
    check_places([page])


def write_all(
    source: Path, outputs: list[Path], kind: Kind, dimension: int, result: Any, unit: Unit, quiet: bool
) -> None:
    """Write a result to all outputs, after the checks of `check`."""
    from cadfit.files import write

    check(source, outputs, kind, dimension)
    for path in outputs:
        with busy(f"writing {path}", quiet) as progress, about(path):
            write(path, result, unit.value, progress)


@contextmanager
def about(path: Path) -> Iterator[None]:
    """Name the file in what goes wrong in the block."""
    try:
        yield
    except Exception as error:
        kernel = sys.modules.get("cadfit.occt")
        if not isinstance(error, (ValueError, kernel.KernelError) if kernel else ValueError):
            raise
        named = str(error).startswith(str(path))
        raise Mistake(str(error) if named else f"{path}: {error}") from error


@contextmanager
def busy(what: str, quiet: bool, count: int | None = None) -> Iterator[Callable[[float], None] | None]:
    """Show a bar on a terminal while the block runs; give what moves it, from 0 to 1. It pulses until that is used.

    With `count` it tells how many of so many are done.
    """
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import MofNCompleteColumn, Progress

    columns = [*Progress.get_default_columns(), *([MofNCompleteColumn()] if count else [])]
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task, total = progress.add_task(escape(what), total=None), count or 1
        yield lambda part: progress.update(task, total=total, completed=part * total)


@contextmanager
def timed(verbose: bool) -> Iterator[None]:
    """Print to stderr how long the stages of the block took, where `verbose`."""
    if not verbose:
        yield
        return
    from time import perf_counter

    from cadfit.stages import times

    start = perf_counter()
    with times() as found:
        try:
            yield
        finally:
            whole = perf_counter() - start
            say_times(found | {"other": whole - sum(found.values()), "all": whole})


def say_times(found: dict[str, float]) -> None:
    """Print seconds by name to stderr."""
    for name, seconds in found.items():
        print(f"{seconds:9.3f} s  {name}", file=sys.stderr)


def report(title: str, facts: dict[str, str], written: list[Path], quiet: bool) -> None:
    """Print names and values, and the files that were written."""
    if quiet:
        return
    from rich.console import Console
    from rich.text import Text

    console = Console(highlight=False, soft_wrap=True)
    console.print(Text(title, style="bold"))
    width = max(map(len, facts))
    for name, value in facts.items():
        console.print(Text.assemble((name.ljust(width), "dim"), "  ", value))
    for path in written:
        console.print(Text(f"wrote {path}"))
