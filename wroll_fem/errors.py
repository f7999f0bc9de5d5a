"""Errors that are reported to users, with their messages and exit codes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any


def _in_line(text: str, most: int) -> str:
    """Text in one line that every terminal shows: control characters escaped, the middle of a long text left out."""
    if not text.isprintable():
        text = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
    return text if len(text) <= most else f"{text[: most // 2]} ... {text[-most // 3 :]}"


class WrollError(Exception):
    """Base class of errors that the command line reports without traceback."""

    exit_code = 1


class InputError(WrollError):
    """Invalid input; the message names file, key, value and remedy.

    Parameters
    ----------
    problem
        What is wrong, with the offending value.
    key
        Dotted key of the case file that causes the error, if there is one.
    remedy
        What to do.
    file
        File the input came from; filled in by the loader when unknown here.
    others
        Further errors of the same input.

    Attributes
    ----------
    line
        Line of the file in which the key stands, counted from 1; None if unknown.
    """

    exit_code = 2

    def __init__(
        self, problem: str, *, key: str | None = None, remedy: str | None = None, file: str | None = None,
        others: Sequence[InputError] = (),
    ):  # fmt: skip
        self.problem, self.key, self.remedy, self.file = problem, key, remedy, file
        self.others = tuple(others)
        self.line: int | None = None
        super().__init__(problem)

    def __str__(self) -> str:
        return f"{self.alone} (and {len(self.others)} more)" if self.others else self.alone

    @property
    def alone(self) -> str:
        """Message without the number of further errors."""
        file = _in_line(self.file or "", 300)
        file = f"{file}:{self.line}" if file and self.line else file
        where = ": ".join(part for part in (file, _in_line(self.key or "", 120)) if part)
        problem = _in_line(self.problem, 600)
        text = f"{where}: {problem}" if where else problem
        return f"{text}; {_in_line(self.remedy, 800)}" if self.remedy else text

    @property
    def lines(self) -> list[str]:
        """Message of each error, in the order of the file."""
        found = [self, *self.others]
        return [error.alone for error in sorted(found, key=lambda error: error.line or 0)]


class StorageError(WrollError):
    """A file cannot be written because the disk is full, a quota is used up, or the storage fails.

    Parameters
    ----------
    problem
        What is wrong, with the reason of the operating system.
    file
        File that could not be written.
    """

    exit_code = 4

    def __init__(self, problem: str, *, file: str) -> None:
        self.problem, self.file = problem, file
        remedy = "free some room there, then run the same command again (`wroll run` with --resume)"
        super().__init__(f"{file}: {problem}; {remedy}")


class ConvergenceError(WrollError):
    """The solver did not converge; results up to that point are kept.

    Parameters
    ----------
    message
        What failed.
    time_s
        Time that could not be reached; None for a static step and for a periodic motion.
    iterations
        Newton iterations spent in the last attempt.
    residual_history
        Relative residuals of the last attempt.
    advice
        What to try.

    Attributes
    ----------
    problem
        The message alone.
    partial
        Results up to the failure; None if there are none. From an analysis: a Dataset like that of a complete run, but
        shorter. From `dynamics.periodic`: the curve up to the failure (HarmonicCurve or BackboneCurve). From
        `numerics.continuation`: its points up to the failure (list of CurvePoint).
    last
        Unknowns of the last iteration if a point of a curve is not found; otherwise None.
    opening
        Fraction of the contact points that open during the period of the motion ``last``.
    """

    exit_code = 3

    def __init__(
        self,
        message: str,
        *,
        time_s: float | None,
        iterations: int,
        residual_history: Sequence[float],
        advice: str,
    ):
        self.problem, self.time_s, self.iterations = message, time_s, iterations
        self.residual_history, self.advice = list(residual_history), advice
        self.partial: Any = None
        self.last: Any = None
        self.opening = 0.0
        tail = ", ".join(f"{r:.2e}" for r in self.residual_history[-5:])
        tail = f" (residuals {tail})" if tail else ""
        when = "" if time_s is None else f" at t = {time_s:.6g} s"
        super().__init__(f"{message}{when} after {iterations} iterations{tail}; {advice}")


class ReductionError(ConvergenceError):
    """The reduced model cannot represent the motion within its tolerance; an exact solver can."""


def require_positive(owner: object, names: Sequence[str], *, section: str = "") -> None:
    """Raise an `InputError` unless all named attributes of an object are finite and positive.

    Parameters
    ----------
    owner
        Object with the attributes.
    names
        Names of the attributes.
    section
        Case section of the names, for the message.

    Raises
    ------
    InputError
        For the first invalid attribute.
    """
    for name in names:
        value = getattr(owner, name)
        if not 0.0 < value < math.inf:
            key = f"{section}.{name}" if section else name
            raise InputError(f"{name} = {value}", key=key, remedy="give a positive number")
