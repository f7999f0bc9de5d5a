"""Process of a batch that executes `wroll run` for one case after another.

The structure of the cases is kept from case to case. Each line on standard input holds the arguments of one run as
JSON; the answer is one line on standard output with the exit code and the last line on standard error.
"""

from __future__ import annotations

import gc
import io
import json
import os
import sys
import traceback
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout

from wroll_fem.cli.app import app
from wroll_fem.dynamics.reduction.kept_structure import keeping_structure
from wroll_fem.jobs.executors import INTERRUPTED


def executed(words: Sequence[str]) -> tuple[int, str]:
    """Exit code of `wroll run` with the arguments ``words``, and the last line that it writes to standard error."""
    told = io.StringIO()
    with redirect_stdout(io.StringIO()), redirect_stderr(told):
        try:
            app(["run", *words], prog_name="wroll")
            code = 0
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else int(end.code is not None)
        except KeyboardInterrupt:
            code = INTERRUPTED
        except Exception:  # a defect in one case must not stop the others
            traceback.print_exc()
            code = 1
    lines = told.getvalue().strip().splitlines()
    return code, lines[-1] if lines else f"the run ended with code {code}"


def main() -> None:
    """Execute the runs on standard input, until it ends or a run is interrupted."""
    with os.fdopen(os.dup(1), "w", encoding="utf-8") as answers, keeping_structure():
        os.dup2(2, 1)  # native libraries may print
        for line in sys.stdin:
            code, message = executed(json.loads(line))
            print(json.dumps([code, message]), file=answers, flush=True)
            if code == INTERRUPTED:
                break
            gc.collect()


if __name__ == "__main__":
    main()
