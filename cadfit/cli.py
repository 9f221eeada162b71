"""The command line: its commands are in `cadfit.commands`. Nothing else prints.

What computes is imported inside the commands, so that `cadfit --help` answers at once.
"""

from __future__ import annotations

import io
import signal
import sys
import warnings
from typing import Annotated

import typer

from cadfit.commands.compare import compare
from cadfit.commands.fit import fit
from cadfit.commands.info import info
from cadfit.commands.sweep import sweep
from cadfit.commands.terminal import Mistake, say
from cadfit.commands.toolpath import toolpath
from cadfit.commands.tube import tube

app = typer.Typer(
    name="cadfit",
    help="Ordered points to B-splines a CAD program can trust.",
    add_completion=False,
    rich_markup_mode=None,  # rich would double the time of --help
    pretty_exceptions_enable=False,
)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line (default: `sys.argv`) and return the exit status: 0, 2 for a mistake, 130 for Ctrl-C."""
    if arguments is None:  # else the process, and what its signals mean, are another's
        signal.signal(signal.SIGTERM, _ended)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # names of files the terminal has no letters for
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("default", category=UserWarning)
            warnings.showwarning = _warn
            given = sys.argv[1:] if arguments is None else arguments  # for what names the command that made it
            return app(arguments, prog_name="cadfit", standalone_mode=False, obj=given) or 0
    except (KeyboardInterrupt, typer.Abort):
        return 130
    except OSError as error:
        line = f"{error.filename}: {error.strerror}" if error.filename else str(error)
    except (Mistake, ValueError, ImportError) as error:
        line = str(error)
    except Exception as error:
        if not hasattr(error, "format_message"):  # how the usage errors of typer and click are known
            raise
        line = f"{error.format_message()} (see cadfit --help)"
    say(line)
    return 2


def _ended(*_: object) -> None:
    """End as the shell says of SIGTERM, but take away the file that is being written first."""
    raise SystemExit(128 + signal.SIGTERM)


def _warn(message: Warning | str, *_: object, **__: object) -> None:
    say(f"warning: {message}")


@app.callback(invoke_without_command=True)
def _top(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
) -> None:
    if version:
        from cadfit import __version__

        print(__version__)
        raise typer.Exit
    if context.invoked_subcommand is None:
        print(context.get_help())


for command in (fit, compare, tube, sweep, info, toolpath):
    app.command()(command)

if __name__ == "__main__":
    sys.exit(main())
