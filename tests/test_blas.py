"""Selection of the kernels of OpenBLAS."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from wroll_fem.blas import AVX2, AVX512, VARIABLE, first_processor, select_kernels, suitable_kernels

INTEL, AMD = "GenuineIntel", "AuthenticAMD"


@pytest.mark.parametrize(
    ("vendor", "family", "flags", "kernels"),
    [
        (INTEL, "6", AVX2 | AVX512, "SkylakeX"),
        (INTEL, "6", AVX2, "Haswell"),
        (INTEL, "6", {"sse4_2"}, None),
        (AMD, "25", AVX2 | AVX512, None),  # known to OpenBLAS
        (AMD, "26", AVX2 | AVX512, "SkylakeX"),
        (AMD, "26", AVX2, "Zen"),
        ("HygonGenuine", "24", AVX2, None),
    ],
)
def test_kernels_follow_the_instruction_sets(vendor, family, flags, kernels):
    processor = {"vendor_id": vendor, "cpu family": family, "flags": " ".join(sorted(flags))}
    assert suitable_kernels(processor) == kernels


def test_the_first_processor_is_read(tmp_path):
    file = tmp_path / "cpuinfo"
    file.write_text("processor\t: 0\nflags\t\t: fma avx2\n\nprocessor\t: 1\nflags\t\t: sse\n", encoding="utf-8")
    assert first_processor(file) == {"processor": "0", "flags": "fma avx2"}
    assert first_processor(tmp_path / "missing") == {}


def test_a_choice_of_the_user_is_kept(monkeypatch):
    monkeypatch.setenv(VARIABLE, "Haswell")
    select_kernels()
    assert os.environ[VARIABLE] == "Haswell"


@pytest.mark.skipif(suitable_kernels(first_processor()) is None, reason="OpenBLAS chooses on this processor")
def test_importing_the_package_first_loads_suitable_kernels():
    code = "import wroll_fem, numpy, wroll_fem.blas as b; print(b.loaded_kernels(), b.slow_kernels())"
    environment = {key: value for key, value in os.environ.items() if key != VARIABLE}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )  # fmt: skip
    assert done.stdout.strip().endswith("None"), done.stdout
    if "OpenBLAS" in done.stdout:
        assert f", {suitable_kernels(first_processor())}'" in done.stdout
