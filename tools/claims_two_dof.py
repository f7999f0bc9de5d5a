"""Judge the claims of chapter 5 of the source (two masses that rub) and draw its figures.

`.venv/bin/python tools/claims_two_dof.py` prints one line per claim, writes its tables into docs/two-dof.md and
docs/tables/two_dof.md and the figures into docs/figures. About fifteen minutes of one core: the map of the design space
takes most of it (`--keep` draws the one in runs/two_dof again). C89 reads the study
configs/studies/layer_modulus.yaml from runs/docs/chapter4.
"""

from __future__ import annotations

import os
import sys

os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import cached_property

import numpy as np
import xarray as xr
from chapter4_runs import ROOT, Runs, Verdict
from claims_design_map import put

from wroll_fem.analyses import run_analysis
from wroll_fem.case import load_case
from wroll_fem.errors import InputError
from wroll_fem.plotting import save_figure, style
from wroll_fem.plotting.two_dof import (
    plot_two_dof,
    plot_two_dof_arrangements,
    plot_two_dof_design_space,
    plot_two_dof_readings,
)
from wroll_fem.progress import SilentProgress
from wroll_fem.results import load_dataset, save_dataset
from wroll_fem.two_dof import PeriodicSolver, TwoMasses, response_map, settle, smoothed_sign
from wroll_fem.two_dof.time import dwell

FIGURES = ROOT / "docs" / "figures"
KEPT = ROOT / "runs" / "two_dof" / "design_space.nc"
CAPACITIES = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0)
FINE = tuple(float(c) for c in np.round(np.geomspace(1.0, 100.0, 41), 3))
SCALES = (1.0, 2.0, 5.0, 10.0)
STUCK = CAPACITIES[1:]
"""Capacities of the study of S; at F_c = 1 the peak at s = 10 needs more harmonics than there are."""
DWELLS = np.linspace(0.4, 2.0, 41)
SETTLED = (0.4, 0.6, 0.8, 0.85, 0.9, 0.95, 1.0, 1.05, 1.1, 1.2, 1.5, 2.0)
FE_STUDY = ROOT / "runs" / "docs" / "chapter4"
ZETA_SOURCE = 0.002
Task = tuple[float, float]


def _settled(task: Task) -> tuple[float, float, int]:
    """Transmissibility by harmonic balance and in time, and the periods that took."""
    pressed = TwoMasses().pressed(task[0])
    found = settle(pressed, task[1])
    return PeriodicSolver(pressed).motion(task[1]).transmissibility, found.transmissibility, found.periods


def _dwelt(task: Task) -> tuple[float, float]:
    """Transmissibility of the periodic motion, and of a run over six of the source's time constants."""
    pressed = TwoMasses().pressed(task[0])
    return PeriodicSolver(pressed).motion(task[1]).transmissibility, dwell(
        pressed, task[1], 6.0 / (ZETA_SOURCE * task[1])
    )


def in_parallel(work: Callable[[Task], tuple], tasks: list[Task]) -> np.ndarray:
    with ProcessPoolExecutor(2) as pool:
        return np.array(list(pool.map(work, tasks, chunksize=4)))


def analysed(*overrides: str) -> xr.Dataset:
    return run_analysis(load_case(ROOT / "configs" / "two_dof.yaml", overrides), progress=SilentProgress())


