"""Trial of a file in a child process: the native libraries HDF5 and gmsh may hang or crash on a damaged file."""

from __future__ import annotations

import os
import subprocess
import sys

LEAST_SECONDS, BYTES_PER_SECOND = 3, 10_000_000
"""CPU time that reading may take: a minimum, and a tenth of the usual speed with decompression."""

MEMORY = 8 << 30
"""Address space that the trial may use, bytes; a damaged size of an array asks for more."""

_LIMITS = """
import math, resource, sys, time
seconds, memory, path = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
resource.setrlimit(resource.RLIMIT_AS, (memory, resource.getrlimit(resource.RLIMIT_AS)[1]))
resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
{imports}
seconds += math.ceil(time.process_time())
resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
"""

_TRIAL = (
    _LIMITS.format(imports="import xarray")
    + """
try:
    xarray.load_dataset(path, engine="h5netcdf")
except Exception as error:
    print(" ".join(str(error).split())[:80] or type(error).__name__)
"""
)

_TRIAL_OF_MESH = (
    _LIMITS.format(imports="import gmsh")
    + """
gmsh.initialize([], readConfigFiles=False, interruptible=False)
gmsh.option.setNumber("General.Terminal", 0)
try:
    gmsh.merge(path)
    gmsh.model.mesh.getNodes()
    for dim, group in gmsh.model.getPhysicalGroups():
        gmsh.model.getPhysicalName(dim, group)
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dim, group):
            for kind in gmsh.model.mesh.getElements(dim, entity)[0]:
                gmsh.model.mesh.getElementProperties(kind)
except Exception:
    pass
print("read")
"""
)


def trial_reading(path: str | os.PathLike[str]) -> str:
    """Read a NetCDF file once in a child process with limits on CPU time and memory.

    Returns
    -------
    str
        Why the file cannot be read; empty if it can.
    """
    done = _tried(_TRIAL, path)
    return _ended(done, "HDF5") if done.returncode else done.stdout.strip()


def trial_mesh(path: str | os.PathLike[str]) -> str:
    """Read a mesh file with gmsh once in a child process with limits on CPU time and memory.

    Returns
    -------
    str
        How gmsh ends the process; empty if it returns, also with an error.
    """
    done = _tried(_TRIAL_OF_MESH, path)
    return "" if done.stdout.endswith("read\n") else _ended(done, "gmsh")


def _tried(script: str, path: str | os.PathLike[str]) -> subprocess.CompletedProcess[str]:
    seconds = LEAST_SECONDS + os.path.getsize(path) // BYTES_PER_SECOND
    words = [str(seconds), str(max(MEMORY, 50 * os.path.getsize(path))), os.fspath(path)]
    return subprocess.run(
        [sys.executable, "-P", "-c", script, *words], stdin=subprocess.DEVNULL, capture_output=True, text=True,
        errors="replace", check=False,
    )  # fmt: skip


def _ended(done: subprocess.CompletedProcess[str], library: str) -> str:
    return f"{library} does not return from it" if done.returncode in (-24, -9) else f"{library} crashes on it"
