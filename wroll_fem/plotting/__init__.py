"""Figures of the Datasets that analyses return.

`wroll_fem.plot` (the module `names`) holds the public functions. Functions based on matplotlib take a Dataset and an
`ax` and return the `ax`. They open no window and repeat no computation. Three-dimensional pictures are written to a
file (mode shapes and coils by pyvista).
"""

from __future__ import annotations


def __getattr__(name: str) -> object:
    """Resolve old names such as `plotting.plot_slip_map`, which is now `wroll_fem.plot.slip_map`."""
    if name.startswith("plot_") or name in ("save_figure", "write_slip_vtu"):
        from wroll_fem.plotting import names

        return getattr(names, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
