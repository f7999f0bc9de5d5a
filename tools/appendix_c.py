"""Appendix C of the source: the scale s of the smoothed sign in the two-mass model of chapter 5.

`.venv/bin/python tools/appendix_c.py` writes docs/tables/appendix_c.md and
docs/figures/appendix_c_*.png. About twenty minutes on one core; what is computed is kept in runs/appendices/orbits.npz.

Equations 5.2 to 5.7 with Table 5.2, S of equation 5.4 with the slip rate scaled by s. Periodic orbits are found by
shooting: LSODA at 1e-11 over half a period with the variational equations, Newton on x(T/2) + x(0) = 0. There is one
periodic orbit and every motion tends to it: friction and dashpots are monotone in the velocities, so that the energy of
the difference of two motions never grows. Hence no frequency has two answers, and a spike in a response curve is a
failure of the computation.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numba
import numpy as np
from scipy.integrate import odeint

ROOT = Path(__file__).resolve().parents[1]
SCALES = (1.0, 2.0, 5.0, 10.0)
CAPACITIES = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0)
ZETA = 0.002  # of the source's estimate of the time constant, equation 5.5


@dataclass(frozen=True)
class TwoMasses:
    """Table 5.2; capacity F_c and scale s are varied. Dimensionless."""

    capacity: float
    scale: float = 1.0
    m1: float = 1.0
    k1: float = 1.0
    c1: float = 0.002
    m2: float = 0.85
    k2: float = 1.15
    c2: float = 0.0025
    amplitude: float = 1.5

    @property
    def parameters(self) -> np.ndarray:
        """m1', k1, c1, m2', k2', c2, F_c, s, Y_0 with equations 5.6 and 5.7."""
        part = np.tanh(0.5 * self.capacity)
        m1, m2, k2 = self.m1 + self.m2 * (1.0 - part), self.m2 * part, self.k2 * part
        return np.array([m1, self.k1, self.c1, m2, k2, self.c2, self.capacity, self.scale, self.amplitude])


@numba.njit(cache=True)
def motion(y, t, omega, p, out):
    """Rates of (x1, x2, v1, v2), and of the columns of their (4, 4) derivative where ``y`` (20,) has them."""
    m1, k1, c1, m2, k2, c2, capacity, scale, base = p
    s = np.tanh(0.5 * scale * (y[2] - y[3]))
    ground, speed = base * np.sin(omega * t), base * omega * np.cos(omega * t)
    out[0], out[1] = y[2], y[3]
    out[2] = (k1 * (ground - y[0]) + c1 * (speed - y[2]) - capacity * s) / m1
    out[3] = (k2 * (ground - y[1]) + c2 * (speed - y[3]) + capacity * s) / m2
    if y.shape[0] > 4:
        slope = 0.5 * capacity * scale * (1.0 - s * s)
        for j in range(4):
            x1, x2, v1, v2 = y[4 + j], y[8 + j], y[12 + j], y[16 + j]
            out[4 + j], out[8 + j] = v1, v2
            out[12 + j] = (-k1 * x1 - c1 * v1 - slope * (v1 - v2)) / m1
            out[16 + j] = (-k2 * x2 - c2 * v2 + slope * (v1 - v2)) / m2


def rates(y, t, omega, p):
    out = np.empty(len(y))
    motion(y, t, omega, p, out)
    return out


def integrate(y, times, omega, p, tolerance):
    scale = tolerance * p[8]
    return odeint(rates, y, times, args=(omega, p), rtol=tolerance, atol=scale, mxstep=1_000_000)


def newton(p: np.ndarray, omega: float, x: np.ndarray, tolerance: float) -> np.ndarray | None:
    """State at t = 0 of the periodic orbit, or None; steps that do not reduce the gap are halved."""
    half, size, step = np.array([0.0, np.pi / omega]), np.inf, np.zeros(4)
    for _ in range(40):
        end = integrate(np.concatenate([x, np.eye(4).ravel()]), half, omega, p, tolerance)[-1]
        gap = x + end[:4]
        new = np.abs(gap).max()
        if new < 1e3 * tolerance * (1.0 + np.abs(x).max()):
            return x
        if new >= size:
            step *= 0.5
            x = x - step
            continue
        size = new
        step = -np.linalg.solve(np.eye(4) + end[4:].reshape(4, 4), gap)
        x = x + step
    return None


