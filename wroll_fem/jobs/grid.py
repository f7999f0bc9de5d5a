"""Grid file of `wroll batch` (case files; dotted keys with values or sampled ranges), and its expansion into cases."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, ValidationError, field_validator, model_validator

from wroll_fem.case import Case, load_case
from wroll_fem.case.base import Real, Section, Whole, validation_error
from wroll_fem.case.loader import locate, read_yaml
from wroll_fem.case.messages import input_error
from wroll_fem.case.overrides import absolute
from wroll_fem.case.renamed import current_key
from wroll_fem.errors import InputError
from wroll_fem.jobs.study_figures import STUDY_FIGURES
from wroll_fem.results.json_types import json_types
from wroll_fem.results.storage.paths import path_problem

MOST_BYTES = 200
"""Longest name of a run folder; file systems allow 255 bytes."""

MOST_CASES = 10_000
"""Largest number of cases of a grid."""

REFERENCE = "reference"
"""Name of the reference case, which is not part of the grid."""


class Range(Section):
    """Range from which the values of a key are sampled."""

    low: Real = Field(description="lower end, in the unit of the key")
    high: Real = Field(description="upper end, in the unit of the key")
    scale: Literal["linear", "log"] = Field(
        default="linear", description="samples are uniform in the value or in its logarithm"
    )

    @model_validator(mode="before")
    @classmethod
    def _pair(cls, value: Any) -> Any:
        if not isinstance(value, list | tuple):
            return value
        if len(value) != 2:
            raise validation_error("is not a range", remedy="write [low, high]", value=value)
        return {"low": value[0], "high": value[1]}

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low < self.high:
            raise validation_error("low is not below high", remedy="write [low, high]", value=[self.low, self.high])
        if self.scale == "log" and self.low <= 0.0:
            raise validation_error("a logarithmic range must start above 0", remedy="use scale: linear", value=self.low)
        return self

    def at(self, share: float) -> float:
        """Value at a fraction (0 to 1) of the range, rounded to six significant digits."""
        if self.scale == "log":
            value = float(self.low * (self.high / self.low) ** share)
        else:
            value = float(self.low + share * (self.high - self.low))
        return float(f"{value:.6g}")


class Samples(Section):
    """Latin hypercube: each of the ``count`` equal slices of every range contains one sample."""

    count: Whole = Field(ge=1, le=MOST_CASES, description="number of samples (count)")
    seed: Whole = Field(
        default=1, ge=0, le=2**32 - 1, description="seed of the random numbers; the same seed gives the same samples"
    )
    ranges: dict[str, Range] = Field(description="dotted key: [low, high], or {low:, high:, scale: log}")

    @field_validator("ranges")
    @classmethod
    def _some(cls, value: dict[str, Range]) -> dict[str, Range]:
        if not value:
            raise validation_error(
                "ranges is empty", remedy="write ranges: {dotted.key: [low, high]}", show_value=False
            )
        return value

    def values(self) -> list[dict[str, float]]:
        """For each sample: dotted key -> value."""
        from scipy.stats import qmc

        shares = qmc.LatinHypercube(len(self.ranges), seed=self.seed).random(self.count)
        pairs = list(self.ranges.items())
        return [{key: r.at(x) for (key, r), x in zip(pairs, row, strict=True)} for row in shares]


class GridFile(Section):
    """Content of a grid file: case files, dotted keys with values, samples, figures."""

    base: Path | None = Field(default=None, description="case file to start from (path, relative to the grid file)")
    cases: list[Path] = Field(
        default_factory=list, description="several case files in place of base: a further axis of the grid"
    )
    reference: Path | None = Field(
        default=None,
        description="case file of a reference run outside the grid (path, relative to the grid file)",
    )
    grid: dict[str, list[Any]] = Field(
        default_factory=dict, description="dotted key: list of values; every combination is a case"
    )
    samples: Samples | None = Field(
        default=None, description="random samples of keys; combined with every case of the grid"
    )
    figure: str | list[str] = Field(default_factory=list, description="figure of the study, or a list of them")

    @field_validator("grid", mode="before")
    @classmethod
    def _lists(cls, value: Any) -> Any:
        if not isinstance(value, Mapping):
            raise validation_error(
                "must be dotted keys with lists of values", remedy="write key: [value, value]", value=value
            )
        for key, values in value.items():
            if not isinstance(values, list) or not values:
                problem = "is an empty list" if isinstance(values, list) else "is not a list"
                raise validation_error(
                    f"{key} {problem}", remedy=f"write the values in brackets, {key}: [value, ...]", value=values
                )
            if len({json.dumps(json_types(v)) for v in values}) < len(values):
                raise validation_error(f"{key} has a duplicate value", remedy="write each value once", value=values)
        return value

    @field_validator("figure")
    @classmethod
    def _known(cls, value: str | list[str]) -> list[str]:
        names = [value] if isinstance(value, str) else value
        for name in names:
            if name not in STUDY_FIGURES:
                raise validation_error("unknown figure", remedy=f"use one of: {', '.join(STUDY_FIGURES)}", value=name)
        return names

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if (self.base is None) == (not self.cases):
            problem = "is missing" if self.base is None else "cannot be combined with cases"
            raise validation_error(
                problem, key="base", show_value=False, remedy="give one case file as base, or a list of them as cases"
            )
        both = set(self.grid) & set(self.samples.ranges if self.samples else ())
        if both:
            remedy = "give each key in grid or in samples.ranges"
            raise validation_error(
                f"{min(both)} is also in grid", key="samples.ranges", show_value=False, remedy=remedy
            )
        if not self.grid and not self.cases and self.samples is None:
            remedy = "write grid: {dotted.key: [value, ...]}"
            raise validation_error("is empty: no key is varied", key="grid", show_value=False, remedy=remedy)
        return self


@dataclass(frozen=True)
class Member:
    """One case of a grid.

    Attributes
    ----------
    name
        Name of its run folder, formed from the values that vary.
    file
        Case file it starts from.
    values
        Dotted key -> value in the validated case; with several case files also "case" -> name of the case file.
    overrides
        The same values as arguments of `wroll run --set`.
    case
        Validated case.
    """

    name: str
    file: Path
    values: dict[str, Any]
    overrides: list[str]
    case: Case


@dataclass(frozen=True)
class Grid:
    """Grid file, expanded and validated."""

    source: Path
    members: list[Member]
    figures: list[str]


def is_grid(path: Path) -> bool:
    """Whether a YAML file has the keys of a grid file rather than those of a case file."""
    content = read_yaml(path, "case or grid file")
    return "analysis" not in content and not GridFile.model_fields.keys().isdisjoint(content)


def grid_schema_text() -> str:
    """JSON schema of the grid file."""
    schema = GridFile.model_json_schema() | {
        "$schema": "https://json-schema.org/draft/2020-12/schema", "title": "wroll_fem grid",
    }  # fmt: skip
    return json.dumps(schema, indent=2, sort_keys=True) + "\n"


def load_grid(path: str | Path) -> Grid:
    """Read a grid file and validate all its cases.

    Raises
    ------
    InputError
        If the grid file or a case is invalid; the message names file, key, problem and remedy. The errors of all cases
        are in `InputError.others`.
    """
    path = Path(path)
    content = read_yaml(path, "grid file")
    try:
        given = GridFile.model_validate(content)
    except ValidationError as error:
        wrong = input_error(error.errors(include_url=False), GridFile, file=str(path))
        locate(wrong, path)
        raise wrong from None
    origin_key = "base" if given.base is not None else "cases"
    files = [path.parent / file for file in ([given.base] if given.base is not None else given.cases)]
    keys = list(given.grid)
    shown = short_names([key for key in keys if len(given.grid[key]) > 1])
    count = math.prod(map(len, given.grid.values())) * len(files) * (given.samples.count if given.samples else 1)
    if count > MOST_CASES:
        remedy = "give fewer values, or split the grid into several files"
        raise InputError(f"has {count} cases, at most {MOST_CASES} are possible", file=str(path), remedy=remedy)
    samples = given.samples.values() if given.samples is not None else [{}]
    numbered = list(enumerate(samples, 1))
    members, errors = [], []
    for file, (number, sample), *values in itertools.product(files, numbered, *given.grid.values()):
        chosen = sample | dict(zip(keys, values, strict=True))
        try:
            case, overrides = _case(file, chosen, path, key=origin_key, sampled=set(sample))
        except InputError as wrong:
            errors += [wrong, *wrong.others]
            continue
        read: dict[str, Any] = {"sample": number} if sample else {}
        read |= {key: _value(case, key) for key in (*sample, *keys)}
        parts = [file.stem] if len(files) > 1 else []
        parts += [f"sample_{number:0{len(str(len(samples)))}d}"] if sample else []
        parts += [f"{shown[key]}_{_value_name(value)}" for key, value in read.items() if key in shown]
        origin = {"case": file.stem} if given.cases else {}
        members.append(Member(_folder_name("__".join(parts) or file.stem), file, origin | read, overrides, case))
    if given.reference is not None:
        file = path.parent / given.reference
        try:
            members.append(Member(REFERENCE, file, {}, [], _case(file, {}, path, key="reference")[0]))
        except InputError as wrong:
            errors += [wrong, *wrong.others]
    if errors:
        first, *others = {str(wrong.alone): wrong for wrong in errors}.values()  # one error may be that of many cases
        first.others = tuple(others)
        locate(first, path)
        raise first
    for name, times in Counter(member.name for member in members).items():
        if times > 1:
            remedy = "give each case file its own name, and each key different values"
            raise InputError(f"two cases have the same folder {name}", file=str(path), remedy=remedy)
    return Grid(path, members, list(given.figure))


def _case(
    file: Path, chosen: Mapping[str, Any], source: Path, *, key: str = "base", sampled: Collection[str] = ()
) -> tuple[Case, list[str]]:
    """Case read from ``file`` with the keys in ``chosen`` changed, and these changes as `--set` arguments."""
    if path_problem(file) or not file.is_file():
        remedy = "give a case file, its path relative to the grid file"
        raise InputError(f"case file not found: {file}", key=key, file=str(source), remedy=remedy)
    overrides = []
    for dotted, value in chosen.items():
        if dotted == "mesh.file" and isinstance(value, str):  # relative to the grid file, as case files are
            value = absolute(source.parent / value)
        overrides.append(f"{dotted}={json.dumps(json_types(value))}")
    try:
        case = load_case(file, overrides)
    except InputError as error:
        for one in (error, *error.others):
            if one.key and one.key.startswith("--set "):
                dotted = one.key.removeprefix("--set ")
                one.key, one.file = f"{'samples.ranges' if dotted in sampled else 'grid'}.{dotted}", str(source)
        raise
    return case, overrides


def _value(case: Case, key: str) -> Any:
    """Value of a dotted key in the validated case, in which text such as "3e4" has become a number."""
    here: Any = case.resolved()
    for part in current_key(key).split("."):
        here = here[part]
    return here


def short_names(keys: Sequence[str]) -> dict[str, str]:
    """Dotted key -> its last part, or the whole key if another key has the same last part."""
    last = [key.rsplit(".", 1)[-1] for key in keys]
    return {key: word if last.count(word) == 1 else key for key, word in zip(keys, last, strict=True)}


def _folder_name(name: str) -> str:
    """Name of a run folder; the end of a name that is too long for a file system is replaced by its hash."""
    name = name.lstrip("=+-@") or "case"  # no formula in the table, no option on a command line
    if len(name.encode()) <= MOST_BYTES:
        return name
    short = name.encode()[: MOST_BYTES - 17].decode(errors="ignore")
    return f"{short}_{hashlib.sha256(name.encode()).hexdigest()[:16]}"


def _value_name(value: Any) -> str:
    """Value as part of a folder name."""
    if isinstance(value, list):
        if len(value) > 1 and all(entry == value[0] for entry in value):
            return f"{len(value)}x{_value_name(value[0])}"
        return "-".join(_value_name(entry) for entry in value)
    if isinstance(value, int | float) and not isinstance(value, bool):
        short = f"{value:g}"
        return short if float(short) == value else repr(value)
    return re.sub(r"[^\w.+-]+", "-", str(value)).strip("-") or "empty"
