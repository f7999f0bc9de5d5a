"""Files that are replaced only by complete ones."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Path to write to, NAME.partial beside `path`; it takes the place of `path` when the block ends.

    When the block fails the partial file is removed and `path` stays as it was.

    Raises
    ------
    OSError
        When the folder cannot be written.
    """
    target = Path(path)
    partial = target.with_name(f"{target.name}.partial")
    try:
        yield partial
        os.replace(partial, target)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
