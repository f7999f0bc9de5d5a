"""Read a case file: YAML to a validated `Case`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from wroll_fem.case.case import Case, Origin
from wroll_fem.case.overrides import WITH_FILE, absolute, overridden
from wroll_fem.case.strict_yaml import key_lines, parse_yaml
from wroll_fem.errors import InputError
from wroll_fem.results.storage.paths import path_problem


def load_case(path: str | Path, overrides: Sequence[str] = ()) -> Case:
    """Load and validate a case file.

    Parameters
    ----------
    path
        YAML file. A relative `mesh.file` or `structure.file` inside is taken relative to this file.
    overrides
        "dotted.key=value" pairs, the value in YAML; checked like the file. A relative
        path given here is taken relative to the working directory.

    Raises
    ------
    InputError
        If the case is invalid; the message names file, key, value and remedy.
    """
    path = Path(path)
    data = read_yaml(path)
    for name in WITH_FILE:
        section = data.get(name)
        if isinstance(section, dict) and isinstance(section.get("file"), str):
            section["file"] = absolute(path.parent / section["file"])
    try:
        return build_case(data, overrides, source=path)
    except InputError as error:
        locate(error, path)
        raise


def locate(error: InputError, path: Path) -> None:
    """Fill in the line of the file ``path`` to which an error and its `others` belong.

    This is the line of the key, or of the innermost section around it that the file contains.
    """
    lines = key_lines(path.read_text(encoding="utf-8"))
    for one in (error, *error.others):
        if one.file != str(path):
            continue
        parts = (one.key or "").split(".")
        inner = [".".join(parts[:k]) for k in range(len(parts), 0, -1)]
        one.line = next((lines[key] for key in inner if key in lines), None)


def build_case(data: Mapping[str, Any], overrides: Sequence[str] = (), *, source: Path | None = None) -> Case:
    """Build a validated case from the content of a case file, changed by overrides.

    Parameters
    ----------
    data
        Content of a case file.
    overrides
        As in `load_case`.
    source
        File of the data, for messages.

    Raises
    ------
    InputError
        If the case is invalid; the message names file, key, value and remedy.
    """
    merged, keys = overridden(data, overrides, str(source) if source is not None else None)
    return Case.model_validate(merged, context=Origin(source, *keys))


def read_yaml(path: Path, what: str = "case file") -> dict[str, Any]:
    """Read a YAML file that contains a mapping; ``what`` names the expected kind of file in error messages.

    Raises
    ------
    InputError
        If the file cannot be read, or is not a mapping.
    """
    if problem := path_problem(path):
        raise InputError(problem, remedy=f"give the path of a {what} (see configs/)", file=str(path))
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError("file not found", remedy=f"give the path of a {what} (see configs/)", file=str(path)) from None
    except UnicodeDecodeError:
        raise InputError("is not a UTF-8 text file", remedy=f"give a YAML {what}", file=str(path)) from None
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"cannot be read ({reason})", remedy=f"give a readable YAML {what}", file=str(path)) from None
    data = parse_yaml(text, str(path))
    if not isinstance(data, dict):
        noun = what.removesuffix(" file")
        kind = "is empty" if data is None else f"is not a {noun}: it contains a {type(data).__name__}"
        raise InputError(kind, remedy="write sections as key: value pairs (see configs/)", file=str(path))
    return data
