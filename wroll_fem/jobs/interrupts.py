"""Signals that stop a run: SIGTERM counts as Ctrl-C, and no interrupt is mistaken for a failure."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from wroll_fem.errors import ConvergenceError

_arrived = False


def interrupt_arrived() -> bool:
    """Whether a signal has asked this process to stop, inside `stopped_by_signals`.

    Native code can replace the KeyboardInterrupt by an error of its own: an interrupted import of an extension
    module ends with ImportError. Such an error is not a failure of the run.
    """
    return _arrived


@contextmanager
def stopped_by_signals() -> Iterator[None]:
    """Raise KeyboardInterrupt on SIGTERM and on Ctrl-C, so that a terminated job saves a checkpoint.

    An ignored SIGINT stays ignored, as in a background job of a shell.

    Raises
    ------
    KeyboardInterrupt
        After one of the signals, also in place of an error that followed it, except ConvergenceError.
    """
    global _arrived

    def interrupt(signum: int, frame: FrameType | None) -> None:
        global _arrived
        _arrived = True
        raise KeyboardInterrupt

    before = {signal.SIGTERM: signal.signal(signal.SIGTERM, interrupt)}
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        before[signal.SIGINT] = signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    except ConvergenceError:  # its results are saved
        raise
    except Exception as error:
        if _arrived:
            raise KeyboardInterrupt from error
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _arrived = False
