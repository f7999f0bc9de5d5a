"""Conditions of a test: which files are trials of the same level and tension."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from math import nan
from pathlib import Path

from pydantic import Field

from wroll_fem.case.base import Real, Section
from wroll_fem.errors import InputError


class ConditionSettings(Section):
    """Condition of a test: files that are its trials, with level and tension."""

    files: list[str] = Field(
        min_length=1, description="patterns of the files, such as `20N_*.csv`; the last parts of the path are compared"
    )
    name: str | None = Field(None, description="label of the condition; by default its tension and level")
    level: Real | None = Field(
        None, gt=0, description="nominal base acceleration, m/s^2: 0-peak of a sweep, rms of a random motion"
    )
    tension: Real | None = Field(None, ge=0, description="winding tension, N")


@dataclass(frozen=True)
class Condition:
    """Trials of one condition.

    Attributes
    ----------
    name
        Label.
    files
        Files of its trials.
    level
        Nominal base acceleration, m/s^2; nan if not given.
    tension
        Winding tension, N; nan if not given.
    """

    name: str
    files: tuple[Path, ...]
    level: float = nan
    tension: float = nan


def grouped(files: Sequence[Path], settings: Sequence[ConditionSettings]) -> list[Condition]:
    """Conditions in the order of the settings, or one per folder in the order of the files.

    Raises
    ------
    InputError
        If a pattern has no file, or a file has no condition or several.
    """
    if not settings:
        folders = list(dict.fromkeys(path.parent for path in files))
        names = [folder.resolve().name for folder in folders]
        unique = names if len(set(names)) == len(names) else [str(folder) for folder in folders]
        return [
            Condition(name, tuple(path for path in files if path.parent == folder))
            for name, folder in zip(unique, folders, strict=True)
        ]
    taken: dict[Path, int] = {}
    for k, one in enumerate(settings):
        for pattern in one.files:
            found = [path for path in files if _matches(path, pattern)]
            if not found:
                raise InputError(
                    f"no file matches {pattern!r}", key=f"conditions.{k}.files",
                    remedy=f"the files are: {', '.join(str(path) for path in files[:6])}",
                )  # fmt: skip
            for path in found:
                if taken.setdefault(path, k) != k:
                    raise InputError(
                        f"{path} belongs to two conditions", key=f"conditions.{k}.files", remedy="narrow the patterns"
                    )
    left = [path for path in files if path not in taken]
    if left:
        raise InputError("belongs to no condition", file=str(left[0]), key="conditions", remedy="add a pattern for it")
    return [
        Condition(
            one.name or _label(one, k), tuple(path for path in files if taken[path] == k),
            nan if one.level is None else one.level, nan if one.tension is None else one.tension,
        )
        for k, one in enumerate(settings)
    ]  # fmt: skip


def _matches(path: Path, pattern: str) -> bool:
    """Whether the last parts of a path match a pattern of as many parts."""
    wanted = Path(pattern).parts
    own = path.resolve().parts[-len(wanted) :]
    return len(own) == len(wanted) and all(fnmatch(part, one) for part, one in zip(own, wanted, strict=True))


def _label(one: ConditionSettings, k: int) -> str:
    parts = [f"{one.tension:g} N"] if one.tension is not None else []
    parts += [f"{one.level:g} m/s²"] if one.level is not None else []
    return " at ".join(parts) or f"condition {k + 1}"
