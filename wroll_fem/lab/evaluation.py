"""Evaluate measurements by one of the kinds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from wroll_fem.errors import InputError
from wroll_fem.lab.inputs import checked_inputs, described
from wroll_fem.lab.kinds import KINDS, find_kind
from wroll_fem.lab.result import LabResult
from wroll_fem.lab.settings import LabSettings, read_settings
from wroll_fem.progress import KeptWarnings, Progress, SilentProgress
from wroll_fem.results.dataset import annotate


def evaluate(
    kind: str,
    files: Sequence[str | Path],
    *,
    settings_file: str | Path | None = None,
    progress: Progress | None = None,
    **settings: Any,
) -> LabResult:
    """Evaluate measurements.

    Parameters
    ----------
    kind
        Name of the kind, a key of `wroll_fem.lab.kinds.KINDS`.
    files
        Paths of the measurements; what they contain depends on the kind.
    settings_file
        YAML file with settings.
    progress
        Receiver of progress reports; silent by default.
    settings
        Settings of the kind, docs/reference/lab.md; they win over those of the file.

    Returns
    -------
    LabResult
        Summary, Dataset, warnings and figures.

    Raises
    ------
    InputError
        If kind, files or settings are wrong.
    """
    model = find_kind(kind).settings
    return evaluate_with(kind, files, read_settings(model, settings_file, values=settings), progress=progress)


def evaluate_with(
    kind: str, files: Sequence[str | Path], settings: LabSettings, *, progress: Progress | None = None
) -> LabResult:
    """Evaluate measurements with complete settings; parameters and errors as for `evaluate`."""
    declared = find_kind(kind)
    paths = checked_inputs(files, folders=declared.folders)
    inputs = tuple(described(path) for path in paths)
    kept = KeptWarnings(progress if progress is not None else SilentProgress())
    try:
        found = declared.evaluate(paths, settings, kept)
    except (np.linalg.LinAlgError, ArithmeticError) as error:  # of data without the motion that the kind needs
        reason = " ".join(str(error).split())[:120]
        raise InputError(
            f"the numbers of the measurement cannot be evaluated ({reason})", file=", ".join(map(str, paths[:3])),
            remedy="look at the columns over each other, and check columns, units and the kind of the test",
        ) from None  # fmt: skip
    summary = {"evaluation": kind, "files": len(paths), **found.summary, "warnings": list(kept.warnings)}
    attrs = {
        "evaluation": kind, "settings_yaml": settings.yaml(), "inputs": list(inputs), "warnings": kept.warnings,
        "summary": summary,
    }  # fmt: skip
    data = annotate(found.data).assign_attrs(attrs)
    return replace(
        found, summary=summary, data=data, kind=kind, settings=settings, inputs=inputs, drawings=declared.figures
    )


def is_evaluation(data: xr.Dataset) -> bool:
    """Whether a Dataset is the result of an evaluation, and not of a run."""
    return "evaluation" in data.attrs


def result_of(data: xr.Dataset, file: str | None = None) -> LabResult:
    """Result with its summary and figures from the Dataset of an evaluation.

    Parameters
    ----------
    data
        Content of a results.nc.
    file
        Its path, for messages.

    Raises
    ------
    InputError
        If the Dataset is of no kind of this version.
    """
    kind = data.attrs.get("evaluation")
    if kind not in KINDS:
        problem = f"contains no evaluation of this version ({kind})" if kind else "contains no evaluation"
        raise InputError(problem, file=file, remedy="give a result of `wroll lab`")
    summary = dict(data.attrs.get("summary") or {"evaluation": kind})
    inputs = tuple(data.attrs.get("inputs") or ())
    return LabResult(summary, data, kind=kind, inputs=inputs, drawings=find_kind(kind).figures)
