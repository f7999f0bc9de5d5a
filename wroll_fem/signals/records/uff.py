"""Records of a universal file (UFF): functions over time of its sets 58."""

from __future__ import annotations

import contextlib
import io
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

TIME_RESPONSE = 1
"""Function type of a time response in set 58."""


def uff_columns(path: Path) -> dict[str, FloatArray]:
    """Name -> values (n,) of the time responses of a universal file, with one column `time` if they share it.

    The name of a record is node and direction, such as ``12:+X``, with the number of the set if that is not unique.

    Raises
    ------
    InputError
        If pyuff is not installed, the file is damaged, or it has no set 58 with a time response.
    """
    where = str(path)
    try:
        import pyuff
    except ImportError:
        raise InputError(
            "universal files need the package pyuff", file=where, remedy="install it: pip install 'wroll_fem[lab]'"
        ) from None
    try:
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            file = pyuff.UFF(where)
            kinds = [int(kind) for kind in np.atleast_1d(file.get_set_types())]
            at = [k for k, kind in enumerate(kinds) if kind == 58]
            sets: list[dict[str, Any]] = [file.read_sets(k) for k in at]
            responses = [entry for entry in sets if int(entry["func_type"]) == TIME_RESPONSE]
            found = _named(responses)
    except Exception as error:  # pyuff raises almost anything on a damaged file
        words = " ".join(str(error).split())[:120] or type(error).__name__
        problem = f"the universal file is damaged or cut off ({words})"
        raise InputError(problem, file=where, remedy="write it again") from None
    if not found:
        raise InputError(
            f"no set 58 with a time response; the file has the sets {sorted(set(kinds))}", file=where,
            remedy="export the time record as set 58",
        )  # fmt: skip
    return found


_DIRECTIONS = {0: "", 1: "+X", 2: "+Y", 3: "+Z", -1: "-X", -2: "-Y", -3: "-Z"}


def _named(sets: list[dict[str, Any]]) -> dict[str, FloatArray]:
    found: dict[str, FloatArray] = {}
    for k, entry in enumerate(sets, start=1):
        name = f"{int(entry['rsp_node'])}:{_DIRECTIONS.get(int(entry['rsp_dir']), entry['rsp_dir'])}"
        name = f"{name} ({k})" if name in found else name
        values, time = np.asarray(entry["data"]), np.asarray(entry["x"], dtype=np.float64)
        if np.iscomplexobj(values):
            raise ValueError("complex values in a time response")
        if "time" not in found:
            found["time"] = time
        elif not np.array_equal(time, found["time"]):
            found[f"time of {name}"] = time
        found[name] = values.astype(np.float64)
    return found
