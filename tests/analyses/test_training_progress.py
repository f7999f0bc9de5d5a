"""What is shown while a basis is trained: the number of the pass, the place, and a line after each pass."""

from __future__ import annotations

from types import SimpleNamespace

from wroll_fem.analyses.training_progress import Passes
from wroll_fem.progress import SilentProgress


def test_passes_are_counted_from_one_and_the_bar_is_full_only_at_the_end() -> None:
    progress, shown = SilentProgress(), []
    stage = SimpleNamespace(update=lambda share, note, left: shown.append((share, note)))
    passes = Passes(progress, stage, 1e-3)
    passes.at_point(1.0, 7, "150 Hz")
    passes.report(1, SimpleNamespace(size=12), 0.02)
    passes.at_point(-0.1, 1, "125 Hz")
    assert [share for share, _ in shown] == [0.99, 0.0]
    assert [note.partition(":")[0] for _, note in shown] == ["pass 1", "pass 2"]
    assert "150 Hz, 7 points (until the error is 0.1 %)" in shown[0][1]
