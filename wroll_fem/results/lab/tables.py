"""Tables of the results of laboratory evaluations, collected from the files of their kinds."""

from __future__ import annotations

from wroll_fem.results.entry import Entry, Field
from wroll_fem.results.lab import fit, friction, shear, slip_images, tension, transmissibility

LAB_ENTRIES: dict[str, dict[str, Entry]] = {
    "Every evaluation of the laboratory": {
        "evaluation": Entry("", "evaluation", "kind of the evaluation, as in `wroll lab KIND`"),
        "files": Entry("", "number of input files", "", "number"),
    },
    "Laboratory: transmissibility": transmissibility.ENTRIES,
    "Laboratory: fit": fit.ENTRIES,
    "Laboratory: slip from images": slip_images.ENTRIES,
    "Laboratory: shear": shear.ENTRIES,
    "Laboratory: friction": friction.ENTRIES,
    "Laboratory: tension": tension.ENTRIES,
}
"""Heading -> name in summary.json -> entry; a kind may also use names of other groups."""

LAB_FIELDS: dict[str, dict[str, Field]] = {
    "Laboratory: transmissibility": transmissibility.FIELDS,
    "Laboratory: fit": fit.FIELDS,
    "Laboratory: slip from images": slip_images.FIELDS,
    "Laboratory: shear": shear.FIELDS,
    "Laboratory: friction": friction.FIELDS,
    "Laboratory: tension": tension.FIELDS,
}
"""Heading -> name in results.nc -> unit and label; a kind may also use names of `results.fields`."""
