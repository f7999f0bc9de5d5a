"""Claims on the slip measurement with a high-speed camera, by simulation: C52 to C55 (Figs 3.20 to 3.22).

The roll has five layers of five wraps with the pressures of windings of 20 N (loose) and 60 N (tight), in a dwell at
its resonance under 5 m/s^2. The targets on wraps 1, 6, 11 and 16 are photographed and read (`camera_images`); the slip
of the whole interfaces is that of the model.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from reproduction.camera_images import FACES, FRAMES, GROUPS, NOISE, PIXEL, photographed
from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.layer_slip import outer_slips
from reproduction.shaker_records import hashes
from reproduction.verdict import Verdict
from reproduction.words import monotone, numbers
from wroll_fem.case.contact import PenaltyFriction
from wroll_fem.plotting import style
from wroll_fem.plotting.study import StudyCase
from wroll_fem.results.interface_slip import surface
from wroll_fem.typing import FloatArray

STUDY = "shaker_slip"
ROLLS = {"slip_20n": "loose, 20 N", "slip_60n": "tight, 60 N"}
"""Case file of a dwell -> name of the roll."""
FACE = math.radians(15.0)
"""Half the angle around an axis that counts as its face."""
REFERENCE = 6
"""Wrap to which the slip of the wraps outside it is related in Fig. 3.22."""


class Seen(NamedTuple):
    """Slip amplitudes of one roll on one face from the images, m, 0-peak.

    `group`, `layer` and `inside` (n,) name the pairs: slip of a layer to the mandrel (0) or to another layer;
    `vertical` and `horizontal` (n,) are the amplitudes; `floor` is the noise floor of a slip.
    """

    group: FloatArray
    layer: FloatArray
    inside: FloatArray
    vertical: FloatArray
    horizontal: FloatArray
    floor: float

    def to_mandrel(self) -> FloatArray:
        """(n,) whether a pair relates a layer to the mandrel."""
        return self.inside == 0

    def over_groups(self, values: FloatArray) -> FloatArray:
        """(groups,) largest value of any layer to the mandrel."""
        own = self.to_mandrel()
        return np.array([values[own & (self.group == g)].max() for g in GROUPS])


def dwells(evidence: Evidence) -> list[StudyCase]:
    """Loose and tight roll."""
    found = {str(m.values["case"]): m for m in evidence.study(STUDY)}
    return [found[name] for name in ROLLS]


def seen(evidence: Evidence) -> list[dict[str, Seen]]:
    """What the camera sees of each roll, by face."""
    rolls = []
    for k, member in enumerate(dwells(evidence)):
        faces = {}
        for j, face in enumerate(FACES):

            def compute(member: StudyCase = member, face: str = face, seed: int = 2 * k + j) -> xr.Dataset:
                return photographed(member.data, face, float(member.data.attrs["frequency_hz"]), seed)

            inputs = {"cases": hashes([member]), "face": face, "groups": list(GROUPS.values()), "noise": NOISE}
            data = evidence.kept(STUDY, compute, **inputs, pixel=PIXEL, frames=FRAMES, seed=2 * k + j)
            size = {str(axis): data["slip_amplitude"].sel(axis=axis).values for axis in ("x", "y")}
            group, layer, inside = (data[f"slip_{name}"].values for name in ("group", "layer", "relative_to"))
            faces[face] = Seen(group, layer, inside, size["y"], size["x"], float(data["floor_m"]))
        rolls.append(faces)
    return rolls


def peak_slip(member: StudyCase) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Angle from the axis (rad, 0 to pi/2), height (m), hoop and axial relative displacement (m) at the mandrel."""
    points = surface(member.data, 0, "peak_slip_hoop", "peak_slip_axial")
    angle = np.abs(points.theta)
    hoop, axial = (np.abs(points.values[name]) for name in ("peak_slip_hoop", "peak_slip_axial"))
    return np.minimum(angle, np.pi - angle), points.z, hoop, axial


def over_height(z: FloatArray, values: FloatArray) -> FloatArray:
    """Largest value at each height, from the base upward."""
    heights = np.unique(np.round(z, 6))
    return np.array([values[np.abs(z - h) < 1e-6].max() for h in heights])


