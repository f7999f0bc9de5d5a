"""Pages say what the code does: references made from it, messages that exist, examples that run."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from pydantic import BaseModel
from support.paths import ROOT

from tools.reference import PAGES
from tools.reference.analyses import with_table
from tools.reference.case import type_name
from tools.reference.files import with_list
from wroll_fem.analyses.registry import find_analysis
from wroll_fem.case import ANALYSES, build_case, load_case
from wroll_fem.case.case import case_kinds
from wroll_fem.case.descriptions import sections, unit_of
from wroll_fem.errors import InputError
from wroll_fem.results.summary import GROUPS, SUMMARY

DOCS = ROOT / "docs"


@pytest.mark.parametrize("name", PAGES)
def test_the_reference_pages_are_those_of_the_code(name: str) -> None:
    written = (DOCS / "reference" / name).read_text(encoding="utf-8")
    assert written == PAGES[name](), f"docs/reference/{name} is behind the code: make schema, and commit it"


def test_the_table_of_analyses_is_that_of_the_registry() -> None:
    page = (DOCS / "api.md").read_text(encoding="utf-8")
    assert page == with_table(page), "docs/api.md is behind the code: make schema, and commit it"


def test_the_list_of_files_is_that_of_the_package() -> None:
    page = (DOCS / "architecture.md").read_text(encoding="utf-8")
    assert page == with_list(page), "docs/architecture.md is behind the code: make schema, and commit it"


def models(model: type[BaseModel], path: str = "") -> Iterator[tuple[str, type[BaseModel]]]:
    yield path, model
    for name, field in model.model_fields.items():
        for inner in sections(field.annotation):
            yield from models(inner, f"{path}.{name}".strip("."))


def test_every_key_is_described_and_every_number_has_a_unit() -> None:
    page = (DOCS / "reference" / "case.md").read_text(encoding="utf-8")
    kinds = [pair for kind in case_kinds().values() for pair in models(kind)]
    for path, model in kinds:
        for name, field in model.model_fields.items():
            where = f"{path}.{name}"
            assert field.description, where
            assert f"| `{name}` |" in page or f"[`{name}`]" in page, where
            kind = type_name(field.annotation)
            if "number" in kind:
                assert unit_of(field.description) or "as the enclosing key" in field.description, (
                    f"{where}: name the unit in its description, as tools/reference/case.py spells units"
                )


EXAMPLES = {
    "sweep": "lab_sweep", "dwell": "lab_dwell", "harmonic": "lab_harmonic", "backbone": "lab_backbone",
    "shock": "lab_shock", "random": "lab_random",
    "modal": "lab_modal", "modal_transient": "case_study", "winding": "winding_case_study",
    "design_map": "design_map",
    "two_dof": "two_dof", "preload": "lab_dwell", "buckling": "lab_buckling",
    "sizing": "sizing_irosa", "slip_damping": "slipping_coil",
    "random_response": "lab_random_response",
}  # fmt: skip


@pytest.mark.parametrize("analysis", ANALYSES)
def test_an_analysis_needs_the_sections_that_the_reference_names(analysis: str) -> None:
    data = yaml.safe_load((ROOT / "configs" / f"{EXAMPLES[analysis]}.yaml").read_text(encoding="utf-8"))
    data["analysis"] = analysis
    build_case(data)
    needed = set()
    for key in set(data) - {"analysis"}:
        try:
            build_case({name: value for name, value in data.items() if name != key})
        except InputError:
            needed.add(key)
    assert needed == set(find_analysis(analysis).sections)


def test_every_name_of_the_summary_is_in_one_group() -> None:
    names = [name for group in GROUPS.values() for name in group]
    assert len(names) == len(set(names)) == len(SUMMARY)


# --- pages ------------------------------------------------------------------------------------------------------------


def source_texts() -> str:
    """All string constants of the package, f-strings with "..." for what varies, one per line."""
    found = []
    for path in (ROOT / "wroll_fem").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.JoinedStr):
                found.append("".join(p.value if isinstance(p, ast.Constant) else "..." for p in node.values))
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                found.append(node.value)
    return "\n".join(" ".join(text.split()) for text in found) + (ROOT / "tools" / "setup.sh").read_text()


def test_troubleshooting_quotes_messages_of_the_program() -> None:
    texts = source_texts()
    page = (DOCS / "troubleshooting.md").read_text(encoding="utf-8")
    quoted = [
        span
        for line in page.splitlines()
        if line.startswith("| `")
        for span in re.findall(r"`([^`]+)`", line.split("|")[1])
    ]
    assert len(quoted) > 40
    for message in quoted:
        for part in message.split("..."):
            if " " in part.strip() and not part.startswith("wroll "):
                assert part.strip(" ,?") in texts, f"no message says {part.strip()!r} any more"


def test_every_page_is_in_the_index() -> None:
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    listed = re.findall(r"```\{toctree\}.*?```", index, flags=re.DOTALL)
    names = {line.strip() for block in listed for line in block.splitlines()}
    for page in DOCS.glob("*.md"):
        assert page.stem in names | {"index"}, f"name {page.stem} in a toctree of docs/index.md"


def test_equations_are_numbered_once_and_references_find_them() -> None:
    texts = [page.read_text(encoding="utf-8") for page in DOCS.glob("*.md")]
    labels = [label for text in texts for label in re.findall(r"^\s*\$\$ \((eq-[\w-]+)\)$", text, flags=re.MULTILINE)]
    assert len(labels) == len(set(labels)) > 40
    used = {label for text in texts for label in re.findall(r"\{eq\}`([\w-]+)`", text)}
    assert used <= set(labels), used - set(labels)


def names_of_python(page: str) -> list[dict[str, Any]]:
    """Names that each Python block of a page leaves."""
    found = []
    for block in re.findall(r"^```python\n(.*?)^```", (DOCS / page).read_text("utf-8"), flags=re.DOTALL | re.MULTILINE):
        names: dict[str, Any] = {}
        exec(compile(block, page, "exec"), names)
        found.append(names)
    return found


PYTHON_OF_PAGES: dict[str, Callable[..., bool]] = {
    "install.md": lambda run: run["result"]["friction_energy"][-1] > 1e-3,  # J
    "laboratory.md": lambda slip, fit: (
        float(slip["slip"].where(slip["slip"]["slip_relative_to"] == 0).max()) > 1.9e-5
        and fit["result"].summary["parameters"]["elastic_slip_m"] < 1e-5
    ),
    "damping-estimators.md": lambda choice: abs(choice["found"].zeta / 0.4 - 1.0) < 0.05,
    "bench-tests.md": lambda stack, rates: (
        abs(stack["data"].attrs["shear_capacity_n"] / stack["test"].capacity - 1.0) < 1e-6
        and abs(rates["data"]["friction_coefficient"][-1] - rates["law"].steady_coefficient(1e-5)) < 1e-6
    ),
}
"""Page -> what holds for the names that its blocks leave, one argument each."""


@pytest.mark.filterwarnings("ignore:the mesh does not resolve")  # the example is coarse, and says so
@pytest.mark.parametrize(
    "page", [pytest.param(p, marks=pytest.mark.slow if p == "laboratory.md" else []) for p in PYTHON_OF_PAGES]
)
def test_the_python_of_a_page_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert PYTHON_OF_PAGES[page](*names_of_python(page))


PLAIN = """
import sys
from sphinx.builders.html import StandaloneHTMLBuilder
from sphinx.cmd.build import main
StandaloneHTMLBuilder.search = False
sys.exit(main(sys.argv[1:]))
"""
"""Sphinx without the index of the search, which no page needs."""


@pytest.mark.slow
def test_the_site_builds_without_warnings(tmp_path: Path) -> None:
    """In a theme without the tree of all pages beside every page, a third of the time; `make docs` builds that."""
    pytest.importorskip("myst_parser")
    words = ["-E", "-q", "-W", "--keep-going", "-b", "html", "-D", "html_theme=basic", "-d", tmp_path / "trees"]
    command = [sys.executable, "-c", PLAIN, *map(str, words), str(DOCS), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-4000:]
    page = (tmp_path / "theory.html").read_text(encoding="utf-8")
    assert page.count('class="eqno"') > 20
    assert "undefined" not in page.lower().split('role="main">', 1)[1].split('<div class="clearer">', 1)[0]


TEXTS = [ROOT / name for name in ("README.md", "CONTRIBUTING.md")] + sorted(DOCS.rglob("*.md"))
CODE = re.compile(r"\b(?:wroll_fem|reproduction|tools|tests|benchmarks)/[\w/]*\w+\.(?:py|sh|yaml|md)\b")


def test_every_file_of_code_that_a_page_names_exists() -> None:
    made_by_recipes = {
        "wroll_fem/contact/dahl.py", "wroll_fem/signals/burst.py", "wroll_fem/analyses/tip_stiffness.py",
    }  # fmt: skip
    found = {(page.name, path) for page in TEXTS for path in CODE.findall(page.read_text(encoding="utf-8"))}
    assert len(found) > 80
    assert [item for item in sorted(found) if item[1] not in made_by_recipes and not (ROOT / item[1]).exists()] == []


def test_no_page_names_a_module_without_its_room() -> None:
    names = {path.name for path in (ROOT / "wroll_fem").rglob("*.py")}
    bare = [
        f"{page.name}: {name}"
        for page in TEXTS
        for name in re.findall(r"(?<![\w/.])(\w+\.py)\b", page.read_text(encoding="utf-8"))
        if name in names or (page.parent == DOCS and not list(ROOT.glob(f"*/{name}")))
    ]
    assert bare == []


def rows_of(heading: str) -> list[list[str]]:
    """Rows of the table under a heading of docs/architecture.md."""
    text = (DOCS / "architecture.md").read_text(encoding="utf-8").split(f"\n## {heading}\n")[1].split("\n## ")[0]
    rows = [line.strip("|").split("|") for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in row] for row in rows[2:]]


def test_names_of_the_glossary_stand_in_the_files_it_names() -> None:
    rows = rows_of("Glossary")
    assert len(rows) >= 40
    missing = []
    for term, ours, _, files in rows:
        text = "".join((ROOT / file).read_text(encoding="utf-8") for file in re.findall(r"`([^`]+)`", files))
        assert text, term
        missing += [f"{term}: {name}" for name in re.findall(r"`(\w+)`", ours) if not re.search(rf"\b{name}\b", text)]
    assert missing == []


def test_the_architecture_page_has_a_row_for_each_usual_change() -> None:
    assert len(rows_of("Where do I put ...")) >= 30


def test_the_layers_on_the_page_and_in_the_picture_are_those_of_the_test() -> None:
    from test_layers import LAYERS

    from tools.sketches import ROOMS

    page = (DOCS / "architecture.md").read_text(encoding="utf-8").split("```text\n")[1].split("```")[0]
    assert [tuple(layer.strip() for layer in row.split(",")) for row in page.replace("\n", " ").split("<")] == list(
        LAYERS
    )
    assert [rooms for rooms, *_ in ROOMS] == list(LAYERS)


def test_case_files_shown_on_pages_are_valid() -> None:
    """Blocks that are whole cases (they begin with `analysis:`)."""
    count = 0
    for page in DOCS.glob("*.md"):
        for block in re.findall(
            r"^```yaml\n(analysis:.*?)^```", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.M
        ):
            build_case(yaml.safe_load(block))
            count += 1
    assert count > 0
    assert load_case(ROOT / "configs" / "tiny.yaml").analysis in ANALYSES
