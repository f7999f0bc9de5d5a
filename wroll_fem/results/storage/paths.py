"""Paths that no file can have."""

from __future__ import annotations

import errno
import os

from wroll_fem.errors import InputError


def path_problem(path: str | os.PathLike[str]) -> str:
    """Reason why a path is not usable: too long, a NUL character, a loop of links; "" for any other path."""
    try:
        os.stat(path)
    except UnicodeEncodeError:
        return "the path contains characters that no file name has"
    except ValueError:
        return "the path contains a NUL character"
    except OSError as error:
        if error.errno in (errno.ENAMETOOLONG, errno.ELOOP):
            return f"the path is not usable ({(error.strerror or '').lower()})"
    return ""


def check_path(path: str | os.PathLike[str], remedy: str = "give another path") -> None:
    """Raise an InputError if a path is not usable.

    Raises
    ------
    InputError
        If it is too long, contains a NUL character or is a loop of links.
    """
    if problem := path_problem(path):
        raise InputError(problem, file=os.fspath(path), remedy=remedy)
