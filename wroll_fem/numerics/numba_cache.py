"""Removal of stale entries from numba's cache on disk."""

from __future__ import annotations

from pathlib import Path

CONTACT = Path(__file__).parents[1] / "contact"


def drop_stale_cache(module: str | Path, *inlined: str | Path, laws: Path = CONTACT) -> list[Path]:
    """Remove the cached functions of a module that are older than the code inlined in them.

    numba checks only the file of the function itself. Without this removal, a change of a contact law would have no
    effect. Call ``drop_stale_cache(__file__)`` at the top of every module whose compiled functions call functions of
    other modules, before they are defined.

    Parameters
    ----------
    module
        The module's ``__file__``.
    inlined
        Files of other modules that contain compiled functions called by the module.
    laws
        Folder of the contact laws. The age of all its files is checked too.

    Returns
    -------
    list of Path
        Cache indices that were removed; numba compiles their functions again.
    """
    module = Path(module)
    changed = max(path.stat().st_mtime for path in (*map(Path, inlined), *laws.glob("*.py")))
    indices = (module.parent / "__pycache__").glob(f"{module.stem}.*.nbi")
    stale = [index for index in indices if _older(index, changed)]
    for index in stale:
        index.unlink(missing_ok=True)
    return stale


def _older(path: Path, time: float) -> bool:
    """Whether a file is older than ``time``; False if another process has removed it meanwhile."""
    try:
        return path.stat().st_mtime < time
    except FileNotFoundError:
        return False
