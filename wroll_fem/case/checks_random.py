"""Checks of a random motion against the structure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wroll_fem.case.base import validation_error

if TYPE_CHECKING:
    from wroll_fem.case.excitation import RandomExcitation


def check_duration(excitation: RandomExcitation, *, roll: bool) -> None:
    """Refuse `duration: auto` for matrices from a file without the frequency of their resonance.

    Raises
    ------
    PydanticCustomError
        If the check fails.
    """
    accuracy = excitation.accuracy
    if excitation.duration != "auto" or roll or (accuracy is not None and accuracy.frequency is not None):
        return
    raise validation_error(
        "the resonance of matrices from a file is not known before the run", key="excitation.duration", value="auto",
        remedy="add excitation.accuracy.frequency, Hz, or give a length in s",
    )  # fmt: skip