class Study:
    """What the claims look at, computed once."""

    @cached_property
    def series(self) -> xr.Dataset:
        """Table 5.2 under the eight capacities."""
        return analysed()

    @cached_property
    def finer(self) -> xr.Dataset:
        """The same on half the frequency step."""
        return analysed("two_dof.omega.points=799")

    @cached_property
    def fine(self) -> xr.Dataset:
        """The same under 41 capacities."""
        return analysed(f"two_dof.friction_capacity={list(FINE)}", "two_dof.omega.points=200")

    @cached_property
    def settled(self) -> np.ndarray:
        """(capacity, omega, (periodic, in time, periods))."""
        tasks = [(c, w) for c in CAPACITIES for w in SETTLED]
        return in_parallel(_settled, tasks).reshape(len(CAPACITIES), len(SETTLED), 3)

    @cached_property
    def dwelt(self) -> np.ndarray:
        """(capacity, omega, (periodic, after six time constants))."""
        tasks = [(c, float(w)) for c in CAPACITIES for w in DWELLS]
        return in_parallel(_dwelt, tasks).reshape(len(CAPACITIES), len(DWELLS), 2)

    @cached_property
    def arrangements(self) -> dict[str, xr.Dataset]:
        """Fig 5.1 a, b, c under a low, two middle and a high capacity."""
        words = {
            "(a) both on the base": "both_on_base",
            "(b) secondary on a wall at rest": "secondary_isolated",
            "(c) secondary on the primary": "secondary_on_primary",
        }
        force = "two_dof.friction_capacity=[2, 5, 20, 100]"
        return {text: analysed(force, f"two_dof.arrangement={name}") for text, name in words.items()}

    @cached_property
    def constant(self) -> xr.Dataset:
        """Masses and stiffness that do not follow the capacity."""
        return analysed("two_dof.preload_dependent=false", "two_dof.friction_capacity=[1.5, 2, 3, 5, 20]")

    @cached_property
    def scales(self) -> dict[float, xr.Dataset]:
        """Table 5.2 with steeper laws."""
        force = f"two_dof.friction_capacity={list(STUCK)}"
        return {s: analysed(force, f"two_dof.smoothing={s}", "two_dof.omega.points=80") for s in SCALES}

    @cached_property
    def over_stiffness(self) -> dict[float, float]:
        """k2 -> largest damping over 25 capacities, m2 of Table 5.2."""
        capacities = [float(c) for c in np.geomspace(1.2, 30.0, 25)]
        found = {}
        for k2 in (0.575, 0.8, 1.15, 1.6, 2.3, 4.6):
            reads = [r.reading.zeta for r in response_map(TwoMasses(k2=k2), capacities, np.linspace(0.4, 3.0, 160))]
            found[k2] = float(np.nanmax(reads))
        return found

    @cached_property
    def over_modulus(self) -> dict[float, float]:
        """Layer modulus in Pa -> largest damping of the finite-element model over the preloads that can be read."""
        found: dict[float, float] = {}
        for member in Runs(FE_STUDY).study("layer_modulus"):
            zeta, modulus = float(member.data.attrs["zeta"]), float(member.values["coil.material.E"])
            if np.isfinite(zeta):
                found[modulus] = max(zeta, found.get(modulus, 0.0))
        return dict(sorted(found.items()))

    @cached_property
    def space(self) -> xr.Dataset:
        """configs/two_dof_design_space.yaml."""
        if "--keep" in sys.argv and KEPT.is_file():
            return load_dataset(KEPT)
        started = time.perf_counter()
        case = load_case(ROOT / "configs" / "two_dof_design_space.yaml")
        found = run_analysis(case, progress=SilentProgress())
        print(f"design space: {time.perf_counter() - started:.0f} s of wall time")
        save_dataset(found, KEPT)
        return found


def listed(values: np.ndarray, form: str = ".3g") -> str:
    return ", ".join(format(float(v), form) for v in values)


def c77(_: Study) -> Verdict:
    x = np.linspace(-30.0, 30.0, 601)
    gap = float(np.abs(smoothed_sign(x) - np.tanh(0.5 * x)).max())
    one, five = smoothed_sign([1.0, 5.0])
    holds = gap < 1e-14 and abs(one - 0.4621) < 5e-5 and abs(five - 0.98661) < 5e-6
    return Verdict(f"S(x) = tanh(x/2) to {gap:.0e}; S(1) = {one:.4f}, S(5) = {five:.5f}", holds)


