"""Claims on the integration schemes: C111 to C113 (appendix B)."""

from __future__ import annotations

from itertools import product

import numpy as np
import scipy.sparse as sp
from matplotlib.axes import Axes

from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.verdict import Verdict
from reproduction.words import numbers, table
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.full import FullStepper
from wroll_fem.dynamics.time_stepping.hht import Scheme, numerical_damping
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.plotting import style
from wroll_fem.plotting.study import StudyCase, read
from wroll_fem.signals.transmissibility import magnitude

STUDY, SCHEME = "integrators_source", "integrator.scheme"
NAMES = ("no_damping", "transient_fidelity", "moderate_dissipation", "quasi_static")
PRINTED = {-0.05: ("0.275625", "0.55"), -0.41421: ("0.5", "0.91421"), 0.0: ("0.25", "0.5")}
"""alpha -> beta and gamma as printed in Table B.1."""
STEP = 3.0722e-4
"""Time step of the run in the thesis (Fig. B.2), s."""
ANGLE = 0.29
"""omega dt at 150 Hz with this time step, rad."""
STEPS = "integrator.steps_per_cycle"
SMOOTHING = 0.01
"""Half width of the running mean over the envelope, relative to the frequency: it removes the ripples."""
ENERGIES = ("input_work", "friction_energy", "numerical_dissipation")


def c111(evidence: Evidence) -> Verdict:
    said, holds = [], True
    for alpha, printed in PRINTED.items():
        found = (1.0 - alpha) ** 2 / 4.0, 0.5 - alpha
        # 0.5 of moderate dissipation stands for 0.49999: the digits of alpha, not of beta, end there
        misses = [abs(value - float(text)) for value, text in zip(found, printed, strict=True)]
        allowed = [0.5e-5 if alpha == -0.41421 else 0.5e-6, 1e-12]
        holds = holds and all(miss < limit for miss, limit in zip(misses, allowed, strict=True))
        scheme = Scheme.hht(alpha)
        holds = holds and (scheme.beta, scheme.gamma) == found
        said.append(f"alpha {alpha:g}: beta {found[0]:.7g} (printed {printed[0]}), gamma {found[1]:g}")
    return Verdict("; ".join(said), holds)


def free_decay(scheme: Scheme, angle: float) -> float:
    """Numerical damping ratio of the time stepper for an undamped oscillator with ``angle`` = omega dt, rad.

    Two complex exponentials satisfy u_{n+1} = p u_n - q u_{n-1} with p = 2 Re(lambda), q = |lambda|^2. The first steps,
    in which the third eigenvalue of HHT decays, are ignored.
    """
    one = sp.csr_matrix(np.ones((1, 1)))
    system = System(one, one, np.ones(1), probes={"tip": np.ones(1)})
    run = FullStepper(system, ContactState.unloaded(system), scheme, NewtonOptions())
    run.start_from(np.array([1.0e-3]))
    u = run.advance(np.zeros(161), angle, 0.0)[20:, 0]
    scale = np.abs(u[1:-1]) + np.abs(u[:-2])
    p, q = np.linalg.lstsq(np.column_stack([u[1:-1], -u[:-2]]) / scale[:, None], u[2:] / scale, rcond=None)[0]
    exponent = np.log(0.5 * p + 1j * np.sqrt(q - 0.25 * p * p))
    return float(-exponent.real / abs(exponent))


def c112(evidence: Evidence) -> Verdict:
    schemes = [Scheme.named(name) for name in NAMES]
    matrix = [numerical_damping(scheme, ANGLE)[0] for scheme in schemes]
    gap = max(abs(free_decay(scheme, ANGLE) - value) for scheme, value in zip(schemes, matrix, strict=True))
    none, fidelity, moderate, euler = matrix
    value = (
        f"none {'below 1e-10' if abs(none) < 1e-10 else f'{none:.1e}'}, transient fidelity {fidelity:.4e}, moderate "
        f"dissipation {moderate:.4e}, backward Euler {euler:.4f}; free decays agree to {gap:.0e}"
    )
    return Verdict(value, gap < 1e-6 and abs(none) < 1e-10 and none < fidelity < moderate < euler)


def by_scheme(evidence: Evidence) -> dict[int, dict[str, StudyCase]]:
    """Steps per cycle of the last frequency, those of the thesis first -> scheme -> sweep."""
    members = evidence.study(STUDY)
    found: dict[int, dict[str, StudyCase]] = {}
    for steps in sorted({int(m.values[STEPS]) for m in members}):
        own = {str(m.values[SCHEME]): m for m in members if m.values[STEPS] == steps}
        found[steps] = {name: own[name] for name in NAMES if name in own}
    return found


def smoothed_peak(member: StudyCase) -> float:
    """Highest value of the running mean of |T| over `SMOOTHING` of the frequency on either side."""
    frequency, size = member.data["frequency"].values, np.asarray(magnitude(member.data).values)
    order = np.argsort(frequency)
    frequency, size = frequency[order], size[order]
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (size[1:] + size[:-1]) * np.diff(frequency))])
    inside = (frequency > frequency[0] * (1 + SMOOTHING)) & (frequency < frequency[-1] * (1 - SMOOTHING))
    ends = [np.interp(frequency[inside] * (1 + side * SMOOTHING), frequency, integral) for side in (-1, 1)]
    return float(((ends[1] - ends[0]) / (2.0 * SMOOTHING * frequency[inside])).max())


