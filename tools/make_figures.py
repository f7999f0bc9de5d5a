"""Figures and tables of README.md and docs/ beyond the claims: `.venv/bin/python tools/make_figures.py`.

Runs are kept in runs/docs, studies in runs/reproduce (as `wroll reproduce` keeps them, which draws the other figures);
what is already there is not computed again. About half an hour on two cores.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MPLBACKEND", "Agg")
ROOT = Path(__file__).resolve().parents[1]
WORKERS = int(os.environ.get("WORKERS", "2"))
RUNS, FIGURES = ROOT / "runs" / "docs", ROOT / "docs" / "figures"
PRESSURES = {"10 kPa": "1.0e4", "30 kPa": "3.0e4", "100 kPa": "1.0e5", "300 kPa": "3.0e5"}
STUDIES = {
    "winding_transmissibility": ("tension", "transmissibility_over_tension"),
    "ch4_preload_low_transmissibility_over_preload": ("preload_low", "transmissibility_over_preload"),
    "ch4_preload_low_damping_over_frequency": ("preload_low", "damping_over_frequency"),
    "ch4_integrators": ("integrators", "integrators"),
    "ch4_elastic_slip": ("elastic_slip", "elastic_slip"),
    "slipping_tension": ("slipping_tension", "damping_over_level"),
}
"""Figure -> study of configs/studies, and the figure's name there."""
STUDY_MESH = ["mesh.circumferential=24", "mesh.axial=12"]
WIDE = ["excitation.f_start=110", "excitation.f_end=185"]


def jobs() -> dict[str, list[str]]:
    """Name of each run -> case file and overrides."""
    found = {"main": ["configs/lab_sweep.yaml"], "modes": ["configs/lab_modal.yaml"]}
    found["case_study"] = ["configs/case_study.yaml"]
    found["slipping_coil"] = ["configs/slipping_coil.yaml"]
    found["slipping_harmonic"] = ["configs/slipping_harmonic.yaml"]
    found["random"] = ["configs/lab_random.yaml"]
    found["shock"] = ["configs/lab_shock.yaml"]
    found["sizing"] = ["configs/sizing_irosa.yaml"]
    found |= {"harmonic": ["configs/lab_harmonic.yaml"], "backbone": ["configs/lab_backbone.yaml"]}
    found["random_response"] = ["configs/lab_random_response.yaml"]
    for base, file in (("free", "lab_sweep.yaml"), ("clamped", "lab_sweep_clamped.yaml")):
        for label, pressure in PRESSURES.items():
            sets = [f"preload.pressure={pressure}", *STUDY_MESH, *WIDE, "output.figures=false"]
            found[f"{base}_{label.replace(' ', '')}"] = [f"configs/{file}", *sets]
    for around, along in ((16, 8), (32, 16), (40, 20)):
        sets = [f"mesh.circumferential={around}", f"mesh.axial={along}", "output.figures=false"]
        found[f"mesh_{around}x{along}"] = ["configs/lab_sweep.yaml", *sets]
    return found


