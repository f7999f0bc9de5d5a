"""Fake analyses that replace the real ones, so that command line and run folder are tested in milliseconds."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import xarray as xr

from support.paths import CONFIGS
from wroll_fem.errors import ConvergenceError
from wroll_fem.results.storage.atomic import replacing
from wroll_fem.results.storage.checkpoint import write_checkpoint

TINY = CONFIGS / "tiny.yaml"


class FakeAnalyses(ModuleType):
    """What `wroll_fem.analyses` offers, without finite elements."""

    def __init__(self) -> None:
        super().__init__("wroll_fem.analyses")
        self.calls: list[dict[str, Any]] = []
        self.fails: BaseException | None = None
        self.leaves_checkpoint = False

    def run_analysis(
        self, case: Any, *, progress: Any, checkpoint: Path | None = None, resume: bool = False
    ) -> xr.Dataset:
        self.calls.append({"case": case, "checkpoint": checkpoint, "resume": resume})
        with progress.stage("fake analysis", 2, "steps") as stage:
            stage.update(1, "half")
            if self.leaves_checkpoint and checkpoint is not None:
                write_checkpoint(checkpoint, {"step": 1})
            if self.fails is not None:
                raise self.fails
            stage.update(2)
        return self.dataset()

    def dataset(self) -> xr.Dataset:
        attrs = {"seed": 3, "flag": True, "nothing": None, "list": [1.0, 2.0]}
        return xr.Dataset({"tip_displacement": ("time", [0.0, 1e-5])}, {"time": [0.0, 1e-4]}, attrs)

    def find_analysis(self, name: str) -> SimpleNamespace:
        return SimpleNamespace(resumable=name in ("sweep", "dwell"))

    def summarise(self, dataset: xr.Dataset) -> dict[str, Any]:
        return {
            "f_n_hz": np.float64(150.25), "zeta": 0.0213, "peak_transmissibility": float("nan"), "dofs": 1200,
            "energy_balance_error": 0.0012, "friction_energy_j": 1.5e-3, "interface_pressure_mean_pa": np.array([5e4]),
        }  # fmt: skip

    def estimate(self, case: Any) -> dict[str, Any]:
        return {"dofs": 1200, "interface_points": 60, "steps": 160, "estimated_seconds": 1.25}

    def case_warnings(self, case: Any) -> list[str]:
        return ["the mesh is coarse; use mesh.axial >= 20"] if case.mesh.axial < 5 else []

    def write_fields(self, dataset: xr.Dataset, folder: Path) -> None:
        with replacing(folder / "slip_map.vtu") as file:
            file.write_text("fields")

    def write_figures(self, dataset: xr.Dataset, folder: Path) -> list[Path]:
        path = folder / "tip.png"
        with replacing(path) as file:
            file.write_bytes(b"picture")
        return [path]


def tree(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def failure(partial: xr.Dataset | None) -> ConvergenceError:
    error = ConvergenceError(
        "step did not converge", time_s=0.01, iterations=30, residual_history=[1.0, 0.5], advice="use smaller steps"
    )
    error.partial = partial
    return error
