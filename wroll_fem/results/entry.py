"""Entry of summary.json, and variable of results.nc: unit, label and format; imports no large library."""

from __future__ import annotations

from typing import Literal, NamedTuple


class Entry(NamedTuple):
    """Entry of summary.json.

    Attributes
    ----------
    unit
        Unit as printed; "" if dimensionless.
    label
        What it is, in a few words.
    sentence
        Further explanation, for the reference page.
    style
        "share": shown in per cent; "number": shown unchanged; "si": shown with an SI prefix.
    console
        Format in the output at the end of `wroll run`; "" omits the entry there.
    """

    unit: str
    label: str
    sentence: str = ""
    style: Literal["si", "number", "share"] = "si"
    console: str = ""


class Field(NamedTuple):
    """Unit (SI, "1" if dimensionless) and label of a variable or coordinate."""

    units: str
    long_name: str


def share(label: str, sentence: str = "", console: str = "") -> Entry:
    """Dimensionless entry that is shown in per cent."""
    return Entry("", label, sentence, "share", console)


def number(unit: str, label: str, sentence: str = "", console: str = "") -> Entry:
    """Entry that is shown unchanged."""
    return Entry(unit, label, sentence, "number", console)
