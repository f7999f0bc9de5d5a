"""Material damping of a case: dashpots of its system."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.body import Body
from wroll_fem.case.coil import Coil
from wroll_fem.case.damping import LossFactor
from wroll_fem.case.mandrel import Mandrel
from wroll_fem.case.material import LaminateMaterial, PlySection
from wroll_fem.case.structural import OnRoll, StructuralCase
from wroll_fem.dynamics.system.modal_damping import ModalDamping
from wroll_fem.dynamics.system.system import System
from wroll_fem.typing import FloatArray

_Owner = TypeVar("_Owner", Mandrel, Coil, PlySection)

LEAST_FACTOR = 1e-12
"""Loss factor in place of zero for one of the materials of a solid coil, relative to that of the other material."""


def with_damping(case: StructuralCase, system: System, bodies: Sequence[Body] = ()) -> System:
    """System with the dashpots of the section `damping`, in addition to those of a matrix file.

    Parameters
    ----------
    system
        Without the stiffness of bonds and of the preload: these have no loss.
    bodies
        Bodies of a roll, inner first; empty for matrices from a file.
    """
    damping = case.damping
    if damping is None:
        return system
    if damping.rayleigh is not None:
        added = damping.rayleigh.alpha * system.mass + damping.rayleigh.beta * system.stiffness
        given = added if system.damping is None else system.damping + added
        return replace(system, damping=sp.csr_matrix(given))
    if damping.loss_factor is None:
        return replace(system, modal_damping=ModalDamping(damping.ratios, damping.table))
    loss = _loss(case.expect(OnRoll), damping.loss_factor, bodies)
    return replace(system, modal_damping=ModalDamping(loss=loss))


def mode_ratios(system: System, eigenvalues: FloatArray, vectors: FloatArray) -> dict[str, tuple[str, FloatArray]]:
    """Variable `mode_damping_ratio`: damping ratio of each mode; empty without damping.

    Parameters
    ----------
    eigenvalues, vectors
        (k,) rad^2/s^2 and (n_dofs, k), at modal mass 1; the lowest k modes.
    """
    found = np.zeros(len(eigenvalues))
    damping, modal = system.damping, system.modal_damping
    if damping is None and modal is None:
        return {}
    if damping is not None:
        rates = np.einsum("ij,ij->j", vectors, damping @ vectors)
        found += 0.5 * rates / np.sqrt(np.where(eigenvalues > 0.0, eigenvalues, np.inf))
    if modal is not None:
        losses = None if modal.loss is None else np.einsum("ij,ij->j", vectors, modal.loss @ vectors)
        found += modal.of_modes(eigenvalues, losses)
    return {"mode_damping_ratio": ("mode", found)}


def _loss(case: OnRoll, factor: LossFactor, bodies: Sequence[Body]) -> sp.csr_matrix:
    """Sum of the stiffness matrices of mandrel and coil, each times its loss factor."""
    if case.coil.model != "solid":
        parts = [body.stiffness * (factor.coil if k else factor.mandrel) for k, body in enumerate(bodies)]
        return sp.block_diag(parts, format="csr")
    from wroll_fem.fem.body import assemble_bodies

    symmetric = bodies[0].symmetric
    least = LEAST_FACTOR * max(factor.mandrel, factor.coil)
    scaled = case.model_copy(
        update={
            "mandrel": _scaled(case.mandrel, max(factor.mandrel, least)),
            "coil": _scaled(case.coil, max(factor.coil, least)),
        }
    )
    return sp.block_diag([body.stiffness for body in assemble_bodies(scaled, symmetric=symmetric)], format="csr")


def _scaled(section: _Owner, factor: float) -> _Owner:
    """Section (mandrel, coil, ply) with the elastic moduli of its material times ``factor``."""
    material = section.material
    scaled = {name: factor * getattr(material, name) for name in type(material).model_fields if name[0] in "EG"}
    if isinstance(material, LaminateMaterial):
        scaled = {"plies": [_scaled(ply, factor) for ply in material.plies]}
    return section.model_copy(update={"material": material.model_copy(update=scaled)})
