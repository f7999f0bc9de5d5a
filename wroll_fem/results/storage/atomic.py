"""Writing of files: atomic replacement that survives a power cut, and errors with one line."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from wroll_fem.errors import InputError, StorageError

PARTIAL = ".partial"
"""Ending of a file that is being written."""

_OF_THE_PATH = {
    errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.EEXIST, errno.ENOTEMPTY,
    errno.ENAMETOOLONG, errno.ELOOP, errno.EINVAL,
}  # fmt: skip
"""Causes for which another path is the remedy; for all others (no space, quota, defect) it is the storage."""

_NO_SYNC = {errno.EINVAL, errno.ENOTSUP, errno.EACCES, errno.EPERM}
"""Answers of file systems whose folders cannot be synchronised."""


def writing_error(
    error: OSError, path: str | os.PathLike[str], remedy: str = "choose another place"
) -> InputError | StorageError:
    """Error in one line for a file or folder that cannot be written.

    Parameters
    ----------
    error
        Error of the operating system.
    path
        File or folder.
    remedy
        What to do if the path is the cause.
    """
    problem = f"cannot be written ({error.strerror or error})"
    if error.errno in _OF_THE_PATH:
        return InputError(problem, file=str(path), remedy=remedy)
    return StorageError(problem, file=str(path))


def make_folder(path: str | os.PathLike[str], remedy: str = "choose another place") -> Path:
    """Create a folder with its parents, unless it exists; return its path.

    Raises
    ------
    InputError, StorageError
        If it cannot be created.
    """
    folder = Path(path)
    try:
        if not folder.is_dir():
            folder.mkdir(parents=True, exist_ok=True)
            _synchronise_folder(folder.parent)
    except OSError as error:
        raise writing_error(error, folder, remedy) from None
    return folder


@contextmanager
def replacing(path: str | os.PathLike[str], remedy: str = "choose another place") -> Iterator[Path]:
    """Context manager that yields the path of a temporary file NAME.partial, which replaces `path` after the block.

    The content is on the disk before the file gets its name, so that after a power cut `path` is the old or the new
    file. If the block fails, the partial file is removed and `path` is unchanged. A symbolic link at either path is
    replaced; its target is not written.

    Parameters
    ----------
    path
        File to write, in an existing folder.
    remedy
        What to do if the path is the cause of a failure.

    Raises
    ------
    InputError
        If the path cannot be written.
    StorageError
        If the disk is full or fails.
    """
    target = Path(path)
    partial = target.with_name(f"{target.name}{PARTIAL}")
    try:
        partial.unlink(missing_ok=True)
        try:
            yield partial
            _synchronise(partial)
            os.replace(partial, target)
        except BaseException:
            with suppress(OSError):  # the first error is the one to report
                partial.unlink(missing_ok=True)
            raise
        _synchronise_folder(target.parent)
    except OSError as error:
        raise writing_error(error, target, remedy) from None


def _synchronise(path: Path) -> None:
    """Wait until the content of a file or folder is on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _synchronise_folder(folder: Path) -> None:
    try:
        _synchronise(folder)
    except OSError as error:
        if error.errno not in _NO_SYNC:
            raise
