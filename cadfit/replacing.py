"""Write beside, then replace: the old file stays whole until the new one is."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield an empty new file beside `path`, with its suffix; it takes the place of `path` when the block succeeds.

    When the block fails or is interrupted the new file is removed, and what was at `path` is as it was. A link stays
    a link, and the permissions of an old file are kept. Raises OSError naming `path` when it cannot be written.
    """
    target = Path(os.path.realpath(path))
    beside = target.with_name(f".{target.stem[:100]}.{secrets.token_hex(4)}{target.suffix}")
    try:
        _refuse(target)
        try:
            beside.open("xb").close()  # in here, or an interruption right after it would leave it
            yield beside
            if target.exists():
                shutil.copymode(target, beside)
            with beside.open("rb+") as file:  # on the disk before it is called by its name: power may fail
                os.fsync(file.fileno())
            beside.replace(target)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        if error.filename not in (None, str(beside), str(target)):
            raise
        raise OSError(error.errno or errno.EIO, error.strerror or str(error), str(path)) from error


def _refuse(target: Path) -> None:
    """Replacing needs leave to write in the folder alone; refuse what writing to the file itself would refuse."""
    if target.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(target))
    if target.exists() and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(target))