def c78(study: Study) -> Verdict:
    gap = np.abs(study.settled[..., 1] / study.settled[..., 0] - 1.0)
    periods = study.settled[..., 2]
    said = f"time integration and harmonic balance agree to {gap.max():.1e} at {gap.size} points; settling took "
    said += f"{periods.min():.0f} to {periods.max():.0f} periods; table in tables/two_dof.md"
    return Verdict(said, bool(gap.max() < 1e-4))


def c79(study: Study) -> Verdict:
    error = study.series.attrs["energy_balance_error"]
    return Verdict(f"{error:.1e} at worst over {study.series['transmissibility'].size} motions", bool(error < 1e-6))


def c80(study: Study) -> Verdict:
    data = study.series
    change = max(
        float(np.abs(study.finer[name] / data[name] - 1.0).max()) for name in ("peak_transmissibility", "omega_peak")
    )
    for capacity, reading in zip(CAPACITIES, data["peak_transmissibility"].values, strict=True):
        tighter = PeriodicSolver(TwoMasses().pressed(capacity), accuracy=5e-6)
        top = tighter.motion(float(data["omega_peak"].sel(friction_capacity=capacity))).transmissibility
        change = max(change, abs(top / reading - 1.0))
    lowest = study.fine["peak_transmissibility"]
    k = int(lowest.values.argmin())
    tops, at = data["peak_transmissibility"].values, data["omega_peak"].values
    said = (
        f"T_pk {listed(tops, '.4g')} at omega {listed(at, '.4f')} (F_c {listed(np.array(CAPACITIES), 'g')}); changes "
    )
    said += (
        f"{change:.1e} with half the step and tolerance; lowest peak {float(lowest[k]):.2f} near F_c = {FINE[k]:.2g}, "
    )
    return Verdict(said + f"of the eight at {CAPACITIES[int(tops.argmin())]:g}", change < 1e-3)


def c81(study: Study) -> Verdict:
    model, peaks = TwoMasses(), study.series["omega_peak"].values
    floor = float(np.sqrt(model.k1 / model.pressed(1.0).m1))
    ceiling = float(np.sqrt((model.k1 + model.k2) / (model.m1 + model.m2)))
    gaps = peaks[0] / floor - 1.0, peaks[-1] / ceiling - 1.0
    said = f"floor {peaks[0]:.4f} against {floor:.4f} ({100 * gaps[0]:+.3f} %), ceiling {peaks[-1]:.4f} against "
    return Verdict(said + f"{ceiling:.4f} ({100 * gaps[1]:+.3f} %)", max(map(abs, gaps)) < 0.005)


def c82(study: Study) -> Verdict:
    peaks, zeta = study.fine["peak_transmissibility"].values, study.fine["zeta"].values
    k, z = int(peaks.argmin()), int(np.nanargmax(zeta))
    rises = bool(np.all(np.diff(peaks[k:]) > 0.0)) and bool(np.all(np.diff(peaks[: k + 1]) < 0.0))
    said = f"T_pk falls from {peaks[0]:.1f} (F_c = 1) to {peaks[k]:.2f} and rises from F_c = {FINE[k]:.2g} upward; "
    said += f"damping is largest, {100 * zeta[z]:.1f} %, at {FINE[z]:.2g}, but {100 * zeta[0]:.2f} % at F_c = 1"
    return Verdict(said, rises)


def c83(study: Study) -> Verdict:
    data = study.series.isel(friction_capacity=slice(1, None))
    peaks, omega, skew = (data[n].values for n in ("peak_transmissibility", "omega_peak", "skewness"))
    drop = float(np.max(np.maximum.accumulate(omega) / omega - 1.0))
    holds = bool(np.all(np.diff(peaks) > 0) and omega[-1] > omega[0] and drop < 1e-3 and np.argmin(np.abs(skew)) == 6)
    said = f"F_c 2 to 100: T_pk {listed(peaks, '.4g')}; peak omega rises, largest drop {100 * drop:.2f} %; SK "
    return Verdict(said + listed(skew + 1.0, ".3f"), holds)


