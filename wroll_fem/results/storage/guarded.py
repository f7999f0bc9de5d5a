"""Trial of a results file without checksum in a child process: HDF5 may hang or crash on a damaged file."""

from __future__ import annotations

import os
import subprocess
import sys

LEAST_SECONDS, BYTES_PER_SECOND = 3, 10_000_000
"""CPU time that reading may take: a minimum, and a tenth of the usual speed with decompression."""

MEMORY = 8 << 30
"""Address space that the trial may use, bytes; a damaged size of an array asks for more."""

_TRIAL = """
import math, resource, sys, time
seconds, memory, path = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
resource.setrlimit(resource.RLIMIT_AS, (memory, resource.getrlimit(resource.RLIMIT_AS)[1]))
resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
import xarray
seconds += math.ceil(time.process_time())
resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
try:
    xarray.load_dataset(path, engine="h5netcdf")
except Exception as error:
    print(" ".join(str(error).split())[:80] or type(error).__name__)
"""


def trial_reading(path: str | os.PathLike[str]) -> str:
    """Read a NetCDF file once in a child process with limits on CPU time and memory.

    Returns
    -------
    str
        Why the file cannot be read; empty if it can.
    """
    seconds = LEAST_SECONDS + os.path.getsize(path) // BYTES_PER_SECOND
    words = [str(seconds), str(max(MEMORY, 50 * os.path.getsize(path))), os.fspath(path)]
    done = subprocess.run(
        [sys.executable, "-P", "-c", _TRIAL, *words], stdin=subprocess.DEVNULL, capture_output=True, text=True,
        errors="replace", check=False,
    )  # fmt: skip
    if done.returncode:
        return "HDF5 does not return from it" if done.returncode in (-24, -9) else "HDF5 crashes on it"
    return done.stdout.strip()
