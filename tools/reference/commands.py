"""Reference of the command `wroll` from its typer application."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, get_args, get_type_hints

import typer

from tools.reference.markdown import GENERATED, code, prose, table

_INTRO = """# Commands

`wroll` is installed in `.venv/bin`; the pages write `.venv/bin/wroll`, or `wroll` for short (after `source
.venv/bin/activate`). `wroll COMMAND --help` prints the same information.
"""

_CODES = """## Exit codes

| code | meaning |
|---|---|
| 0 | done |
| 1 | `wroll info`: a required library does not work |
| 2 | the input is wrong: one line with file, key, problem and remedy; nothing was computed |
| 3 | the solver did not converge: time, iterations, residuals and remedy; results up to that point are saved |
| 130 | interrupted; a sweep or dwell continues with `--resume`, a batch with the same command |
"""


def commands_page() -> str:
    """Markdown of all commands with their arguments and options."""
    from wroll_fem.cli import app

    root: Any = typer.main.get_command(app)
    commands, hints = _commands(root), _hints(app)
    parts = [GENERATED, _INTRO, table(("command", "does"), _overview(commands))]
    for name, command in commands.items():
        words = " ".join((command.help or "").split())
        usage = " ".join([f"wroll {name}", *(_metavar(p) for p in command.params if p.param_type_name == "argument")])
        options = any(p.param_type_name == "option" and p.name != "help" for p in command.params)
        parts += [f"## wroll {name}", prose(words), code(usage + (" [OPTIONS]" if options else ""))]
        rows = list(_rows(command, hints[name]))
        if rows:
            parts.append(table(("argument or option", "meaning", "default"), rows))
    parts.append(_CODES)
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _commands(group: Any, before: str = "") -> dict[str, Any]:
    """Commands by name; those of a group in its place, such as "lab transmissibility"."""
    found: dict[str, Any] = {}
    for name, command in group.commands.items():
        inner = getattr(command, "commands", None)
        found |= {f"{before}{name}": command} if inner is None else _commands(command, f"{before}{name} ")
    return found


def _hints(app: typer.Typer, before: str = "") -> dict[str, dict[str, Any]]:
    """Types of the parameters of each command."""
    found = {
        f"{before}{c.name or c.callback.__name__}": get_type_hints(c.callback)
        for c in app.registered_commands if c.callback
    }  # fmt: skip
    for group in app.registered_groups:
        if group.typer_instance is not None:
            found |= _hints(group.typer_instance, f"{before}{group.name} ")
    return found


def _overview(commands: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for name, command in commands.items():
        yield (
            f"[{code(f'wroll {name}')}](#wroll-{name.replace(' ', '-')})",
            prose(" ".join((command.help or "").split())),
        )


def _rows(command: Any, hints: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    for parameter in command.params:
        if parameter.name == "help":
            continue
        argument = parameter.param_type_name == "argument"
        name = _metavar(parameter) if argument else _option(parameter, hints[parameter.name])
        default = "required" if parameter.required else _default(parameter.default)
        yield code(name), prose(" ".join((parameter.help or "").split())), default


def _metavar(parameter: Any) -> str:
    return str(parameter.metavar or parameter.name.upper())


def _option(parameter: Any, hint: Any) -> str:
    """Option with the type of its value."""
    if parameter.is_flag:
        return str(parameter.opts[0])
    kinds = {hint, *get_args(hint)}
    value = parameter.metavar or ("N" if int in kinds else "PATH" if Path in kinds else "TEXT")
    return f"{parameter.opts[0]} {value}"


def _default(value: Any) -> str:
    return "" if value in (None, False) or callable(value) else code(str(value))
