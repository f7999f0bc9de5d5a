"""Mutants of a module: small changes of its syntax tree, written back as text so that all other lines stay."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

COMPARISONS: dict[type, tuple[type, ...]] = {
    ast.Lt: (ast.LtE, ast.Gt), ast.LtE: (ast.Lt, ast.GtE), ast.Gt: (ast.GtE, ast.Lt), ast.GtE: (ast.Gt, ast.LtE),
    ast.Eq: (ast.NotEq,), ast.NotEq: (ast.Eq,), ast.Is: (ast.IsNot,), ast.IsNot: (ast.Is,), ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}  # fmt: skip
ARITHMETIC: dict[type, tuple[type, ...]] = {
    ast.Add: (ast.Sub,), ast.Sub: (ast.Add,), ast.Mult: (ast.Div,), ast.Div: (ast.Mult,), ast.Pow: (ast.Mult,),
    ast.FloorDiv: (ast.Div,), ast.Mod: (ast.Mult,), ast.BitAnd: (ast.BitOr,), ast.BitOr: (ast.BitAnd,),
}  # fmt: skip
SKIPPED = ("__repr__", "__str__")


@dataclass(frozen=True)
class Mutant:
    """A change of a file: the bytes from ``start`` to ``end`` become ``text``."""

    file: str
    line: int
    kind: str
    start: int
    end: int
    before: str
    text: str

    @property
    def name(self) -> str:
        """Name of the mutant in messages."""
        return f"{self.file}:{self.line} {self.before} -> {self.text}".replace("\n", " ")

    def applied(self, content: bytes) -> bytes:
        """Content of the file with the change."""
        return content[: self.start] + self.text.encode() + content[self.end :]


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or isinstance(getattr(node, "value", None), str)


def _is_removable(node: ast.stmt) -> bool:
    if isinstance(node, ast.Expr):
        return not isinstance(node.value, ast.Constant | ast.Yield | ast.YieldFrom)
    if isinstance(node, ast.Assign):
        return isinstance(node.targets[0], ast.Subscript | ast.Attribute)
    return isinstance(node, ast.Raise | ast.Break | ast.Continue)


class _Finder:
    """Mutants of one file."""

    def __init__(self, file: str, content: bytes):
        self.file, self.content = file, content
        self.starts = [0]
        for line in content.splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))

    def _span(self, node: ast.AST) -> tuple[int, int]:
        return (
            self.starts[node.lineno - 1] + node.col_offset,  # type: ignore[attr-defined]
            self.starts[node.end_lineno - 1] + node.end_col_offset,  # type: ignore[attr-defined]
        )

    def _mutant(self, node: ast.AST, kind: str, text: str) -> Mutant:
        start, end = self._span(node)
        before = self.content[start:end].decode()
        return Mutant(self.file, node.lineno, kind, start, end, before, text)  # type: ignore[attr-defined]

    def _replaced(self, node: ast.expr, kind: str, new: ast.expr) -> Mutant:
        return self._mutant(node, kind, f"({ast.unparse(new)})")

    def expression(self, node: ast.expr) -> Iterator[Mutant]:
        """Mutants of an expression itself, without its parts."""
        if isinstance(node, ast.Compare):
            for i, operator in enumerate(node.ops):
                for new in COMPARISONS[type(operator)]:
                    ops = [*node.ops[:i], new(), *node.ops[i + 1 :]]
                    yield self._replaced(node, "comparison", ast.Compare(node.left, ops, node.comparators))
        elif isinstance(node, ast.BinOp) and not _is_text(node.left):
            for new in ARITHMETIC.get(type(node.op), ()):
                yield self._replaced(node, "arithmetic", ast.BinOp(node.left, new(), node.right))
        elif isinstance(node, ast.BoolOp):
            other = ast.And() if isinstance(node.op, ast.Or) else ast.Or()
            yield self._replaced(node, "boolean", ast.BoolOp(other, node.values))
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
            yield self._replaced(node, "negation", node.operand)
        elif isinstance(node, ast.Constant):
            yield from self._constant(node)
        elif isinstance(node, ast.IfExp):
            yield self._replaced(node, "condition", ast.IfExp(node.test, node.orelse, node.body))

    def _constant(self, node: ast.Constant) -> Iterator[Mutant]:
        value = node.value
        if isinstance(value, bool):
            yield self._mutant(node, "constant", str(not value))
        elif isinstance(value, int):
            yield self._mutant(node, "constant", str(value + 1))
            yield self._mutant(node, "constant", f"({value - 1})")
        elif isinstance(value, float):
            yield self._mutant(node, "constant", repr(2.0 * value) if value else "1.0")

    def statement(self, node: ast.stmt, compiled: bool) -> Iterator[Mutant]:
        """Mutants of a statement itself, without its parts."""
        if isinstance(node, ast.If | ast.While) and not isinstance(node.test, ast.Compare):
            yield self._replaced(node.test, "condition", ast.UnaryOp(ast.Not(), node.test))
        elif isinstance(node, ast.AugAssign):
            yield self._mutant(node, "removed", "pass")
            for new in ARITHMETIC.get(type(node.op), ()):
                yield self._mutant(node, "arithmetic", ast.unparse(ast.AugAssign(node.target, new(), node.value)))
        elif _is_removable(node):
            yield self._mutant(node, "removed", "pass")
        elif isinstance(node, ast.Return) and not compiled and getattr(node.value, "value", node.value) is not None:
            yield self._mutant(node, "returned", "return None")

    def walk(self, node: ast.AST, compiled: bool = False) -> Iterator[Mutant]:
        """Mutants of all parts of a node."""
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            if node.name in SKIPPED:
                return
            compiled = any("njit" in ast.unparse(d) for d in node.decorator_list)
            if isinstance(node, ast.FunctionDef):
                for default in (*node.args.defaults, *(d for d in node.args.kw_defaults if d is not None)):
                    yield from self._parts(default, compiled)
            for child in node.body:
                yield from self.walk(child, compiled)
            return
        if isinstance(node, ast.Import | ast.ImportFrom | ast.JoinedStr | ast.Assert):
            return
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            return
        if isinstance(node, ast.Raise):  # the words of an error are no behaviour
            yield from self.statement(node, compiled)
            return
        yield from self._parts(node, compiled)

    def _parts(self, node: ast.AST, compiled: bool) -> Iterator[Mutant]:
        if isinstance(node, ast.stmt):
            yield from self.statement(node, compiled)
        elif isinstance(node, ast.expr):
            yield from self.expression(node)
        for name, value in ast.iter_fields(node):
            if name in ("annotation", "returns", "decorator_list"):
                continue
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    yield from self.walk(child, compiled)


@lru_cache(maxsize=512)
def mutants_of(path: Path, root: Path) -> list[Mutant]:
    """All mutants of a file, in the order of the file."""
    content = path.read_bytes()
    return list(_Finder(path.relative_to(root).as_posix(), content).walk(ast.parse(content)))


def parses(mutant: Mutant, root: Path) -> bool:
    """Whether the changed file is Python."""
    try:
        ast.parse(mutant.applied((root / mutant.file).read_bytes()))
    except SyntaxError:
        return False
    return True


@lru_cache(maxsize=256)
def functions(path: Path) -> list[tuple[str, int, int, bool]]:
    """All functions of a file: qualified name, first line of the definition, last line, and whether compiled."""
    found: list[tuple[str, int, int, bool]] = []

    def visit(node: ast.AST, outer: str) -> None:
        for child in ast.iter_child_nodes(node):
            inside = outer
            if isinstance(child, ast.ClassDef):
                inside = f"{outer}{child.name}."
            elif isinstance(child, ast.FunctionDef):
                compiled = any("njit" in ast.unparse(d) for d in child.decorator_list)
                found.append((outer + child.name, child.lineno, child.end_lineno or child.lineno, compiled))
                inside = f"{outer}{child.name}.<locals>."
            visit(child, inside)

    visit(ast.parse(path.read_bytes()), "")
    return found


def functions_at(path: Path, line: int) -> list[tuple[str, bool]]:
    """Functions around a line, innermost first: qualified name, and whether compiled."""
    around = [(first, name, compiled) for name, first, last, compiled in functions(path) if first <= line <= last]
    return [(name, compiled) for _, name, compiled in sorted(around, reverse=True)]
