"""Provenance of results: versions, git revision, machine, time."""

from __future__ import annotations

import os
import platform
import subprocess
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import Path

from wroll_fem.blas import loaded_kernels

# Distribution names. Read from their metadata: importing dolfinx or gmsh for a version number would cost seconds.
DISTRIBUTIONS = {
    "wroll_fem": "wroll-fem",
    "numpy": "numpy",
    "scipy": "scipy",
    "xarray": "xarray",
    "h5netcdf": "h5netcdf",
    "numba": "numba",
    "pydantic": "pydantic",
    "matplotlib": "matplotlib",
    "gmsh": "gmsh",
    "meshio": "meshio",
    "pyvista": "pyvista",
    "dolfinx": "fenics-dolfinx",
    "petsc4py": "petsc4py",
    "slepc4py": "slepc4py",
    "mpi4py": "mpi4py",
}


def program_version() -> str:
    """Version of the installed package."""
    return metadata.version(DISTRIBUTIONS["wroll_fem"])


def versions() -> dict[str, str | None]:
    """Versions of Python and the libraries by name; None if a library is not installed."""
    return {"python": platform.python_version()} | {name: _version(own) for name, own in DISTRIBUTIONS.items()}


@cache
def _version(distribution: str) -> str | None:
    """Version of an installed distribution; its search takes some milliseconds, and each result names all of them."""
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return None


_REVISION = "# branch.oid "
"""Beginning of the line of `git status --branch` with the revision."""


def _git(folder: Path, *arguments: str) -> str | None:
    """Output of a git command in `folder`; None if git is missing or fails."""
    try:
        done = subprocess.run(
            ["git", "--no-optional-locks", "-C", str(folder), *arguments],  # else `status` locks the index
            capture_output=True, text=True, timeout=10, check=False,
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.strip() if done.returncode == 0 else None


def git_revision(folder: Path | None = None) -> dict[str, str | bool | None]:
    """Git revision of the checkout of this package, and whether it has uncommitted changes.

    Returns
    -------
    dict
        `revision` (full hash) and `modified`; both None when the package is not a file tracked by git
        (installed from a wheel, even into a folder inside some other repository).
    """
    here = folder or Path(__file__).resolve().parent
    state = _git(here, "status", "--porcelain=v2", "--branch", "--untracked-files=no", "--", ".")
    lines = [] if state is None else state.splitlines()
    revision = next((line.removeprefix(_REVISION) for line in lines if line.startswith(_REVISION)), None)
    if revision in (None, "(initial)") or not _tracks_package(here, revision):
        return {"revision": None, "modified": None}
    return {"revision": revision, "modified": any(not line.startswith("#") for line in lines)}


@cache
def _tracks_package(folder: Path, revision: str) -> bool:
    """Whether the package in ``folder`` is tracked; asked once per revision."""
    return _git(folder, "ls-files", "--error-unmatch", "__init__.py") is not None


def provenance() -> dict[str, object]:
    """Collect the general entries of provenance.json, in JSON types.

    Returns
    -------
    dict
        `versions`, `git`, `machine` (system, machine, processor count, host name, OMP_NUM_THREADS, kernels of
        OpenBLAS) and `time_utc` (ISO 8601).
    """
    return {
        "versions": versions(),
        "git": git_revision(),
        "machine": {
            "system": platform.platform(),
            "architecture": platform.machine(),
            "processors": os.cpu_count(),
            "host": platform.node(),
            "omp_num_threads": os.environ.get("OMP_NUM_THREADS"),
            "blas": "; ".join(loaded_kernels()),
        },
        "time_utc": datetime.now(UTC).isoformat(timespec="seconds"),
    }
