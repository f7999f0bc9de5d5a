"""Friction between the wraps and on the mandrel in one model, against the models that have one of the two."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.case import load_case
from wroll_fem.errors import InputError

CASE = CONFIGS / "slipping_harmonic.yaml"
SMALL = (
    "mesh={circumferential: 8, axial: 8, grading: 20, radial: 2}", "excitation.amplitude_g=8", "harmonic.harmonics=3",
)  # fmt: skip
SOFT, STIFF = ("excitation.f_start=60",), ("excitation.f_start=80", "excitation.f_end=102")
"""Bands about the resonances of a coil that slips on its mandrel, and of one that does not."""
ON_MANDREL = ("coil.interface=friction", "preload={kind: winding_stress}")


def contact(mu: float, elastic_slip: float = 1e-6) -> str:
    return f"contact={{friction: {{mu: {mu}, elastic_slip: {elastic_slip}}}}}"


def run(*changes: str) -> xr.Dataset:
    return wf.run(load_case(CASE, [*SMALL, *changes]), progress=False)


def top(data: xr.Dataset) -> tuple[float, float, float]:
    """Largest tip amplitude, resonance frequency and friction work per cycle."""
    return float(data["tip_amplitude"].max()), data.attrs["f_n_hz"], float(data["friction_work_per_cycle"].max())


def assert_close(found: xr.Dataset, expected: xr.Dataset, tip: float, frequency: float, work: float) -> None:
    for value, reference, tolerance in zip(top(found), top(expected), (tip, frequency, work), strict=True):
        assert value == pytest.approx(reference, rel=tolerance)


@pytest.mark.slow
def test_wraps_that_hold_leave_the_coil_that_rubs() -> None:
    """Without slip inside: modes of the path against all modes of the coil that rubs on its mandrel (own solver)."""
    both = run(*SOFT, *ON_MANDREL, contact(0.1), "winding.mu=50")
    rubs = run(*SOFT, *ON_MANDREL, contact(0.1), "coil.inside=stiff")
    assert both["interface_name"].values.tolist() == ["mandrel/coil", "coil"]
    assert both.attrs["stuck_resonance_hz"] == pytest.approx(rubs.attrs["stuck_resonance_hz"], rel=3e-4)
    assert_close(both, rubs, tip=5e-3, frequency=5e-3, work=1e-2)
    slipped = [int(data["slipped"].isel(interface=0).sum()) for data in (both, rubs)]
    assert slipped[0] == pytest.approx(slipped[1], abs=2)
    assert float(both["slipped"].isel(interface=1).sum()) == 0.0
    assert both.attrs["span_error_estimate"] < 5e-3


def test_a_coil_that_holds_on_the_mandrel_slips_as_a_bonded_one() -> None:
    """With a stiff penalty: that by default gives way as half of the first element of the soft coil."""
    stiff = "contact={friction: {mu: 50, elastic_slip: 1.0e-7}, normal: {penalty: 1.0e13}}"
    assert_close(run(*STIFF, *ON_MANDREL, stiff), run(*STIFF), tip=5e-3, frequency=3e-3, work=1e-2)


@pytest.mark.slow
def test_both_dissipate_and_lower_the_frequency() -> None:
    both, bonded = run(*SOFT, *ON_MANDREL, contact(0.3)), run(*SOFT)
    work = (both["friction_work_density"] * both["area"]).sum("point").values
    assert (work > 0.0).all()
    peak = int(np.abs(both["transmissibility_real"] + 1j * both["transmissibility_imag"]).values.argmax())
    assert work.sum() == pytest.approx(float(both["friction_work_per_cycle"][peak]), rel=2e-3)
    assert top(both)[1] < 0.98 * top(bonded)[1]
    assert both.attrs["energy_balance_error"] < 1e-6
    assert np.isnan(both["r_m"].isel(interface=0)).all()
    assert np.isfinite(both["r_m"].isel(interface=1)).all()


def test_another_preload_contradicts_the_pressure_of_the_wound_roll() -> None:
    with pytest.raises(InputError, match=r"preload.kind: does not go with the pressure between the wraps"):
        load_case(CASE, ["coil.interface=friction", "preload={pressure: 1.0e5}", contact(0.3)])
    with pytest.raises(InputError, match=r"coil.interface"):
        load_case(CONFIGS / "slipping_coil.yaml", [*ON_MANDREL, contact(0.3)])
