"""Versions of the libraries that wroll_fem depends on, and whether each works here (`wroll info`)."""

from __future__ import annotations

import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from wroll_fem.blas import VARIABLE, loaded_kernels, slow_kernels


@dataclass(frozen=True)
class Part:
    """One library: its version, and the problem if it does not work."""

    name: str
    version: str
    problem: str = ""


def _dolfinx() -> str:
    import dolfinx
    from mpi4py import MPI

    dolfinx.mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    return metadata.version("fenics-dolfinx")


def _petsc() -> str:
    from petsc4py import PETSc

    PETSc.Vec().createSeq(1).destroy()
    return ".".join(map(str, PETSc.Sys.getVersion()))


def _slepc() -> str:
    from slepc4py import SLEPc

    SLEPc.EPS().create().destroy()
    return ".".join(map(str, SLEPc.Sys.getVersion()))


def _numpy() -> str:
    import numpy as np

    return str(np.__version__)


def _scipy() -> str:
    import scipy
    import scipy.sparse.linalg

    return str(scipy.__version__)


def _blas() -> str:
    import scipy.linalg  # noqa: F401  (loads the library)

    if wanted := slow_kernels():
        raise RuntimeError(
            f"kernels without AVX; set {VARIABLE}={wanted} before Python starts, or import wroll_fem before numpy"
        )
    return "; ".join(loaded_kernels()) or "not OpenBLAS"


def _gmsh() -> str:
    """Mesh a box in a separate process, so that harmless MPI messages of gmsh are not shown."""
    code = (
        "import gmsh; gmsh.initialize([], readConfigFiles=False, interruptible=False); "
        "gmsh.option.setNumber('General.Terminal', 0); gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1); "
        "gmsh.model.occ.synchronize(); gmsh.model.mesh.generate(3); print(gmsh.option.getString('General.Version'))"
    )
    return _in_own_process(code, "cannot mesh").splitlines()[-1]


def _numba() -> str:
    import numba

    if numba.njit(lambda x: x + 1)(1) != 2:
        raise RuntimeError("compiled code gives a wrong result")
    return str(numba.__version__)


def _xarray() -> str:
    import xarray as xr

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "check.nc"
        xr.Dataset({"x": ("time", [1.0, 2.0])}).to_netcdf(path, engine="h5netcdf")
        if xr.load_dataset(path, engine="h5netcdf")["x"].values.tolist() != [1.0, 2.0]:
            raise RuntimeError("NetCDF does not read back what was written")
    return str(xr.__version__)


def _pyvista() -> str:
    """Render a figure in a separate process, because a broken OpenGL terminates the process."""
    import pyvista as pv

    code = "import pyvista as pv; p = pv.Plotter(off_screen=True); p.add_mesh(pv.Sphere()); p.screenshot(None)"
    _in_own_process(code, "cannot render off screen")
    return str(pv.__version__)


def _in_own_process(code: str, problem: str) -> str:
    """Run Python code in a separate process; return its output.

    Raises
    ------
    RuntimeError
        If the code fails, with the last line of its error output.
    """
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    if done.returncode:
        lines = done.stderr.strip().splitlines()
        raise RuntimeError(f"{problem} ({lines[-1] if lines else f'exit code {done.returncode}'})")
    return done.stdout.strip()


def _h5py() -> str:
    import h5py

    if Path(h5py.__file__).is_relative_to(sys.prefix):
        raise RuntimeError("comes from PyPI and clashes with dolfinx; pip uninstall h5py (Debian's is used then)")
    return str(h5py.__version__)


_PARTS: dict[str, Callable[[], str]] = {
    "python": platform.python_version, "dolfinx": _dolfinx, "petsc": _petsc, "slepc": _slepc, "numpy": _numpy,
    "scipy": _scipy, "blas": _blas, "gmsh": _gmsh, "numba": _numba, "xarray": _xarray, "pyvista": _pyvista,
    "h5py": _h5py,
}  # fmt: skip

#: Parts that only some figures need.
OPTIONAL = ("pyvista",)


def check_environment() -> list[Part]:
    """Import and test every library; return the results.

    Returns
    -------
    list of Part
        In a fixed order. dolfinx comes before h5py, because a clash of two HDF5 libraries shows only in this order.
    """
    parts = []
    for name, attempt in _PARTS.items():
        try:
            parts.append(Part(name, attempt()))
        except Exception as error:
            # any failure of a foreign library is what is to be reported here
            parts.append(Part(name, "-", f"{type(error).__name__}: {error}"))
    return parts
