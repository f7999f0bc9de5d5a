"""Progress of long work: a bar on a terminal, plain lines elsewhere, silence in tests and batches."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from datetime import datetime
from math import isfinite
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, Self, TextIO

#: A plain line appears when this much time (s) or this share of the work has passed since the last one,
#: the latter not more often than once per second.
LINE_SECONDS, LINE_SHARE, LINE_SHARE_SECONDS = 10.0, 0.1, 1.0

#: Time between two redrawings of the bar, s; `update` is called in tight loops.
BAR_SECONDS = 0.1


class Stage(Protocol):
    """One stretch of work with a known total."""

    def update(self, done: float, note: str = "", left: float | None = None) -> None:
        """Report that `done` of the stage's total is finished.

        Parameters
        ----------
        note
            Shown behind it.
        left
            Seconds left, where the caller knows better than a constant pace would tell; nan for unknown.
        """


class Progress(Protocol):
    """What long work reports to."""

    def stage(self, name: str, total: float, unit: str = "") -> AbstractContextManager[Stage]:
        """Open a stage of `total` units of work."""

    def info(self, text: str) -> None:
        """Tell a fact."""

    def warning(self, text: str) -> None:
        """Tell something the user should act on."""


class _SilentStage:
    def update(self, done: float, note: str = "", left: float | None = None) -> None:
        """Ignore the report."""


class SilentProgress:
    """Shows nothing; keeps what was said.

    Attributes
    ----------
    infos, warnings
        Texts in the order they came.
    stages
        Names of the stages that were opened.
    """

    def __init__(self) -> None:
        self.infos: list[str] = []
        self.warnings: list[str] = []
        self.stages: list[str] = []

    @contextmanager
    def stage(self, name: str, total: float, unit: str = "") -> Iterator[Stage]:
        """Remember the name."""
        self.stages.append(name)
        yield _SilentStage()

    def info(self, text: str) -> None:
        """Remember the text."""
        self.infos.append(text)

    def warning(self, text: str) -> None:
        """Remember the text."""
        self.warnings.append(text)


class TerminalProgress:
    """Bar when the stream is a terminal, otherwise a line at the start, now and then, and at the end.

    Parameters
    ----------
    stream
        Where to write; standard output by default.
    terminal
        Whether the stream is a terminal; asked of the stream by default.

    Notes
    -----
    With `log_to`, everything said is also appended to a file with time stamps. Usable as a context manager,
    which closes that file.
    """

    def __init__(self, stream: TextIO | None = None, *, terminal: bool | None = None) -> None:
        self._stream = stream if stream is not None else sys.stdout
        self._terminal = self._stream.isatty() if terminal is None else terminal
        self._log: TextIO | None = None
        self._bars: Any = None
        self._open = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def log_to(self, path: Path) -> None:
        """Append everything said from now on to a file."""
        self.close()
        self._log = path.open("a", encoding="utf-8")

    def close(self) -> None:
        """Close the log file."""
        if self._log is not None:
            self._log.close()
            self._log = None

    def info(self, text: str) -> None:
        """Print and log a fact."""
        self._say(text)

    def warning(self, text: str) -> None:
        """Print and log a warning."""
        self._say(f"warning: {text}")

    @contextmanager
    def stage(self, name: str, total: float, unit: str = "") -> Iterator[Stage]:
        """Open a stage; its start, its end and its duration are logged."""
        size = f" ({total:g} {unit})" if unit else ""
        self._write_log(f"{name}{size}: start")
        started = time.monotonic()
        outcome = "stopped"
        try:
            if self._terminal:
                with self._bar(name, total, unit) as bar:
                    yield bar
            else:
                self._print(f"{name}{size} ...")
                yield _LineStage(self, name, total, unit, started)
            outcome = "done"
        finally:
            text = f"{name}: {outcome} in {_duration(time.monotonic() - started)}"
            self._print(text)
            self._write_log(text)

    @contextmanager
    def _bar(self, name: str, total: float, unit: str) -> Iterator[_BarStage]:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            Task,
            TaskProgressColumn,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )
        from rich.progress import Progress as Bars
        from rich.text import Text

        class Left(TimeRemainingColumn):
            """The stage's own estimate where it gives one."""

            def render(self, task: Task) -> Text:
                left = task.fields["left"]
                if left is None:
                    return super().render(task)
                return Text(f"{_duration(left)} left" if isfinite(left) else "", "progress.remaining")

        if self._bars is None:
            columns = ("{task.description}", "{task.fields[note]}")
            console = Console(file=self._stream, force_terminal=True)
            self._bars = Bars(
                TextColumn(columns[0]), BarColumn(), TaskProgressColumn(), TimeElapsedColumn(), Left(),
                TextColumn(columns[1]), console=console, transient=True,
            )  # fmt: skip
        if self._open == 0:
            self._bars.start()
        self._open += 1
        task = self._bars.add_task(name, total=total, note=unit, left=None)
        try:
            yield _BarStage(self._bars, task)
        finally:
            self._bars.remove_task(task)
            self._open -= 1
            if self._open == 0:
                self._bars.stop()

    def _say(self, text: str) -> None:
        self._print(text)
        self._write_log(text)

    def _print(self, text: str) -> None:
        if self._open:  # a live bar owns the bottom line
            self._bars.console.print(text, markup=False, highlight=False, soft_wrap=True)
        else:
            print(text, file=self._stream, flush=True)

    def _write_log(self, text: str) -> None:
        if self._log is not None:
            self._log.write(f"{datetime.now().astimezone().isoformat(timespec='seconds')} {text}\n")
            self._log.flush()


class _BarStage:
    def __init__(self, bars: Any, task: Any) -> None:
        self._bars, self._task, self._last = bars, task, 0.0

    def update(self, done: float, note: str = "", left: float | None = None) -> None:
        now = time.monotonic()
        if now - self._last >= BAR_SECONDS:
            self._last = now
            self._bars.update(self._task, completed=done, note=note, left=left)


class _LineStage:
    def __init__(self, owner: TerminalProgress, name: str, total: float, unit: str, started: float) -> None:
        self._owner, self._name, self._total, self._unit = owner, name, max(total, 1e-300), unit
        self._started = self._last = started
        self._shown = 0.0

    def update(self, done: float, note: str = "", left: float | None = None) -> None:
        now = time.monotonic()
        share = done / self._total
        waited = now - self._last
        due = waited >= LINE_SECONDS or (waited >= LINE_SHARE_SECONDS and share - self._shown >= LINE_SHARE)
        if not due or share >= 1:
            return
        self._last, self._shown = now, share
        if left is None and share > 0:
            left = (now - self._started) * (1 - share) / share
        shown = f", {_duration(left)} left" if left is not None and isfinite(left) else ""
        tail = f", {note}" if note else ""
        self._owner.info(
            f"{self._name}: {share:.0%} ({done:g} of {self._total:g} {self._unit}){shown}{tail}".replace(" )", ")")
        )


def _duration(seconds: float) -> str:
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60} h {minutes % 60:02d} min" if minutes >= 60 else f"{minutes} min {rest:02d} s"
