"""Read the records of shear tests as the settings of an evaluation describe them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.common.channels import Channel, clipped, per_file, read_channels
from wroll_fem.lab.shear.events import find_event
from wroll_fem.lab.shear.fixture import Fixture
from wroll_fem.lab.shear.loops import crossings
from wroll_fem.lab.shear.record import ShearRecord
from wroll_fem.lab.shear.settings import ShearRecordSettings
from wroll_fem.progress import Progress

Found = Literal["ramp", "loops", "sliding"]

LONG = 10.0
"""Displacement of a record, relative to the displacement at the onset of slip, above which it is a sliding test."""

VARIES = 0.02
"""Relative standard deviation of a measured normal force above which it is reported."""


class Read(NamedTuple):
    """Record with its profile; ``specimen`` has the displacement without the fixture."""

    record: ShearRecord
    specimen: ShearRecord
    profile: Found


def read_all(
    files: Sequence[Path], settings: ShearRecordSettings, progress: Progress
) -> tuple[list[Read], Fixture | None]:
    """Read all records; doubts go to the progress object.

    Raises
    ------
    InputError
        If a file or a setting is wrong.
    """
    fixture = fixture_of(settings)
    for text in fixture.doubts if fixture is not None else ():
        progress.warning(text)
    forces = per_file(settings.normal_force, len(files), "normal_force")
    if forces is not None and settings.columns.normal_force is not None:
        raise InputError(
            "normal_force and columns.normal_force are both given", key="normal_force", remedy="give one of them"
        )
    profiles = [settings.profile] * len(files) if isinstance(settings.profile, str) else settings.profile
    if len(profiles) != len(files):
        raise InputError(
            f"{len(profiles)} values for {len(files)} files", key="profile", remedy="give one word, or one per file"
        )
    found = []
    with progress.stage("records", len(files)) as stage:
        for k, path in enumerate(files):
            record = read_record(path, settings, forces[k] if forces is not None else None, progress)
            specimen = record if fixture is None else fixture.corrected(record)
            beyond = fixture.exceeded(record) if fixture is not None else ""
            if beyond:
                progress.warning(beyond)
            wanted = profiles[k]
            found.append(Read(record, specimen, profile_of(specimen) if wanted == "auto" else wanted))
            stage.update(k + 1)
    return found, fixture


def read_record(
    path: Path, settings: ShearRecordSettings, normal_force: float | None, progress: Progress
) -> ShearRecord:
    """Read one record.

    Raises
    ------
    InputError
        If the file is wrong.
    """
    columns, units = settings.columns, settings.units
    channels = [
        Channel("time", columns.time, units.time, "s"),
        Channel("displacement", columns.displacement, units.displacement, "m"),
        Channel("force", columns.force, units.force, "N"),
    ]
    if columns.normal_force is not None:
        channels.append(Channel("normal_force", columns.normal_force, units.normal_force, "N"))
    data = read_channels(path, channels)
    for text in clipped(data["force"], path, "force"):
        progress.warning(text)
    pressed = float("nan") if normal_force is None else normal_force
    if "normal_force" in data:
        pressed = float(np.mean(data["normal_force"]))
        scatter = float(np.std(data["normal_force"])) / abs(pressed) if pressed else np.inf
        if scatter > VARIES:
            progress.warning(f"{path}: the normal force varies by {100 * scatter:.1f} % (standard deviation)")
    return ShearRecord(data["time"], data["displacement"], data["force"], pressed, str(path))


def fixture_of(settings: ShearRecordSettings) -> Fixture | None:
    """Compliance of the fixture: given, measured, or None.

    Raises
    ------
    InputError
        If both are given, or the record of the rigid specimen is wrong.
    """
    if settings.rigid is None:
        if settings.fixture_stiffness is None:
            return None
        return Fixture.given(settings.fixture_stiffness, settings.fixture_stiffness_error)
    if settings.fixture_stiffness is not None:
        raise InputError("rigid and fixture_stiffness are both given", key="rigid", remedy="give one of them")
    columns = settings.columns
    data = read_channels(
        Path(settings.rigid),
        [
            Channel("time", columns.time, settings.units.time, "s"),
            Channel("displacement", columns.displacement, settings.units.displacement, "m"),
            Channel("force", columns.force, settings.units.force, "N"),
        ],
    )
    rigid = ShearRecord(data["time"], data["displacement"], data["force"], source=settings.rigid)
    return Fixture.measured(rigid, degree=settings.rigid_degree)


def profile_of(record: ShearRecord) -> Found:
    """Kind of test of a record: loops pass their middle upwards twice or more; sliding goes far beyond the onset."""
    if len(crossings(record.displacement)) >= 2:
        return "loops"
    smooth, x = record.smooth_force, record.displacement
    if smooth[0] > 0.5 * smooth.max():
        return "sliding"
    try:
        onset = find_event(record).onset
    except InputError:
        return "ramp"
    return "sliding" if x[-1] - x[0] > LONG * (x[onset] - x[0]) else "ramp"
