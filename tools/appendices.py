"""Appendices A and B of the source on the lab roll: elastic slip and integrators.

`.venv/bin/python tools/appendices.py` writes docs/tables/appendix_a.md and appendix_b.md, docs/figures/appendix_a_*.png
and appendix_b_*.png.
Runs are kept in runs/appendices; what is there is not computed again. About fifteen minutes on two idle cores.
Appendix C has a tool of its own, tools/appendix_c.py.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from wroll_fem.dynamics.hht import Scheme, numerical_damping
from wroll_fem.plotting import style
from wroll_fem.results import load_dataset
from wroll_fem.signals.transmissibility import magnitude

ROOT = Path(__file__).resolve().parents[1]
RUNS, FIGURES, TABLES = ROOT / "runs" / "appendices", ROOT / "docs" / "figures", ROOT / "docs" / "tables"
MESH = ["mesh.circumferential=16", "mesh.axial=8", "output.figures=false"]
SLIPS = {"100um": "1.0e-4", "10um": "1.0e-5", "1um": "1.0e-6", "0.1um": "1.0e-7"}
CONDENSED, REDUCED = "solver.method=condensed", "solver.method=reduced"
SERIES = {
    "slip": ("1 kPa (576 Pa at the interface), condensed", ["preload.pressure=1.0e3", CONDENSED]),
    "reduced": ("1 kPa, reduced", ["preload.pressure=1.0e3", REDUCED]),
    "mean": ("1.737 kPa (1 kPa at the interface), condensed", ["preload.pressure=1.737e3", CONDENSED]),
    "tied": (
        "1 kPa, surfaces that cannot separate, condensed",
        ["preload.pressure=1.0e3", CONDENSED, "contact.normal.separation=false"],
    ),
    "firm": ("10 kPa, condensed", ["preload.pressure=1.0e4", CONDENSED]),
}
ALPHAS = {"no_damping": "0", "transient_fidelity": "-0.05", "moderate_dissipation": "-0.41421", "quasi_static": "0"}
STEP = 3.0722e-4
"""Time step of the source's run (figure B.2), s."""
# the source's 35.0978 s at 2 oct/min are a factor 2.25 in frequency; 15 steps per cycle of 217 Hz are its time step
SOURCE_RUN = [
    "excitation.f_start=96.4444444444", "excitation.f_end=217", "preload.pressure=1.0e4", "contact.friction.mu=0.45",
    "solver.allow_coarse=true", CONDENSED,
]  # fmt: skip


def jobs() -> dict[str, list[str]]:
    """Name of each run -> overrides of configs/lab_sweep.yaml."""
    found = {}
    for series, (_, sets) in SERIES.items():
        for name, value in SLIPS.items():
            band = ["excitation.f_start=110", "excitation.f_end=170"]
            found[f"{series}_{name}"] = [*MESH, *band, *sets, f"contact.friction.elastic_slip={value}"]
    for name, alpha in ALPHAS.items():
        scheme = [f"integrator.scheme={name}", f"integrator.alpha={alpha}", "integrator.steps_per_cycle=15"]
        found[f"scheme_{name}"] = [*MESH, *SOURCE_RUN, *scheme]
    found["scheme_reference"] = [*MESH, *SOURCE_RUN, "integrator.steps_per_cycle=60"]
    return found


def run(name: str, sets: list[str]) -> dict | None:
    """Summary of one case; None where the solver gave up (its results until then are kept)."""
    out = RUNS / name
    if (out / "summary.json").exists():
        return json.loads((out / "summary.json").read_text())
    if not (out / "results.nc").exists():
        command = [str(ROOT / ".venv/bin/wroll"), "run", "configs/lab_sweep.yaml", "--out", str(out)]
        command += [word for text in sets for word in ("--set", text)]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
        print(f"{name}: exit {done.returncode} {done.stderr.strip().splitlines()[-1:]}", flush=True)
        if done.returncode == 0:
            return json.loads((out / "summary.json").read_text())
        if done.returncode != 3:
            sys.exit(f"{name}: {done.stderr.strip()}")
    return None


def row(*cells: object) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def shear_lag(pressure: float, mu: float, slip: float) -> float:
    """Length over which friction hands axial force to the layer, m: sqrt((E t)_series gamma* / (mu p))."""
    series = 1.0 / (1.0 / (2.7e9 * 1.5e-3) + 1.0 / (2.8e9 * 1.25e-3))
    return float(np.sqrt(series * slip / (mu * pressure)))


