"""Every command that README and docs show, run as it stands there or with what makes it small.

Commands stand in fenced shell blocks and in inline code. Each page's commands run in the order of the page, in a
scratch copy of the folders they read, so that `wroll report runs/loose` finds what the line above it made.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from support.here_pool import HerePool
from support.page_commands import PAGES, bare, commands, of_another_python, shown
from support.paths import ROOT
from support.small_tools import PRINTED, TOOLS
from typer.testing import CliRunner

from wroll_fem.cli import app
from wroll_fem.jobs import batch
from wroll_fem.results.summary import SUMMARY

_PLACEHOLDER = re.compile(r"\b(CASE|GRID|DIR|RUN_DIR|HOST|COMMAND|OUT|KIND|FILE)\b")

COARSE = ["mesh.circumferential=8", "mesh.axial=2", "mesh.grading=1", "output.figures=false"]
SHORT_CHIRP = [
    "excitation.f_start=120",
    "excitation.f_end=185",
    "excitation.rate_oct_per_min=120",
    "excitation.ramp_cycles=1",
]
SOLID = [
    "mesh.circumferential=8",
    "mesh.axial=3",
    "mesh.radial=1",
    "mesh.grading=1",
    "modal.count=4",
    "output.figures=false",
]

COUNTS = ("mesh.", "excitation.f_", "modal.count", "harmonic.", "integrator.steps_per_cycle", "solver.allow_coarse")

STUDY_MESHES = {"mesh.circumferential": [8, 12], "mesh.axial": [2, 4]}
"""Axes of studies over the mesh."""

WRAPS = "mesh={circumferential: 8, axial: 4, radial: 1}"
FLIGHT = [
    WRAPS, "preload.pressure=1.0e6", "harmonic.harmonics=1",
    "harmonic.reduction_tolerance=0.1", "excitation.amplitude_g=0.02",
]  # fmt: skip
"""At a level at which no coil opens."""

SMALLER: dict[str, list[str]] = {
    "case_study": [*SOLID, "winding.cells=600"],
    "coiled_stiff": SOLID,
    "coiled_stiff_mass": [*COARSE, "modal.count=4"],
    "design_map": ["design_map.mandrel_radius=[0.02, 0.03]", "design_map.mandrel_thickness=[0.002]", "mesh.axial=4"],
    "kapton_mandrel": [*COARSE, "modal.count=4"],
    "kapton_roll": SOLID,
    "lab_buckling": [*COARSE, "modal.count=2"],
    "lab_dwell": [*COARSE, "excitation.cycles=8"],
    "lab_dwell_layers": [*COARSE, "excitation.cycles=2", "excitation.ramp_cycles=1"],
    "lab_backbone": [*COARSE, "harmonic.harmonics=1", "harmonic.reduction_tolerance=0.1", "backbone.tip_largest=3e-5"],
    "lab_harmonic": [*COARSE, "harmonic.harmonics=1", "harmonic.reduction_tolerance=0.1"],
    "lab_integrators": [*COARSE, *SHORT_CHIRP],
    "lab_mandrel": [*COARSE, "modal.count=4"],
    "lab_modal": [*COARSE, "modal.count=4"],
    "lab_random_response": [
        *COARSE, "harmonic.harmonics=1", "harmonic.reduction_tolerance=0.1", "random_response.levels_db=[0]",
        "random_response.limits={}",
    ],
    "lab_shock": [*COARSE, "excitation.decay=0.05"],
    "lab_sweep": [*COARSE, *SHORT_CHIRP, "harmonic.harmonics=1", "harmonic.reduction_tolerance=0.1"],
    "lab_sweep_clamped": [*COARSE, *SHORT_CHIRP],
    "lab_sweep_rate": [*COARSE, *SHORT_CHIRP],
    "own_roll": [
        *COARSE, "coil.layers=1", "excitation.rate_oct_per_min=60", "excitation.ramp_cycles=1", "winding.cells=100",
        "harmonic.harmonics=1", "harmonic.reduction_tolerance=0.1", "backbone.tip_largest=2e-5",
    ],
    "sizing_habex": ["mesh.axial=40"],
    "sizing_irosa": ["mesh.axial=40"],
    "sizing_sspp": ["mesh.axial=40"],
    "habex_friction": FLIGHT,
    "irosa_friction": FLIGHT,
    "sspp_friction": FLIGHT,
    "structure": [*SHORT_CHIRP, "output.figures=false"],
    "tiny": [],
    "two_dof": ["two_dof.omega.points=60", "two_dof.friction_capacity=[5, 20]"],
    "two_dof_design_space": [
        "two_dof.friction_capacity=[5, 20]", "two_dof.omega.points=40", "two_dof.design_space.points=24",
        "two_dof.design_space.m2.points=2", "two_dof.design_space.k2.points=2",
    ],
    "winding_case_study": ["winding.cells=600"],
    "winding_lab": [],
    "winding_sweep": [*COARSE, *SHORT_CHIRP, "winding.cells=100"],
    "slipping_kapton": [WRAPS, "excitation.amplitude_g=[2]"], "slipping_flight": [WRAPS, "excitation.amplitude_g=[1]"],
    "slipping_harmonic": [WRAPS, "excitation.amplitude_g=3", "harmonic.harmonics=1"],
    "slipping_coil": [WRAPS, "excitation.amplitude_g=[5]"],
}  # fmt: skip
"""Case file -> what is changed in the scratch copy so that a run takes seconds: coarse mesh, short motion, few values.

