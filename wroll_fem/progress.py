"""Progress reports: bars on a terminal, plain lines elsewhere, or silent."""

from __future__ import annotations

import logging
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from datetime import datetime
from math import isfinite
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, Self, TextIO

from wroll_fem.errors import StorageError

#: A plain line is printed if the first time (s) has passed since the last line, or if the share of the work has been
#: done since then and the second time (s) has passed.
LINE_SECONDS, LINE_SHARE, LINE_SHARE_SECONDS = 10.0, 0.1, 1.0

#: Share of a stage that must be done before its remaining time is estimated from its pace.
LEAST_SHARE = 0.05

#: Time between two redrawings of the bar, s; `update` is called in tight loops.
BAR_SECONDS = 0.1


class Stage(Protocol):
    """Stage of work with a known total."""

    def update(self, done: float, note: str = "", left: float | None = None) -> None:
        """Report the finished amount `done` of the total.

        Parameters
        ----------
        note
            Text shown behind the progress.
        left
            Remaining time, s; nan if unknown. By default it is extrapolated from the time taken so far.
        """


class Progress(Protocol):
    """Receiver of progress reports and messages."""

    def stage(self, name: str, total: float, unit: str = "") -> AbstractContextManager[Stage]:
        """Open a stage.

        Parameters
        ----------
        name
            Name of the stage.
        total
            Amount of work.
        unit
            Unit of the amount.
        """

    def info(self, text: str) -> None:
        """Report information."""

    def warning(self, text: str) -> None:
        """Report a warning."""


class _SilentStage:
    def update(self, done: float, note: str = "", left: float | None = None) -> None:
        """Ignore the report."""


class SilentProgress:
    """Progress that shows nothing and stores the messages.

    Attributes
    ----------
    infos, warnings
        Messages in their order.
    stages
        Names of the stages that were opened.
    """

    def __init__(self) -> None:
        self.infos: list[str] = []
        self.warnings: list[str] = []
        self.stages: list[str] = []

    @contextmanager
    def stage(self, name: str, total: float, unit: str = "") -> Iterator[Stage]:
        """Store the name of the stage."""
        self.stages.append(name)
        yield _SilentStage()

    def info(self, text: str) -> None:
        """Store the message."""
        self.infos.append(text)

    def warning(self, text: str) -> None:
        """Store the message."""
        self.warnings.append(text)


class KeptWarnings:
    """Progress that forwards everything to another progress object and stores the warnings.

    Parameters
    ----------
    inner
        Receiver of reports and messages.

    Attributes
    ----------
    warnings
        Warnings in their order, each once.
    """

    def __init__(self, inner: Progress) -> None:
        self._inner = inner
        self.warnings: list[str] = []

    def stage(self, name: str, total: float, unit: str = "") -> AbstractContextManager[Stage]:
        """Open a stage on the wrapped progress object."""
        return self._inner.stage(name, total, unit)

    def info(self, text: str) -> None:
        """Forward information."""
        self._inner.info(text)

    def warning(self, text: str) -> None:
        """Forward a warning and store it; a repeated warning is ignored."""
        if text not in self.warnings:
            self.warnings.append(text)
            self._inner.warning(text)


def draws_bars(stream: TextIO) -> bool:
    """Whether a stream is a terminal that can redraw lines, and this process runs in its foreground."""
    if not stream.isatty() or os.environ.get("TERM", "dumb").lower() in ("", "dumb", "unknown"):
        return False
    try:
        return os.tcgetpgrp(stream.fileno()) == os.getpgrp()  # not in the background of a shell
    except (AttributeError, OSError):
        return True