def slip_table(found: dict[str, dict | None]) -> str:
    """Appendix A: response over gamma*."""
    lines = [
        "Lab roll, base of the layer free, 16 x 8 cells, mu = 0.25, 5 m/s^2, 110 to 170 Hz at 2 oct/min, 40 steps per",
        "cycle: `.venv/bin/python tools/appendices.py`. Change: against the row above. Open: largest part of the",
        "interface that was open at once. Shear lag: sqrt((E t)_series gamma*/(mu p)), also over the root element.",
        "",
    ]
    for series, (text, _) in SERIES.items():
        head = [
            "gamma*",
            "f_n",
            "change",
            "peak T",
            "change",
            "zeta",
            "open",
            "steps cut",
            "ledger error",
            "shear lag",
            "",
        ]
        lines += [f"External pressure {text}", "", row(*head), row(*["---"] * len(head))]
        before = None
        for name, value in SLIPS.items():
            s, d = found[f"{series}_{name}"], load_dataset(RUNS / f"{series}_{name}" / "results.nc")
            pressure = float((d["pressure"] * d["area"]).sum() / d["area"].sum())
            z = np.unique(np.round(d["z_m"].values, 9))
            lag = shear_lag(pressure, 0.25, float(value))
            end = f"{100 * float(d['open_fraction'].max()):.0f} %"
            if s is None:
                reached = float(d["instantaneous_frequency"].values[-1])
                top = np.abs(d["tip_acceleration"] + d["base_acceleration"]).values.max() / 5.0
                cells = [f"stopped at {reached:.1f} Hz", "", f"above {top:.0f}", "", "", end, d.attrs["step_cuts"], ""]
                before = None
            else:
                f, t = s["f_n_hz"], s["peak_transmissibility"]
                change = ["", ""]
                if before is not None:
                    change = [f"{f - before[0]:+.2f} Hz", f"{100 * (t / before[1] - 1):+.1f} %"]
                zeta = "not read" if s["zeta"] is None else f"{100 * s['zeta']:.2f} %"
                cells = [f"{f:.2f} Hz", change[0], f"{t:.1f}", change[1], zeta, end, s["step_cuts"]]
                cells.append(f"{s['energy_balance_error']:.0e}")
                before = f, t
            lengths = f"{1e3 * lag:.0f} mm", f"{lag / (z[1] - z[0]):.1f} elements"
            lines.append(row(f"{float(value) * 1e6:g} um", *cells, *lengths))
        lines.append("")
    return "\n".join(lines)


def scheme_table(found: dict[str, dict | None]) -> str:
    """Appendix B: damping of the schemes alone, and the sweep with each."""
    head = ["scheme", "damping ratio", "period", "f_n", "peak T", "zeta", "friction/input", "numerical/input", "CPU"]
    lines = [
        "`.venv/bin/python tools/appendices.py`. First the schemes on a free oscillator at omega dt = 0.29 (150 Hz and",
        "the source's step), then the lab roll at 10 kPa, mu = 0.45, 16 x 8 cells, at the source's duration and step:",
        "35.098 s from 96.4 to 217 Hz, 114 244 steps of 0.30722 ms. Reference: alpha = -0.05, a quarter of the step.",
        "",
        row(*head),
        row(*["---"] * len(head)),
    ]
    for name in [*ALPHAS, "reference"]:
        s = found[f"scheme_{name}"]
        if s is None:
            sys.exit(f"{name} did not converge")
        angle = 0.29 if name != "reference" else 0.29 / 4
        damping, period = numerical_damping(Scheme.named(name) if name in ALPHAS else Scheme.hht(-0.05), angle)
        damping = 0.0 if abs(damping) < 1e-12 else damping
        lines.append(
            row(
                name, f"{damping:.4e}", f"{100 * period:+.2f} %", f"{s['f_n_hz']:.2f} Hz",
                f"{s['peak_transmissibility']:.2f}", f"{100 * s['zeta']:.2f} %",
                f"{100 * s['friction_energy_j'] / s['input_work_j']:.2g} %",
                f"{100 * s['numerical_dissipation_j'] / s['input_work_j']:.2g} %", f"{s['solver_time_s']:.0f} s",
            )
        )  # fmt: skip
    return "\n".join(lines) + "\n"


