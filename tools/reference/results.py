"""Reference of the results of a run: entries of summary.json and variables of results.nc."""

from __future__ import annotations

from tools.reference.markdown import GENERATED, code, prose, table
from wroll_fem.results.fields import AXES, FIELDS
from wroll_fem.results.lab.tables import LAB_FIELDS
from wroll_fem.results.summary import GROUPS, Entry, label

_INTRO = """# Results

A run folder holds

| file | contents |
|---|---|
| `case.yaml` | the case with all defaults filled in |
| `summary.json` | the numbers of the table below: flat, SI, the unit in the name |
| `results.nc` | NetCDF of all curves and fields, `units` and `long_name` on each; `wf.load_result` reads it |
| `fields/*.vtu` | slip maps, mode shapes, stress points, for ParaView or pyvista |
| `figures/*.png` | figures of the analysis |
| `run.log` | progress and warnings |
| `.lock` | empty; locked while a process works in the folder |
| `provenance.json` | versions, machine, command, wall time |
| `checkpoint*` | during a sweep or dwell: state from which `--resume` continues |

`wroll lab` writes `settings.yaml` in place of `case.yaml`; its `provenance.json` has the SHA-256 of each input.

A batch adds `batch.csv` and `batch.nc`, one row per case. Amplitudes are 0-peak. Lists run over interfaces or layers
(inner first), over modes, or over the levels of the case; `null` means that there is no value.
"""

_GROUPS = (
    ("Axes and places", ("time", "area")),
    ("Histories", ("base_acceleration", "slipping_fraction")),
    ("Energies, cumulative from the start of the motion", ("input_work", "numerical_dissipation")),
    ("Interfaces", ("cumulative_slip", "relative_displacement_axial")),
    ("Curves over frequency", ("transmissibility_real", "transmissibility_spectrum_magnitude")),
    ("Periodic motions", ("branch_point", "memory_change")),
    ("Modes", ("mode_frequency", "solid_cell_nodes")),
    ("Solid coil under a steady sine", ("amplitude_g", "slip_zone_depth")),
    ("The wound roll", ("r", "wrap_hoop_stress_pa")),
    ("Map of mandrels", ("mandrel_radius", "limit_kind")),
    ("Two masses", ("omega", "capacity_at_zeta_max")),
)
"""Heading, first and last name of each group in `FIELDS`; the remaining names form the last
group before those of the laboratory."""


def results_page() -> str:
    """Markdown of run folder, summary.json and results.nc."""
    parts = [GENERATED, _INTRO, "## summary.json"]
    for heading, entries in GROUPS.items():
        rows = ((code(name), entry.unit, _words(name, entry)) for name, entry in entries.items())
        parts += [f"### {heading}", table(("name", "unit", "meaning"), rows)]
    parts += [
        "## results.nc",
        "One Dataset per run, with those of these variables that its analysis has; complex curves as real and "
        "imaginary parts.",
    ]
    for heading, fields in _grouped():
        rows = ((code(name), _unit(FIELDS[name].units), prose(FIELDS[name].long_name)) for name in fields)
        parts += [f"### {heading}", table(("variable", "unit", "meaning"), rows)]
    rows = ((code(name), entry.units, prose(entry.long_name)) for name, entry in AXES.items())
    parts += ["### Axes with a meaning of their own", table(("axis", "unit", "meaning"), rows)]
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _words(name: str, entry: Entry) -> str:
    words = label(name)
    return prose(f"{words}: {entry.sentence}" if entry.sentence else words)


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _grouped() -> list[tuple[str, list[str]]]:
    names, groups, at = list(FIELDS), [], 0
    for heading, (_, last) in _GROUPS:
        end = names.index(last) + 1
        groups.append((heading, names[at:end]))
        at = end
    lab = {name for fields in LAB_FIELDS.values() for name in fields}
    rest = [name for name in names[at:] if name not in lab]
    return [*groups, ("Statics and others", rest), *((head, list(fields)) for head, fields in LAB_FIELDS.items())]