def c113(evidence: Evidence) -> Verdict:
    said, holds = [], True
    for steps, found in by_scheme(evidence).items():
        peaks = [smoothed_peak(found[name]) for name in NAMES]
        spread = max(peaks[:3]) / min(peaks[:3]) - 1.0
        holds = holds and spread <= 0.05 and peaks[3] < 0.5 * min(peaks[:3])
        highest = [read(found[name]).peak for name in NAMES]
        said.append(
            f"{steps} steps per cycle of the last frequency: {numbers(peaks[:3], '.2f')}, {100 * spread:.1f} % apart; "
            f"backward Euler {peaks[3]:.2f} (highest points {numbers(highest, '.2f')})"
        )
    value = f"peak of the smoothed envelope (no damping, transient fidelity, moderate dissipation): {'; '.join(said)}"
    return Verdict(value, holds and len(said) == 2)


def schemes_table(evidence: Evidence) -> str:
    """Table of the numerical damping of the schemes, and of the sweep with each."""
    head = (
        "scheme", "steps", "damping ratio", "period", "f_n", "peak T", "smoothed", "zeta", "friction/input",
        "numerical/input",
    )  # fmt: skip
    rows = []
    sweeps = by_scheme(evidence)
    coarsest = min(sweeps)
    for steps, name in product(sweeps, NAMES):
        m = sweeps[steps][name]
        damping, period = numerical_damping(Scheme.named(name), ANGLE * coarsest / steps)
        last, found = {key: float(m.data[key].values[-1]) for key in ENERGIES}, read(m)
        zeta = f"{100 * found.zeta:.2f} %" if np.isfinite(found.zeta) else "not read"
        rows.append((
            name.replace("_", " "), f"{steps}", f"{damping if abs(damping) > 1e-12 else 0.0:.4e}",
            f"{100 * period:+.2f} %", f"{found.f_n:.2f} Hz", f"{found.peak:.2f}", f"{smoothed_peak(m):.2f}", zeta,
            *(f"{100 * last[key] / last['input_work']:.2g} %" for key in ENERGIES[1:]),
        ))  # fmt: skip
    return table(head, rows)


def plot_damping(evidence: Evidence) -> Axes:
    """Draw the numerical damping ratio of the schemes of Fig. B.1 over the steps per cycle."""
    ax = style.axes(None)
    steps = np.geomspace(8.0, 320.0, 200)
    for name, colour in zip(NAMES[:0:-1], style.LINES, strict=False):
        ratio = [numerical_damping(Scheme.named(name), 2.0 * np.pi / n)[0] for n in steps]
        ax.loglog(steps, ratio, color=colour, lw=1.6, label=name)
    ax.axvline(1.0 / (150.0 * STEP), color="black", lw=0.8, ls="--", label="the thesis's step at 150 Hz: 21.7")
    ax.axhspan(0.01, 0.05, color="#DDDDDD", label="damping of the roll: 1 to 5 %")
    ax.plot([], [], " ", label="no_damping: zero")
    ax.set_xlabel("Steps per cycle (–)")
    ax.set_ylabel(r"Numerical damping ratio $\zeta$ (–)")
    ax.legend(fontsize=8)
    style.title(ax, "HHT takes a small part of the roll's damping; backward Euler exceeds it below 60 steps per cycle")
    return ax


def plot_schemes(evidence: Evidence) -> Axes:
    """Draw Fig. B.3: sweep with each scheme at the step of the thesis, and with alpha = -0.05 at the default step."""
    ax = style.axes(None, 4.6)
    sweeps = by_scheme(evidence)
    found = sweeps[min(sweeps)]
    lines = {**found, f"transient_fidelity, {max(sweeps)} steps": sweeps[max(sweeps)]["transient_fidelity"]}
    for (name, m), colour, dash in zip(lines.items(), style.LINES, ("-", "--", "-.", ":", "-"), strict=False):
        ax.plot(
            m.data["frequency"].values, np.asarray(magnitude(m.data).values), color=colour, lw=1.5, ls=dash, label=name
        )
    ax.set_xlim(110, 180)
    ax.set_xlabel("Frequency (Hz)")
    ax.set_ylabel("Transmissibility |T|, tip over base (–)")
    ax.legend(fontsize=8)
    peaks = [smoothed_peak(found[name]) for name in NAMES]
    style.title(
        ax,
        f"The three HHT variants peak within {100 * (max(peaks[:3]) / min(peaks[:3]) - 1):.1f} % of each other; "
        f"backward Euler leaves {peaks[3]:.1f} of {min(peaks[:3]):.0f}",
    )
    return ax


GROUP = ClaimGroup(
    {"C111": c111, "C112": c112, "C113": c113},
    figures={
        "appendix_b_damping": ("Figs B.1 and B.2: numerical damping of the schemes", plot_damping),
        "appendix_b_schemes": ("Fig B.3: sweep with each scheme at the thesis's step", plot_schemes),
    },
    tables={
        "Schemes on a free oscillator at omega dt = 0.29 and at the finer step, and the lab roll's sweep with each "
        "(steps per cycle of the last frequency)": schemes_table
    },
    studies=("integrators_source",),
)
