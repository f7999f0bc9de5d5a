"""What every section of the case file shares: strict frozen models and number types."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict
from pydantic_core import PydanticCustomError

if TYPE_CHECKING:
    from wroll_fem.case.case import Case


class Section(BaseModel):
    """A section of the case file: frozen, unknown keys refused, SI units throughout."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, validate_default=False)


def wrong(
    problem: str, *, remedy: str, key: str = "", value: Any = None, show_value: bool = True
) -> PydanticCustomError:
    """Error of a check that a bound on a field cannot express.

    Parameters
    ----------
    problem
        What is wrong, without the value.
    remedy
        What would be right.
    key
        Dotted key relative to the model that raises; empty when the field's own validator raises.
    value
        The offending value, shown as "got VALUE".
    show_value
        False when there is no value to show (a missing section).
    """
    context = {"problem": problem, "remedy": remedy, "key": key, "value": value, "show_value": show_value}
    return PydanticCustomError("wroll", "{problem}; {remedy}", context)


def _number(value: Any) -> Any:
    """Turn PyYAML's strings such as '1e-3' into floats; refuse booleans and text."""
    if isinstance(value, bool):
        raise wrong("must be a number", remedy="write a number, not true or false", value=value)
    if isinstance(value, str):
        try:
            return float(value)
        except ValueError:
            remedy = "write a plain number in SI units, for example 1.5e-3"
            raise wrong("must be a number", remedy=remedy, value=value) from None
    return value


def _switch(value: Any) -> Any:
    if not isinstance(value, bool):
        raise wrong("must be true or false", remedy="write true or false", value=value)
    return value


Real = Annotated[float, BeforeValidator(_number)]
Whole = Annotated[int, BeforeValidator(_number)]
Switch = Annotated[bool, BeforeValidator(_switch)]


def owns_section(case: Case, analysis: str, *, lacks: str, missing: str, add: str) -> bool:
    """Whether the case runs ``analysis``, whose section of the same name no other analysis has.

    Parameters
    ----------
    lacks, missing
        What the others have none of, and what the section holds, for the messages.
    add
        The section in short, as one would write it.

    Raises
    ------
    PydanticCustomError
        The section is missing, or stands in the case of another analysis.
    """
    given = getattr(case, analysis) is not None
    if case.analysis == analysis and not given:
        problem = f"required section is missing: {missing}"
        raise wrong(problem, key=analysis, show_value=False, remedy=f"add {analysis}: {add}")
    if case.analysis != analysis and given:
        problem, remedy = f"analysis {case.analysis} has no {lacks}", f"leave it out, or use analysis: {analysis}"
        raise wrong(problem, key=analysis, show_value=False, remedy=remedy)
    return case.analysis == analysis
