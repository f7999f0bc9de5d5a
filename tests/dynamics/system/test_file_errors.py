"""What is wrong with a file of matrices, or with a case that uses one, in one line."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp
import xarray as xr
from support.structures import DWELL, FORCE, MASS, K, oscillator, write_case, wroll

from wroll_fem.analyses import run_analysis
from wroll_fem.case import load_case
from wroll_fem.progress import SilentProgress

UP = np.array([[K, 5.0], [0.0, 1.0]])
WRONG = {
    "no K": ({"K": None}, "K: required field is missing; add it (stiffness matrix, N/m)"),
    "no M": ({"M": None}, "M: required field is missing; add it (mass matrix, kg)"),
    "no influence": ({"influence": None}, "influence: required field is missing; add it (displacement of each DOF"),
    "no tip": ({"probe_tip": None}, "probe_tip: required field is missing; add it (row that gives the displacement"),
    "no operator": ({"interface_1_operator": None}, "interface_1_operator: required field is missing"),
    "no area": ({"interface_1_area": None}, "interface_1_area: required field is missing; add it (area of each point"),
    "no law": ({"interface_1_friction_law": None}, "interface_1_friction_law: required field is missing"),
    "no mu": ({"interface_1_friction_mu": None}, "interface_1_friction_mu: required field is missing"),
    "no kn": ({"interface_1_normal_stiffness": None}, "interface_1_normal_stiffness: required field is missing"),
    "K not square": ({"K": np.ones((2, 3))}, "K: is 2 x 3, not 2 x 2; write the stiffness matrix"),
    "M too large": ({"M": np.eye(3)}, "M: is 3 x 3, not 2 x 2; write the mass matrix, kg"),
    "influence too long": ({"influence": [1, 0, 0]}, "influence: is 1 x 3, not 2 values; write the displacement"),
    "influence table": ({"influence": np.eye(2)}, "influence: is 2 x 2, not 2 values"),
    "operator short": ({"interface_1_operator": [[0, 1], [1, 0]]}, "interface_1_operator: is 2 x 2, not 3 x 2"),
    "points": ({"interface_1_points": [0, 0]}, "interface_1_points: is 1 x 2, not 1 x 3; write the theta (rad)"),
    "one triangle": ({"K": UP}, "K: holds one triangle only; write the whole matrix"),
    "unsymmetric": ({"K": [[K, 5.0], [4.0, 1.0]]}, "K: is not symmetric: entries (0, 1) and (1, 0), counted from 0"),
    "negative mass": ({"M": np.diag([1.0, -1.0])}, "M: is not positive semi-definite: diagonal entry 1, counted"),
    "indefinite mass": ({"M": [[1.0, 2.0], [2.0, 1.0]]}, "M: is not positive semi-definite: it has a negative eigen"),
    "hollow mass": ({"M": [[1.0, 0.1], [0.1, 0.0]]}, "M: is not positive semi-definite: row 1, counted from 0, has"),
    "negative damping ratio": ({"damping_ratios": np.array([0.01, -0.01])}, "damping_ratios: is empty or negative"),
    "unsorted damping table": (
        {"damping_table": np.array([[20.0, 0.01], [10.0, 0.01]])},
        "damping_table: has negative numbers, or frequencies that do not rise",
    ),
    "lossy matrix": ({"damping_loss": np.diag([1.0, -1.0])}, "damping_loss: is not symmetric with a positive diagonal"),
    "two kinds of ratios": (
        {"damping_ratios": np.array([0.01]), "damping_loss": np.diag([1.0, 1.0])},
        "damping_ratios: is given beside damping_loss",
    ),
    "negative damping": ({"C": np.diag([1.0, -1.0])}, "C: is not positive semi-definite"),
    "negative stiffness": ({"K": np.diag([-K, 0.0])}, "K: is not positive semi-definite: diagonal entry 0"),
    "massless": ({"M": np.diag([1.0, 0.0])}, "M: is singular: 1 DOFs carry no mass; eliminate"),
    "singular mass": ({"M": np.ones((2, 2))}, "M: is singular; eliminate these DOFs (Guyan condensation)"),
    "NaN": ({"K": np.diag([K, np.nan])}, "K: holds NaN or infinite values; write finite numbers"),
    "complex": ({"K": np.diag([K * (1 + 0.02j), 0])}, "K: is complex; write real matrices; structural damping"),
    "text": ({"M": "identity"}, "M: does not hold numbers; write real numbers"),
    "number for text": ({"interface_1_friction_law": 3}, "interface_1_friction_law: is not a text"),
    "area zero": ({"interface_1_area": 0}, "interface_1_area: area 0, counted from 0, is 0 m^2; give every point a"),
    "area negative": ({"interface_1_area": -1}, "interface_1_area: area 0, counted from 0, is -1 m^2"),
    "law unknown": ({"interface_1_friction_law": "dahl"}, "is 'dahl'; use one of: penalty_coulomb, rate_coulomb"),
    "mu negative": ({"interface_1_friction_mu": -0.1}, "interface_1_friction_law: coefficient of friction -0.1 is neg"),
    "kn zero": ({"interface_1_normal_stiffness": 0}, "interface_1_normal_stiffness: is 0 Pa/m; give a positive"),
    "no normal": ({"interface_1_operator": [[0, 0], [1, 0], [0, 1]]}, "the normal row of point 0, counted from 0, is"),
    "turned load": ({"load_preload": [0, FORCE]}, "load_preload: the preload opens every contact point; reverse"),
    "turned normal": ({"interface_1_operator": [[0, -1], [1, 0], [0, 0]]}, "load_preload: the preload opens every con"),
    "loose body": ({"interface_1_operator": [[1, 0], [1, 0], [0, 0]], "load_preload": [-1, 0]}, "K: is singular, alth"),
    "pressure": (
        {"load_preload": None, "interface_1_preload_pressure": -1}, "interface_1_preload_pressure: is -1 Pa at one poi"
    ),
    "two states": (
        {"interface_1_preload_pressure": 1, "interface_1_preload_jump": [0, 0, 0]}, "is given with other fields of a p"
    ),
    "turned traction": (
        {"interface_1_preload_jump": [-1e-7, 0, 0], "interface_1_preload_traction": [10, 0, 0],
         "interface_1_preload_elastic_slip": [0, 0]}, "follow from its laws: tractions differ by up to 20 Pa"
    ),
    "unbalanced": (
        {"interface_1_preload_jump": [-2e-7, 0, 0], "interface_1_preload_traction": [-20, 0, 0],
         "interface_1_preload_elastic_slip": [0, 0], "preload_displacement": [0, -2e-7]},
        "the preload state does not balance load_preload (relative error"
    ),
    "half a state": ({"interface_1_preload_jump": [0, 0, 0]}, "interface_1_preload_traction: required field is miss"),
    "misspelt": ({"interface_1_frction_mu": 0.2}, "interface_1_frction_mu: unknown field; did you mean interface_1_fr"),
    "stiffness": ({"stiffness": 1.0}, "stiffness: unknown field; did you mean K? (fields of your own begin with user_"),
    "gap in numbers": ({"interface_3_area": 1.0}, "has the interfaces 1, 3; number them 1, 2, ... from the inside"),
    "newer": ({"wroll_format": 2}, "wroll_format: has format 2; read it with a newer wroll_fem"),
}  # fmt: skip


@pytest.mark.parametrize(("changes", "expected"), WRONG.values(), ids=WRONG)
def test_a_wrong_field_gets_one_line_with_file_field_and_remedy(tmp_path: Path, changes: Any, expected: str) -> None:
    path = write_case(tmp_path, oscillator(**changes))
    done = wroll("validate", path)
    assert done.exit_code == 2
    assert expected in done.output
    assert done.output.startswith(f"{tmp_path / 'structure.mat'}: ")
    assert done.output.count("\n") == 1


def test_a_massless_dof_needs_the_whole_structure(tmp_path: Path) -> None:
    short = {"excitation": DWELL | {"cycles": 5.0, "ramp_cycles": 2.0}}
    expected = run_analysis(load_case(write_case(tmp_path, oscillator(), **short)), progress=SilentProgress())
    path = write_case(tmp_path, oscillator(M=np.diag([MASS, 0.0])), solver={"method": "full"}, **short)
    result = run_analysis(load_case(path), progress=SilentProgress())
    assert float(result["friction_energy"][-1]) > 0.0
    scale = float(np.abs(expected["tip_displacement"]).max())
    np.testing.assert_allclose(result["tip_displacement"], expected["tip_displacement"], atol=1e-6 * scale)


def files(folder: Path) -> dict[str, tuple[Path, str]]:
    """Files that are no structure, and what is said about each."""
    pickled, parts, damaged, text = (folder / name for name in ("pickled.npz", "parts.npz", "damaged.npz", "text.mat"))
    np.savez(pickled, **oscillator(K=np.array(sp.csr_matrix(np.eye(2)), dtype=object)))
    sparse = {"K_data": [1.0], "K_indptr": [0, 1, 1], "K_shape": [2, 2]}
    np.savez(parts, **oscillator(K=None), **sparse)
    np.savez(folder / "wild.npz", **oscillator(K=None), **sparse, K_indices=[7])
    damaged.write_bytes(b"PK\x03\x04 and then nothing")
    np.savez_compressed(folder / "compression.npz", **oscillator())
    packed = (folder / "compression.npz").read_bytes()
    # method 8 (deflate), after version and flags, in both headers of every member
    unknown = re.sub(rb"(PK(?:\x03\x04|\x01\x02..)..\0\0)\x08\0", b"\\1\x63\0", packed, flags=re.DOTALL)
    assert unknown != packed
    (folder / "compression.npz").write_bytes(unknown)
    np.savez(folder / "header.npz", **oscillator())
    whole_header = (folder / "header.npz").read_bytes()
    (folder / "header.npz").write_bytes(whole_header.replace(b"{'descr': ", b"{'descr':((", 1))
    text.write_text("# Created by Octave 8\n# name: K\n")
    (folder / "hdf.mat").write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512) + b"\x89HDF\r\n")
    whole = folder / "whole.mat"
    scipy.io.savemat(whole, oscillator())
    (folder / "cut.mat").write_bytes(whole.read_bytes()[:300])
    return {
        "pickled": (
            pickled,
            "K: is a pickled Python object; save K_data, K_indices, K_indptr, K_shape, or K.toarra",
        ),
        "parts": (parts, "K: K_indices is missing; save all four parts of the sparse matrix"),
        "wild": (folder / "wild.npz", "K: its sparse parts do not fit together"),
        "damaged": (damaged, "is not a readable .npz file"),
        "compression": (folder / "compression.npz", "is not a readable .npz file (That compression method is not"),
        "header": (folder / "header.npz", "is not a readable .npz file"),
        "text": (text, "is not a readable .mat file"),
        "hdf": (folder / "hdf.mat", "is a MATLAB v7.3 (HDF5) file, which is not read here; save it again with -v7"),
        "cut": (folder / "cut.mat", "is not a readable .mat file"),
    }


@pytest.mark.parametrize("kind", ["pickled", "parts", "wild", "damaged", "compression", "header", "text", "hdf", "cut"])
def test_a_file_that_is_no_structure_is_refused_in_one_line(tmp_path: Path, kind: str) -> None:
    file, expected = files(tmp_path)[kind]
    path = write_case(tmp_path, {}, structure={"file": file.name})
    done = wroll("run", path, "--out", tmp_path / "run")
    assert done.exit_code == 2
    assert done.output.startswith(f"{file}: {expected}")
    assert done.output.count("\n") == 1


@pytest.mark.parametrize(
    ("sections", "expected"),
    [
        ({"geometry": {"length": 0.3, "mandrel_outer_diameter": 0.08, "mandrel_thickness": 1e-3}},
         "geometry: cannot be combined with structure, whose file replaces it; leave geometry out, or leave "
         "structure out"),
        ({"coil": {"model": "none"}}, "coil: cannot be combined with structure, whose file replaces it"),
        ({"mesh": {"axial": 12}}, "mesh: cannot be combined with structure, whose file replaces it"),
        ({"preload": {"pressure": 1e5}}, "preload: cannot be combined with structure, whose file replaces it"),
        ({"excitation": DWELL | {"direction": "x"}},
         "excitation.direction: the direction is set by the influence vector in structure.file, got 'x'; leave it out"),
        ({"structure": {"file": "nothing.npz"}}, "structure.file: structure file not found, got '"),
        ({"structure": {"file": "case.yaml"}}, "structure.file: must be a .npz or .mat file, got '"),
        ({"structure": {"file": 3}}, "structure.file: must be the path of a .npz or .mat file, got 3"),
        ({"structure": {}}, "structure.file: required key is missing; add it (matrices and interfaces"),
        ({"structure": {"file": "structure.mat", "preload_steps": 0}}, "structure.preload_steps: must be 1 or more"),
    ],
)  # fmt: skip
def test_a_case_with_structure_says_what_does_not_belong(tmp_path: Path, sections: Any, expected: str) -> None:
    path = write_case(tmp_path, oscillator(), **sections)
    done = wroll("validate", path)
    assert done.exit_code == 2
    told = re.fullmatch(rf"{re.escape(f'{path}:')}(\d+): {re.escape(expected)}.*\n", done.output)
    assert told is not None
    section, _, key = expected.split(": ")[0].partition(".")
    place = section if "required key is missing" in expected else key or section
    assert path.read_text().splitlines()[int(told[1]) - 1].strip().startswith(f"{place}:")


def test_a_case_without_structure_names_every_section_that_is_missing(tmp_path: Path) -> None:
    path = write_case(tmp_path, oscillator(), structure=None)
    done = wroll("validate", path)
    assert done.exit_code == 2
    assert [line.removeprefix(f"{path}: ").split(";")[0] for line in done.output.splitlines()] == [
        f"{section}: required section is missing" for section in ("geometry", "mandrel", "coil")
    ]


def test_doubtful_files_are_warned_about(tmp_path: Path) -> None:
    loose = wroll("validate", write_case(tmp_path, oscillator(load_preload=None)))
    assert "warning: the interfaces have no preload" in loose.output
    wrong_row = wroll("validate", write_case(tmp_path, oscillator(probe_tip=[0.5, 0])))
    assert "warning: probe_tip moves 0.5 m when the base moves 1 m" in wrong_row.output
    still = wroll("validate", write_case(tmp_path, oscillator(influence=[0, 0])))
    assert "warning: influence is zero" in still.output
    assert [r.exit_code for r in (loose, wrong_row, still)] == [0, 0, 0]


def test_matrices_cannot_be_meshed(tmp_path: Path) -> None:
    done = wroll("mesh", write_case(tmp_path, oscillator()), "--out", tmp_path / "mesh")
    assert done.exit_code == 2
    assert "structure: cannot be meshed; its file contains only matrices" in done.output


@pytest.mark.parametrize("name", ["roll.txt", "no/such/folder/roll.npz"])
def test_export_says_where_it_cannot_write(tmp_path: Path, name: str) -> None:
    path = write_case(tmp_path, oscillator())
    done = wroll("export", path, "--out", tmp_path / name)
    assert done.exit_code == 2
    assert re.search(r"is neither \.npz nor \.mat; give|cannot be written \(No such file", done.output)


def test_a_dry_run_knows_the_size_of_the_file(tmp_path: Path) -> None:
    done = wroll("run", write_case(tmp_path, oscillator()), "--dry-run")
    assert done.exit_code == 0
    assert re.search(r"dofs +2\ninterface points +1\nsteps +1200", done.output)


def test_analysis_preload_works_on_a_structure(tmp_path: Path) -> None:
    result = run_analysis(load_case(write_case(tmp_path, oscillator(), analysis="preload")), progress=SilentProgress())
    assert isinstance(result, xr.Dataset)
    assert float(result["pressure"][0, 0]) == pytest.approx(FORCE, rel=1e-9)
