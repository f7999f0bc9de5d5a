"""Result of a run: Dataset, summary and figures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wroll_fem import api
from wroll_fem.api import ShowProgress
from wroll_fem.case import Case

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["Result", "ShowProgress", "run_case"]


def run_case(case: Case, *, out: str | Path | None = None, progress: ShowProgress = None) -> Result:
    """Run a case and return its `Result`; parameters and errors as for `wroll_fem.run`."""
    return Result(api.run(case, out=out, progress=progress))


class Result:
    """Result of a run: its Dataset, with summary and figures as attributes and methods.

    Parameters
    ----------
    data
        Dataset of a run, from `wroll_fem.run` or `wroll_fem.load_result`.

    Attributes
    ----------
    data
        xarray.Dataset with `units` and `long_name` on every variable.
    """

    def __init__(self, data: xr.Dataset) -> None:
        self.data = data
        self._summary: dict[str, Any] | None = None

    @classmethod
    def load(cls, path: str | Path) -> Result:
        """Read a result from a run folder, or from a file written by `save`.

        Raises
        ------
        InputError
            If there are no results.
        """
        return cls(api.load_result(path))

    def __repr__(self) -> str:
        numbers = ("f_n_hz", "zeta", "peak_transmissibility")
        known = [f"{name}={self.summary[name]:.4g}" for name in numbers if self.summary.get(name) is not None]
        return f"<Result of {', '.join([str(self.summary['analysis']), *known])}>"

    @property
    def summary(self) -> Mapping[str, Any]:
        """Entries of summary.json: flat, in SI, with units in the names."""
        if self._summary is None:
            self._summary = api.summarise(self.data)
        return self._summary

    @property
    def case(self) -> Case:
        """Case from which the result was computed."""
        return api.case_of(self.data)

    @property
    def f_n_hz(self) -> float | None:
        """Resonance frequency in Hz; None if the analysis does not estimate it."""
        return self.summary.get("f_n_hz")

    @property
    def zeta(self) -> float | None:
        """Damping ratio, dimensionless; None if the analysis does not estimate it, or if the estimate is invalid."""
        return self.summary.get("zeta")

    @property
    def zeta_quality(self) -> str | None:
        """Quality of the damping ratio: ok, doubtful or invalid; None if the analysis does not judge it."""
        return self.summary.get("zeta_quality")

    @property
    def peak_transmissibility(self) -> float | None:
        """Largest transmissibility, dimensionless; None if the analysis does not compute it."""
        return self.summary.get("peak_transmissibility")

    @property
    def transmissibility(self) -> xr.DataArray:
        """Transmissibility |T| versus frequency in Hz.

        Raises
        ------
        InputError
            If the analysis does not compute it.
        """
        return api.transmissibility(self.data)

    def save(self, path: str | Path) -> Path:
        """Write the Dataset as NetCDF; `load` reads it."""
        from wroll_fem.results.dataset import save_dataset

        return save_dataset(self.data, path)

    def plot_transmissibility(self, ax: Axes | None = None) -> Axes:
        """Draw the transmissibility versus frequency, with f_n and the half-power points."""
        return self._plot("transmissibility", ax)

    def plot_harmonic_response(self, ax: Axes | None = None) -> Axes:
        """Draw the steady response versus frequency."""
        return self._plot("harmonic_response", ax)

    def plot_hysteresis(self, ax: Axes | None = None) -> Axes:
        """Draw force versus relative displacement of the joints at the peak of a steady response."""
        return self._plot("hysteresis", ax)

    def plot_backbone(self, ax: Axes | None = None) -> Axes:
        """Draw frequency and damping versus the amplitude of the tip."""
        return self._plot("backbone", ax)

    def plot_response(self, ax: Axes | None = None) -> Axes:
        """Draw the acceleration of the tip versus time."""
        return self._plot("response", ax)

    def plot_energy_ledger(self, ax: Axes | None = None) -> Axes:
        """Draw input work, stored energy and losses versus time."""
        return self._plot("energy_ledger", ax)

    def plot_modes(self, ax: Axes | None = None) -> Axes:
        """Draw the natural frequencies by kind of mode."""
        return self._plot("modes", ax)

    def plot_slip_map(self, ax: Axes | None = None, **options: Any) -> Axes:
        """Draw the slip of an interface versus angle and height."""
        return self._plot("slip_map", ax, **options)

    def plot_pressure_map(self, ax: Axes | None = None, **options: Any) -> Axes:
        """Draw the pressure of an interface versus angle and height."""
        return self._plot("pressure_map", ax, **options)

    def plot_winding(self, ax: Axes | None = None) -> Axes:
        """Draw pressure, friction capacity and hoop stress versus the radius of the wound roll."""
        return self._plot("winding", ax)

    def plot_steady_response(self, ax: Axes | None = None) -> Axes:
        """Draw the tip motion of a roll with solid coil from rest to steady state."""
        return self._plot("steady_response", ax)

    def plot_design_map(self, ax: Axes | None = None) -> Axes:
        """Draw the difference of the bending frequency between the stiffest and the softest coil for each mandrel.

        The horizontal axis is the radius of the mandrel. There is one line per wall thickness.
        """
        return self._plot("design_map", ax)

    def plot(self, figure: str, *args: Any, **options: Any) -> Any:
        """Draw any figure of `wroll_fem.plot` by its name.

        Raises
        ------
        InputError
            If the result lacks data for the figure.
        """
        from wroll_fem.plotting import names

        return getattr(names, figure)(self.data, *args, **options)

    def _plot(self, figure: str, ax: Axes | None, **options: Any) -> Axes:
        drawn: Axes = self.plot(figure, **options, **({} if ax is None else {"ax": ax}))
        return drawn
