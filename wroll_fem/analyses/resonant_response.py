"""Resonance of a backbone with the other modes of its structure, and its response to a random base acceleration."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr

from wroll_fem.dynamics.periodic.backbone import BackboneCurve
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.signals.averaging.amplitude_process import AmplitudeDensity, Density, NonlinearMode, amplitude_density
from wroll_fem.signals.averaging.averaged_spectrum import LinearModes, ResponseSpectra, frequency_axis, response_spectra
from wroll_fem.signals.random.psd import PsdTable

WIDE, LEAST = 10.0, 1e-6
"""Modes up to `WIDE` times the highest frequency of the PSD with a participation at the tip above `LEAST` are kept; the
static deflection of all others is one mode at this frequency."""


@dataclass(frozen=True)
class Resonance:
    """Backbone of the main mode, and the other modes with their interfaces stuck.

    Attributes
    ----------
    mode : backbone of the main mode
    others : other modes
    rigid : displacement of the tip per displacement of the base in rigid-body motion
    """

    mode: NonlinearMode
    others: LinearModes
    rigid: float = 1.0

    @classmethod
    def of_curve(cls, curve: BackboneCurve, highest_hz: float) -> Resonance:
        """Resonance of a computed backbone; ``highest_hz`` is the highest frequency of the PSD, Hz."""
        model = curve.balance.model
        condensation, number = model.condensation, curve.problem.mode
        sign = float(np.sign(model.base[number] * model.tip[number])) or 1.0
        action = np.sum(curve.balance.orders[:, None] ** 2 * curve.coefficients**2, axis=(1, 2))
        mode = NonlinearMode(
            curve.frequencies, curve.damping, 0.5 * curve.frequencies**2 * action, curve.fundamental(model.base),
            sign * curve.tip,
        )  # fmt: skip
        natural = float(np.sqrt(model.eigenvalues[number]))
        return cls(mode, other_modes(condensation, natural, 2.0 * np.pi * WIDE * highest_hz), condensation.rigid_tip)

    @classmethod
    def of_dataset(cls, dataset: xr.Dataset) -> Resonance:
        """Resonance that the result of a run contains."""
        hertz = 2.0 * np.pi
        mode = NonlinearMode(
            hertz * dataset["resonance_frequency"].values, dataset["modal_damping"].values,
            dataset["kinetic_energy_amplitude"].values, dataset["mass_displacement_amplitude"].values,
            dataset["tip_amplitude"].values * dataset.attrs["tip_sign"],
        )  # fmt: skip
        others = LinearModes(
            hertz * dataset["other_frequency"].values, dataset["other_damping"].values,
            dataset["other_participation"].values,
        )  # fmt: skip
        return cls(mode, others, float(dataset.attrs["rigid_tip"]))

    def stored(self, backbone: xr.Dataset) -> xr.Dataset:
        """Dataset of the backbone with the other modes, from which `of_dataset` restores the resonance."""
        dim, others = "other_mode", self.others
        return backbone.assign(
            other_frequency=(dim, others.frequency / (2.0 * np.pi)),
            other_damping=(dim, others.damping),
            other_participation=(dim, others.participation),
        ).assign_attrs(tip_sign=float(np.sign(self.mode.tip[0])), rigid_tip=self.rigid)

    def law(self, table: PsdTable, factor: float = 1.0) -> AmplitudeDensity:
        """Stationary density of the amplitude of the main mode under ``factor`` times a PSD."""
        return amplitude_density(self.mode, scaled(table, factor), largest=factor * largest_density(table))


def other_modes(condensation: Condensation, main: float, highest: float) -> LinearModes:
    """Modes beside the one at the frequency ``main`` that reach the tip; frequencies in rad/s, up to ``highest``."""
    values = condensation.eigenvalues
    natural = np.sqrt(np.maximum(values, 1e-300))
    share = condensation.base * condensation.tip
    close = np.abs(natural / main - 1.0) < 1e-3
    number = int(np.argmax(np.where(close, np.abs(share), -1.0)))
    share = np.where(np.arange(len(share)) == number, 0.0, share)
    kept = (np.abs(share) > LEAST) & (natural < highest)
    rates = np.concatenate([c if c.ndim == 1 else np.diag(c) for c in condensation.damping] or [np.zeros(len(values))])
    rest = float(np.sum(share[~kept & (values > 0.0)] / values[~kept & (values > 0.0)]))
    return LinearModes(
        np.append(natural[kept], highest), np.append(0.5 * rates[kept] / natural[kept], 0.0),
        np.append(share[kept], rest * highest**2),
    )  # fmt: skip


def scaled(table: PsdTable, factor: float) -> Density:
    """PSD of a table times a factor, as a function of the frequency in Hz."""
    return lambda frequency: factor * table.density(frequency)


def at_level(table: PsdTable, factor: float) -> PsdTable:
    """Table of a base acceleration that is multiplied by ``factor``."""
    return PsdTable.of(table.frequency, factor**2 * np.array(table.g2_per_hz))


def largest_density(table: PsdTable) -> float:
    """Largest density of a table, (m/s^2)^2/Hz."""
    return float(table.density(table.frequency).max())


@dataclass(frozen=True)
class Response:
    """Response of a resonance to a random base acceleration.

    Attributes
    ----------
    law : stationary density of the amplitude
    spectra : spectra of base and tip
    base_rms : rms of the base acceleration, m/s^2
    """

    law: AmplitudeDensity
    spectra: ResponseSpectra
    base_rms: float

    @classmethod
    def of(cls, resonance: Resonance, table: PsdTable, factor: float = 1.0) -> Response:
        """Averaged response of the main mode to ``factor`` times a PSD, with the linear response of the others."""
        law = resonance.law(table, factor)
        axis = frequency_axis(law, table.band, np.array(table.frequency), resonance.others)
        spectra = response_spectra(law, scaled(table, factor), axis, resonance.others, rigid=resonance.rigid)
        return cls(law, spectra, float(np.sqrt(factor)) * table.rms)

    @cached_property
    def displacement_rms(self) -> float:
        """Rms of the displacement of the tip relative to the base, m."""
        return self.spectra.rms("displacement")

    @cached_property
    def acceleration_rms(self) -> float:
        """Rms of the absolute acceleration of the tip, m/s^2."""
        return self.spectra.rms("acceleration")