def periodic_orbit(
    model: TwoMasses, omega: float, guess: np.ndarray | None = None, tolerance: float = 1e-11
) -> np.ndarray:
    """State (4,) at t = 0 of the periodic orbit; where Newton fails, started from the orbit of a smoother law."""
    x = newton(model.parameters, omega, np.zeros(4) if guess is None else guess, tolerance)
    if x is not None:
        return x
    if model.scale < 1e-6:
        raise RuntimeError(f"no periodic orbit at F_c = {model.capacity}, omega = {omega}")
    return periodic_orbit(model, omega, periodic_orbit(replace(model, scale=model.scale / 2.0), omega), tolerance)


def amplitude_of(model: TwoMasses, omega: float, state: np.ndarray, points: int = 1001) -> float:
    """Largest abs(x1) / Y_0 on the orbit; between the points by the parabola of x, v and a."""
    p = model.parameters
    path = integrate(state, np.linspace(0.0, np.pi / omega, points), omega, p, 1e-11)
    i = int(np.argmax(np.abs(path[:, 0])))
    x, v = path[i, 0], path[i, 2]
    a = rates(path[i], np.linspace(0.0, np.pi / omega, points)[i], omega, p)[2]
    return float(abs(x - 0.5 * v * v / a) / model.amplitude)


def curve(model: TwoMasses, omegas: np.ndarray) -> np.ndarray:
    """Amplitude over a rising grid, each orbit started from its neighbour's."""
    state, found = None, []
    for omega in omegas:
        state = periodic_orbit(model, omega, state)
        found.append(amplitude_of(model, omega, state))
    return np.array(found)


def off_neighbours(omegas: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Relative distance of each inner point from the straight line between its neighbours."""
    share = (omegas[1:-1] - omegas[:-2]) / (omegas[2:] - omegas[:-2])
    line = values[:-2] + share * (values[2:] - values[:-2])
    return np.abs(values[1:-1] - line) / np.abs(values[1:-1])


def adapted_curve(model: TwoMasses, omegas: np.ndarray, bound: float = 0.005, finest: float = 2e-6):
    """Grid and amplitudes, bisected until every point is within ``bound`` of its neighbours' line."""
    states: dict[float, np.ndarray] = {}
    values: dict[float, float] = {}
    todo = list(omegas)
    while todo:
        for omega in todo:
            known = np.array(sorted(states)) if states else np.array([])
            guess = states[known[np.argmin(np.abs(known - omega))]] if len(known) else None
            states[omega] = periodic_orbit(model, omega, guess)
            values[omega] = amplitude_of(model, omega, states[omega])
        grid = np.array(sorted(values))
        bad = np.flatnonzero(off_neighbours(grid, np.array([values[w] for w in grid])) > bound) + 1
        ends = {(i, i + 1) for b in bad for i in (b - 1, b)}
        todo = sorted(0.5 * (grid[i] + grid[j]) for i, j in ends if grid[j] - grid[i] > finest)
    return grid, np.array([values[w] for w in grid])


# --- a run as in the source: ode45 from rest for six time constants ---------------------------------------------------

C = np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0])
A = np.zeros((7, 6))
A[1, :1] = 1 / 5
A[2, :2] = 3 / 40, 9 / 40
A[3, :3] = 44 / 45, -56 / 15, 32 / 9
A[4, :4] = 19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729
A[5, :5] = 9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656
A[6] = 35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84
E = np.array([71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])


