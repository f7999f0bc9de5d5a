"""Where the cases of a batch run: local processes, or workers of a Dask cluster; waits for a folder in use."""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from filelock import FileLock, Timeout

from wroll_fem.errors import InputError
from wroll_fem.jobs.folder import RunFolder

CONNECT_SECONDS = 10.0
"""How long a scheduler may take to answer."""

RETRIES = 5
"""Workers that one case may lose before it counts as failed."""

FREE_SECONDS = 60.0
"""How long a run whose worker died may take to save itself."""

_PR_SET_PDEATHSIG = 1  # prctl(2): signal to a child whose parent dies
_LIBC = ctypes.CDLL(None) if sys.platform == "linux" else None  # loaded here: not between fork and exec


class Ended(NamedTuple):
    """End of a `wroll run`: exit code, and the last line on stderr."""

    code: int
    message: str


class Pool(Protocol):
    """Runs `wroll run` commands, several at a time."""

    def submit(self, words: Sequence[str], folder: Path) -> Future[Ended]:
        """Start `wroll run` with these words; it writes to ``folder``."""

    def at_work(self) -> dict[str, float]:
        """Name of the folder -> start (time.time) of every case that runs now."""

    def stop(self) -> None:
        """End what runs; each process saves itself."""

    def close(self) -> None:
        """Let go of the workers when all is done."""


def _started(words: Sequence[str], **options: Any) -> subprocess.Popen[str]:
    """`wroll run` in a session of its own: Ctrl-C reaches it through `Pool.stop`, once.

    On Linux it follows its parent: when that is killed it gets SIGTERM, saves itself and frees its folder. Elsewhere it
    runs on to its end.
    """
    return subprocess.Popen(
        [sys.executable, "-m", "wroll_fem.cli", "run", *words],
        env=os.environ | {"OMP_NUM_THREADS": "1", "MPLBACKEND": "Agg"},
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=_follow_parent if sys.platform == "linux" else None, **options,
    )  # fmt: skip


def _follow_parent() -> None:
    """Ask the kernel for SIGTERM when the parent dies; runs in the child. No other system has such a call."""
    assert _LIBC is not None
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


def _ended(process: subprocess.Popen[str]) -> Ended:
    lines = process.communicate()[1].strip().splitlines()
    message = lines[-1] if lines else f"the process ended with code {process.returncode}"
    return Ended(process.returncode if process.returncode >= 0 else 1, message)


class LocalPool:
    """Processes on this machine.

    Parameters
    ----------
    workers
        Cases at a time, each on one thread.
    """

    def __init__(self, workers: int) -> None:
        if workers < 1:
            remedy = "give the cases to run at a time"
            raise InputError(f"must be 1 or more, got {workers}", key="--workers", remedy=remedy)
        self._threads = ThreadPoolExecutor(workers)
        self._running: dict[subprocess.Popen[str], tuple[str, float]] = {}
        self._lock = threading.Lock()
        self._stopped = False

    def submit(self, words: Sequence[str], folder: Path) -> Future[Ended]:
        """Run one case in a process of its own."""
        return self._threads.submit(self._run, list(words), folder)

    def _run(self, words: list[str], folder: Path) -> Ended:
        _wait_until_free(folder, lambda: self._stopped)
        with self._lock:
            if self._stopped:
                return Ended(130, "not started")
            process = _started(words)
            self._running[process] = folder.name, time.time()
        try:
            return _ended(process)
        finally:
            with self._lock:
                del self._running[process]

    def at_work(self) -> dict[str, float]:
        """Folder names and starts of the processes."""
        with self._lock:
            return dict(self._running.values())

    def stop(self) -> None:
        """End every process; each saves itself."""
        with self._lock:
            self._stopped = True
            for process in self._running:
                process.terminate()

    def close(self) -> None:
        """Wait for the threads."""
        self._threads.shutdown()


class ClusterPool:
    """Workers of a Dask cluster that see the same files under the same paths; one case per worker thread.

    A case whose worker dies is started again on another one and goes on from its checkpoint.

    Parameters
    ----------
    address
        Of the scheduler, "tcp://HOST:PORT".

    Raises
    ------
    InputError
        If dask.distributed is not installed, or the scheduler does not answer.
    """

    def __init__(self, address: str) -> None:
        try:
            from distributed import Client
        except ImportError:
            remedy = "install it into .venv: pip install distributed"
            raise InputError("needs dask.distributed", key="--scheduler", remedy=remedy) from None
        for name in (
            "distributed",
            "distributed.client",
        ):  # a lost scheduler is reported as failed cases, without traceback
            logging.getLogger(name).setLevel(logging.CRITICAL)
        try:
            self._client = Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            remedy = "start one with `dask scheduler`, or leave --scheduler out"
            problem = f"no answer from {address} within {CONNECT_SECONDS:g} s ({type(error).__name__})"
            raise InputError(problem, key="--scheduler", remedy=remedy) from None
        self._executor: Executor = self._client.get_executor(pure=False, retries=RETRIES)
        self._begun = time.time()
        self._folders: dict[Future[Ended], Path] = {}

    def submit(self, words: Sequence[str], folder: Path) -> Future[Ended]:
        """Run one case on some worker."""
        future: Future[Ended] = self._executor.submit(run_on_worker, list(words), str(folder.resolve()), os.getcwd())
        self._folders[future] = folder
        return future

    def at_work(self) -> dict[str, float]:
        """Cases whose folder says that they run, since this batch began: the scheduler knows queued ones as well."""
        found = {}
        for folder in [folder for future, folder in self._folders.items() if not future.done()]:
            file = RunFolder(folder).provenance_file
            with contextlib.suppress(OSError, InputError):  # not there yet, or just being written
                start = file.stat().st_mtime
                if start >= self._begun and RunFolder(folder).status() == "running":
                    found[folder.name] = start
        return found

    def stop(self) -> None:
        """Forget what has not begun; processes that run save themselves."""
        self._client.cancel(self._client.futures, force=True, reason="interrupted")
        self._client.run(end_processes)

    def close(self) -> None:
        """Disconnect."""
        self._client.close()


_on_this_worker: set[subprocess.Popen[str]] = set()


def run_on_worker(words: list[str], folder: str, working_directory: str) -> Ended:
    """Run `wroll run` on a Dask worker, once ``folder`` is free of a process whose worker has died."""
    _wait_until_free(Path(folder))
    process = _started(words, cwd=working_directory)
    _on_this_worker.add(process)
    try:
        return _ended(process)
    finally:
        _on_this_worker.discard(process)


def end_processes() -> None:
    """End what this worker runs; each process saves itself."""
    for process in tuple(_on_this_worker):
        process.terminate()


def _wait_until_free(folder: Path, stopped: Callable[[], bool] = lambda: False) -> None:
    """Wait for a run that is ending to release its folder (`RunFolder.open` locks it)."""
    lock = RunFolder(folder).lock_file
    end = time.monotonic() + FREE_SECONDS
    while time.monotonic() < end and lock.exists() and not stopped():
        with contextlib.suppress(Timeout), FileLock(lock).acquire(timeout=0.2):
            return
