"""Random motion of the base: a realisation of an acceleration PSD."""

from __future__ import annotations

import math
from itertools import pairwise
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
            raise validation_error(text, key=key, show_value=False, remedy=remedy)  # the text names what is wrong
        return self

    @property
    def table(self) -> PsdTable:
        """Table of the density; numpy is imported on use."""
        from wroll_fem.signals.random.psd import PsdTable

        return PsdTable(tuple(self.frequency), tuple(self.g2_per_hz))


class Accuracy(Section):
    """Wanted accuracy of the averaged spectra, from which `duration: auto` follows."""

    random_error: Real = Field(
        default=0.1, gt=0, le=0.5, description="standard error of the PSDs, relative, dimensionless"
    )
    bias: Real = Field(
        default=0.02,
        gt=0,
        le=0.1,
        description="part of the peak of a PSD that the resolution takes, dimensionless",
    )
    zeta: Real = Field(default=0.02, gt=0, lt=1, description="smallest damping ratio that is expected, dimensionless")
    frequency: Real | None = Field(
        default=None, gt=0, description="frequency of the resonance, Hz; of a roll the estimate by default"
    )


class RandomSpectrum(TaggedSection):
    """Gaussian random motion of the base with a given acceleration PSD; a record of it needs a `duration`."""

    kind: Literal["random"] = Field(default="random", description="random: stationary, with the PSD of a table")
    psd: Psd = Field(description="acceleration PSD of the base")
    duration: Literal["auto"] | Real | None = Field(
        default=None, description="length of a record, s, or auto, from `accuracy`; random alone uses it"
    )
    accuracy: Accuracy | None = Field(default=None, description="wanted accuracy of the averaged spectra")
    seed: Whole = Field(
        default=1, ge=0, le=2**63 - 1, description="seed of the record (count): another seed, another record"
    )
    records: Whole | None = Field(
        default=None,
        ge=1,
        le=1000,
        description="records per level (count), each with its own seed; spectra and rms are averaged over them "
        "(random alone; 1)",
    )
    level_db: Real = Field(
        default=0.0,
        description="level relative to the PSD, dB: the same record, times 10^(level_db / 20)",
    )
    levels: list[Real] | None = Field(
        default=None,
        description="factors of the record, ascending, dimensionless: one history for each, in one run (random alone)",
    )
    levels_db: list[Real] | None = Field(
        default=None,
        description="levels relative to the PSD, dB, ascending: 10^(level / 20) times the record, in place of levels",
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

    @field_validator("duration", mode="before")
    @classmethod
    def _seconds(cls, value: Any) -> Any:
        return value if value is None or value == "auto" else positive(value, "write a length in s, or auto")

    @field_validator("levels", "levels_db", mode="before")
    @classmethod
    def _listed(cls, value: Any) -> Any:
        return value if value is None or isinstance(value, list | tuple) else [value]

    @model_validator(mode="after")
    def _levels_ascend(self) -> Self:
        for key in ("levels", "levels_db"):
            given = getattr(self, key)
            if given is None:
                continue
            if self.level_db != 0.0 or (key == "levels_db" and self.levels is not None):
                raise validation_error(
                    "the level is given twice", key=key, value=given, remedy="give levels, levels_db or level_db"
                )
            least = 0.0 if key == "levels" else -121.0
            if not given or any(b <= a for a, b in pairwise([least, *given])) or given[-1] > 1e6:
                raise validation_error(
                    "must ascend" if key == "levels_db" else "must be above zero and ascend", key=key, value=given,
                    remedy="write for example " + ("[-12, -6, 0]" if key == "levels_db" else "[0.25, 0.5, 1]"),
                )  # fmt: skip
        return self

    @model_validator(mode="after")
    def _long_enough(self) -> Self:
        low, high = self.psd.frequency[0], self.psd.frequency[-1]
        if isinstance(self.duration, float) and self.duration * (high - low) < FEWEST_LINES:
            raise validation_error(
                f"too short to average spectra in the band of {low:g} to {high:g} Hz", key="duration",
                value=self.duration, remedy=f"give {FEWEST_LINES / (high - low):.3g} s or more, or a wider band",
            )  # fmt: skip
        return self

    @model_validator(mode="after")
    def _resolved(self) -> Self:
        low, high = self.psd.frequency[0], self.psd.frequency[-1]
        if self.resolution == "auto" or not isinstance(self.duration, float):
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

    duration: Literal["auto"] | Real = Field(description="length of a record, s, or auto, from `accuracy`")

    @property
    def most_cycles(self) -> float:
        """Length of all records times the highest frequency, cycles; nan while the length is to be chosen."""
        length = float("nan") if self.duration == "auto" else float(self.duration)
        return length * self.highest_frequency_hz * (self.records or 1) * len(self.all_levels_db)

    @property
    def in_series(self) -> bool:
        """Whether there are several levels or records."""
        return self.levels is not None or self.levels_db is not None or (self.records or 1) > 1

    @property
    def all_levels_db(self) -> list[float]:
        """Levels in dB, ascending."""
        if self.levels is not None:
            return [20.0 * math.log10(factor) for factor in self.levels]
        return [self.level_db] if self.levels_db is None else list(self.levels_db)

    @property
    def attributes(self) -> dict[str, float | str]:
        """Attributes of results that describe the motion."""
        low, high = self.psd.table.band
        return {
            "f_low_hz": low, "f_high_hz": high, "duration_s": self.duration, "seed": self.seed,
            "level_db": self.level_db, "psd_rms_m_s2": self.factor * self.psd.table.rms,
        }  # fmt: skip
