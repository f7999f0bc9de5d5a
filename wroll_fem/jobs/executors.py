"""Executors of a batch: local processes, or workers of a Dask cluster.

A case waits until no other process uses its run folder.
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import logging
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from filelock import FileLock, Timeout

from wroll_fem.errors import InputError
from wroll_fem.jobs.folder import RunFolder

CONNECT_SECONDS = 10.0
"""Longest wait for an answer of the scheduler, s."""

RETRIES = 5
"""Number of lost workers after which a case counts as failed."""

FREE_SECONDS = 60.0
"""Longest wait for a run to save its checkpoint after its worker has died, s."""

INTERRUPTED = 130
"""Exit code of an interrupted run."""

_PR_SET_PDEATHSIG = 1  # prctl(2): signal to a child whose parent dies
_LIBC = ctypes.CDLL(None) if sys.platform == "linux" else None  # loaded here: not between fork and exec


class Ended(NamedTuple):
    """End of a `wroll run`: exit code, and the last line on stderr."""

    code: int
    message: str


@dataclass(frozen=True)
class Job:
    """A `wroll run` of a batch.

    Attributes
    ----------
    words : arguments of the command
    folder : run folder
    structure : text that is the same for runs that may share bodies and modes; empty if there is nothing to share
    """

    words: Sequence[str]
    folder: Path
    structure: str = ""


class Pool(Protocol):
    """Pool that executes `wroll run` commands in parallel."""

    def submit(self, jobs: Sequence[Job]) -> list[Future[Ended]]:
        """Start the jobs as workers become free."""

    def at_work(self) -> dict[str, float]:
        """Folder name -> start time (time.time) of every running case."""

    def stop(self) -> None:
        """Terminate the running processes; each saves a checkpoint."""

    def close(self) -> None:
        """Release the workers."""


def _started(module: str, words: Sequence[str], **options: Any) -> subprocess.Popen[str]:
    """Start a module in its own session, so that Ctrl-C reaches it only through `Pool.stop`.

    On Linux the process receives SIGTERM if its parent is killed. It then saves a checkpoint and releases its folder.
    On other systems it runs to its end.
    """
    return subprocess.Popen(
        [sys.executable, "-m", module, *words],
        env=os.environ | {"OMP_NUM_THREADS": "1", "MPLBACKEND": "Agg"},
        text=True, start_new_session=True,
        preexec_fn=_follow_parent if sys.platform == "linux" else None, **options,
    )  # fmt: skip


def _follow_parent() -> None:
    """Request SIGTERM for this child process when its parent dies (Linux only)."""
    assert _LIBC is not None
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


def _ended(code: int, errors: str) -> Ended:
    """End of a process from its exit code and its text on standard error."""
    lines = errors.strip().splitlines()
    message = lines[-1] if lines else f"the process ended with code {code}"
    return Ended(code if code >= 0 else 1, message)


class _Worker:
    """Process that executes the runs of one structure one after another (`wroll_fem.cli.worker`)."""

    def __init__(self, structure: str):
        self.structure = structure
        self._errors = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")  # noqa: SIM115
        # not a pipe: PETSc, where it is loaded, ends the program on SIGPIPE
        self._jobs, theirs = socket.socketpair()
        with theirs:
            self.process = _started(
                "wroll_fem.cli.worker", [], stdin=theirs, stdout=subprocess.PIPE, stderr=self._errors
            )

    def run(self, words: Sequence[str]) -> Ended:
        """End of one run; that of the process itself if it dies."""
        assert self.process.stdout is not None
        answer = ""
        with contextlib.suppress(ConnectionError):
            self._jobs.sendall(f"{json.dumps(list(words))}\n".encode(), getattr(socket, "MSG_NOSIGNAL", 0))
            answer = self.process.stdout.readline()
        if answer:
            return Ended(*json.loads(answer))
        code = self.process.wait()
        self._errors.seek(0)
        return _ended(code, self._errors.read())

    @property
    def alive(self) -> bool:
        """Whether the process can execute a further run."""
        return self.process.poll() is None

    def close(self) -> None:
        """End the process after its present run."""
        self._jobs.close()  # the end of its standard input
        self.process.communicate()
        self._errors.close()


class LocalPool:
    """Pool of processes on this machine.

    A process executes runs of one structure, whose bodies and modes it keeps. A run without structure has a process of
    its own.

    Parameters
    ----------
    workers
        Number of cases that run at the same time, each on one thread.
    """

    def __init__(self, workers: int) -> None:
        if workers < 1:
            remedy = "give the number of parallel cases"
            raise InputError(f"must be 1 or more, got {workers}", key="--workers", remedy=remedy)
        self._threads = ThreadPoolExecutor(workers)
        self._waiting: list[tuple[Job, Future[Ended]]] = []
        self._running: dict[_Worker, tuple[str, float]] = {}
        self._structures: dict[int, str] = {}  # of the last job of each thread
        self._own: dict[int, _Worker] = {}  # of each thread
        self._lock = threading.Lock()
        self._stopped = False

    def submit(self, jobs: Sequence[Job]) -> list[Future[Ended]]:
        """Run every job as soon as a thread is free for it."""
        futures: list[Future[Ended]] = [Future() for _ in jobs]
        with self._lock:
            self._waiting += zip(jobs, futures, strict=True)
        for _ in jobs:
            self._threads.submit(self._run_next)
        return futures

    def _run_next(self) -> None:
        job, future = self._next()
        try:
            future.set_result(self._run(job))
        except BaseException as error:
            future.set_exception(error)

    def _next(self) -> tuple[Job, Future[Ended]]:
        """Take a waiting job: of the structure of this thread, else of one that no thread has, else of any."""
        with self._lock:
            me = threading.get_ident()
            own = self._structures.get(me, "")
            others = {structure for thread, structure in self._structures.items() if thread != me}

            def rank(entry: tuple[Job, Future[Ended]]) -> int:
                structure = entry[0].structure
                return 1 if not structure else 0 if structure == own else 2 if structure in others else 1

            found = min(self._waiting, key=rank)
            self._waiting.remove(found)
            self._structures[me] = found[0].structure
            return found

    def _run(self, job: Job) -> Ended:
        _wait_until_free(job.folder, lambda: self._stopped)
        me = threading.get_ident()
        worker = self._own.get(me)
        if worker is not None and not (job.structure and job.structure == worker.structure and worker.alive):
            self._end(me, worker)
            worker = None
        with self._lock:
            if self._stopped:
                return Ended(INTERRUPTED, "not started")
            if worker is None:
                worker = self._own[me] = _Worker(job.structure)
            self._running[worker] = job.folder.name, time.time()
        try:
            ended = worker.run(job.words)
        finally:
            with self._lock:
                del self._running[worker]
        if ended.code == INTERRUPTED:
            self._end(me, worker)
        return ended

    def _end(self, thread: int, worker: _Worker) -> None:
        """End the process of a thread."""
        worker.close()
        with self._lock:
            del self._own[thread]

    def at_work(self) -> dict[str, float]:
        """Folder name -> start time (time.time) of every running case."""
        with self._lock:
            return dict(self._running.values())

    def stop(self) -> None:
        """Terminate all running processes; each saves a checkpoint."""
        with self._lock:
            self._stopped = True
            for worker in self._running:
                worker.process.terminate()

    def close(self) -> None:
        """Wait for all runs to finish, and end the processes."""
        self._threads.shutdown()
        for thread, worker in list(self._own.items()):
            self._end(thread, worker)


class ClusterPool:
    """Pool of Dask workers that access the same files under the same paths; one case per worker thread.

    A case whose worker dies is started again on another worker and continues from its checkpoint.

    Parameters
    ----------
    address
        Address of the scheduler, "tcp://HOST:PORT".

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

    def submit(self, jobs: Sequence[Job]) -> list[Future[Ended]]:
        """Run every job on one of the workers, in a process of its own."""
        started = []
        for job in jobs:
            words = list(job.words), str(job.folder.resolve()), os.getcwd()
            future: Future[Ended] = self._executor.submit(run_on_worker, *words)
            self._folders[future] = job.folder
            started.append(future)
        return started

    def at_work(self) -> dict[str, float]:
        """Folder name -> start time of every running case, found from the status in its folder.

        The scheduler does not distinguish running from queued cases.
        """
        found = {}
        for folder in [folder for future, folder in self._folders.items() if not future.done()]:
            file = RunFolder(folder).provenance_file
            with contextlib.suppress(OSError, InputError):  # not there yet, or just being written
                start = file.stat().st_mtime
                if start >= self._begun and RunFolder(folder).status() == "running":
                    found[folder.name] = start
        return found

    def stop(self) -> None:
        """Cancel queued cases and terminate running ones, which save checkpoints."""
        self._client.cancel(self._client.futures, force=True, reason="interrupted")
        self._client.run(end_processes)

    def close(self) -> None:
        """Disconnect from the scheduler."""
        self._client.close()


_on_this_worker: set[subprocess.Popen[str]] = set()


def run_on_worker(words: list[str], folder: str, working_directory: str) -> Ended:
    """Execute `wroll run` on a Dask worker, after processes of dead workers have released the run folder.

    Parameters
    ----------
    words
        Arguments of the command.
    folder
        Run folder.
    working_directory
        Directory of the process.
    """
    _wait_until_free(Path(folder))
    process = _started(
        "wroll_fem.cli", ["run", *words], cwd=working_directory, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )
    _on_this_worker.add(process)
    try:
        errors = process.communicate()[1]
        return _ended(process.returncode, errors)
    finally:
        _on_this_worker.discard(process)


def end_processes() -> None:
    """Terminate the processes of this worker; each saves a checkpoint."""
    for process in tuple(_on_this_worker):
        process.terminate()


def _wait_until_free(folder: Path, stopped: Callable[[], bool] = lambda: False) -> None:
    """Wait until a terminating run releases its folder (`RunFolder.open` locks it)."""
    lock = RunFolder(folder).lock_file
    end = time.monotonic() + FREE_SECONDS
    while time.monotonic() < end and lock.exists() and not stopped():
        with contextlib.suppress(Timeout), FileLock(lock).acquire(timeout=0.2):
            return
