"""The recipes of docs/extend.md, applied to a copy of the package and run."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from support.paths import ROOT

PAGE = (ROOT / "docs" / "extend.md").read_text(encoding="utf-8")
FRICTION, ANALYSIS, EXCITATION, BODY = (
    PAGE.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    for heading in ("A friction law", "An analysis", "An excitation", "A body")
)

ALONE = """
from wroll_fem.contact import registry
registry.LAWS[:] = [law for law in registry.LAWS if law.name in ("penalty_coulomb", "dahl")]
"""
"""The kernels compile with every registered law in them; two take a third of the seconds of seven."""

DAHL_POINT = """
import numpy as np
from wroll_fem.contact import kernels
from wroll_fem.contact.dahl import Dahl
from wroll_fem.contact.laws import stack_laws

law = stack_laws([np.array([1.0])], [Dahl(0.25, 1.0e-6)], [1.0e12], [True])
start, e_c = np.array([0.0, 0.0, -1.0e-7]), np.array([2.0e-7, -3.0e-7])

def traction(g):
    t, e, status = np.zeros(3), np.zeros(2), np.zeros(1, np.int64)
    kernels.trial_traction(g, start, e_c, law, 1.0, t, e, status)
    return t

at, d = start + np.array([4.0e-7, -6.0e-7, 2.0e-8]), np.zeros((1, 3, 3))
kernels.consistent_tangent(at, start, e_c, law, 1.0, d)
steps = 1.0e-11 * np.eye(3)
differences = np.stack([(traction(at + h) - traction(at - h)) / 2.0e-11 for h in steps], axis=1)
assert np.abs(d[0] - differences).max() < 1.0e-6 * np.abs(differences).max(), (d[0], differences)
"""

DAHL_CASE = """
from wroll_fem import example_case
from wroll_fem.analyses import run_analysis, summarise
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.case import build_case
from wroll_fem.case.schema import schema_text
from wroll_fem.contact.dahl import Dahl
from wroll_fem.dynamics.system.io import load_system, save_system
from wroll_fem.errors import InputError
from wroll_fem.progress import SilentProgress

case = example_case().changed(
    "contact.friction.law=dahl", "excitation.amplitude=50", "solver.method=full", "integrator.steps_per_cycle=20",
    "mesh.circumferential=8", "mesh.axial=2", "excitation.cycles=2", "excitation.ramp_cycles=1", "preload.steps=2",
)
summary = summarise(run_analysis(case, progress=SilentProgress()), case)
assert summary["friction_energy_j"] > 0.05 * summary["input_work_j"] > 0, summary
assert summary["energy_balance_error"] < 1.0e-6, summary

assert "elastic slip, m: sets the stiffness at rest" in schema_text()
try:
    case.changed("contact.friction.mu=-1")
except InputError as error:
    assert "contact.friction.mu" in str(error)
else:
    raise AssertionError("a negative coefficient was accepted")

system, state = prepare(case, SilentProgress())
save_system(system, "dahl.npz", preload=state)
assert load_system("dahl.npz")[0].interfaces[0].friction == Dahl(case.contact.friction.mu, 1.0e-6)
"""

BURST = """
import numpy as np
from wroll_fem import example_case
from wroll_fem.analyses import run_analysis
from wroll_fem.progress import SilentProgress

case = example_case().changed(
    "excitation={kind: burst, amplitude: 5, frequency: 150, cycles: 2, rest_cycles: 2}", "solver.method=full",
    "mesh.circumferential=8", "mesh.axial=2",
)
result = run_analysis(case, progress=SilentProgress())
time, base = result["time"].values, result["base_acceleration"].values
assert abs(time[-1] - 4 / 150) < 1.0e-9 and np.abs(base).max() > 4.9
assert not base[time > 2.0001 / 150].any()
assert abs(result["input_work"].values[-1] - result["input_work"].values[time > 2.05 / 150][0]) < 1e-12
"""

ONE_BY_ONE = """
import json, traceback
from pathlib import Path

