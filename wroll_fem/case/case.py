"""Case: the complete, immutable input of a run in SI units."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self, TypeVar, cast, get_args

from pydantic import (
    Field,
    ModelWrapValidatorHandler,
    PrivateAttr,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import InitErrorDetails, PydanticCustomError

from wroll_fem.case.base import Section, validation_error
from wroll_fem.case.checks import check_damping_method
from wroll_fem.case.descriptions import sections
from wroll_fem.case.integrator import DEFAULT_STEPS
from wroll_fem.case.messages import input_error
from wroll_fem.case.output import Output
from wroll_fem.case.overrides import WITH_FILE, overridden, override_texts
from wroll_fem.case.renamed import current_key, with_current_keys, with_former_keys
from wroll_fem.case.strict_yaml import dump_yaml
from wroll_fem.errors import InputError

SECTIONS = (
    "analysis", "structure", "geometry", "mandrel", "coil", "contact", "preload", "winding", "excitation", "damping",
    "damping_ratio", "integrator", "solver", "mesh", "modal", "harmonic", "backbone", "random_response",
    "design_map", "two_dof", "sizing", "probes", "output",
)  # fmt: skip
"""Top-level keys of a case file, in the order of serialisation."""

C = TypeVar("C", bound="Case")
K = TypeVar("K")

_NOT_PHYSICS = ("checkpoint_seconds", "allow_coarse")
"""Solver keys that do not affect the results; they do not enter the hash of a case."""

_OFF_BY_DEFAULT = (
    ("preload", "geometric_stiffness"), ("integrator", "follow_frequency"), ("excitation", "rate_hz_per_s"),
    ("excitation", "profile"), ("excitation", "sweep_direction"), ("excitation", "accuracy"), ("excitation", "records"),
    ("excitation", "levels"), ("excitation", "levels_db"), ("excitation", "rows"), ("excitation", "length"),
    ("solver", "hyper_reduction"),
)  # fmt: skip
"""(Section, key) of switches and options that are off (false or null) by default; they enter the hash of a case only if
they are given."""

_OWNERS = {
    "two_dof": ("two masses", "two_dof"), "design_map": ("map", "design_map"),
    "damping_ratio": ("modal damping", "modal_transient or slip_damping"), "sizing": ("mandrel to be sized", "sizing"),
}  # fmt: skip
"""Key that only one analysis uses -> (description of the key, name of the analysis)."""


Check = Callable[[], object]
"""Check of case sections against each other; raises PydanticCustomError. It reads the sections when it is called."""


class Origin(NamedTuple):
    """Origin of a case, for messages: its file, the keys set with `--set`, and the former key names used in it."""

    file: Path | None = None
    overrides: Sequence[str] = ()
    former: tuple[str, ...] = ()


class Case(Section):
    """Content of a case file: one analysis with its case sections.

    `Case(...)`, `Case.model_validate` and `load_case` return an object of the class that belongs to `analysis`
    (`SweepCase`, `ModalCase`, ...), which has the sections of that analysis and no others.

    Raises
    ------
    InputError
        One line that names key, value and remedy, when the content is wrong.
    """

    analysis: str = Field(description="what to compute")
    output: Output = Field(default_factory=Output, description="what a run writes")

    ALWAYS_WRITTEN: ClassVar[tuple[str, ...]] = ("analysis", "output")
    """Case sections that the resolved case always contains; other sections appear only if the file has them."""

    _source: Path | None = PrivateAttr(default=None)
    _former: tuple[str, ...] = PrivateAttr(default=())

    def __new__(cls, **sections: Any) -> Self:
        """Create an object of the case class that belongs to the analysis."""
        return super().__new__(cls._kind(sections) or cls)

    @classmethod
    def _kind(cls, sections: Mapping[Any, Any]) -> type[Self] | None:
        """Class for a case with the given case sections: `cls` itself or a subclass; None if no class fits."""
        if cls in _KINDS.values():
            return cls
        analysis = sections.get("analysis", cls._own_analysis())
        if not isinstance(analysis, str):
            return None
        on_structure = sections.get("structure") is not None
        kind = _KINDS.get((analysis, on_structure)) or _KINDS.get((analysis, False))
        return kind if kind is not None and issubclass(kind, cls) else None

    @classmethod
    def _own_analysis(cls) -> str | None:
        """Name of the analysis that this class and its subclasses serve, or None if they serve several."""
        found = {analysis for (analysis, _), kind in _KINDS.items() if issubclass(kind, cls)}
        return found.pop() if len(found) == 1 else None

    @model_validator(mode="wrap")
    @classmethod
    def _of_its_analysis(cls, data: Any, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo) -> Self:
        """Build the object of the class that fits the analysis; report validation errors in one line."""
        if isinstance(data, cls):
            return data
        origin = info.context if isinstance(info.context, Origin) else Origin()
        if not isinstance(data, Mapping):
            raise InputError(f"is not a case but a {type(data).__name__}", remedy="write sections as key: value pairs")
        given = {key: value for key, value in data.items() if value is not None or key not in SECTIONS[1:]}
        given, former = with_current_keys(given)
        origin = origin._replace(former=origin.former + former)
        if "analysis" not in given and cls._own_analysis() is not None:
            given["analysis"] = cls._own_analysis()
        kind = cls._kind(given)
        try:
            if kind is None:
                raise cls._without_kind(given)
            if kind is not cls:
                return kind.model_validate(given, context=origin)
            case = handler(given)
            if problems := case._problems():
                raise ValidationError.from_exception_data(cls.__name__, problems)
        except ValidationError as error:
            file = None if origin.file is None else str(origin.file)
            known = [key for key in SECTIONS if kind is not cls or key in cls.model_fields]
            details = error.errors(include_url=False)
            if kind is cls and any(detail["loc"] for detail in details):
                wrong = {detail["loc"][0] for detail in details if detail["loc"]}
                problems = cls._valid_part(given, wrong, origin)._problems(complete=False)
                details += ValidationError.from_exception_data(cls.__name__, problems).errors(include_url=False)
            raise input_error(
                details, cls, file=file, overrides=origin.overrides, known=known, refusal=cls._refusal
            ) from None
        case._source, case._former = origin.file, origin.former
        return case

    @classmethod
    def _without_kind(cls, given: Mapping[Any, Any]) -> ValidationError:
        """Validation error for a missing or unknown analysis."""
        problems: list[InitErrorDetails] = [
            {"type": "extra_forbidden", "loc": (str(key),), "input": value}
            for key, value in given.items() if key not in SECTIONS
        ]  # fmt: skip
        if "analysis" not in given:
            problems.append({"type": "missing", "loc": ("analysis",), "input": given})
        else:
            value, names = (
                given["analysis"],
                dict.fromkeys(a for (a, _), kind in _KINDS.items() if issubclass(kind, cls)),
            )
            wrong = validation_error(
                "this analysis is not available", remedy=f"use one of: {', '.join(names)}", value=value
            )
            problems.append({"type": wrong, "loc": ("analysis",), "input": value})
        return ValidationError.from_exception_data(cls.__name__, problems)

    @classmethod
    def _refusal(cls, key: str) -> tuple[str, str] | None:
        """Problem and remedy for a key that belongs to other analyses; None for an unknown key."""
        if key not in SECTIONS:
            return None
        analysis = cls._own_analysis()
        lacks, owner = _OWNERS.get(key, (f"section {key}", ""))
        return f"analysis {analysis} has no {lacks}", "leave it out" + (f", or use analysis: {owner}" if owner else "")

    @classmethod
    def _valid_part(cls, given: Mapping[str, Any], wrong: Collection[str | int], origin: Origin) -> Self:
        """Case without its wrong sections, to check the others; reading a wrong section raises AttributeError."""
        valid: dict[str, Any] = {}
        for name in (cls.model_fields.keys() & given.keys()) - set(wrong):
            valid[name] = cls._adapter(name).validate_python(given[name], context=origin)
        part = cls.model_construct(_fields_set=set(given), **valid)
        for section in wrong:
            part.__dict__.pop(str(section), None)  # the default
        return cast("Self", part)

    @classmethod
    @lru_cache(maxsize=512)
    def _adapter(cls, name: str) -> TypeAdapter[Any]:
        """Validator of one section; pydantic takes some milliseconds to build it."""
        field = cls.model_fields[name]
        kind: Any = Annotated[(field.annotation, *field.metadata, Field(discriminator=field.discriminator))]
        return TypeAdapter(kind)

    def _problems(self, *, complete: bool = True) -> list[InitErrorDetails]:
        """What the checks of the case sections against each other find; ``complete``: every section is valid."""
        found: list[InitErrorDetails] = []
        for check in self._checks():
            try:
                check()
            except PydanticCustomError as problem:
                found.append({"type": problem, "loc": (), "input": None})
            except AttributeError:
                if complete:
                    raise
        return found

    def _checks(self) -> Iterator[Check]:
        """Checks of case sections against each other; subclasses add their own checks."""
        yield lambda: check_damping_method(self.output, self.analysis)

    def __eq__(self, other: object) -> bool:
        """Compare the contents of two cases; their origin is ignored."""
        return isinstance(other, Case) and type(self) is type(other) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        return hash(self.resolved_yaml())

    @property
    def source(self) -> Path | None:
        """File from which the case was read."""
        return self._source

    @property
    def renamed(self) -> list[str]:
        """Warnings about keys written with their former names."""
        return [f"{key} is now called {current_key(key)}; both names are accepted" for key in self._former]

    def resolved(self) -> dict[str, Any]:
        """All values, with defaults, as plain types, of the sections that were given or are in `ALWAYS_WRITTEN`."""
        left_out = set(type(self).model_fields) - self.model_fields_set - set(self.ALWAYS_WRITTEN)
        data = self.model_dump(mode="json", exclude=left_out)
        return {key: data[key] for key in SECTIONS if key in data}

    def resolved_yaml(self) -> str:
        """All values as YAML text; loading it gives an equal case."""
        return dump_yaml(self.resolved(), default_flow_style=None, width=120)

    def hash(self) -> str:
        """Return the SHA-256 hash of everything in the case that can change the results.

        A mesh file or structure file enters with its content. Of section `output`, only the damping estimator enters,
        and only if it is not the default. Switches that are off by default enter only if they are on. A case without
        these keys therefore keeps the hash that it had before the keys existed.
        """
        data = with_former_keys(self.resolved())
        del data["output"]
        if self.output.damping != Output.model_fields["damping"].default:
            data["output"] = {"damping": self.output.damping}
        integrator = data.get("integrator") or {}
        if integrator.get("steps_per_cycle") == "auto" and self.analysis not in ("dwell", "random"):
            integrator["steps_per_cycle"] = DEFAULT_STEPS  # value of auto there, and the default before auto existed
        for section, key in _OFF_BY_DEFAULT:
            if data.get(section, {}).get(key, True) in (False, None):
                del data[section][key]
        for key in _NOT_PHYSICS:
            data.get("solver", {}).pop(key, None)
        for section in WITH_FILE:
            if data.get(section, {}).get("file") is not None:
                data[section]["file"] = _content_hash(Path(data[section]["file"]))
        return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()

    def expect(self, kind: type[K]) -> K:
        """Return this case with a narrower type, for example `case.expect(SweepCase).excitation`.

        Raises
        ------
        InputError
            When the case is of another class.
        """
        if not isinstance(self, kind):
            raise InputError(
                f"a case of analysis {self.analysis} is a {type(self).__name__}, not a {kind.__name__}", key="analysis"
            )
        return self

    def replace(self, *overrides: str | Mapping[str, Any]) -> Case:
        """Return a copy with new values of dotted keys, validated again.

        Parameters
        ----------
        overrides
            "dotted.key=value" texts, the value in YAML, or mappings of dotted keys to values:
            `case.replace("contact.friction.mu=0.5")`, `case.replace({"preload.pressure": 3e4})`.

        Returns
        -------
        Case
            Of another class when `analysis` changes.

        Raises
        ------
        InputError
            If the case is invalid; the message names key, value and remedy.
        """
        given = self.model_dump(mode="json", exclude_unset=True)
        file = None if self._source is None else str(self._source)
        try:
            data, keys = overridden(given, override_texts(*overrides), file)
            return Case.model_validate(data, context=Origin(self.source, *keys))
        except InputError as error:  # speaks of the command line
            error.key = (error.key or "").removeprefix("--set ") or None
            error.remedy = (error.remedy or "").replace("--set ", "") or None
            raise

    def changed(self, *overrides: str | Mapping[str, Any]) -> Case:
        """Same as `replace`, under its former name."""
        return self.replace(*overrides)


_KINDS: dict[tuple[str, bool], type[Case]] = {}
"""(Analysis, whether matrices come from a file) -> class; filled by `case_kind`."""


def case_kind(kind: type[C]) -> type[C]:
    """Class decorator that registers a case class for its analysis, either for a roll or for matrices from a file."""
    (analysis,) = get_args(kind.model_fields["analysis"].annotation)
    _KINDS[analysis, "structure" in kind.model_fields] = kind
    return kind


def case_kinds() -> dict[tuple[str, bool], type[Case]]:
    """(Analysis, whether matrices come from a file) -> class of its cases."""
    return dict(_KINDS)


def case_sections() -> dict[str, FieldInfo]:
    """Top-level key of a case file -> pydantic field of this key, for the keys of all analyses."""
    kinds = list(_KINDS.values())
    names = tuple(dict.fromkeys(analysis for analysis, _ in _KINDS))
    found = {"analysis": FieldInfo(annotation=Literal[names], description=Case.model_fields["analysis"].description)}  # type: ignore[arg-type]
    for key in SECTIONS[1:]:
        fields = [kind.model_fields[key] for kind in kinds if key in kind.model_fields]
        found[key] = max(fields, key=lambda field: len(sections(field.annotation)))
    return found


@lru_cache(maxsize=64)
def _hash_of_version(path: Path, changed_ns: int, size: int) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _content_hash(path: Path) -> str:
    """SHA-256 of a file, cached until the file changes."""
    found = path.stat()
    return _hash_of_version(path, found.st_mtime_ns, found.st_size)
