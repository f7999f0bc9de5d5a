"""Properties of matrix files for generated structures (hypothesis, derandomised)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from support.structures import oscillator

from wroll_fem.dynamics.system.io import load_system, save_system
from wroll_fem.dynamics.system.matrix_checks import symmetry_problem
from wroll_fem.errors import InputError

SAME = settings(
    derandomize=True, deadline=None, max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
entries = st.floats(-1e3, 1e3)


def written(path: Path, fields: dict[str, Any]) -> Path:
    if path.suffix == ".npz":
        np.savez(path, **fields)
    else:
        scipy.io.savemat(path, fields)
    return path


@SAME
@given(
    half=arrays(np.float64, (3, 3), elements=entries),
    mass=arrays(np.float64, 3, elements=st.floats(1e-3, 1e3)),
    probe=arrays(np.float64, 3, elements=entries),
    form=st.sampled_from([np.asarray, sp.csr_matrix, sp.csc_matrix, sp.coo_matrix]),
    suffix=st.sampled_from([".npz", ".mat"]),
)
def test_any_structure_comes_back_bit_by_bit(
    half: np.ndarray, mass: np.ndarray, probe: np.ndarray, form: Any, suffix: str, tmp_path: Path
) -> None:
    stiffness = half @ half.T + np.diag([1.0, 2.0, 3.0])
    fields = {
        "K": stiffness, "M": np.diag(mass), "influence": [1, 0, 0], "probe_tip": probe, "load_own": probe[::-1],
    }  # fmt: skip
    if suffix == ".mat":
        fields["K"] = form(stiffness)
    first, _ = load_system(written(tmp_path / f"a{suffix}", fields))
    again, _ = load_system(save_system(first, tmp_path / f"b{suffix}"))
    for system in (first, again):
        assert sp.csr_matrix(system.stiffness).toarray().tobytes() == stiffness.tobytes()
        assert sp.csr_matrix(system.mass).toarray().tobytes() == np.diag(mass).tobytes()
        np.testing.assert_array_equal(system.probes["tip"], probe)
        np.testing.assert_array_equal(system.loads["own"], probe[::-1])


@SAME
@given(
    name=st.sampled_from(sorted(oscillator())),
    value=st.none()
    | st.floats()
    | st.text("xµ", max_size=3)
    | arrays(np.float64, st.sampled_from([(0,), (2,), (3,), (2, 2), (3, 2), (1, 2, 2)]), elements=st.floats()),
    suffix=st.sampled_from([".npz", ".mat"]),
)
def test_any_value_of_any_field_is_a_structure_or_one_line(name: str, value: Any, suffix: str, tmp_path: Path) -> None:
    path = written(tmp_path / f"structure{suffix}", oscillator(**{name: value}))
    refused: list[InputError] = []
    try:
        load_system(path)
    except InputError as error:
        refused.append(error)
    for error in refused:
        assert "\n" not in str(error)
        assert str(path) in str(error)
        assert error.remedy


@SAME
@given(row=st.integers(0, 1), column=st.integers(0, 1), wrong=st.sampled_from([np.nan, np.inf, -np.inf]))
def test_no_entry_of_a_matrix_may_be_infinite(row: int, column: int, wrong: float, tmp_path: Path) -> None:
    stiffness = np.array(oscillator()["K"])
    stiffness[row, column] = wrong
    with pytest.raises(InputError, match=r"K: .*(finite|nan|inf)"):
        load_system(written(tmp_path / "s.npz", oscillator(K=stiffness)))


def test_rounding_is_symmetric_and_a_difference_above_it_is_located() -> None:
    """Sums in another order differ in their last digits."""
    matrix = sp.csr_matrix(np.array([[4.0, 1.0, 0.0], [1.0, 3.0, 2.0], [0.0, 2.0, 5.0]]))
    rounded, wrong = matrix.copy(), matrix.copy()
    rounded[1, 2] *= 1.0 + 1e-15
    wrong[1, 2] *= 1.01
    assert symmetry_problem(matrix) == symmetry_problem(rounded) == ("", "")
    assert "entries (1, 2) and (2, 1), counted from 0, differ by 0.02" in symmetry_problem(wrong)[0]