def c84(study: Study) -> Verdict:
    skew = float(study.series["skewness"].sel(friction_capacity=2.0)) + 1.0
    bound = float(study.series["skewness"][0]) + 1.0
    return Verdict(f"SK = {skew:.2f} at F_c = 2 (F_c/(k_1 Y_0) = 1.33 > pi/4); {bound:.2f} at F_c = 1", skew > 1.05)


def c85(study: Study) -> Verdict:
    gap = np.abs(study.dwelt[..., 1] / study.dwelt[..., 0] - 1.0)
    i, j = np.unravel_index(int(gap.argmax()), gap.shape)
    above = 100.0 * float((gap > 0.05).mean())
    said = (
        f"worst {100 * gap.max():.1f} % off, at F_c = {CAPACITIES[i]:g}, omega = {DWELLS[j]:.2f}; more than 5 % off at "
    )
    said += f"{above:.1f} % of {gap.size} points; worst per F_c {listed(100 * gap.max(axis=1), '.2g')} %"
    return Verdict(said, bool(gap.max() < 0.05))


def c86(_: Study) -> Verdict:
    """Table 5.1, equation 5.8."""
    mu, sigma, radius, height, tip, young, wall = 0.25, 300e3, 0.040, 0.300, 1e-3, 2.8e9, 1.6e-3
    capacity = 2.0 * np.pi * radius * height * mu * sigma
    inertia = 0.25 * np.pi * (radius**4 - (radius - wall) ** 4)
    stiffness = 3.0 * young * inertia / height**3
    ratio = capacity / (stiffness * tip)
    holds = abs(ratio / 60.0 - 1.0) < 0.02 and abs(capacity / 5650.0 - 1) < 0.02 and abs(stiffness / 94.2e3 - 1) < 0.02
    said = (
        f"sigma_c = {1e-3 * mu * sigma:g} kPa, F_c = {1e-3 * capacity:.2f} kN, k = {1e-3 * stiffness:.1f} N/mm, F_k = "
    )
    return Verdict(said + f"{stiffness * tip:.1f} N, ratio {ratio:.1f}", holds)


def c87(study: Study) -> Verdict:
    section = load_case(ROOT / "configs" / "two_dof.yaml").two_dof
    assert section is not None
    said = f"0.12/0.15 = {0.12 / 0.15:.2f}, not 0.85; F_c/(k_1 Y_0) = {100.0 / (section.k1 * section.Y0):.1f}; m_2 is "
    return Verdict(said + f"{section.m2:g}", section.m2 == 0.85, "thesis error: explained")


def c88(study: Study) -> Verdict:
    found = study.over_stiffness
    values = np.array(list(found.values()))
    near = study.space["zeta_max"].sel(m2=0.85, method="nearest").values
    m2, k2 = study.space["m2"].values, study.space["k2"].values
    above = np.array(list(found)) >= TwoMasses().k2  # from Table 5.2 upward, as C89 from the layer's modulus upward
    said = f"m_2 = 0.85, k_2 {listed(np.array(list(found))[above], 'g')}: {listed(100 * values[above])} %; but at k_2 "
    said += f"{listed(np.array(list(found))[~above], 'g')}: {listed(100 * values[~above])} % (see below); map of "
    said += f"{len(m2)} x {len(k2)} (m_2 {m2[0]:g} to {m2[-1]:g}, k_2 {k2[0]:g} to {k2[-1]:g}), next to m_2 = 0.85: "
    said += f"{100 * near[0]:.1f} to {100 * near[-1]:.1f} %, lowest {100 * near.min():.1f} %"
    return Verdict(said, bool(np.all(np.diff(values) > 0.0)))


def c89(study: Study) -> Verdict:
    found = study.over_modulus
    values = np.array(list(found.values()))
    said = f"lab roll, E_l {listed(1e-9 * np.array(list(found)), 'g')} GPa, largest zeta of 10, 30 and 100 kPa: "
    return Verdict(said + f"{listed(100 * values)} %: it rises", bool(np.all(np.diff(values) < 0.0)))


