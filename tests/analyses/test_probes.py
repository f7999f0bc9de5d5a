"""Named probes in the case and in every result: against the tip, the clamped base, and rigid-body motion."""

from __future__ import annotations

import numpy as np
import pytest
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.errors import InputError

PROBES = {
    "top": {"z": 0.300, "theta": 1.0},  # the rigid tip of the mandrel: all of it moves alike along x
    "opposite": {"z": 0.300, "theta": -2.0},
    "root": {"z": 0.0},
    "axial": {"z": 0.0, "theta": 2.0, "direction": "z"},
    "layer": {"z": 0.300, "body": "layer_01", "theta": 0.4},
}
ORDER = ["tip", "top", "opposite", "root", "axial", "layer"]
COARSE = ["mesh.circumferential=8", "mesh.axial=3", "mesh.grading=1", "output.figures=false"]


def case(name: str, *overrides: str, probes: dict | None = None) -> wf.Case:
    return wf.load_case(CONFIGS / f"{name}.yaml", [*COARSE, *overrides]).replace({"probes": probes or PROBES})


@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")
@pytest.mark.parametrize("method", ["condensed", "reduced", pytest.param("full", marks=pytest.mark.slow)])
def test_a_history_holds_the_motion_of_every_probe(method: str) -> None:
    length = ["excitation.cycles=2"] if method == "full" else ["excitation.cycles=4"]
    result = wf.run(case("tiny", f"solver.method={method}", *length), progress=False)
    assert list(result["probe"].values) == ORDER
    for quantity in ("displacement", "velocity", "acceleration"):
        motion = result[f"probe_{quantity}"].transpose("probe", "time").values
        tip = result[f"tip_{quantity}"].values
        scale = np.abs(tip).max()
        np.testing.assert_array_equal(motion[0], tip)
        np.testing.assert_allclose(motion[1], motion[2], atol=1e-9 * scale)
        np.testing.assert_allclose(motion[1], tip, atol=0.05 * scale)  # the tip of a result is that of the layer
        assert np.abs(motion[3:5]).max() == 0.0  # clamped: no motion relative to the base
        assert 0.5 * scale < np.abs(motion[5]).max() < 1.5 * scale


@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")
def test_probes_change_no_other_number() -> None:
    plain = wf.load_case(CONFIGS / "tiny.yaml", [*COARSE, "excitation.cycles=4"])
    first, second = wf.run(plain, progress=False), wf.run(plain.replace({"probes": PROBES}), progress=False)
    assert "probe" not in first.coords
    for name in first.data_vars:  # the probes move other arrays in memory, which the sums of BLAS may depend on
        a, b = first[name].values, second[name].values
        np.testing.assert_allclose(b, a, rtol=0, atol=1e-10 * np.abs(a).max(initial=0.0), err_msg=str(name))


@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")
def test_steady_response_at_the_probes() -> None:
    short = ["excitation.f_start=150", "excitation.f_end=156", "harmonic.harmonics=1", "harmonic.samples=32"]
    result = wf.run(case("lab_harmonic", *short), progress=False)
    ratio = (result["probe_transmissibility_real"] + 1j * result["probe_transmissibility_imag"]).values
    tip = (result["transmissibility_real"] + 1j * result["transmissibility_imag"]).values
    np.testing.assert_array_equal(ratio[0], tip)
    np.testing.assert_allclose(ratio[1], ratio[2], rtol=1e-9)
    np.testing.assert_allclose(np.abs(ratio[1]), np.abs(tip), rtol=0.02)
    np.testing.assert_allclose(ratio[3], 1.0, atol=1e-12)
    np.testing.assert_allclose(ratio[4], 0.0, atol=1e-12)


@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")
def test_backbone_and_modes_at_the_probes() -> None:
    result = wf.run(case("lab_backbone", "harmonic.harmonics=1", "harmonic.samples=32"), progress=False)
    amplitude = result["probe_amplitude"].values
    np.testing.assert_allclose(amplitude[0], result["tip_amplitude"].values, rtol=1e-12)
    np.testing.assert_allclose(amplitude[1], amplitude[2], rtol=1e-9)
    np.testing.assert_allclose(amplitude[1], amplitude[0], rtol=0.02)
    assert amplitude[3:5].max() == 0.0
    modes = wf.run(case("lab_modal", "modal.count=4"), progress=False)
    shape = modes["mode_at_probe"].values
    bending = np.abs(shape[:, 1]) > 0.1 * np.abs(shape[:, 1]).max()
    assert bending.any()
    np.testing.assert_allclose(shape[bending, 1], shape[bending, 2], rtol=1e-6)
    np.testing.assert_allclose(shape[bending, 1], shape[bending, 0], rtol=0.02)
    assert np.abs(shape[:, 3:5]).max() == 0.0


@pytest.mark.parametrize(
    ("probes", "told"),
    [
        ({"tip": {"z": 0.1}}, r"probes\.tip: is the name of the default probe"),
        ({"mid height": {"z": 0.1}}, r"probes\.mid height: is not a valid name"),
        ({"a": {"z": 0.31}}, r"probes\.a\.z: is above the roll, got 0\.31; give at most geometry\.length = 0\.3 m"),
        ({"a": {"z": 0.1, "body": "layer_02"}}, r"probes\.a\.body: .*use one of: mandrel, layer_01"),
        ({"a": {"z": 0.1, "direktion": "x"}}, r"probes\.a\.direktion: unknown key, got 'x'; did you mean direction"),
        ({"a": {}}, r"probes\.a\.z: required key is missing; add it \(height above the base, m\)"),
    ],
)
def test_a_wrong_probe_is_one_line(probes: dict, told: str) -> None:
    with pytest.raises(InputError, match=told):
        case("tiny", probes=probes)


def test_matrices_bring_their_own_probes() -> None:
    with pytest.raises(InputError, match="leave probes out, or leave structure out"):
        wf.load_case(CONFIGS / "oscillator.yaml", ["probes={a: {z: 0.1}}"])