errors = {}
for name, code in json.loads(Path("checks.json").read_text()).items():
    try:
        exec(compile(code, name, "exec"), {})
        errors[name] = ""
    except BaseException:
        errors[name] = traceback.format_exc()
Path("errors.json").write_text(json.dumps(errors))
"""
"""Runs checks in one process, which loads the libraries once."""

TIP = """
import sys
from typer.testing import CliRunner
import wroll_fem as wf
from wroll_fem.analyses import find_analysis
from wroll_fem.cli import app

coarse = ["analysis=tip_stiffness", "mesh.circumferential=8", "mesh.axial=3", "preload.steps=2"]
words = [word for text in coarse for word in ("--set", text)]
done = CliRunner().invoke(app, ["run", sys.argv[1], "--out", "stiff", *words])
assert done.exit_code == 0, done.output
result = wf.load_result("stiff")
stiffness = wf.summarise(result)["tip_stiffness_n_m"]
whole = wf.run(wf.load_case(sys.argv[1], [*coarse, "solver.symmetry=false"]), progress=False)
assert abs(wf.summarise(whole)["tip_stiffness_n_m"] / stiffness - 1.0) < 1.0e-6, stiffness
case, pi = wf.case_of(result), 3.141592653589793
tubes = ((case.mandrel.material.E, 0.03925, 1.5e-3), (case.coil.material.E, 0.040625, 1.25e-3))
bonded = sum(3.0 * E * pi * r**3 * t for E, r, t in tubes) / case.geometry.length**3  # without shear flexibility
assert 0.3 * bonded < stiffness < bonded, (stiffness, bonded)
page = CliRunner().invoke(app, ["report", "stiff"])
assert page.exit_code == 0 and find_analysis("tip_stiffness").sentence in open("stiff/report.html").read()
"""


def blocks(text: str, language: str) -> list[str]:
    """Content of the fenced blocks of one language."""
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)


def apply(diff: str, root: Path) -> None:
    """Apply a diff without line numbers: each hunk's old lines must stand in the file exactly once."""
    for part in re.split(r"^--- .*\n(?=\+\+\+)", diff, flags=re.MULTILINE)[1:]:
        name = re.match(r"\+\+\+ b/(\S+)\n", part)[1]
        for hunk in part.split("@@\n")[1:]:
            lines = hunk.splitlines()
            old = "".join(f"{line[1:]}\n" for line in lines if not line.startswith("+"))
            new = "".join(f"{line[1:]}\n" for line in lines if not line.startswith("-"))
            text = (root / name).read_text(encoding="utf-8")
            assert text.count(old) == 1, f"{name}: {text.count(old)} times\n{old}"
            (root / name).write_text(text.replace(old, new), encoding="utf-8")


def run_in(copy: Path, code: str, *, compiled: bool = False) -> str:
    """Error of Python with the copy of the package; "" if none. Interpreted: compiling it all would take a minute."""
    environment = os.environ | {"PYTHONPATH": str(copy), "NUMBA_DISABLE_JIT": str(int(not compiled))}
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=copy,
        env=environment,
        capture_output=True,
        text=True,
        timeout=600,  # only against hanging: ten seconds, but minutes on a loaded machine
        check=False,
    )
    return done.stderr if done.returncode else ""


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    shutil.copytree(ROOT / "wroll_fem", tmp_path / "wroll_fem")  # with its bytecode: seconds of compiling
    return tmp_path


@pytest.mark.slow
def test_the_friction_law_of_the_recipe_runs(copy: Path) -> None:
    law, check = blocks(FRICTION, "python")
    (copy / "wroll_fem" / "contact" / "dahl.py").write_text(law, encoding="utf-8")
    (registration,) = blocks(FRICTION, "diff")  # one file beside the law's own
    apply(registration, copy)
    assert run_in(copy, ALONE + DAHL_POINT, compiled=True) == ""
    assert run_in(copy, check + DAHL_POINT + DAHL_CASE) == ""


