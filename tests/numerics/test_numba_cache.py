"""Compiled functions in numba's cache contain those of other modules; they must not outlive a change of these."""

from __future__ import annotations

import ast
from functools import lru_cache

import pytest
from support.paths import ROOT

PACKAGE = ROOT / "wroll_fem"


def compiled(tree: ast.Module) -> list[ast.FunctionDef]:
    """Functions of a module that numba compiles."""
    functions = (node for node in tree.body if isinstance(node, ast.FunctionDef))
    return [node for node in functions if any("njit" in ast.unparse(d) for d in node.decorator_list)]


@lru_cache
def tree_of(module: str) -> ast.Module | None:
    path = ROOT / (module.replace(".", "/") + ".py")
    return ast.parse(path.read_text(encoding="utf-8")) if path.is_file() else None


def inlined(tree: ast.Module | None) -> set[str]:
    """Modules of the package whose names the cached compiled functions of a module use."""
    if tree is None:
        return set()
    origin: dict[str, str] = {}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("wroll_fem"):
            origin |= {alias.asname or alias.name: str(node.module) for alias in node.names}
    cached = [f for f in compiled(tree) if any("cache=True" in ast.unparse(d) for d in f.decorator_list)]
    names = {part.id for function in cached for part in ast.walk(function) if isinstance(part, ast.Name)}
    return {origin[name] for name in names & origin.keys()}


def has_compiled_functions(module: str) -> bool:
    """Whether a module has functions that others can inline; `contact.laws` compiles those of the law files."""
    tree = tree_of(module)
    return tree is not None and "njit" in ast.unparse(tree)


def modules() -> list[str]:
    """Modules whose cached functions contain compiled functions of others."""
    files = (path for path in sorted(PACKAGE.rglob("*.py")) if "njit" in path.read_text(encoding="utf-8"))
    names = [path.relative_to(ROOT).with_suffix("").as_posix().replace("/", ".") for path in files]
    return [name for name in names if any(map(has_compiled_functions, inlined(tree_of(name))))]


@pytest.mark.parametrize("module", modules())
def test_a_module_drops_its_cache_when_code_that_it_inlines_is_newer(module: str) -> None:
    tree = tree_of(module)
    assert tree is not None
    calls = [node.value for node in tree.body if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)]
    dropping = [call for call in calls if ast.unparse(call.func) == "drop_stale_cache"]
    assert len(dropping) == 1
    assert ast.unparse(dropping[0].args[0]) == "__file__"
    first = min(function.lineno for function in compiled(tree))
    assert dropping[0].lineno < first


def test_the_compiled_equations_of_two_masses_contain_the_friction_law() -> None:
    assert "wroll_fem.contact.laws" in inlined(tree_of("wroll_fem.two_dof.time"))
    assert "wroll_fem.two_dof.time" in modules()
