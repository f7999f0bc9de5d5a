"""Cache of compiled loops on disk: stale entries are dropped."""

from __future__ import annotations

from pathlib import Path

CONTACT = Path(__file__).parents[1] / "contact"


def drop_stale_cache(module: str | Path, *inlined: str | Path, laws: Path = CONTACT) -> list[Path]:
    """Remove numba's cache indices of a module where they are older than code that it inlines.

    numba compares the file of the function alone, so a change of the contact laws would otherwise have no effect.
    Call it at the top of every module with compiled functions that call others', before they are defined:
    ``drop_stale_cache(__file__)``.

    Parameters
    ----------
    module
        The module's ``__file__``.
    inlined
        Files of further modules whose compiled functions it calls.
    laws
        Folder of the contact laws; all its files count as inlined.

    Returns
    -------
    list of Path
        The indices removed; numba compiles these functions again and writes new ones.
    """
    module = Path(module)
    changed = max(path.stat().st_mtime for path in (*map(Path, inlined), *laws.glob("*.py")))
    indices = (module.parent / "__pycache__").glob(f"{module.stem}.*.nbi")
    stale = [index for index in indices if index.stat().st_mtime < changed]
    for index in stale:
        index.unlink(missing_ok=True)
    return stale