def c90(study: Study) -> Verdict:
    a, b, c = study.arrangements.values()
    tops = [float(d["omega_peak"][-1]) for d in (a, b, c)]
    skews = [listed(d["skewness"].values + 1.0, ".2f") for d in (a, b, c)]
    said = f"peak omega at F_c = 100: (a) {tops[0]:.3f}, (b) {tops[1]:.3f}, (c) {tops[2]:.3f} (primary alone 1); SK at "
    said += f"F_c = 2, 5, 20, 100: (a) {skews[0]}; (b) {skews[1]}; (c) {skews[2]}"
    negative = bool((b["skewness"].values[:3] < 0.0).all())
    return Verdict(said, tops[2] <= 1.0 < tops[0] and negative)


CLAIMS: dict[str, tuple[str, Callable[[Study], Verdict]]] = {
    "C77": ("smoothed sign S(x) = 2/(1 + e^-x) - 1", c77),
    "C78": ("periodic response of eqs 5.2 to 5.7 with Table 5.2", c78),
    "C79": ("input of a cycle = losses in c_1, c_2 and friction", c79),
    "C80": ("peak transmissibility and its frequency over F_c", c80),
    "C81": ("m_2 sets the frequency floor, k_2 the ceiling", c81),
    "C82": ("low preload generally gives the largest damping", c82),
    "C83": ("growing preload: more symmetric, higher amplitude and frequency", c83),
    "C84": ("low preload gives positive skew", c84),
    "C85": ("a dwell of 6 tau with zeta = 0.2 % is conservative", c85),
    "C86": ("force ratio of the experiments about 60", c86),
    "C87": ("m_s/m_m about 0.85; F_c/(k_1 Y_0) about 70", c87),
    "C88": ("largest damping rises with k_2 at fixed m_2", c88),
    "C89": ("in the finite-element model it falls with the layer's modulus", c89),
    "C90": ("(a) is kept; (b) skews the other way; (c) does not stiffen", c90),
}


def tables(study: Study) -> list[str]:
    """Lines of docs/tables/two_dof.md."""
    data, lines = (
        study.series,
        ["# Two masses: tables of chapter 5", "", "`tools/claims_two_dof.py`; Table 5.2, SI names.", ""],
    )
    lines += [
        "Readings of the refined peaks (C80 to C84):",
        "",
        "| F_c | T_pk | omega_pk | half power | zeta, % | SK |",
    ]
    lines += ["|---|---|---|---|---|---|"]
    for capacity in CAPACITIES:
        one = data.sel(friction_capacity=capacity)
        lines.append(
            f"| {capacity:g} | {float(one['peak_transmissibility']):.3f} | {float(one['omega_peak']):.5f} | "
            f"{float(one['omega_low']):.5f} to {float(one['omega_high']):.5f} | {100 * float(one['zeta']):.3f} | "
            f"{float(one['skewness']) + 1:.3f} |"
        )
    lines += ["", "x1 amplitude / Y0, harmonic balance (time integration agrees to the digits given but one, C78):", ""]
    lines += [f"| F_c \\ omega | {' | '.join(format(w, 'g') for w in SETTLED)} |", "|---" * (len(SETTLED) + 1) + "|"]
    for capacity, row in zip(CAPACITIES, study.settled, strict=True):
        lines.append(f"| {capacity:g} | {' | '.join(format(v, '.5f') for v in row[:, 0])} |")
    lines += ["", "Relative difference of the two methods:", ""]
    lines += [f"| F_c \\ omega | {' | '.join(format(w, 'g') for w in SETTLED)} |", "|---" * (len(SETTLED) + 1) + "|"]
    for capacity, row in zip(CAPACITIES, study.settled, strict=True):
        lines.append(f"| {capacity:g} | {' | '.join(format(b / a - 1.0, '.0e') for a, b, _ in row)} |")
    return lines