class TerminalProgress:
    """Progress on a stream: bars if possible, otherwise lines at the start, at intervals and at the end.

    Parameters
    ----------
    stream
        Where to write; standard output by default.
    bars
        Whether to draw bars; by default, `draws_bars` decides.

    Notes
    -----
    Messages are records of the standard library's logging. They use a logger of this object, so the loggers of the
    program that imports `wroll_fem` do not change. With `log_to` they are also written to a file, together with the
    progress that a terminal shows as a bar. As a context manager, the object closes that file at the end.
    """

    def __init__(self, stream: TextIO | None = None, *, bars: bool | None = None) -> None:
        self._stream = stream if stream is not None else sys.stdout
        self._draws = draws_bars(self._stream) if bars is None else bars
        self._logger = logging.Logger("wroll_fem")
        self._logger.addHandler(_Shown(self._print))
        self._file: logging.Handler | None = None
        self._bars: Any = None
        self._open = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def log_to(self, path: Path) -> None:
        """Log all further messages and progress to a file, with time stamps."""
        self.close()
        try:
            self._file = _LogFile(path, encoding="utf-8")
        except OSError as error:
            raise _storage_error(error, path) from None
        self._file.setFormatter(_Stamped())
        self._logger.addHandler(self._file)

    def close(self) -> None:
        """Close the log file."""
        if self._file is not None:
            self._logger.removeHandler(self._file)
            self._file.close()
            self._file = None

    def info(self, text: str) -> None:
        """Print and log information."""
        self._logger.info("%s", text)

    def warning(self, text: str) -> None:
        """Print and log a warning."""
        self._logger.warning("%s", text)

    @contextmanager
    def stage(self, name: str, total: float, unit: str = "") -> Iterator[Stage]:
        """Open a stage; log its start, end and duration."""
        size = f" ({total:g} {unit})" if unit else ""
        self._logger.debug("%s%s: start", name, size)
        started = time.monotonic()
        outcome = "stopped"
        try:
            if self._draws:
                with self._bar(name, total, unit) as bar:
                    yield _Stage(self._logger.debug, name, total, unit, bar)
            else:
                self._print(f"{name}{size} ...")
                yield _Stage(self._logger.info, name, total, unit)
            outcome = "done"
        finally:
            self._logger.info("%s: %s in %s", name, outcome, duration(time.monotonic() - started))

    @contextmanager
    def _bar(self, name: str, total: float, unit: str) -> Iterator[Callable[[float, str, str], None]]:
        """Show a progress bar during a stage; yield a function that redraws it with amount, remaining time and note."""
        from rich.console import Console
        from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn
        from rich.progress import Progress as Bars

        if self._bars is None:
            title, left, note = (TextColumn(f"{{task.{key}}}", markup=False) for key in _TEXTS)
            self._bars = Bars(
                title, BarColumn(), TaskProgressColumn(), TimeElapsedColumn(), left, note,
                console=Console(file=self._stream, force_terminal=True), transient=True,
            )  # fmt: skip
        if self._open == 0:
            self._bars.start()
        self._open += 1
        task = self._bars.add_task(name, total=total, note=unit, left="")
        try:
            yield lambda done, left, note: self._bars.update(task, completed=done, left=left, note=note)
        finally:
            self._bars.remove_task(task)
            self._open -= 1
            if self._open == 0:
                self._bars.stop()

    def _print(self, text: str) -> None:
        encoding = getattr(self._stream, "encoding", None) or "utf-8"
        text = text.encode(encoding, "replace").decode(encoding)
        if self._open:  # a live bar owns the bottom line
            self._bars.console.print(text, markup=False, highlight=False, soft_wrap=True)
            return
        try:
            print(text, file=self._stream, flush=True)
        except BrokenPipeError:  # the reader has ended
            raise
        except OSError as error:
            raise _storage_error(error, "standard output") from None


_TEXTS = ("description", "fields[left]", "fields[note]")  # of a bar


class _Stage:
    """Stage that updates its bar, if it has one, and prints or logs a plain line at intervals."""

    def __init__(
        self,
        say: Callable[[str, str], None],
        name: str,
        total: float,
        unit: str,
        bar: Callable[[float, str, str], None] | None = None,
    ) -> None:
        self._say, self._name, self._total, self._unit, self._bar = say, name, max(total, 1e-300), unit, bar
        self._started = self._last = time.monotonic()
        self._drawn = self._shown = 0.0

    def update(self, done: float, note: str = "", left: float | None = None) -> None:
        now = time.monotonic()
        share = done / self._total
        waited = now - self._last
        line = waited >= LINE_SECONDS or (waited >= LINE_SHARE_SECONDS and share - self._shown >= LINE_SHARE)
        line = line and share < 1
        draw = self._bar is not None and now - self._drawn >= BAR_SECONDS
        if not line and not draw:
            return
        if left is None and share >= LEAST_SHARE:
            left = (now - self._started) * (1 - share) / share
        rest = f"{duration(left)} left" if left is not None and isfinite(left) else ""
        if self._bar is not None and draw:
            self._drawn = now
            self._bar(done, rest, note)
        if line:
            self._last, self._shown = now, share
            size = f"{done:g} of {self._total:g} {self._unit}".rstrip()
            self._say("%s", ", ".join(part for part in (f"{self._name}: {share:.0%} ({size})", rest, note) if part))


class _Shown(logging.Handler):
    """Handler that shows messages to the user, with a prefix on warnings."""

    def __init__(self, show: Callable[[str], None]) -> None:
        super().__init__(logging.INFO)
        self._show = show

    def emit(self, record: logging.LogRecord) -> None:
        self._show(_marked(record))


class _LogFile(logging.FileHandler):
    """Log file handler that raises an error if it cannot write, for example because the disk is full.

    The handler of `logging` would only print the error.
    """

    def handleError(self, record: logging.LogRecord) -> None:
        error = sys.exc_info()[1]  # called while the error is handled
        if not isinstance(error, OSError):
            raise
        raise _storage_error(error, self.baseFilename) from None

    def close(self) -> None:
        try:
            super().close()
        except OSError as error:  # the rest of a line for which there was no room
            raise _storage_error(error, self.baseFilename) from None


def _storage_error(error: OSError, file: str | Path) -> StorageError:
    return StorageError(f"cannot be written ({error.strerror or error})", file=str(file))


class _Stamped(logging.Formatter):
    """Format a record as time stamp with UTC offset, and message."""

    def format(self, record: logging.LogRecord) -> str:
        stamp = datetime.fromtimestamp(record.created).astimezone().isoformat(timespec="seconds")
        return f"{stamp} {_marked(record)}"


def _marked(record: logging.LogRecord) -> str:
    return f"warning: {record.getMessage()}" if record.levelno >= logging.WARNING else record.getMessage()


def duration(seconds: float) -> str:
    """Duration as text, such as "1 min 30 s"."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60} h {minutes % 60:02d} min" if minutes >= 60 else f"{minutes} min {rest:02d} s"
