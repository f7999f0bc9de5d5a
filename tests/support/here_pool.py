"""Stand-in for the processes of a batch."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future

from wroll_fem.case import load_case
from wroll_fem.jobs import executors as pools
from wroll_fem.jobs.run import run_case
from wroll_fem.progress import SilentProgress


class HerePool:
    """Runs the cases of a batch in this process: that they are processes of their own is tested in test_batch.py."""

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def submit(self, jobs: Sequence[pools.Job]) -> list[Future[pools.Ended]]:
        futures: list[Future[pools.Ended]] = [Future() for _ in jobs]
        for job, future in zip(jobs, futures, strict=True):
            overrides = [job.words[at + 1] for at, word in enumerate(job.words) if word == "--set"]
            case = load_case(job.words[0], overrides)
            run_case(case, job.folder, progress=SilentProgress(), resume=True, command="")
            future.set_result(pools.Ended(0, ""))
        return futures

    def at_work(self) -> dict[str, float]:
        return {}

    def stop(self) -> None:
        pass

    def close(self) -> None:
        pass
