"""Settings of the evaluation `slip`."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field, model_validator

from wroll_fem.case.base import Real, Section, Switch, Whole, validation_error
from wroll_fem.lab.settings import LabSettings
from wroll_fem.lab.slip_images.frames.stream import RawFormat
from wroll_fem.lab.slip_images.targets.survey import Search
from wroll_fem.lab.slip_images.targets.targets import Filters


class Raw(Section):
    """Layout of raw video."""

    width: Whole = Field(gt=0, le=20000, description="columns of a frame, px")
    height: Whole = Field(gt=0, le=20000, description="rows of a frame, px")
    bits: Literal[8, 16] = Field(8, description="bits of a grey value: 8 or 16")
    header: Whole = Field(0, ge=0, description="size of what stands before the first frame, bytes")
    big_endian: Switch = Field(False, description="whether the high byte of 16 bits is first")

    def layout(self) -> RawFormat:
        """Layout for `open_frames`."""
        return RawFormat(self.width, self.height, self.bits, self.header, self.big_endian)


class SlipSettings(LabSettings):
    """Camera, excitation, and how targets are found."""

    PATHS: ClassVar[tuple[str, ...]] = ("rest", "table")

    frame_rate: Real = Field(gt=0.0, description="frames per second, Hz")
    frequency: Real = Field(gt=0.0, description="frequency of the excitation, Hz")
    band: Real = Field(10.0, gt=0.0, description="half width of the band around the excitation, Hz")
    rest: str | None = Field(
        None, description="folder or file of frames at rest, for the noise floor; by default from the band itself"
    )
    table: str | None = Field(
        None,
        description="CSV file with the columns target, group, layer (number or mandrel), as targets.csv of a run",
    )
    relative_to: Whole | None = Field(
        None, ge=1, description="number of the layer inside of the pairs of layers, count; by default the next inside"
    )
    target_diameter: Real | None = Field(
        None, gt=0.0, description="outer diameter of all targets, m; different ones: column diameter_mm of the table"
    )
    target_diameter_error: Real = Field(0.0, ge=0.0, description="standard uncertainty of the diameters, m")
    first_frame: Whole = Field(0, ge=0, description="first frame that is used, from 0, count")
    frames: Whole | None = Field(None, gt=0, description="number of frames that are used, count; by default all")
    raw: Raw | None = Field(None, description="layout of raw video")
    targets: Literal["auto", "bright", "dark"] = Field(
        "auto", description="whether targets are brighter or darker than the ground"
    )
    background: Literal["surface", "median", "none"] = Field(
        "surface",
        description="ground behind the targets. surface: smooth polynomial; median: wide median filter; none: zero",
    )
    background_window: Whole = Field(128, gt=2, description="width of the median filter, px")
    evening: Literal["targets", "ground", "none"] = Field(
        "targets",
        description="by what the signal is divided against uneven light. targets: their contrast, as a smooth surface; "
        "ground: the light on it; none: nothing",
    )
    threshold: Literal["otsu", "local"] | Real = Field(
        "otsu",
        description="threshold above the ground, grey values; otsu: half of the contrast of the frame; local: half of "
        "the contrast within the window",
    )
    threshold_window: Whole | None = Field(
        None, gt=2, description="width of the local window, px; by default 1.5 times the largest diameter"
    )
    smoothing: Whole = Field(1, ge=0, le=10, description="passes of a filter of 3 x 3 px before the threshold, count")
    margin: Whole = Field(
        2, ge=0, le=20, description="width of the surroundings of a region that count for its centroid, px"
    )
    area: tuple[Real, Real] = Field((30.0, 1e5), description="least and largest area of a target, px^2")
    diameter: tuple[Real, Real] = Field((5.0, 300.0), description="least and largest outer diameter of a target, px")
    circularity: Real = Field(
        0.75, ge=0.0, le=1.2, description="least circularity of a target, dimensionless; 1 for a circle"
    )
    gate: Real | None = Field(
        None,
        gt=0.0,
        description="largest distance of a target from its prediction, px; by default from the distances",
    )

    @model_validator(mode="after")
    def _limits_rise(self) -> SlipSettings:
        for name in ("area", "diameter"):
            low, high = getattr(self, name)
            if not 0.0 < low < high:
                raise validation_error(
                    "must be positive and rise", remedy="write [least, largest]", key=name, value=[low, high]
                )
        return self

    def search(self) -> Search:
        """How targets are found in a frame."""
        threshold = self.threshold if isinstance(self.threshold, str) else float(self.threshold)
        return Search(
            Filters(self.area, self.diameter, self.circularity), self.targets, self.background,
            self.background_window, self.evening, threshold, self.threshold_window, self.smoothing, self.margin,
            self.gate,
        )  # fmt: skip