def smoothing_rows(study: Study) -> list[str]:
    """Peak and damping over capacity for each scale s (appendix C)."""
    rows = [f"| s | {' | '.join(f'F_c = {c:g}' for c in STUCK)} |", "|---" * (len(STUCK) + 1) + "|"]
    for s, data in study.scales.items():
        read = zip(data["peak_transmissibility"].values, data["zeta"].values, strict=True)
        rows.append(f"| {s:g} | {' | '.join(f'{t:.4g}; {100 * z:.3g} %' for t, z in read)} |")
    return rows


def constant_rows(study: Study) -> list[str]:
    """Peaks with and without equations 5.6 and 5.7."""
    rows = ["| F_c | peak omega, T_pk, SK as in the source | with constant masses and stiffness |", "|---|---|---|"]
    both = analysed("two_dof.friction_capacity=[1.5, 2, 3, 5, 20]")
    for k, capacity in enumerate(study.constant["friction_capacity"].values):
        ones = [d.isel(friction_capacity=k) for d in (both, study.constant)]
        cells = [
            f"{float(d['omega_peak']):.3f}, {float(d['peak_transmissibility']):.1f}, {float(d['skewness']) + 1:.2f}"
            for d in ones
        ]
        rows.append(f"| {capacity:g} | {cells[0]} | {cells[1]} |")
    return rows


def plot_stiffness(study: Study) -> None:
    """Draw both models on one axis: largest damping over the secondary's stiffness; Table 5.2 and 2.8 GPa are 1."""
    ax = style.axes(None, 4.2)
    k2, zeta = (np.array(list(v)) for v in (study.over_stiffness, study.over_stiffness.values()))
    ax.plot(k2 / 1.15, 100 * zeta, "o-", color=style.BLUE, lw=1.8, label="two masses, $m_2$ = 0.85: $k_2$ / 1.15")
    modulus, found = (np.array(list(v)) for v in (study.over_modulus, study.over_modulus.values()))
    ax.plot(
        modulus / 2.8e9, 100 * found, "s-", color=style.RED, lw=1.8, label="finite elements, lab roll: $E_l$ / 2.8 GPa"
    )
    ax.set_xscale("log", base=2)
    ax.set_yscale("log")
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(lambda value, _: f"{value:g}")
    ax.set_yticks([2, 5, 10, 20, 30])
    ax.minorticks_off()
    ax.set_xlabel("Stiffness of the secondary over that of the reference (–)")
    ax.set_ylabel("Largest half-power damping (%)")
    ax.legend(fontsize=8, framealpha=0.9)
    style.title(ax, "Largest damping over the preloads against the stiffness of the secondary, in both models")
    print(save_figure(ax, FIGURES / "two_dof_stiffness.png"))


def figures(study: Study) -> None:
    print(save_figure(plot_two_dof(study.series), FIGURES / "two_dof.png"))
    print(save_figure(plot_two_dof_readings(study.fine), FIGURES / "two_dof_readings.png"))
    print(save_figure(plot_two_dof_arrangements(study.arrangements), FIGURES / "two_dof_arrangements.png"))
    print(save_figure(plot_two_dof_design_space(study.space), FIGURES / "two_dof_design_space.png"))
    if (FE_STUDY / "layer_modulus").is_dir():
        plot_stiffness(study)


def main() -> None:
    study, rows = Study(), ["| id | the source says | computed here | verdict |", "|---|---|---|---|"]
    for name, (said, claim) in CLAIMS.items():
        started = time.perf_counter()
        try:
            verdict = claim(study)
        except InputError as error:
            verdict = Verdict(str(error), None)
        print(f"{name:<5} {verdict.text():<24} {verdict.value}  [{time.perf_counter() - started:.0f} s]", flush=True)
        rows.append(f"| {name} | {said} | {verdict.value} | **{verdict.text()}** |")
    (ROOT / "docs" / "tables" / "two_dof.md").write_text("\n".join(tables(study)) + "\n")
    page = ROOT / "docs" / "two-dof.md"
    if page.is_file():
        text = put(put(page.read_text(), "claims", rows), "smoothing", smoothing_rows(study))
        page.write_text(put(text, "constant", constant_rows(study)))
    figures(study)


if __name__ == "__main__":
    main()
