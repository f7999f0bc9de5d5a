"""Fields of a matrix file for the damping ratios of modes (`ModalDamping`)."""

from __future__ import annotations

from typing import Any

import numpy as np

from wroll_fem.dynamics.system.array_file import ArrayFile
from wroll_fem.dynamics.system.modal_damping import ModalDamping

DAMPING_FIELDS = ("damping_ratios", "damping_table", "damping_loss")


def damping_content(damping: ModalDamping) -> dict[str, Any]:
    """Fields that describe ``damping``."""
    if damping.loss is not None:
        return {"damping_loss": damping.loss}
    name = "damping_table" if damping.table else "damping_ratios"
    return {name: np.array(damping.table or damping.ratios)}


def read_damping(file: ArrayFile, n: int) -> ModalDamping | None:
    """Damping ratios of the modes in ``file``, of a system with ``n`` degrees of freedom; None without them.

    Raises
    ------
    InputError
        If a field is wrong, or if several of `DAMPING_FIELDS` are in the file.
    """
    given = [name for name in DAMPING_FIELDS if name in file]
    if not given:
        return None
    (name, *others) = given
    if others:
        raise file.error(f"is given beside {others[0]}", key=name, remedy="keep one of them")
    if name == "damping_loss":
        loss = file.matrix(name, (n, n), "sum of the stiffness matrices times their loss factors, N/m")
        if loss.nnz and (abs(loss - loss.T).max() > 1e-9 * abs(loss).max() or loss.diagonal().min() < 0.0):
            raise file.error("is not symmetric with a positive diagonal", key=name, remedy="sum loss factor times K")
        return ModalDamping(loss=loss)
    if name == "damping_table":
        table = file.matrix(name, (None, 2), "rows of frequency, Hz, and damping ratio").toarray()
        if np.any(table < 0.0) or np.any(np.diff(table[:, 0]) <= 0.0):
            raise file.error("has negative numbers, or frequencies that do not rise", key=name, remedy="sort its rows")
        return ModalDamping(table=tuple((float(at), float(ratio)) for at, ratio in table))
    ratios = file.vector(name, None, "damping ratios of natural frequencies 1, 2, ...")
    if not ratios.size or ratios.min() < 0.0:
        raise file.error("is empty or negative", key=name, remedy="give ratios from 0 on, such as 0.01")
    return ModalDamping(ratios=tuple(float(ratio) for ratio in ratios))