def c52(evidence: Evidence) -> Verdict:
    members, images = dwells(evidence), seen(evidence)
    targets = [1e6 * max(float(f.vertical[f.to_mandrel()].max()) for f in faces.values()) for faces in images]
    across = [1e6 * max(float(f.horizontal[f.to_mandrel()].max()) for f in faces.values()) for faces in images]
    found = [peak_slip(m)[2:] for m in members]
    slip, hoop = ([1e6 * float(part.max()) for part in pair] for pair in (
        [np.hypot(*one) for one in found], [one[0] for one in found]
    ))  # fmt: skip
    at = numbers((float(m.data.attrs["frequency_hz"]) for m in members), "g", " and ")
    value = (
        f"dwells at {at} Hz, 5 m/s^2, 20 and 60 N: targets in the images {numbers(targets, '.1f')} um, horizontally "
        f"{numbers(across, '.1f')} um (noise floor {1e6 * images[0]['axial'].floor:.1f} um); largest relative "
        f"displacement of the whole mandrel {numbers(slip, '.1f')} um, horizontal part {numbers(hoop, '.2f')} um"
    )
    return Verdict(value, max(slip + targets) < 30.0 and max(hoop + across) < 5.0)


def c53(evidence: Evidence) -> Verdict:
    members, (loose, tight) = dwells(evidence), seen(evidence)
    own = loose["axial"].to_mandrel()
    along, across = (1e6 * float(loose[face].vertical[own].max()) for face in FACES)
    horizontal = 1e6 * float(loose["axial"].horizontal[own].max())
    other = 1e6 * float(tight["axial"].vertical[own].max())
    groups = 1e6 * loose["axial"].over_groups(loose["axial"].vertical)
    angle, z, hoop, axial = peak_slip(members[0])
    size = np.hypot(hoop, axial)
    faces = [float(size[angle <= FACE].max()), float(size[angle >= 0.5 * np.pi - FACE].max())]
    friction = evidence.roll("lab_sweep").friction
    assert isinstance(friction, PenaltyFriction)
    profile = over_height(z, size)
    slips = np.where(profile > friction.elastic_slip, profile, 0.0)  # below gamma* it sticks
    few = 1e6 * profile[:: max(1, profile.size // 6)]
    value = (
        f"images, loose (20 N): {along:.1f} um on the axial face, {across:.1f} on the transverse one, horizontal "
        f"{horizontal:.1f} um; groups at 10, 25, 40 mm {numbers(groups, '.1f')} um; tight (60 N) {other:.1f} um; whole "
        f"mandrel, loose: {1e6 * faces[0]:.1f} and {1e6 * faces[1]:.1f} um on the faces, over the height "
        f"{numbers(few, '.1f')} um"
    )
    larger = along > across and along > horizontal and along > other and faces[0] > faces[1]
    lowest = int(groups.argmax()) == 0 and float(z[int(size.argmax())]) <= 0.1 * float(z.max())
    return Verdict(value, larger and lowest and monotone(slips.tolist(), -1))


def c54(evidence: Evidence) -> Verdict:
    """Slip counts as real from twice the noise floor on, as in the thesis (section 3.5) and in `lab slip`."""
    loose, *_ = seen(evidence)
    view = loose["axial"]
    beyond = float(view.vertical[view.inside == REFERENCE].max())
    slips = outer_slips(dwells(evidence)[0])
    value = (
        f"images, 20 N: wraps 11 and 16 move by at most {1e6 * beyond:.2f} um to wrap 6, real from "
        f"{2e6 * view.floor:.2f} um on; interfaces of the model {numbers(1e6 * slips, '.2f')} um, inner first "
        "(sticking ones yield by up to gamma* = 1 um); wrap 6 is the first of the second layer"
    )
    return Verdict(value, beyond < 2.0 * view.floor and bool(slips[1:].max() < 2e-6))


def c55(evidence: Evidence) -> Verdict:
    found = [outer_slips(m) for m in dwells(evidence)]
    said = "; ".join(f"{name}: {numbers(1e6 * s, '.2f')} um" for name, s in zip(ROLLS.values(), found, strict=True))
    value = f"largest relative displacement of each interface, inner first (1 is at the mandrel): {said}"
    return Verdict(value, all(int(s.argmax()) == 0 for s in found))


# ---- figures -------------------------------------------------------------------------------------


def _groups(ax: Axes, floor: float) -> None:
    """Axis of the groups, and the noise floor."""
    ax.axhline(1e6 * floor, color=style.GREY, ls="--", lw=1.0, label="noise floor")
    ax.set_xticks(list(GROUPS), [f"group {g}\n{1e3 * z:g} mm" for g, z in GROUPS.items()])
    ax.set_ylim(bottom=0.0)


def overview_figure(evidence: Evidence) -> Axes:
    """Draw Fig. 3.20: largest slip of each group, axial and transverse face, loose and tight."""
    ax = style.axes(None)
    rolls = seen(evidence)
    largest: dict[str, float] = {}
    for k, (faces, name, colour) in enumerate(zip(rolls, ROLLS.values(), (style.BLUE, style.GREEN), strict=True)):
        for face, mark, line in zip(FACES, "os", ("-", (0, (4, 2))), strict=True):
            view = faces[face]
            size = 1e6 * view.over_groups(np.maximum(view.vertical, view.horizontal))
            largest[f"{name}, {face} face"] = float(size.max())
            x = np.array(list(GROUPS)) + 0.03 * (2 * k + FACES.index(face) - 1.5)
            ax.errorbar(
                x, size, 1e6 * view.floor, color=colour, marker=mark, ls=line, ms=5, lw=1.4, capsize=3,
                label=f"{name}, {face} face",
            )  # fmt: skip
    views = [view for faces in rolls for view in faces.values()]
    top = 1e6 * max(float(view.horizontal[view.to_mandrel()].max()) for view in views)
    ax.axhline(top, color="black", ls=(0, (5, 2)), lw=1.0, label=f"largest horizontal slip, {top:.1f} µm")
    _groups(ax, views[0].floor)
    ax.set_ylabel("Largest slip to the mandrel, 0-peak (µm)")
    ax.legend(fontsize=8, framealpha=0.9)
    where = max(largest, key=lambda name: largest[name])
    style.title(ax, f"Simulated images: the largest slip is {largest[where]:.1f} µm ({where})")
    return ax


def layers_figure(evidence: Evidence) -> Axes:
    """Draw Fig. 3.21: vertical slip of each wrap to the mandrel on the axial face, loose and tight."""
    _, panels = plt.subplots(1, 2, figsize=(style.WIDTH * 1.15, 3.9), dpi=style.DPI, layout="constrained", sharey=True)
    rolls = seen(evidence)
    for ax, faces, name in zip(panels, rolls, ROLLS.values(), strict=True):
        view = faces["axial"]
        _by_layer(style.axes(ax), view, view.to_mandrel())
        _groups(ax, view.floor)
        style.title(ax, f"Simulated images, {name}", 46)
    panels[0].set_ylabel("Vertical slip to the mandrel, 0-peak (µm)")
    panels[0].legend(fontsize=8, framealpha=0.9)
    first: Axes = panels[0]
    return first


def between_figure(evidence: Evidence) -> Axes:
    """Draw Fig. 3.22: vertical slip relative to wrap 6 on the axial face, loose roll."""
    ax = style.axes(None, 3.8)
    view = seen(evidence)[0]["axial"]
    beyond = view.inside == REFERENCE
    _by_layer(ax, view, beyond)
    _groups(ax, view.floor)
    ax.set_ylim(0.0, 2.2e6 * max(view.floor, float(view.vertical[beyond].max())))
    ax.set_ylabel(f"Vertical slip to wrap {REFERENCE}, 0-peak (µm)")
    ax.legend(fontsize=8, framealpha=0.9)
    largest = 1e6 * float(view.vertical[beyond].max())
    style.title(
        ax, f"Simulated images, loose, 20 N: slip beyond wrap {REFERENCE} is at most {largest:.2f} µm, the noise floor "
        f"{1e6 * view.floor:.2f} µm",
    )  # fmt: skip
    return ax


def _by_layer(ax: Axes, view: Seen, chosen: FloatArray) -> None:
    """One line per layer over the groups, with error bars."""
    for k, layer in enumerate(np.unique(view.layer[chosen])):
        own = chosen & (view.layer == layer)
        order = np.argsort(view.group[own])
        x, y = view.group[own][order] + 0.05 * (k - 1), 1e6 * view.vertical[own][order]
        colour, mark = style.LINES[k % len(style.LINES)], "osD^"[k % 4]
        ax.errorbar(x, y, 1e6 * view.floor, color=colour, marker=mark, ms=5, lw=1.2, capsize=2, label=f"wrap {layer:g}")


GROUP = ClaimGroup(
    {"C52": c52, "C53": c53, "C54": c54, "C55": c55},
    figures={
        "ch3_camera_slip": (
            "Fig 3.20 by simulation: largest slip to the mandrel per group, from images",
            overview_figure,
        ),
        "ch3_camera_slip_layers": (
            "Fig 3.21 by simulation: vertical slip per wrap, loose and tight, from images",
            layers_figure,
        ),
        "ch3_camera_slip_between": ("Fig 3.22 by simulation: slip relative to wrap 6, from images", between_figure),
    },
    studies=(STUDY,),
)
