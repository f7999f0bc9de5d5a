"""Case study of section 2.4: valid inputs of its case file, and runs with both discretisations on coarse meshes."""

from __future__ import annotations

import json

import matplotlib.pyplot as plt
import numpy as np
import pytest

from wroll_fem.analyses import write_figures
from wroll_fem.analyses.shared import figures
from wroll_fem.case import load_case
from wroll_fem.errors import InputError
from wroll_fem.jobs.run import run_case
from wroll_fem.mesh.point_grid import coil_grid
from wroll_fem.plotting import names
from wroll_fem.plotting.coil_slip import points_of
from wroll_fem.plotting.style import figure_of
from wroll_fem.results.dataset import load_dataset

COARSE = [
    "mesh.circumferential=8", "mesh.axial=8", "mesh.grading=12", "mesh.radial=3", "mesh.radial_grading=8",
    "modal.count=3",
]  # fmt: skip
FIGURES = {"steady_response", "shear_distribution", "root_section", "slip_zone", "modes"}


@pytest.fixture(scope="module")
def runs(root, tmp_path_factory):
    """Finished runs of both discretisations without figures: summaries and results."""
    folder, found = tmp_path_factory.mktemp("case_study"), {}
    for name in ("three_dimensional", "fourier"):
        words = [*COARSE, f"mesh.discretisation={name}", "output.figures=false"]
        run = run_case(load_case(root / "configs" / "case_study.yaml", words), folder / name)
        found[name] = run, load_dataset(run.folder.results_file)
    return found


def test_both_discretisations_answer_alike(runs):
    (solid, a), (harmonics, b) = runs["three_dimensional"], runs["fourier"]
    assert a.attrs["f_n_hz"] == pytest.approx(b.attrs["f_n_hz"], rel=5e-3)
    assert a.attrs["transmissibility"] == pytest.approx(b.attrs["transmissibility"], rel=2e-3)
    assert float(a["volume"].sum()) == pytest.approx(float(b["volume"].sum()), rel=1e-3)  # quadratic arcs
    # half way up, where both meshes resolve the stress: largest of each component on the innermost points
    middle = {}
    for name, data in (("a", a), ("b", b)):
        grid = coil_grid(points_of(data))
        assert grid is not None
        inner = {key: data[key].values[grid.numbers[0]].max(axis=1) for key in ("shear_rz", "shear_rt")}
        middle[name] = [grid.r[0], *(np.interp(0.15, grid.z, values) for values in inner.values())]
    np.testing.assert_allclose(middle["a"][:2], middle["b"][:2], rtol=0.02)
    assert middle["a"][2] == pytest.approx(middle["b"][2], abs=0.02 * middle["b"][1])  # hoop shear is small there
    assert solid.summary["slip_onset_g"] == pytest.approx(
        harmonics.summary["slip_onset_g"], rel=0.35
    )  # root unresolved


def test_slip_starts_on_the_face_and_stress_has_its_symmetry(runs):
    data = runs["three_dimensional"][1]
    grid = coil_grid(points_of(data))
    assert grid is not None
    rz, rt = (data[name].values[grid.numbers] for name in ("shear_rz", "shear_rt"))
    np.testing.assert_allclose(rz, rz[:, :, ::-1], atol=1e-4 * rz.max())  # mirror about the plane of excitation
    np.testing.assert_allclose(rt, rt[:, :, ::-1], atol=1e-4 * rt.max())
    scale = np.abs(np.cos(grid.theta))
    np.testing.assert_allclose(rz, (rz / scale).mean(axis=2, keepdims=True) * scale, atol=0.02 * rz.max())
    assert data["shear_resultant"].values[grid.numbers].max(axis=(1, 2)).argmax() == 0  # innermost


