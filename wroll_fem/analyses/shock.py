"""Shock: time history under a shock of the base, shock response spectra, and the decay after it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from wroll_fem.analyses.forecasts.computing_time import estimate_history
from wroll_fem.analyses.history import FIELDS, FIGURES, PLOTS, SUMMARY, VARIABLES, time_history
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import preflight
from wroll_fem.analyses.shared.figures import figure
from wroll_fem.analyses.shock_plan import planned
from wroll_fem.results.dataset import annotate
from wroll_fem.signals.decay import Decay, free_decay
from wroll_fem.signals.shock.spectrum import GOOD_SAMPLES, INTERVALS, shock_spectra
from wroll_fem.signals.tip import absolute_tip

if TYPE_CHECKING:
    from wroll_fem.case import ShockCase
    from wroll_fem.progress import Progress
    from wroll_fem.typing import FloatArray

LINES_PER_OCTAVE = 24
"""Natural frequencies of the spectra per octave."""

FADE = 0.1
"""Share of the tip's record, at its end, over which it fades: the end of the computed time is no shock of its own."""

SLIPS = 1e-6
"""Friction work after the shock, relative to the input work, from which slip counts as the cause of a frequency that
changes with the amplitude."""

NUMERICAL_SHARE = 0.1
"""Share of the damping of the decay that is due to the integration scheme, above which it is doubtful."""


def run_shock(
    case: ShockCase, *, progress: Progress, checkpoint: Path | None = None, resume: bool = False
) -> xr.Dataset:
    """Compute the time history with energy ledger and slip fields, the shock response spectra and the decay.

    Parameters
    ----------
    checkpoint
        Checkpoint file; None writes none.
    resume
        Continue from the checkpoint.

    Raises
    ------
    ConvergenceError
        If a step does not converge; ``partial`` has the history up to that step.
    """
    plan = planned(case)
    history = time_history(plan, progress=progress, checkpoint=checkpoint, resume=resume)
    dataset = xr.merge([history, _spectra(history)], combine_attrs="drop_conflicts")
    decay = _decay(history)
    if decay.amplitude.size:
        dataset = dataset.assign_coords(decay_amplitude=decay.amplitude)
        for name in ("frequency", "damping", "time"):
            dataset[f"decay_{name}"] = ("decay_amplitude", getattr(decay, name))
    tip, base = absolute_tip(history), history["base_acceleration"].values
    attrs = {
        "tip_peak_m_s2": float(np.abs(tip).max()),
        "tip_displacement_peak_m": float(np.abs(history["tip_displacement"].values).max()),
        "base_peak_m_s2": float(np.abs(base).max()),
    } | decay_attributes(history, decay)
    for text in attrs["zeta_doubts"].split("\n"):
        if text:
            progress.warning(text)
    return annotate(dataset.assign_attrs(history.attrs | attrs))


def _spectra(history: xr.Dataset) -> xr.Dataset:
    """Shock response spectra of base and tip: three quantities, during and after the record, and the largest."""
    time, q = history["time"].values, float(history.attrs["srs_q"])
    dt = float(time[1] - time[0])
    lowest = 0.25 / max(float(history.attrs["shock_end_s"]), dt)
    resonance = float(history.attrs.get("stuck_resonance_hz", np.nan))
    if np.isfinite(resonance):
        lowest = min(lowest, 0.25 * resonance)
    highest = 1.0 / (GOOD_SAMPLES * dt)
    lowest = min(max(lowest, 1.0 / float(time[-1])), 0.5 * highest)
    count = int(np.ceil(LINES_PER_OCTAVE * np.log2(highest / lowest))) + 1
    lines = np.geomspace(lowest, highest, count)
    lines[-1] = highest
    base = history["base_acceleration"].values
    last = int(np.ceil(float(history.attrs["shock_end_s"]) / dt - 1e-6))
    jumps = abs(base[min(last, len(base) - 1)]) > 1e-9 * np.abs(base).max()  # to zero, along the next step
    shaken = base[: last + 1 + int(jumps)]
    dims = "interval", "natural_frequency"
    data: dict[str, tuple[Any, FloatArray]] = {}
    for name, record in {"base": shaken, "tip": _faded(absolute_tip(history))}.items():
        found = shock_spectra(record, dt, lines, q)
        data[f"srs_{name}"] = ("natural_frequency", found["absolute_acceleration"][INTERVALS.index("maximax")])
        data |= {f"srs_{name}_{quantity}": (dims, values) for quantity, values in found.items()}
    return xr.Dataset(data, coords={"natural_frequency": lines, "interval": list(INTERVALS)})