The commands stay as they are printed. A grid keeps the middle and the end of its longest axis (the lowest preload
of a study may have no reading in so short a sweep), the end alone where it has three case files or more, the first
value of the others, and none of mesh, band and counts; its cases run in this process, one after the other.
"""

SLOW = tuple(
    f"docs/{name}.md"
    for name in (
        "architecture", "batch", "chapter4", "chapter6", "coil-slip", "coiled-stiff", "design-map", "excitations",
        "flight-scale", "geometric-stiffness", "install", "laboratory", "matrices", "own-roll", "random-response",
        "report", "sizing", "slipping-coil", "two-dof", "winding",
    )
)  # fmt: skip
"""Pages whose commands take 2 to 40 s. What they run has tests of its own in `make test`."""

ELSEWHERE = {
    "make test": "runs this test",
    "make test-all": "runs this test",
    "make test-random": "runs this test",
    "make run": "the job of `wroll run configs/lab_sweep.yaml`, here and in tests/test_runs.py on coarse meshes",
    "make lint": "run by .ci/run",
    "make docs": "tests/pages/test_docs.py builds the site",
    "make schema": "its two commands write what tests/case/test_case.py and tests/pages/test_docs.py compare",
    "make setup": "what every make target runs first",
    "make bench": "ten minutes; tests/tools/test_benchmark.py runs its parts",
    "make test-debian13": "these tests in a chroot",
    "wroll reproduce": "minutes to hours; tests/reproduction/test_claims.py runs it on coarse studies",
    "pip install": "changes the environment that runs the tests; tools/setup.sh does it in CI",
    "pip uninstall": "likewise",
    "apt install": "likewise",
    "dask scheduler": "tests/jobs/test_cluster.py starts one",
    "dask worker": "tests/jobs/test_cluster.py starts two",
    "jupyter lab": "a server; tests/pages/test_notebooks.py runs the notebooks",
    ".venv/bin/jupytext --sync": "tests/pages/test_notebooks.py compares the pairs",
    ".venv/bin/python -m pytest": "runs tests of this suite; a test below looks for them",
    ".venv/bin/python -m tools.shaker_table": "tests/tools/test_shaker_table.py runs it on made-up readings",
    ".venv/bin/python -m tools.flight_table": "tests/tools/test_flight_table.py runs it on coarse results",
    ".venv/bin/python benchmarks/shock_spectra.py": "tests/tools/test_shock_spectra.py runs it without pyyeti",
    ".venv/bin/python benchmarks/flight_meshes.py --page": "tests/tools/test_flight_meshes.py makes the page",
    ".venv/bin/python benchmarks/random_rolls.py --page": "tests/tools/test_random_rolls.py makes the page",
    ".venv/bin/python tools/notebook_pages.py": "executes the notebooks, as tests/pages/test_notebooks.py does",
}
"""Commands that cannot run inside a test, by their beginning, and who runs them."""

MODULES = {"python -m wroll_fem.cli"}
"""Modules that a page names as what they are, in any environment."""


def elsewhere(command: str) -> bool:
    return any(bare(command) == known or bare(command).startswith(f"{known} ") for known in ELSEWHERE)


def mention(command: str) -> bool:
    """Whether a command is only named: `wroll run`, `wroll batch GRID.yaml`, `wroll batch --workers`, `wroll lab X`."""
    words = command.split()
    if words[1:2] == ["lab"] and len(words) == 3:
        return words[0] in ("wroll", ".venv/bin/wroll")
    if words[1:] in (["info"], ["schema"]):
        return False
    return words[0] in ("wroll", ".venv/bin/wroll") and (
        len(words) == 1 or all(_PLACEHOLDER.search(word) or word.startswith("--") for word in words[2:])
    )


def tool(command: str) -> bool:
    return re.match(r"\.venv/bin/python (-m )?(tools|benchmarks)[/.]", command) is not None


def runnable(page: Path) -> list[str]:
    return [line for line in commands(page) if not elsewhere(line) and not mention(line) and not tool(line)]


def words_of(command: str) -> list[str]:
    words = shlex.split(command)
    return ["wroll", *words[1:]] if words[0] == ".venv/bin/wroll" else words


# --- what is named exists ---------------------------------------------------------------------------------------------


def every(kind: str) -> list[str]:
    return sorted({line for page in PAGES for line in commands(page) if line.split()[0].endswith(kind)})


def test_every_make_target_that_is_named_exists() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for command in every("make"):
        assert re.search(rf"^{command.split()[1]}:", makefile, flags=re.MULTILINE), command


@pytest.mark.parametrize("command", [line for line in every("wroll") if mention(line) and len(line.split()) > 1])
def test_every_command_that_is_only_named_has_its_options(command: str) -> None:
    words = command.split()
    done = CliRunner().invoke(app, [words[1], "--help"], terminal_width=200)
    assert done.exit_code == 0, done.output
    for option in (word for word in words[2:] if word.startswith("--")):
        assert option in done.output, command


def test_every_file_in_a_command_exists() -> None:
    for page in PAGES:
        for command in commands(page):
            for word in command.split():
                if re.match(r"(configs|tools|tests|meshes|notebooks|benchmarks)/\S+\.\w+$", word):
                    assert any(ROOT.glob(word)) or command.startswith("cp "), f"{page.name}: {command}"


def test_no_page_shows_a_command_of_another_python() -> None:
    """Written as `.venv/bin/python ...`, so that `commands` finds it."""
    found = {line for page in [*PAGES, *(ROOT / "docs").rglob("*.md")] for line, _ in shown(page)}
    assert {line for line in found if of_another_python(line)} == MODULES


@pytest.mark.parametrize("module", sorted(MODULES))
def test_a_module_that_a_page_names_is_the_command(module: str) -> None:
    done = subprocess.run([sys.executable, *module.split()[1:], "--help"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "Usage" in done.stdout
    assert "validate" in done.stdout


COLLECT = """import contextlib, io, json, sys, pytest
for words in json.loads(sys.argv[1]):
    with contextlib.redirect_stdout(io.StringIO()) as out:
        code = pytest.main([*words, "--collect-only"])
    print(json.dumps([int(code), out.getvalue()[-2000:]]))
