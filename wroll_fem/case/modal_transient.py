"""What `analysis: modal_transient` asks of a case beyond single keys."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wroll_fem.case.base import wrong

if TYPE_CHECKING:
    from wroll_fem.case.case import Case


def damping_ratio_fits(case: Case) -> None:
    """`damping_ratio` belongs to the analyses in modes, and there it has no default."""
    wanted = case.analysis == "modal_transient"
    if wanted and case.damping_ratio is None:
        raise wrong(
            "required key is missing", key="damping_ratio", show_value=False,
            remedy="add it (share of critical damping of every mode; the source takes 0.02)",
        )  # fmt: skip
    if not wanted and case.damping_ratio is not None:
        raise wrong(
            f"analysis {case.analysis} has no modal damping", key="damping_ratio", value=case.damping_ratio,
            remedy="leave it out, or use analysis: modal_transient",
        )  # fmt: skip


def solid_coil(case: Case) -> None:
    """Shear stress is recovered in a solid coil alone."""
    if case.analysis != "modal_transient":
        return
    if case.structure is not None:
        raise wrong(
            "holds matrices alone, without stresses", key="structure", show_value=False,
            remedy="describe the roll by geometry, mandrel and coil",
        )  # fmt: skip
    if case.coil.model != "solid":
        raise wrong(
            "analysis modal_transient recovers the stress of a solid coil", key="coil.model", value=case.coil.model,
            remedy="use coil.model: solid; for layers use analysis: dwell",
        )  # fmt: skip
