"""Shocks of the base: pulses, motions of a shock response spectrum, and records from files."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

from pydantic import Field, field_validator, model_validator

from wroll_fem.case.base import Real, Section, TaggedSection, Whole, _number, validation_error
from wroll_fem.case.excitation.shared import STANDARD_GRAVITY, AmplitudeSection, Direction, positive
from wroll_fem.errors import InputError

if TYPE_CHECKING:
    from wroll_fem.signals.shock.table import SpectrumTable


def _auto_or_positive(value: Any) -> Any:
    return value if value == "auto" else positive(value, "write a number above zero, or auto")


def _motion_of(excitation: ShockSection) -> Any:
    """Base motion of a section; imported here, so that loading a case of another kind imports no numpy."""
    from wroll_fem.signals.motions import base_motion

    return base_motion(excitation)


class ShockSection(TaggedSection):
    """What all shocks share: the time after them, the time step, and the spectra of the results."""

    direction: Direction = "x"
    decay: Literal["auto"] | float = Field(
        default="auto",
        description="time after the shock, s, in which the roll vibrates freely; auto: 60 cycles of the estimated "
        "resonance of a roll, or 20 times the shock",
    )
    highest_frequency: Literal["auto"] | float = Field(
        default="auto",
        description="frequency whose cycle has integrator.steps_per_cycle time steps, Hz; auto: the frequency below "
        "which 99 % of the energy of the shock lies, and at least 3 times the estimated resonance of a roll",
    )
    q: Real = Field(
        default=10.0,
        gt=0.5,
        description="quality factor Q = 1 / (2 zeta) of the shock response spectra of base and tip, dimensionless",
    )

    @field_validator("decay", "highest_frequency", mode="before")
    @classmethod
    def _auto(cls, value: Any) -> Any:
        return _auto_or_positive(value)

    @property
    def highest_frequency_hz(self) -> float:
        """Highest frequency of the base motion that the time steps resolve, Hz."""
        if self.highest_frequency != "auto":
            return float(self.highest_frequency)
        return float(_motion_of(self).highest_frequency_hz)

    @property
    def attributes(self) -> dict[str, float]:
        """Attributes of results that describe the motion."""
        motion = _motion_of(self)
        return {
            "amplitude_m_s2": motion.amplitude, "shock_end_s": motion.end, "srs_q": self.q,
            "velocity_change_m_s": motion.velocity_change,
        }  # fmt: skip


class PulseSection(ShockSection, AmplitudeSection):
    """One-sided pulse with an amplitude and a length."""

    duration: Real = Field(gt=0, description="length of the pulse, s")


class HalfSineExcitation(PulseSection):
    """Half-sine pulse of the base."""

    kind: Literal["half_sine"] = Field(default="half_sine", description="half_sine: half a period of a sine")


class SawtoothExcitation(PulseSection):
    """Terminal-peak sawtooth pulse of the base."""

    kind: Literal["sawtooth"] = Field(
        default="sawtooth", description="sawtooth: straight rise to the amplitude, then a jump to zero"
    )


class TrapezoidExcitation(PulseSection):
    """Trapezoidal pulse of the base."""

    kind: Literal["trapezoid"] = Field(
        default="trapezoid", description="trapezoid: straight rise, flat top, straight fall"
    )
    rise: Real = Field(default=0.1, ge=0, le=1, description="rise divided by the length of the pulse, dimensionless")
    fall: Real = Field(default=0.1, ge=0, le=1, description="fall divided by the length of the pulse, dimensionless")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.rise + self.fall > 1.0 + 1e-12:
            raise validation_error(
                f"rise and fall take {self.rise + self.fall:g} times the duration", key="rise", value=self.rise,
                remedy="give shares that add up to 1 at most",
            )  # fmt: skip
        return self


class Spectrum(Section):
    """Shock response spectrum (absolute acceleration, maximax): rows of a table, log-log between them."""

    frequency: list[Real] = Field(description="natural frequencies of the rows, Hz, ascending")
    acceleration_g: list[Real] = Field(
        description="absolute accelerations at these frequencies, multiples of 9.80665 m/s^2"
    )
    q: Real = Field(default=10.0, gt=0.5, description="quality factor Q = 1 / (2 zeta) of the spectrum, dimensionless")

    @model_validator(mode="after")
    def _possible(self) -> Self:
        try:
            self.table.refuse_impossible()
        except InputError as error:
            key = (error.key or "").removeprefix("excitation.srs").removeprefix(".")
            raise validation_error(error.problem, key=key, show_value=False, remedy=error.remedy or "") from None
        return self

    @property
    def table(self) -> SpectrumTable:
        """Table of the spectrum, m/s^2."""
        from wroll_fem.signals.shock.table import SpectrumTable

        return SpectrumTable(tuple(self.frequency), tuple(STANDARD_GRAVITY * a for a in self.acceleration_g), self.q)


class SrsExcitation(ShockSection):
    """Motion of wavelets with a given shock response spectrum."""

    kind: Literal["srs"] = Field(
        default="srs", description="srs: wavelets with a given shock response spectrum, within 1.5 dB"
    )
    srs: Spectrum = Field(description="shock response spectrum of the base")
    seed: Whole = Field(
        default=1, ge=0, le=2**63 - 1, description="seed of delays and signs (count): another seed, another motion"
    )


class FileExcitation(ShockSection):
    """Motion of the base from a record."""

    kind: Literal["file"] = Field(default="file", description="file: record of the base acceleration")
    file: Path = Field(
        description="record: .csv, .txt, .npz, .mat (up to version 7.2) or .uff (path, relative to the case file)"
    )
    unit: str = Field(description="unit of the record: m/s^2, g (9.80665 m/s^2) or mm/s^2")
    column: str | int | None = Field(
        default=None,
        description="column of the base acceleration, by name, or by its place (count, the first is 1); needed if "
        "there are several besides the time",
    )
    time: str | int | None = Field(
        default=None, description="column of the time, s, by name or by its place; by default the one called time or t"
    )
    sampling_rate: Real | None = Field(
        default=None, gt=0, description="samples per second, Hz, in place of a column of the time"
    )
    rows: Whole | None = Field(
        default=None, ge=16, description="samples that the file must have (count): finds a text that is cut off"
    )
    length: Real | None = Field(
        default=None, gt=0, description="time from the first to the last sample that the file must have, s"
    )
    scale: Real = Field(default=1.0, description="factor of the record, dimensionless; not 0")
    baseline: Literal["none", "velocity", "displacement"] = Field(
        default="none",
        description="none; velocity subtracts a constant, so that the velocity of the base ends at zero; displacement "
        "subtracts a straight line, so that velocity and displacement end at zero",
    )
    taper: Real = Field(
        default=0.0, ge=0, le=0.5, description="cosine taper at each end, divided by the length, dimensionless"
    )
    low_pass: Real | None = Field(
        default=None,
        gt=0,
        description="limit of the low-pass filter, Hz; by default 8 times the frequency below which 99 % of the energy "
        "lies",
    )

    @field_validator("file", mode="before")
    @classmethod
    def _a_path(cls, value: Any) -> Any:
        if not isinstance(value, str | Path):
            raise validation_error("must be the path of a record", remedy="write a path", value=value)
        return value

    @field_validator("column", "time", mode="before")
    @classmethod
    def _a_column(cls, value: Any) -> Any:
        if value is None or isinstance(value, str) or (isinstance(value, int) and not isinstance(value, bool)):
            return value
        raise validation_error("must be a name, or a place counted from 1", remedy="write one", value=value)

    @field_validator("scale")
    @classmethod
    def _not_zero(cls, value: float) -> float:
        if value == 0.0 or not math.isfinite(float(_number(value))):
            raise validation_error("must be a number other than zero", remedy="leave it out, or write it", value=value)
        return value

    @model_validator(mode="after")
    def _readable(self) -> Self:
        try:
            _motion_of(self)
        except InputError as error:
            key = (error.key or "excitation.file").removeprefix("excitation.")
            where = f" ({error.file})" if error.file else ""
            raise validation_error(
                f"{error.problem}{where}", key=key, value=str(getattr(self, key, None)), show_value=False,
                remedy=error.remedy or "check the record",
            ) from None  # fmt: skip
        return self


ShockExcitation = HalfSineExcitation | SawtoothExcitation | TrapezoidExcitation | SrsExcitation | FileExcitation
"""Motions of the analysis shock."""

SHOCK_KINDS = ("half_sine", "sawtooth", "trapezoid", "srs", "file")
"""Kinds of the analysis shock."""
