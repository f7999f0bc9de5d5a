"""Progress of a batch: finished, failed and running cases, and remaining time."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import nan

NAMED = 3
"""Largest number of running cases shown by name; the others are counted."""


@dataclass
class BatchProgress:
    """Counts of cases in a call of `run_grid`.

    Attributes
    ----------
    total
        Number of cases of the grid.
    done, failed
        Number of finished cases, including those finished before this call, and number of failed cases among them.
    seconds
        Wall time of each case that ended in this call.
    """

    total: int
    done: int = 0
    failed: int = 0
    seconds: list[float] = field(default_factory=list)
    begun: float = field(default_factory=time.time)

    def add(self, *, failed: bool, started: float | None = None) -> None:
        """Count a finished case; ``started`` (time.time) is None if it did not run in this call."""
        self.done += 1
        self.failed += failed
        if started is not None:
            self.seconds.append(time.time() - started)

    def left(self, running: Mapping[str, float]) -> float:
        """Remaining time, s, extrapolated from this call; nan before the first case has finished.

        Parameters
        ----------
        running
            Name -> start (time.time) of the running cases. Each counts as the fraction of a case that it has run, found
            from the mean duration.
        """
        if not self.seconds:
            return nan
        now, mean = time.time(), max(sum(self.seconds) / len(self.seconds), 1e-3)
        shares = sum(min((now - start) / mean, 0.9) for start in running.values())
        undone = max(self.total - self.done - shares, 0.0)
        return (now - self.begun) * undone / (len(self.seconds) + shares)

    def note(self, running: Mapping[str, float]) -> str:
        """Text with the number of failed cases and the names of the running cases."""
        names = sorted(running, key=lambda name: running[name])
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        parts = [f"running {', '.join(names[:NAMED])}{more}"] if names else []
        return "; ".join(([f"{self.failed} failed"] if self.failed else []) + parts)