@pytest.fixture(scope="module")
def errors(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Error of the check of each recipe; both are applied to one copy and run in one process."""
    copy = tmp_path_factory.mktemp("recipes")
    shutil.copytree(ROOT / "wroll_fem", copy / "wroll_fem")
    for recipe, file in ((ANALYSIS, "analyses/tip_stiffness.py"), (EXCITATION, "signals/burst.py")):
        (code,) = blocks(recipe, "python")
        (copy / "wroll_fem" / file).write_text(code, encoding="utf-8")
        for diff in blocks(recipe, "diff"):
            apply(diff, copy)
    case = ROOT / "configs" / "lab_dwell.yaml"
    checks = {"analysis": TIP.replace("sys.argv[1]", repr(str(case))), "excitation": BURST}
    (copy / "checks.json").write_text(json.dumps(checks), encoding="utf-8")
    assert run_in(copy, ONE_BY_ONE) == ""
    found: dict[str, str] = json.loads((copy / "errors.json").read_text(encoding="utf-8"))
    return found


def test_the_analysis_of_the_recipe_runs(errors: dict[str, str]) -> None:
    assert errors["analysis"] == ""


def test_the_excitation_of_the_recipe_runs(errors: dict[str, str]) -> None:
    assert errors["excitation"] == ""


def test_the_rigid_sleeve_of_the_recipe_is_a_body() -> None:
    names: dict = {}
    exec(compile(blocks(BODY, "python")[0], "extend.md", "exec"), names)
    sleeve, layer, mandrel, system = (names[name] for name in ("sleeve", "layer", "mandrel", "system"))
    (interface,) = system.interfaces
    both = np.concatenate([mandrel.influence, sleeve.influence])  # both translate: no jump but by the clamped ring
    first_row = np.unique(mandrel.nodes[mandrel.cells[:, :4], 2].round(9))[1]  # upper edge of the elements that hold it
    off_the_base = np.repeat(interface.points[:, 1] > first_row, 3)
    assert 0 < off_the_base.sum() < off_the_base.size
    assert np.abs((interface.operator @ both)[off_the_base]).max() < 1e-9
    motions = layer.expand @ (layer.expand.T @ sleeve.expand) - sleeve.expand
    assert abs(motions).max() < 1e-12  # the layer can move rigidly
    kinetic = sleeve.influence.T @ sleeve.mass @ sleeve.influence
    np.testing.assert_allclose(kinetic, layer.mass_total * np.eye(3), atol=1e-9)
    energy = layer.expand.T @ sleeve.expand
    assert abs(energy.T @ layer.stiffness @ energy).max() < 1e-6 * abs(layer.stiffness).max()
    assert np.abs(sleeve.pressure_force).max() < 1e-9 * np.abs(layer.pressure_force).sum()


def test_an_absorber_added_to_the_matrices_splits_the_resonance(tmp_path: Path, monkeypatch) -> None:
    from wroll_fem import example_case
    from wroll_fem.analyses import run_analysis
    from wroll_fem.analyses.shared.preparation import prepare
    from wroll_fem.case import build_case
    from wroll_fem.dynamics.system.io import save_system
    from wroll_fem.progress import SilentProgress

    monkeypatch.chdir(tmp_path)
    system, state = prepare(example_case().changed("mesh.circumferential=8", "mesh.axial=2"), SilentProgress())
    save_system(system, "roll.npz", preload=state)
    exec(compile(blocks(BODY, "python")[1], "extend.md", "exec"), {})
    found = {}
    for name in ("roll", "roll_with_absorber"):
        case = {"analysis": "modal", "structure": {"file": f"{name}.npz"}, "modal": {"count": 4, "interface": "stuck"}}
        found[name] = run_analysis(build_case(case), progress=SilentProgress())["mode_frequency"].values
    alone, both = found["roll"][0], found["roll_with_absorber"][:2]
    assert both[0] < min(alone, 150.0) < max(alone, 150.0) < both[1]
