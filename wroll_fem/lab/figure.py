"""Figure of a laboratory evaluation: the function that draws it, imported on use."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes


class Figure(NamedTuple):
    """Figure of a kind.

    Attributes
    ----------
    function
        "module:function"; the function takes the Dataset and, as keyword, `ax`, and returns the axes. The module is
        imported when the figure is drawn.
    needs
        Variable that the figure needs; without it, the figure is not drawn.
    """

    function: str
    needs: str = ""

    def draw(self, data: xr.Dataset, ax: Axes | None = None) -> Axes:
        """Draw the figure, in ``ax`` if it is given."""
        module, _, name = self.function.partition(":")
        drawn: Axes = getattr(import_module(module), name)(data, **({} if ax is None else {"ax": ax}))
        return drawn
