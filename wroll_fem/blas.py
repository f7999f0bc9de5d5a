"""Kernels of OpenBLAS that suit the processor.

OpenBLAS selects its kernels by the model number of the processor. A model that is younger than the library is unknown
to it and gets kernels for any processor (OpenBLAS 0.3.21 of Debian 12: "Prescott", with a quarter of the speed of
AVX-512 in matrix products). The environment variable `OPENBLAS_CORETYPE` selects them by name. OpenBLAS reads it once,
when numpy or scipy is imported for the first time.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from contextlib import AbstractContextManager
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

VARIABLE = "OPENBLAS_CORETYPE"

GENERIC = ("Prescott", "Core2", "Generic", "Katmai", "Banias", "Northwood", "Athlon", "Opteron")
"""Kernels that use no AVX."""

AVX512 = frozenset({"avx512f", "avx512bw", "avx512dq", "avx512vl"})
AVX2 = frozenset({"avx2", "fma"})

FIRST_UNKNOWN_AMD = 26
"""Family of AMD processors (Zen 5) from which on OpenBLAS 0.3.21 knows none."""

CPUINFO = Path("/proc/cpuinfo")

USERS = ("numpy", "scipy.linalg", "petsc4py.PETSc")
"""Modules that load a BLAS when they are imported."""


def first_processor(file: Path = CPUINFO) -> dict[str, str]:
    """Entries of the first processor of Linux's /proc/cpuinfo; empty where there is no such file."""
    entries: dict[str, str] = {}
    try:
        with file.open(encoding="utf-8", errors="replace") as lines:
            for line in lines:
                if not line.strip():
                    break
                key, _, value = line.partition(":")
                entries[key.strip()] = value.strip()
    except OSError:
        return {}
    return entries


def suitable_kernels(processor: Mapping[str, str]) -> str | None:
    """Name of the OpenBLAS kernels for a processor of /proc/cpuinfo; None if OpenBLAS should choose.

    OpenBLAS knows the AMD processors up to Zen 4. For Intel, the instruction sets determine the kernels.
    """
    flags, vendor = set(processor.get("flags", "").split()), processor.get("vendor_id")
    family = processor.get("cpu family", "")
    if vendor == "AuthenticAMD" and not (family.isdecimal() and int(family) >= FIRST_UNKNOWN_AMD):
        return None
    if vendor not in ("AuthenticAMD", "GenuineIntel") or not flags >= AVX2:
        return None
    if flags >= AVX512:
        return "SkylakeX"
    return "Zen" if vendor == "AuthenticAMD" else "Haswell"


def select_kernels() -> None:
    """Set `OPENBLAS_CORETYPE` for this process and its children, unless it is set."""
    kernels = suitable_kernels(first_processor())
    if kernels is not None:
        os.environ.setdefault(VARIABLE, kernels)


@lru_cache
def _controller(imported: tuple[bool, ...]) -> ThreadpoolController:
    """Thread settings of the BLAS that are loaded; the search through all libraries of the process takes 10 ms."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def _present() -> ThreadpoolController:
    """Thread settings of the BLAS that the modules imported so far have loaded."""
    return _controller(tuple(name in sys.modules for name in USERS))


def one_thread() -> AbstractContextManager[Any]:
    """Context manager within which BLAS uses one thread: faster for small matrices, and results repeat bit by bit."""
    return _present().limit(limits=1, user_api="blas")


def _loaded() -> list[tuple[str, str]]:
    """Version and kernels of each OpenBLAS that is loaded in this process."""
    found = [library for library in _present().info() if library.get("internal_api") == "openblas"]
    return [(str(library["version"]), str(library["architecture"])) for library in found]


def loaded_kernels() -> list[str]:
    """Kernels of each OpenBLAS that is loaded in this process, "OpenBLAS 0.3.21, SkylakeX"."""
    return [f"OpenBLAS {version}, {kernels}" for version, kernels in _loaded()]


def slow_kernels() -> str | None:
    """Name of the kernels to select if OpenBLAS was loaded with generic ones and the processor has faster ones."""
    wanted = suitable_kernels(first_processor())
    return wanted if any(kernels in GENERIC for _, kernels in _loaded()) else None
