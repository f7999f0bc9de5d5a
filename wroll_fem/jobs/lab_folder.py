"""Folder of a laboratory evaluation that is finished, for `wroll plot` and `wroll report`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from wroll_fem.jobs.folder import RunFolder
from wroll_fem.jobs.result_folder import ResultFolder

if TYPE_CHECKING:
    from wroll_fem.lab.result import LabResult

_AGAIN = "delete the folder and run `wroll lab` again"


class LabFolder(ResultFolder):
    """Paths and state of one laboratory evaluation; the attributes are those of `ResultFolder`."""

    def is_one(self) -> bool:
        """Whether the folder is that of an evaluation: settings.yaml without the case.yaml of a run."""
        return self.input_file.is_file() and not RunFolder(self.path).case_file.is_file()

    def load(self) -> LabResult:
        """Load the result of the evaluation.

        Raises
        ------
        InputError
            If the folder has no results, or the file is damaged.
        """
        if not self.results_file.is_file():
            raise self._refuse("has no results (results.nc): the evaluation did not end", _AGAIN)
        return load_lab_result(self.results_file)


def load_lab_result(path: Path) -> LabResult:
    """Load the result of an evaluation from its results file (.nc).

    Raises
    ------
    InputError
        If the file is missing or damaged, or contains no evaluation of this version.
    """
    from wroll_fem.lab.evaluation import result_of
    from wroll_fem.results.dataset import load_dataset

    return result_of(load_dataset(path), str(path))
