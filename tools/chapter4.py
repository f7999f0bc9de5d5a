"""Run the studies of chapter 4 (configs/studies) and make its figures and its page of claims.

`.venv/bin/python tools/chapter4.py [STUDY ...]`: all studies without a name, two cases at a time (WORKERS);
what is done in runs/docs/chapter4 is not computed again. Figures go to docs/figures/ch4_*.png,
the claims to docs/claims-chapter4.md.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MPLBACKEND", "Agg")

import claims_ch4
import numpy as np
from chapter4_runs import ROOT, STUDIES
from matplotlib.axes import Axes

from wroll_fem.case import load_case
from wroll_fem.contact.laws import slip_update, stack_laws
from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.plotting import save_figure, style

RUNS, FIGURES = ROOT / "runs" / "docs" / "chapter4", ROOT / "docs" / "figures"


def run_study(path: Path) -> None:
    """Run one study by the command that its page gives; says which cases failed and goes on."""
    command = [str(ROOT / ".venv/bin/wroll"), "batch", str(path.relative_to(ROOT)), "--out", str(RUNS / path.stem)]
    command += ["--workers", os.environ.get("WORKERS", "2")]
    print(f"== {path.stem}", flush=True)
    subprocess.run(command, cwd=ROOT, check=False)


def friction_law_figure() -> Axes:
    """Draw the penalty law of the lab case on a closed path of slip, beside Coulomb's (Fig 4.2)."""
    friction = load_case(ROOT / "configs" / "lab_sweep.yaml").contact.friction
    law = PenaltyCoulomb(mu=float(friction.mu or 0.0), elastic_slip=friction.elastic_slip)
    laws = stack_laws([np.array([1.0])], [law], [1e12], [True])
    reach = 4.0 * law.elastic_slip
    path = np.interp(np.linspace(0.0, 3.0, 1201), [0.0, 1.0, 2.0, 3.0], [0.0, reach, -reach, reach])
    elastic, traction = 0.0, []
    for before, now in pairwise(path):
        elastic, _, _ = slip_update(0, elastic + now - before, 0.0, now - before, 0.0, laws, np.inf)
        traction.append(elastic / law.elastic_slip)
    ax = style.axes(None, 4.0)
    ax.plot([-4, 0, 0, 4], [-1, -1, 1, 1], color=style.GREY, lw=1.4, ls="--", label="Coulomb")
    ax.plot(1e6 * path[1:], traction, color=style.BLUE, lw=1.8, label="penalty law, there and back")
    ax.axvspan(0.0, 1e6 * law.elastic_slip, color="#E4EEF5", label=f"elastic slip γ* = {1e6 * law.elastic_slip:g} µm")
    ax.set_xlabel("Relative tangential displacement (µm)")
    ax.set_ylabel("Shear stress over µp (–)")
    ax.legend(fontsize=8, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)
    first = int(np.argmax(np.array(traction) >= 1.0 - 1e-9))
    back = int(np.argmax((np.array(traction) <= -1.0 + 1e-9) & (np.arange(1200) > 400)))
    slips = (path[first + 1] / law.elastic_slip, (reach - path[back + 1]) / law.elastic_slip)
    said = f"is reached after {slips[0]:.1f} γ*, from a turn after {slips[1]:.1f} γ*"
    ax.set_title(f"From rest the limit µp (µ = {law.mu:g}) {said}", loc="left", pad=22, fontsize=10)
    return ax


def collect() -> None:
    """Copy the figures of all studies to docs/figures and judge the claims from what has been run."""
    FIGURES.mkdir(parents=True, exist_ok=True)
    for path in sorted(STUDIES.glob("*.yaml")):
        for figure in sorted((RUNS / path.stem / "figures").glob("*.png")):
            same = figure.stem == path.stem or path.stem in ("preload", "dwell_layers")
            name = figure.stem if same else f"{path.stem}_{figure.stem}"
            shutil.copy(figure, FIGURES / f"ch4_{name}.png")
    save_figure(friction_law_figure(), FIGURES / "ch4_friction_law.png")
    claims_ch4.write(RUNS)


def main(names: list[str]) -> None:
    """Run the studies named (all without), then collect figures and claims."""
    for path in sorted(STUDIES.glob("*.yaml")):
        if not names or path.stem in names:
            run_study(path)
    collect()


if __name__ == "__main__":
    main(sys.argv[1:])