def test_summary_and_files_of_a_run(runs):
    run = runs["fourier"][0]
    summary = json.loads(run.folder.summary_file.read_text(encoding="utf-8"))
    assert summary["analysis"] == "modal_transient"
    assert summary["amplitude_g"] == [1.0, 3.0, 5.0, 8.0, 11.0, 15.0]
    fraction = summary["slipping_volume_fraction"]
    assert len(fraction) == 6
    assert fraction == sorted(fraction)
    assert summary["slip_statement"].startswith("slip starts above")
    assert summary["capacity_mandrel_pa"] > 1e6
    assert (run.folder.fields / "coil_slip.vtu").is_file()


def test_a_run_makes_its_figures(runs, tmp_path, monkeypatch):
    """All but those in space, without writing them, which takes most of the time."""
    monkeypatch.setattr(names, "save", lambda ax, path: (plt.close(figure_of(ax)), path)[1])
    monkeypatch.setattr(figures, "find_spec", lambda name: None)
    paths = write_figures(runs["fourier"][1], tmp_path)
    assert {path.stem for path in paths} >= FIGURES


@pytest.mark.slow
def test_a_run_writes_its_figures(runs, tmp_path):
    paths = write_figures(runs["fourier"][1], tmp_path)
    assert {path.stem for path in paths} >= FIGURES
    assert all(path.is_file() for path in paths)


@pytest.mark.parametrize(
    ("override", "expected"),
    [
        ("damping_ratio=null", "damping_ratio: required key is missing; add it (damping ratio of every mode"),
        ("damping_ratio=0", "damping_ratio: must be 0.001 or more, got 0"),
        ("damping_ratio=1", "damping_ratio: must be less than 1, got 1"),
        ("analysis=modal", "damping_ratio: analysis modal has no modal damping, got 0.02; leave it out"),
        ("excitation.frequency=high", "excitation.frequency: must be a number, got 'high'"),
        ("excitation.frequency=-5", "excitation.frequency: must be a number above zero, got -5; write a frequency"),
        ("excitation.amplitude_g=[]", "excitation.amplitude_g: must be an ascending list of levels, got []"),
        ("excitation.amplitude_g=[1, 15, 5]", "excitation.amplitude_g: must be an ascending list of levels, got [1"),
        ("excitation.amplitude_g=[1, -5]", "excitation.amplitude_g: must be a number above zero, got -5; write"),
        ("excitation.amplitude=5", "excitation.amplitude: unknown key, got 5; did you mean amplitude_g?"),
        ("excitation={kind: dwell, amplitude: 1, frequency: 90, cycles: 9}", "excitation.kind: analysis modal_tra"),
        ("coil={model: none}", "coil.model: analysis modal_transient recovers the stress of a solid coil, got 'none'"),
        ("winding.wraps=200", "winding.wraps: 200 wraps of 5e-05 m are 0.01 m thick, the coil is 0.015 m"),
        ("winding=null", "winding: required section is missing"),
        ("winding.mu=0", "winding.mu: the coefficient of friction is zero, got 0.0; use a value above 0: "
        "without friction every"),
    ],
)  # fmt: skip
def test_a_wrong_case_study_gets_one_line(root, override, expected):
    with pytest.raises(InputError) as error:
        load_case(root / "configs" / "case_study.yaml", [override])
    assert expected in str(error.value)


def test_a_sine_belongs_to_the_modal_transient(root):
    with pytest.raises(InputError) as error:
        load_case(root / "configs" / "lab_sweep.yaml", ["excitation={kind: sine, frequency: 100, amplitude_g: [1]}"])
    assert "needs a chirp, got 'sine'; use excitation.kind: chirp, or analysis: modal_transient" in str(error.value)


def test_one_level_may_be_a_number(root):
    case = load_case(root / "configs" / "case_study.yaml", ["excitation.amplitude_g=2", "excitation.frequency=95"])
    assert case.excitation.amplitude_g == [2.0]
    assert case.excitation.amplitude == pytest.approx(19.6133)
    assert load_case(root / "configs" / "lab_sweep.yaml").resolved().get("damping_ratio") is None
