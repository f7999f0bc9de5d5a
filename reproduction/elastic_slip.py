"""Claim on the elastic slip of the penalty law: C110 (appendix A)."""

from __future__ import annotations

from functools import partial
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from matplotlib.axes import Axes

from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.verdict import Verdict
from reproduction.words import numbers, table
from wroll_fem.contact.interface import Interface, NormalPenalty, PenaltyCoulomb
from wroll_fem.contact.kernels import interface_work
from wroll_fem.dynamics.statics.contact_state import ContactState, TrialContact
from wroll_fem.dynamics.system.system import System
from wroll_fem.plotting import style
from wroll_fem.plotting.study import PRESSURE, StudyCase, read
from wroll_fem.results.energy import energy_balance_error
from wroll_fem.signals.transmissibility import magnitude

SLIP = "contact.friction.elastic_slip"
LOW, TIED = "elastic_slip_low", "elastic_slip_tied"
SERIES = {
    "slip": ("1.737 kPa (1 kPa at the interface), condensed", LOW, 1.737e3),
    "tied": ("1.737 kPa (1 kPa at the interface), surfaces that cannot separate, condensed", TIED, 1.737e3),
    "firm": ("10 kPa, condensed", LOW, 1.0e4),
    "stiff": ("100 kPa, reduced", "elastic_slip", 1.0e5),
}
"""Name -> description, study, external pressure (Pa)."""
SENTENCES = {
    "slip": "1 kPa at the interface: the peak falls with the elastic slip; the layer opens",
    "tied": "1 kPa at the interface, without separation: each smaller elastic slip changes the peak less",
    "firm": "10 kPa: an elastic slip of 1 µm has not converged, the stick stiffness being six times that at 1.737 kPa",
}


def members(evidence: Evidence, series: str) -> list[StudyCase]:
    """Cases of one study in order of decreasing elastic slip."""
    _, study, pressure = SERIES[series]
    found = [m for m in evidence.study(study) if float(m.values[PRESSURE]) == pressure]
    return sorted(found, key=lambda m: -float(m.values[SLIP]))


def loop_area_error(mu: float = 0.3, pressure: float = 2.0e4, slip: float = 1.0e-6, amplitude: float = 5.0e-6) -> float:
    """Relative error of the friction work of one contact point over a closed cycle; exact is 4 mu N (X - mu N/k).

    The friction law is evaluated along a cycle of relative displacement with the amplitude X, a multiple of gamma*;
    k = mu N/gamma*.
    """
    area = 2.0e-4
    laws = PenaltyCoulomb(mu, slip), NormalPenalty(1.0e12, separation=False)
    point = Interface("point", sp.csr_matrix(np.eye(3)), np.array([area]), np.zeros((1, 3)), *laws)
    system = System(sp.csr_matrix((3, 3)), sp.csr_matrix(np.eye(3)), np.zeros(3), (point,))
    closed = np.array([0.0, 0.0, -pressure / 1.0e12])
    trial, state, work = TrialContact(system), ContactState.unloaded(system), np.zeros(5)
    fraction = slip / 4.0  # the steps end where the point starts to slide, so that their mean tractions are exact
    top = round(amplitude / fraction)
    path = fraction * np.concatenate([np.arange(top), np.arange(top, -top, -1), np.arange(-top, top + 1)])
    for k, value in enumerate(path):
        jump = closed + np.array([value, 0.0, 0.0])
        trial(jump, state)
        after = trial.committed(np.zeros(3), jump)
        if k > top:
            interface_work(
                state.jump, state.elastic_slip, state.traction, after.jump, after.elastic_slip, after.traction,
                system.laws, work,
            )  # fmt: skip
        state = after
    return abs(work[3] / (4.0 * mu * pressure * area * (amplitude - slip)) - 1.0)


def distance(coarse: StudyCase, fine: StudyCase) -> float:
    """L2 distance of two transmissibility curves over their common band, relative to the norm of the second."""
    curves = [(m.data["frequency"].values, np.asarray(magnitude(m.data).values)) for m in (coarse, fine)]
    band = np.linspace(max(f[0] for f, _ in curves), min(f[-1] for f, _ in curves), 4001)
    a, b = (np.interp(band, *curve) for curve in curves)
    return float(np.linalg.norm(a - b) / np.linalg.norm(b))


def falls(values: list[float]) -> bool:
    """Whether every value is smaller than the one before."""
    return len(values) > 1 and bool(np.all(np.diff(values) < 0.0))