def run(name: str, words: list[str]) -> dict:
    """Run one case (or find it done) and return its summary."""
    out = RUNS / name
    command = [str(ROOT / ".venv/bin/wroll"), "run", words[0], "--out", str(out), "--resume"]
    command += [word for text in words[1:] for word in ("--set", text)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{name}: {done.stderr.strip()}")
    print(f"{name}: done", flush=True)
    return json.loads((out / "summary.json").read_text())


def read(value: float | None, digits: str, unit: str = "") -> str:
    """A reading with its unit, or that there is none."""
    if value is None:
        return "not read"
    return f"{100 * value if unit == '%' else value:{digits}} {unit}".strip()


def base_table(summaries: dict[str, dict]) -> str:
    """Free against clamped, preload by preload, as Markdown."""
    lines = [
        "Half-power zeta and skewness of a roll that does not slip describe the sweep, not damping.",
        "Last column: friction work until the tip acceleration reaches the peak of the roll with a free layer base.",
        "",
        "| base | preload | interface pressure | f_n | zeta | peak T | skewness | friction work "
        "| friction work / largest stored energy | friction work at equal motion |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for base in ("free", "clamped"):
        for label in PRESSURES:
            s = summaries[f"{base}_{label.replace(' ', '')}"]
            level = summaries[f"free_{label.replace(' ', '')}"]["peak_transmissibility"] * 5.0
            over_stored, equal = friction_measures(f"{base}_{label.replace(' ', '')}", 0.99 * level)
            lines.append(
                f"| {base} | {label} | {s['interface_pressure_mean_pa'][0] / 1e3:.1f} kPa | "
                f"{read(s['f_n_hz'], '.1f', 'Hz')} | {read(s['zeta'], '.2f', '%')} | "
                f"{read(s['peak_transmissibility'], '.1f')} | {read(s['skewness'], '+.2f')} | "
                f"{1e3 * s['friction_energy_j']:.3g} mJ | {over_stored:.3g} | {1e3 * equal:.3g} mJ |"
            )
    return "\n".join(lines) + "\n"


def friction_measures(name: str, level: float) -> tuple[float, float]:
    """Friction work over largest stored energy, and friction work (J) until the tip first reaches ``level``, m/s^2."""
    import numpy as np

    from wroll_fem.results.dataset import load_dataset

    d = load_dataset(RUNS / name / "results.nc")
    stored = (d["kinetic_energy"] + d["strain_energy"] + d["contact_energy"]).values
    tip = np.abs((d["tip_acceleration"] + d["base_acceleration"]).values)
    friction = d["friction_energy"].values
    reached = int(np.argmax(tip >= level)) if tip.max() >= level else -1
    equal = float(friction[reached])
    return float(friction[-1] / stored.max()), equal if equal > 1e-12 else 0.0


def mesh_table(summaries: dict[str, dict]) -> str:
    """Convergence of the friction response with the mesh, as Markdown."""
    lines = [
        "| mesh | DOFs | contact points | f_n | zeta | peak T | friction work | time loop |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, s in summaries.items():
        if not name.startswith("mesh_"):
            continue
        lines.append(
            f"| {name[5:]} | {s['dofs']} | {s['interface_points']} | {read(s['f_n_hz'], '.2f', 'Hz')} | "
            f"{read(s['zeta'], '.2f', '%')} | {read(s['peak_transmissibility'], '.2f')} | "
            f"{1e3 * s['friction_energy_j']:.1f} mJ | {s['solver_time_s']:.0f} s |"
        )
    return "\n".join(lines) + "\n"


def comparison(path: Path, base: str) -> None:
    """Transmissibility of all preloads of one base condition."""
    from wroll_fem.plotting.names import comparison, save
    from wroll_fem.results.dataset import load_dataset

    runs = {label: load_dataset(RUNS / f"{base}_{label.replace(' ', '')}" / "results.nc") for label in PRESSURES}
    save(comparison(runs), path)


def studies() -> None:
    """Figures of studies that no claim is judged on."""
    from reproduction import Evidence
    from reproduction.claim_group import study_figure
    from wroll_fem.plotting.names import save

    with Evidence(ROOT / "runs" / "reproduce", workers=WORKERS) as evidence:
        for name, (study, figure) in STUDIES.items():
            print(save(study_figure(study, figure)(evidence), FIGURES / f"{name}.png"), flush=True)


LAB = {
    ("slip", "slip_groups"): "laboratory_slip_groups",
    ("slip", "noise"): "laboratory_noise",
    ("shear", "force_displacement"): "lab_shear",
    ("friction", "rate"): "lab_friction_rate",
    ("friction", "state"): "lab_friction_state",
    ("tension", "tension"): "lab_tension",
}
"""Kind and figure of a laboratory evaluation -> its picture, drawn from the example of the kind."""


def laboratory() -> None:
    """Draw the figures of docs/laboratory.md from the examples of the kinds."""
    import wroll_fem as wf
    from wroll_fem.lab.examples import example_files
    from wroll_fem.plotting.names import save

    with TemporaryDirectory() as folder:
        for kind in dict.fromkeys(kind for kind, _ in LAB):
            files = example_files(kind, Path(folder) / kind)
            result = wf.lab.evaluate(kind, files, settings_file=files[0].parent / "settings.yaml")
            for (other, figure), name in LAB.items():
                if other == kind:
                    print(save(result.plot(figure), FIGURES / f"{name}.png"), flush=True)


def branches(path: Path) -> None:
    """Both branches of a sweep up and down of an oscillator of 10 Hz; a friction joint is 30 % of its stiffness."""
    import wroll_fem as wf

    stiffness = (20.0 * math.pi) ** 2
    joint = wf.joints.Jenkins(at=0, stiffness=0.3 * stiffness, limit=0.6)
    oscillator = wf.structure([[0.7 * stiffness]], [[1.0]], [joint], damping=0.02)
    sweep = {"f_start": 7, "f_end": 13, "rate_hz_per_s": 0.1, "ramp_cycles": 10, "sweep_direction": "up_down"}
    wf.plot.save(wf.plot.transmissibility(oscillator.run_sweep(wf.Chirp(amplitude=0.8, **sweep)).data), path)


def main() -> None:
    """Run everything, then copy pictures and write tables."""
    FIGURES.mkdir(parents=True, exist_ok=True)
    todo = jobs()
    with ThreadPoolExecutor(WORKERS) as pool:
        summaries = dict(zip(todo, pool.map(run, todo, todo.values()), strict=True))
    for source, target in (
        ("main/figures/transmissibility.png", "transmissibility.png"),
        ("main/figures/slip_map_01.png", "slip_map.png"),
        ("main/figures/slip_on_cylinder.png", "slip_on_cylinder.png"),
        ("main/figures/energy_ledger.png", "energy_ledger.png"),
        ("main/figures/response.png", "response.png"),
        ("modes/figures/mode_shapes.png", "mode_shapes.png"),
        ("harmonic/figures/transmissibility.png", "harmonic_response.png"),
        ("backbone/figures/backbone.png", "backbone.png"),
        ("random_response/figures/random_response.png", "random_response.png"),
        ("sizing/figures/margin.png", "sizing.png"),
        ("case_study/figures/slip_in_coil.png", "case_study_slip_in_coil.png"),
        ("slipping_coil/figures/slip_work.png", "slipping_coil_work.png"),
        ("slipping_coil/figures/slip_work_sections.png", "slipping_coil_sections.png"),
        ("slipping_coil/figures/slip_work_in_coil.png", "slipping_coil_space.png"),
        ("slipping_harmonic/figures/wrap_slip.png", "slipping_coil_wraps.png"),
        ("random/figures/spectra.png", "random_spectra.png"),
        ("shock/figures/shock.png", "shock.png"),
    ):
        shutil.copy(RUNS / source, FIGURES / target)
    branches(FIGURES / "up_and_down.png")
    comparison(FIGURES / "base_free.png", "free")
    comparison(FIGURES / "base_clamped.png", "clamped")
    (ROOT / "docs" / "tables").mkdir(exist_ok=True)
    (ROOT / "docs" / "tables" / "base.md").write_text(base_table(summaries))
    (ROOT / "docs" / "tables" / "mesh.md").write_text(mesh_table(summaries))
    studies()
    laboratory()


if __name__ == "__main__":
    main()