"""
"""Collects the tests of several commands in one process, which imports them once."""


def test_the_tests_that_the_commands_name_are_found() -> None:
    named = [line for line in every("") if " -m pytest " in line]
    assert len(named) > 5
    words = [shlex.split(bare(line).replace("tests/ROOM", "tests/contact"))[3:] for line in named]
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}  # a plugin may change the assertions
    done = subprocess.run(
        [sys.executable, "-c", COLLECT, json.dumps(words)], cwd=ROOT, env=environment, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(found) == len(named), done.stdout[-2000:] + done.stderr[-2000:]
    for command, (code, text) in zip(named, found, strict=True):
        assert code == 0, f"{command}: {text}"
        assert re.search(r"[1-9]\d*(/\d+)? tests collected", text), f"{command}: {text}"


# --- what is shown runs -----------------------------------------------------------------------------------------------


def scratch(folder: Path) -> None:
    """Copies of what commands read, made small by `SMALLER` and `TOOLS`."""
    for name in ("configs", "meshes", "tools", "benchmarks"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("tables", "figures"):
        (folder / "docs" / name).mkdir(parents=True)
    shutil.copy(ROOT / "Makefile", folder)
    (folder / ".venv").symlink_to(ROOT / ".venv")
    shutil.copy(folder / "configs" / "oscillator.yaml", folder / "structure.yaml")  # the page's own file of matrices
    for name, changes in SMALLER.items():
        path = folder / (f"{name}.yaml" if name == "structure" else f"configs/{name}.yaml")
        case = override(yaml.safe_load(path.read_text(encoding="utf-8")), changes)
        if name == "structure":
            case["structure"] = {"file": "roll.npz"}
            case.pop("contact", None)
        path.write_text(yaml.safe_dump(case), encoding="utf-8")
    for path in (folder / "configs" / "studies").glob("*.yaml"):
        grid = yaml.safe_load(path.read_text(encoding="utf-8"))
        axes = {key: axis for key, axis in grid["grid"].items() if not key.startswith(COUNTS)}
        meshes = {key: values for key, values in STUDY_MESHES.items() if len(grid["grid"].get(key, [])) > 1}
        longest = max(axes, key=lambda key: len(axes[key]), default="")
        for key in axes:
            if key != "analysis":
                middle = axes[key][(len(axes[key]) - 1) // 2]
                two = key == longest and len(axes[key]) > 1 and len(grid.get("cases", [])) < 3
                axes[key] = [middle, axes[key][-1]] if two else axes[key][-1:] if key == longest else axes[key][:1]
        grid["grid"] = axes | meshes
        path.write_text(yaml.safe_dump(grid), encoding="utf-8")
    for name, replaced in TOOLS.items():
        text = (folder / name).read_text(encoding="utf-8")
        for old, new in replaced:
            assert old in text, f"{name}: {old}"
            text = text.replace(old, new)
        (folder / name).write_text(text, encoding="utf-8")


def override(case: dict, changes: list[str]) -> dict:
    for change in changes:
        key, _, value = change.partition("=")
        *path, last = key.split(".")
        section = case
        for part in path:
            section = section.setdefault(part, {})
        section[last] = yaml.safe_load(value)
    return case


def cases_of(words: list[str]) -> list[str]:
    """Names of the case files that a `wroll` command computes."""
    if words[1] == "batch":
        grid = yaml.safe_load(Path(words[2]).read_text(encoding="utf-8"))
        files = [*grid.get("cases", []), *(grid[key] for key in ("base", "reference") if key in grid)]
        return [Path(file).stem for file in files]
    return [Path(words[2]).stem] if words[1] in ("run", "export", "mesh") else []


def run(command: str, folder: Path) -> str:
    """What a command prints."""
    words = words_of(command)
    if words[0] != "wroll":
        path = f"{ROOT / '.venv' / 'bin'}{os.pathsep}{os.environ['PATH']}"
        environment = os.environ | {"PATH": path, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
        if words[0] == ".venv/bin/python":
            words[0] = sys.executable
        done = subprocess.run(
            words, cwd=folder, env=environment, capture_output=True, text=True, timeout=600, check=False
        )
        assert done.returncode == 0, f"{command}\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
        return done.stdout
    for name in cases_of(words):
        assert name in SMALLER, f"{command}: say in SMALLER what makes {name}.yaml quick"
    answer = CliRunner().invoke(app, words[1:])
    assert answer.exit_code == 0, f"{command}\n{answer.output}{answer.exception!r}"
    return answer.output


def pages() -> list:
    """Pages with a command that no page before them has; the longest is marked slow."""
    seen: set[tuple[str, ...]] = set()
    found = []
    for page in PAGES:
        own = {tuple(words_of(command)) for command in runnable(page)}
        if own - seen:
            name = str(page.relative_to(ROOT))
            found.append(pytest.param(page, id=name, marks=[pytest.mark.slow] if name in SLOW else []))
        seen |= own
    return found


@pytest.mark.parametrize("page", pages())
def test_the_commands_of_a_page_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scratch(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(batch, "LocalPool", HerePool)
    for command in runnable(page):
        run(command, tmp_path)
    for summary in tmp_path.glob("runs/**/summary.json"):
        unknown = set(json.loads(summary.read_text(encoding="utf-8"))) - set(SUMMARY)
        assert not unknown, f"{summary.parent.name}: not in wroll_fem/results/summary.py: {sorted(unknown)}"


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    sorted({line for page in PAGES for line in commands(page) if tool(line) and not elsewhere(line)}),
    ids=str,
)
def test_the_tools_that_make_tables_and_figures_run(command: str, tmp_path: Path) -> None:
    scratch(tmp_path)
    printed = run(command, tmp_path)
    own = [known for known in PRINTED if f"{command} ".startswith(f".venv/bin/python {known} ")]
    if own:
        row = re.escape(PRINTED[max(own, key=len)]).replace(r"\#", r"[+-]?\d+(\.\d*)?(e[+-]\d+)?")
        assert re.search(f"^{row}$", printed, flags=re.MULTILINE), printed
        return
    made = [*tmp_path.glob("docs/tables/*.md"), *tmp_path.glob("docs/figures/*.png"), *tmp_path.glob("FILE")]
    assert made
    for path in made:
        assert path.stat().st_size, path.name
        if path.suffix == ".md":
            assert re.search(r"^\|.*\d.*\|$", path.read_text(encoding="utf-8"), flags=re.MULTILINE), path.name