def damping_figure(path: Path) -> None:
    """Numerical damping ratio over steps per cycle."""
    ax = style.axes(None)
    steps = np.geomspace(8.0, 320.0, 200)
    for name, colour in zip(("quasi_static", "moderate_dissipation", "transient_fidelity"), style.LINES, strict=False):
        ratio = [numerical_damping(Scheme.named(name), 2.0 * np.pi / n)[0] for n in steps]
        ax.loglog(steps, ratio, color=colour, lw=1.6, label=name)
    ax.axvline(1.0 / (150.0 * STEP), color="black", lw=0.8, ls="--", label="the source's step at 150 Hz: 21.7")
    ax.axhspan(0.01, 0.05, color="#DDDDDD", label="damping of the roll: 1 to 5 %")
    ax.plot([], [], " ", label="no_damping: zero")
    ax.set_xlabel("Steps per cycle (–)")
    ax.set_ylabel(r"Numerical damping ratio $\zeta$ (–)")
    ax.legend(fontsize=8)
    style.title(ax, "HHT takes a small part of the roll's damping; backward Euler exceeds it below 60 steps per cycle")
    style.save_figure(ax, path)


def curves_figure(path: Path, names: dict[str, str], sentence: str, log: bool = False, band=(None, None)) -> None:
    """Transmissibility of several runs; those that stopped are drawn as far as they went."""
    ax = style.axes(None, 4.6)
    for (name, text), colour, dash in zip(names.items(), style.LINES, ("-", "--", "-.", ":", "-"), strict=False):
        frequency, size = response(load_dataset(RUNS / name / "results.nc"))
        ax.plot(frequency, size, color=colour, lw=1.5, ls=dash, label=text)
    if log:
        ax.set_yscale("log")
        ax.set_ylim(bottom=1.0)
    ax.set_xlim(*band)
    ax.set_xlabel("Frequency (Hz)")
    ax.set_ylabel("Transmissibility |T|, tip over base (–)")
    ax.legend(fontsize=8)
    style.title(ax, sentence)
    style.save_figure(ax, path)


def response(d: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Frequency and |T| of a sweep; of one that stopped, the largest tip acceleration in 60 steps over the base's."""
    if "transmissibility_real" in d:
        return d["frequency"].values, magnitude(d).values
    tip = np.abs((d["tip_acceleration"] + d["base_acceleration"]).values) / 5.0
    size = 60
    count = tip.size // size
    return d["instantaneous_frequency"].values[: count * size : size], tip[: count * size].reshape(count, size).max(
        axis=1
    )


def main() -> None:
    """Run everything, then write tables and pictures."""
    todo = jobs()
    RUNS.mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(int(os.environ.get("WORKERS", "2"))) as pool:
        found = dict(zip(todo, pool.map(run, todo, todo.values()), strict=True))
    (TABLES / "appendix_a.md").write_text(slip_table(found))
    (TABLES / "appendix_b.md").write_text(scheme_table(found))
    damping_figure(FIGURES / "appendix_b_damping.png")
    plt.close("all")
    for series in SENTENCES:
        names = {f"{series}_{n}": rf"$\gamma^*$ = {float(v) * 1e6:g} µm" for n, v in SLIPS.items()}
        curves_figure(FIGURES / f"appendix_a_{series}.png", names, SENTENCES[series], log=True)
    t = {name: found[f"scheme_{name}"]["peak_transmissibility"] for name in ALPHAS}
    hht = [t[name] for name in ("no_damping", "transient_fidelity", "moderate_dissipation")]
    curves_figure(
        FIGURES / "appendix_b_schemes.png",
        {f"scheme_{name}": name for name in [*ALPHAS, "reference"]},
        f"The three HHT variants peak within {100 * (max(hht) / min(hht) - 1):.1f} % of each other; "
        f"backward Euler leaves {t['quasi_static']:.1f} of {min(hht):.0f}",
        band=(110, 180),
    )


SENTENCES = {
    "slip": "1 kPa: large elastic slips let the resonance grow until the layer's impacts stop the run",
    "tied": "1 kPa without separation: each smaller elastic slip changes the peak less",
    "firm": "10 kPa: an elastic slip of 1 µm has not converged, the stick stiffness being ten times that at 1 kPa",
}


if __name__ == "__main__":
    main()
