"""Queue of the cases of many studies: cases of later studies run while results of earlier ones are awaited."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
from pathlib import Path

from wroll_fem.jobs.executors import Ended, Job, LocalPool


class StudyQueue:
    """Pool of processes that several batches share; a case that was queued before is not started again.

    Parameters
    ----------
    workers
        Number of cases that run at the same time.
    """

    def __init__(self, workers: int) -> None:
        self._pool = LocalPool(workers)
        self._queued: dict[Path, Future[Ended]] = {}

    def begin(self, jobs: Sequence[Job]) -> None:
        """Queue jobs whose results are awaited later."""
        new = [job for job in jobs if job.folder not in self._queued]
        self._queued |= zip((job.folder for job in new), self._pool.submit(new), strict=True)

    def submit(self, jobs: Sequence[Job]) -> list[Future[Ended]]:
        """Futures of the jobs; those that are not queued yet are queued."""
        self.begin(jobs)
        return [self._queued[job.folder] for job in jobs]

    def at_work(self) -> dict[str, float]:
        """Folder name -> start time (time.time) of every running case."""
        return self._pool.at_work()

    def stop(self) -> None:
        """Terminate all running processes, which save checkpoints; queued cases do not start."""
        self._pool.stop()

    def close(self) -> None:
        """Wait for all runs to finish, and end the processes."""
        self._pool.close()