def _faded(record: FloatArray) -> FloatArray:
    count = max(1, int(FADE * len(record)))
    fade = np.ones(len(record))
    fade[-count:] = 0.5 + 0.5 * np.cos(np.pi * (np.arange(count) + 1) / count)
    return record * fade


def _decay(history: xr.Dataset) -> Decay:
    time = history["time"].values
    after = time >= float(history.attrs["shock_end_s"]) * (1.0 + 1e-9)
    expected = float(history.attrs.get("stuck_resonance_hz", np.nan))
    tip = history["tip_displacement"].values[after]
    start = float(time[after][0]) if after.any() else 0.0
    rubbed = history["friction_energy"].values[after] if "friction_energy" in history else np.zeros(1)
    put_in = float(np.abs(history["input_work"].values).max())
    return free_decay(
        tip, float(time[1] - time[0]), start=start, expected=expected if np.isfinite(expected) else None,
        slipping=bool(rubbed.size) and float(np.ptp(rubbed)) > SLIPS * put_in,
    )  # fmt: skip


def decay_attributes(history: xr.Dataset, decay: Decay) -> dict[str, Any]:
    """Attributes `decay_f_hz`, `decay_zeta` with its quality, and its parts by the energies lost meanwhile."""
    if decay.invalid:
        return {
            "decay_f_hz": np.nan, "decay_zeta": np.nan, "zeta_quality": "invalid", "zeta_doubts": decay.invalid
        }  # fmt: skip
    level, doubts = decay.amplitude, list(decay.doubts)
    found: dict[str, Any] = {
        "decay_f_hz": decay.f_hz, "decay_zeta": decay.zeta, "decay_amplitude_start_m": float(level[0]),
        "decay_amplitude_end_m": float(level[-1]),
    }  # fmt: skip
    half = int(np.argmax(level <= 0.5 * level[0] * (1.0 + 1e-9))) or len(level) - 1
    time = history["time"].values
    first, last = (int(np.searchsorted(time, decay.time[k])) for k in (0, half))
    last = min(max(last, first + 1), len(time) - 1)

    def lost(*names: str) -> float:
        return sum(float(history[n].values[last] - history[n].values[first]) for n in names if n in history)

    numerical = lost("numerical_dissipation", "impact_dissipation")
    material, friction = lost("material_damping"), lost("friction_energy", "pressure_modulation_work")
    whole = numerical + material + friction
    if whole > 0.0:
        share = numerical / whole
        found["decay_zeta_numerical"] = share * decay.zeta
        if material > 0.0:
            found["zeta_material"] = material / whole * decay.zeta
            found["zeta_friction"] = max(decay.zeta - found["zeta_material"] - share * decay.zeta, 0.0)
        if share > NUMERICAL_SHARE:
            doubts.append(
                f"the integration scheme dissipates {100 * share:.0f} % of the energy lost in the decay, so a part of "
                "zeta is numerical; raise integrator.steps_per_cycle, or use integrator.alpha: 0"
            )
    return found | {"zeta_quality": "doubtful" if doubts else "ok", "zeta_doubts": "\n".join(doubts)}


def estimate_shock(case: ShockCase) -> dict[str, Any]:
    """Size and approximate time of the run."""
    return estimate_history(planned(case))


ANALYSIS = Analysis(
    name="shock",
    sentence="Time history under a shock of the base: peaks, shock response spectra, and damping of the decay.",
    sections=("geometry", "mandrel", "coil", "contact", "preload", "excitation"),
    run=run_shock,
    summary=SUMMARY,
    figures=(figure("shock", "shock", needs="srs_base"), *FIGURES),
    fields=FIELDS,
    variables=VARIABLES
    | {
        "natural_frequency": ("srs_base", "srs_tip"),
        "interval, natural_frequency": tuple(
            f"srs_{name}_{quantity}" for name in ("base", "tip")
            for quantity in ("absolute_acceleration", "relative_displacement", "pseudo_velocity")
        ),
        "decay_amplitude": ("decay_frequency", "decay_damping", "decay_time"),
    },
    plots=("shock", *PLOTS),
    preflight=preflight.CHECKS["shock"],
    estimate=estimate_shock,
    resumable=True,
)  # fmt: skip