def lacks(evidence: Evidence) -> str:
    """Difference of the response at 1 um from the one at 0.1 um, at 1.737, 10 and 100 kPa, as text."""
    said = []
    for name in ("slip", "firm", "stiff"):
        found = {float(m.values[SLIP]): m for m in members(evidence, name)}
        if not {1e-6, 1e-7} <= found.keys():
            continue
        one, tenth = found[1e-6], found[1e-7]
        peak, shift = read(one).peak / read(tenth).peak - 1.0, read(one).f_n - read(tenth).f_n
        pressure = 1e-3 * SERIES[name][2]
        said.append(f"{pressure:g} kPa {100 * peak:+.0f} % in the peak, {shift:+.2f} Hz in f_n")
    return "; ".join(said)


def c110(evidence: Evidence) -> Verdict:
    said, holds = [], True
    for name, words in (("tied", "without separation"), ("slip", "with it")):
        own = members(evidence, name)
        apart = [distance(a, b) for a, b in pairwise(own)]
        holds = holds and falls(apart)
        peaks, frequencies = ([getattr(read(m), key) for m in own] for key in ("peak", "f_n"))
        said.append(
            f"{words} L2 distances {numbers((100 * a for a in apart), '.0f')} % (peaks {numbers(peaks, '.1f')}, "
            f"f_n {numbers(frequencies, '.2f')} Hz)"
        )
    slips = numbers((1e6 * float(m.values[SLIP]) for m in members(evidence, "tied")), "g")
    error = loop_area_error()
    value = (
        f"single element: loop area to {error:.0e}; 1 kPa at the interface, from step to step of {slips} um: "
        f"{'; '.join(said)}; 1 um against 0.1 um: {lacks(evidence)}"
    )
    return Verdict(value, holds and error < 1e-6)


def shear_lag(evidence: Evidence, pressure: float, slip: float) -> float:
    """Length over which friction transfers axial force to the layer, m: sqrt((E t)_series gamma* / (mu p))."""
    case = evidence.roll("lab_sweep")
    tube = case.mandrel.material.in_plane.E_z * case.geometry.mandrel_thickness
    layer = case.coil.layer_material.in_plane.E_z * case.coil.total_thickness
    return float(np.sqrt(slip / (1.0 / tube + 1.0 / layer) / (case.friction.mu * pressure)))


def series_table(series: str, evidence: Evidence) -> str:
    """Table of the response over gamma*, with the change from the row above."""
    head = ("gamma*", "f_n", "change", "peak T", "change", "zeta", "open", "steps cut", "ledger error", "shear lag", "")
    rows, before = [], None
    for m in members(evidence, series):
        data, found, slip = m.data, read(m), float(m.values[SLIP])
        pressure = float((data["pressure"] * data["area"]).sum() / data["area"].sum())
        z = np.unique(np.round(data["z_m"].values, 9))
        lag = shear_lag(evidence, pressure, slip)
        change = ("", "")
        if before is not None:
            change = (f"{found.f_n - before.f_n:+.2f} Hz", f"{100 * (found.peak / before.peak - 1):+.1f} %")
        zeta = f"{100 * found.zeta:.2f} %" if np.isfinite(found.zeta) else "not read"
        rows.append((
            f"{1e6 * slip:g} um", f"{found.f_n:.2f} Hz", change[0], f"{found.peak:.1f}", change[1], zeta,
            f"{100 * float(data['open_fraction'].max()):.0f} %", f"{data.attrs['step_cuts']}",
            f"{energy_balance_error(data):.0e}", f"{1e3 * lag:.0f} mm", f"{lag / (z[1] - z[0]):.1f} rows",
        ))  # fmt: skip
        before = found
    return table(head, rows)


def plot_curves(series: str, evidence: Evidence) -> Axes:
    """Draw Fig. A.2: transmissibility, one curve per elastic slip."""
    ax = style.axes(None, 4.6)
    for m, colour, dash in zip(members(evidence, series), style.LINES, ("-", "--", "-.", ":"), strict=False):
        text = rf"$\gamma^*$ = {1e6 * float(m.values[SLIP]):g} µm"
        ax.plot(
            m.data["frequency"].values, np.asarray(magnitude(m.data).values), color=colour, lw=1.5, ls=dash, label=text
        )
    ax.set_yscale("log")
    ax.set_ylim(bottom=1.0)
    ax.set_xlabel("Frequency (Hz)")
    ax.set_ylabel("Transmissibility |T|, tip over base (–)")
    ax.legend(fontsize=8)
    style.title(ax, SENTENCES[series])
    return ax


GROUP = ClaimGroup(
    {"C110": c110},
    figures={
        f"appendix_a_{name}": (
            f"Fig A.2, {SERIES[name][0]}: response over the elastic slip",
            partial(plot_curves, name),
        )
        for name in SENTENCES
    },
    tables={
        f"Elastic slip, external pressure {words}; shear lag sqrt((E t)_series gamma*/(mu p)), also over the distance "
        "of the lowest rows of contact points": partial(series_table, name)
        for name, (words, _, _) in SERIES.items()
    },
    studies=("elastic_slip", "elastic_slip_low", "elastic_slip_tied"),
)