@numba.njit(cache=True)
def six_time_constants(omega, p, rtol, atol, cycles, c, a, e):
    """Largest abs(x1) over the last ``cycles`` from rest to t = 6 / (0.002 omega), and the number of steps.

    Dormand and Prince's pair of orders 5 and 4 with the usual step control (error of a step in the largest norm,
    relative to max(abs(y), atol/rtol); factor 0.8 (rtol/err)^(1/5) between 0.1 and 5). As MATLAB's ode45, it looks at
    four points per step.
    """
    end = 6.0 / (0.002 * omega)
    start = end - cycles * 2.0 * np.pi / omega
    threshold = atol / rtol
    y, k, new, stage = np.zeros(4), np.zeros((7, 4)), np.zeros(4), np.zeros(4)
    t, peak, steps = 0.0, 0.0, 0
    motion(y, t, omega, p, k[0])
    h = min(0.1 * end, 0.8 * rtol**0.2 / max(1e-300, np.max(np.abs(k[0])) / threshold))
    while t < end:
        h = min(h, end - t)
        failed = False
        while True:
            for i in range(1, 7):
                stage[:] = y
                for j in range(i):
                    stage += h * a[i, j] * k[j]
                motion(stage, t + c[i] * h, omega, p, k[i])
            new[:] = stage
            err = 0.0
            for q in range(4):
                d = 0.0
                for i in range(7):
                    d += e[i] * k[i, q]
                err = max(err, abs(h * d) / max(max(abs(y[q]), abs(new[q])), threshold))
            if err <= rtol:
                break
            h *= 0.5 if failed else max(0.1, 0.8 * (rtol / err) ** 0.2)
            failed = True
        if t + h >= start:
            for i in range(1, 5):
                u = 0.25 * i
                x = (1 + 2 * u) * (1 - u) ** 2 * y[0] + u * u * (3 - 2 * u) * new[0]
                x += h * (u * (1 - u) ** 2 * y[2] - u * u * (1 - u) * new[2])
                peak = max(peak, abs(x))
        t += h
        steps += 1
        y[:] = new
        k[0] = k[6]
        if not failed:
            ratio = 1.25 * (err / rtol) ** 0.2
            h = h / ratio if ratio > 0.2 else 5.0 * h
    return peak, steps


def run_from_rest(model: TwoMasses, omega: float, rtol: float, atol: float, cycles: int = 20) -> tuple[float, int]:
    """(largest abs(x1) / Y_0 over the last cycles, steps) of a run over 6 tau."""
    peak, steps = six_time_constants(omega, model.parameters, rtol, atol, cycles, C, A, E)
    return peak / model.amplitude, steps


# --- what is computed, tables and pictures ----------------------------------------------------------------------------

BAND = np.unique(np.concatenate([np.linspace(0.9, 1.15, 251), np.linspace(1.07, 1.09, 401)]))
"""Frequencies of claim C114, fine around the resonance of the stuck masses."""
DWELLS = np.linspace(0.4, 2.0, 81)
"""Frequencies of the runs from rest."""


def compute() -> dict[str, np.ndarray]:
    """Orbits on an adapted grid, on BAND and on DWELLS, and runs over 6 tau with loose and tight tolerance."""
    found: dict[str, np.ndarray] = {}
    for capacity in CAPACITIES:
        for scale in SCALES:
            started, key = time.process_time(), f"{capacity:g}_{scale:g}"
            model = TwoMasses(capacity, scale)
            found[f"grid_{key}"], found[f"orbit_{key}"] = adapted_curve(model, np.linspace(0.4, 2.0, 161))
            if capacity >= 50.0:
                found[f"band_{key}"] = curve(model, BAND)
            found[f"dwell_{key}"] = curve(model, DWELLS)
            for name, rtol, atol in (("loose", 1e-3, 1e-6), ("tight", 1e-8, 1e-8)):
                runs = [run_from_rest(model, omega, rtol, atol) for omega in DWELLS]
                found[f"{name}_{key}"], found[f"{name}_steps_{key}"] = np.array(runs).T
            print(f"F_c = {capacity:g}, s = {scale:g}: {time.process_time() - started:.0f} s", flush=True)
    return found


