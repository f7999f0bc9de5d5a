"""Random motion of the base: a realisation of an acceleration PSD."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, Self

from pydantic import Field, field_validator, model_validator

from wroll_fem.case.base import Real, Section, TaggedSection, Whole, validation_error
from wroll_fem.case.excitation.shared import Direction, positive
from wroll_fem.signals.random.psd_rows import table_problem

if TYPE_CHECKING:
    from wroll_fem.signals.random.psd import PsdTable

FEWEST_LINES = 150
"""Smallest product of duration and band: with less, averaged spectra have too few lines for a resonance."""

FEWEST_SEGMENT_LENGTHS, FEWEST_AVERAGED_LINES = 4.0, 20
"""Smallest duration in units of the length of a segment, of which a quarter may be left out at the start; and smallest
number of lines of the averaged spectra."""


class Psd(Section):
    """Power spectral density (PSD) of the base acceleration: rows of a table, log-log between them, zero outside."""

    frequency: list[Real] = Field(description="frequencies of the rows, Hz, ascending")
    g2_per_hz: list[Real] = Field(
        description="one-sided density at these frequencies, g^2/Hz (g = 9.80665 m/s^2); one number for a constant band"
    )

    @field_validator("g2_per_hz", mode="before")
    @classmethod
    def _listed(cls, value: Any) -> Any:
        return value if isinstance(value, list | tuple) else [value]

    @model_validator(mode="after")
    def _valid_table(self) -> Self:
        if len(self.g2_per_hz) == 1 and len(self.frequency) > 1:
            self.__dict__["g2_per_hz"] = self.g2_per_hz * len(self.frequency)
        problem = table_problem(self.frequency, self.g2_per_hz)
        if problem is not None:
            key, text, remedy = problem
            raise validation_error(text, key=key, value=getattr(self, key), remedy=remedy)
        return self

    @property
    def table(self) -> PsdTable:
        """Table of the density; numpy is imported on use."""
        from wroll_fem.signals.random.psd import PsdTable

        return PsdTable(tuple(self.frequency), tuple(self.g2_per_hz))


class RandomSpectrum(TaggedSection):
    """Gaussian random motion of the base with a given acceleration PSD; a record of it needs a `duration`."""

    kind: Literal["random"] = Field(default="random", description="random: stationary, with the PSD of a table")
    psd: Psd = Field(description="acceleration PSD of the base")
    duration: Real | None = Field(default=None, gt=0, description="length of the record, s; random alone uses it")
    seed: Whole = Field(
        default=1, ge=0, le=2**63 - 1, description="seed of the record (count): another seed, another record"
    )
    level_db: Real = Field(
        default=0.0,
        description="level relative to the PSD, dB: the same record, times 10^(level_db / 20)",
    )
    crest_limit: Real | None = Field(
        default=None,
        ge=2,
        description="largest acceleration divided by the rms, dimensionless; without it about 4 to 5",
    )
    resolution: Literal["auto"] | Real = Field(
        default="auto",
        description="distance of the lines of the averaged spectra of the results, Hz; auto: a tenth of the half-power "
        "width of the resonance, as far as the record is long enough",
    )
    direction: Direction = "x"

    @field_validator("resolution", mode="before")
    @classmethod
    def _hertz(cls, value: Any) -> Any:
        return value if value == "auto" else positive(value, "write a distance in Hz, or auto")

    @model_validator(mode="after")
    def _long_enough(self) -> Self:
        low, high = self.psd.frequency[0], self.psd.frequency[-1]
        if self.duration is not None and self.duration * (high - low) < FEWEST_LINES:
            raise validation_error(
                f"too short to average spectra in the band of {low:g} to {high:g} Hz", key="duration",
                value=self.duration, remedy=f"give {FEWEST_LINES / (high - low):.3g} s or more, or a wider band",
            )  # fmt: skip
        return self

    @model_validator(mode="after")
    def _resolved(self) -> Self:
        low, high = self.psd.frequency[0], self.psd.frequency[-1]
        if self.resolution == "auto" or self.duration is None:
            return self
        finest, coarsest = FEWEST_SEGMENT_LENGTHS / self.duration, (high - low) / FEWEST_AVERAGED_LINES
        if not finest <= self.resolution <= coarsest:
            fault = "too fine for the length of the record" if self.resolution < finest else "too coarse for the band"
            raise validation_error(
                fault, key="resolution", value=self.resolution,
                remedy=f"give {finest:.3g} to {coarsest:.3g} Hz, or auto, or a longer record",
            )  # fmt: skip
        return self

    @property
    def factor(self) -> float:
        """Factor of the record due to `level_db`."""
        return float(10.0 ** (self.level_db / 20.0))

    @property
    def highest_frequency_hz(self) -> float:
        """Highest frequency with energy, Hz."""
        return self.psd.table.highest_frequency_hz


class RandomExcitation(RandomSpectrum):
    """Gaussian random motion of the base with a given acceleration PSD: a record of some length."""

    duration: Real = Field(gt=0, description="length of the record, s")

    @property
    def most_cycles(self) -> float:
        """Length of the record times its highest frequency, cycles."""
        return self.duration * self.highest_frequency_hz

    @property
    def attributes(self) -> dict[str, float]:
        """Attributes of results that describe the motion."""
        low, high = self.psd.table.band
        return {
            "f_low_hz": low, "f_high_hz": high, "duration_s": self.duration, "seed": self.seed,
            "level_db": self.level_db, "psd_rms_m_s2": self.factor * self.psd.table.rms,
        }  # fmt: skip
