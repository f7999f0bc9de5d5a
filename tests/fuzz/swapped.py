"""Mutants without new imports: one session of pytest collects the tests, and forks a child for every mutant.

The child replaces the code of the changed function wherever it is held, and runs the chosen tests. This takes a tenth
of the time of a new process. It serves mutants inside a function that is not compiled; the others change a file.
"""

from __future__ import annotations

import gc
import importlib
import os
import resource
import time
import traceback
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import pytest

from tests.fuzz.mutations import Mutant, functions_at

Key = tuple[str, str, int]
NOT_SWAPPED = 97
"""Exit code of a child that found no function with the changed code."""


def codes(code: CodeType) -> Iterator[CodeType]:
    """Code objects inside of a code object."""
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield constant
            yield from codes(constant)


def is_swappable(mutant: Mutant, root: Path) -> bool:
    """Whether the change lies in the body of a function that is not compiled, nor inlined by numba (friction laws)."""
    path = root / mutant.file
    around = functions_at(path, mutant.line)
    if not around or any(compiled for _, compiled in around):
        return False
    if path.parent.name == "contact" and "." not in around[-1][0]:
        return False
    before, after = (compile(c, "x", "exec") for c in (path.read_bytes(), mutant.applied(path.read_bytes())))
    return [c.co_qualname for c in codes(before)] == [c.co_qualname for c in codes(after)] and (
        _outside(before) == _outside(after)
    )


def _outside(code: CodeType) -> Any:
    """What a module or class does itself, without the code of its functions: defaults, constants, decorators."""
    inner = [c for c in code.co_consts if isinstance(c, CodeType)]
    parts = [_outside(c) for c in inner if not c.co_flags & 2]  # 2: optimised locals, which functions have
    return code.co_code, [c for c in code.co_consts if not isinstance(c, CodeType)], code.co_names, parts


class Server:
    """Plugin of pytest: in place of the loop over the tests it calls ``work(run)``; ``files`` will be changed."""

    def __init__(
        self, root: Path, files: Iterable[str], work: Callable[[Callable[..., tuple[int, str, int, float]]], None]
    ):
        self.root, self.files, self.work = root, sorted(set(files)), work
        self.failed = ""
        self.functions: dict[Key, list[FunctionType]] = defaultdict(list)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        self.items = {item.nodeid: item for item in session.items}
        package = str(self.root / "wroll_fem") + os.sep
        for file in self.files:  # many modules are imported on first use
            importlib.import_module(file.removesuffix(".py").replace("/", "."))
        gc.unfreeze()  # conftest.py has frozen all objects; `get_objects` leaves them out
        gc.collect()
        for found in gc.get_objects():
            if type(found) is FunctionType and found.__code__.co_filename.startswith(package):
                code = found.__code__
                self.functions[code.co_filename, code.co_qualname, code.co_firstlineno].append(found)
        gc.freeze()
        self.work(self.run)
        return True

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed = self.failed or report.nodeid

    def run(self, mutant: Mutant, tests: list[str], budget: float, per_test: float) -> tuple[int, str, int, float]:
        """Exit code (0 survived, 1 killed, 98 budget spent), name of the failed test, tests run, CPU seconds."""
        source, sink = os.pipe()
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        child = os.fork()
        if not child:
            os.close(source)
            errors = os.dup(2)
            try:
                code = self._child(mutant, tests, budget, per_test, sink)
            except BaseException:
                os.write(errors, traceback.format_exc().encode())
                code = NOT_SWAPPED
            os._exit(code)
        os.close(sink)
        with os.fdopen(source, errors="replace") as stream:
            lines = stream.read().splitlines()
        _, status = os.waitpid(child, 0)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime
        return os.waitstatus_to_exitcode(status), lines[-1] if lines else "", len(lines), round(cpu, 2)

    def _child(self, mutant: Mutant, tests: list[str], budget: float, per_test: float, sink: int) -> int:
        null = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(null, stream)
        self.swap(mutant)
        start = time.process_time()
        chosen = [self.items[name] for name in tests if name in self.items]
        for item, following in zip(chosen, [*chosen[1:], None], strict=True):
            os.write(sink, f"{item.nodeid}\n".encode())
            now = time.process_time()
            if now - start > budget:
                return 98
            resource.setrlimit(resource.RLIMIT_CPU, (int(now + per_test) + 1, resource.RLIM_INFINITY))
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            if self.failed:
                return 1
        return 0

    def swap(self, mutant: Mutant) -> None:
        """Give the functions of the changed file their new code; at least one of them changes."""
        changed = 0
        path = self.root / mutant.file
        new = compile(mutant.applied(path.read_bytes()), str(path), "exec", dont_inherit=True)
        for code in codes(new):
            for function in self.functions.get((str(path), code.co_qualname, code.co_firstlineno), ()):
                if function.__code__.co_freevars == code.co_freevars:
                    changed += function.__code__ != code
                    function.__code__ = code
        if not changed:
            os._exit(NOT_SWAPPED)