def row(*cells: object) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def band_table(found: dict[str, np.ndarray]) -> list[str]:
    """C114: is the curve the same for every s?"""
    head = (
        "F_c",
        "largest spread",
        "at omega",
        "part of the band within 1e-3",
        "largest spread beyond 2 % of the peak",
    )
    lines = [
        "Largest spread of the amplitude between s = 1, 2, 5, 10, over that at s = 10; omega 0.9 to 1.15, orbits.",
        "",
        row(*head, *(f"peak at s = {scale:g}" for scale in SCALES)),
        row(*["---"] * (len(head) + len(SCALES))),
    ]
    for capacity in (50.0, 100.0):
        values = np.array([found[f"band_{capacity:g}_{scale:g}"] for scale in SCALES])
        spread = np.ptp(values, axis=0) / values[-1]
        within = np.mean(np.interp(np.linspace(0.9, 1.15, 5001), BAND, spread) < 1e-3)
        worst, top = int(np.argmax(spread)), BAND[int(np.argmax(values[-1]))]
        far = spread[np.abs(BAND / top - 1.0) > 0.02].max()
        peaks = [f"{v.max():.2f} at {BAND[v.argmax()]:.4f}" for v in values]
        cells = f"{capacity:g}", f"{100 * spread[worst]:.2f} %", f"{BAND[worst]:.4f}", f"{100 * within:.0f} %"
        lines.append(row(*cells, f"{far:.1e}", *peaks))
    return lines


def spikes_table(found: dict[str, np.ndarray]) -> list[str]:
    """C115: orbits are smooth; what loose tolerances make of them."""
    head = (
        "F_c", "s", "peak", "points", "off its neighbours", "loose against tight", "loose points off by > 1 %",
        "steps of the loose run", "tight 6 tau against orbit", "tight points off by > 1 %",
    )  # fmt: skip
    lines = [
        "Orbits: largest distance of a point from its neighbours' line on a grid of `points` frequencies, 0.4 to 2.",
        "Runs from rest over 6 tau at 81 frequencies, largest abs(x1) of the last 20 cycles: by how much the run at",
        "rtol 1e-3 (the default of ode45) differs from the one at 1e-8, how many are more than 1 % off, and how far",
        "the run at 1e-8 is from the periodic orbit.",
        "",
        row(*head),
        row(*["---"] * len(head)),
    ]
    for capacity in CAPACITIES:
        for scale in SCALES:
            key = f"{capacity:g}_{scale:g}"
            grid, orbit = found[f"grid_{key}"], found[f"orbit_{key}"]
            loose, tight, dwell = (found[f"{name}_{key}"] for name in ("loose", "tight", "dwell"))
            wrong, late = np.abs(loose / tight - 1.0), np.abs(tight / dwell - 1.0)
            lines.append(
                row(
                    f"{capacity:g}",
                    f"{scale:g}",
                    f"{orbit.max():.2f} at {grid[orbit.argmax()]:.4f}",
                    len(grid),
                    f"{100 * off_neighbours(grid, orbit).max():.2f} %",
                    f"{100 * wrong.max():.2g} %",
                    np.sum(wrong > 0.01),
                    f"{found[f'loose_steps_{key}'].mean():.0f}",
                    f"{100 * late.max():.2g} %",
                    np.sum(late > 0.01),
                )
            )
    return lines


def main() -> None:
    """Compute (or find computed) and write."""
    from appendix_c_figures import figures

    kept = ROOT / "runs" / "appendices" / "orbits.npz"
    if kept.exists() and "--again" not in sys.argv:
        with np.load(kept) as data:
            found = dict(data)
    else:
        found = compute()
        kept.parent.mkdir(parents=True, exist_ok=True)
        np.savez(kept, **found)
    text = [
        "Smoothed sign S(s x) in the two-mass model of chapter 5: `.venv/bin/python tools/appendix_c.py`.", "",
        *band_table(found), "", *spikes_table(found),
    ]  # fmt: skip
    (ROOT / "docs" / "tables" / "appendix_c.md").write_text("\n".join(text) + "\n")
    figures(found, ROOT / "docs" / "figures")


if __name__ == "__main__":
    main()
