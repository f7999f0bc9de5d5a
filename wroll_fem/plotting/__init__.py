"""Figures from Datasets only.

`wroll_fem.plot` (the module `names`) is the one set of public names. Every function of matplotlib takes a Dataset and
an `ax` and returns the `ax`; nothing is shown or computed again. Pictures in space write a file (those of modes and
coils by pyvista).
"""

from __future__ import annotations


def __getattr__(name: str) -> object:
    """Old spelling: `plotting.plot_slip_map` for `wroll_fem.plot.slip_map`."""
    if name.startswith("plot_") or name in ("save_figure", "write_slip_vtu"):
        from wroll_fem.plotting import names

        return getattr(names, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
