"""Run folder with synthetic results, and the parts of its report."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest
import xarray as xr

from support import synthetic_roll
from support.paths import ROOT
from wroll_fem import analyses, load_case
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.jobs.run import run_case

SWEEP = ROOT / "configs" / "lab_sweep.yaml"
NASTY = "<script>alert('1')</script> & \"quoted\" \x07"


def with_modulation(data: xr.Dataset) -> xr.Dataset:
    """The synthetic roll's stick stiffness does not depend on the pressure."""
    return data.assign(pressure_modulation_work=0.0 * data["friction_energy"])


def synthetic_run(out: Path, *overrides: str) -> RunFolder:
    """Run folder as `wroll run` leaves it, with a synthetic roll's results in place of finite elements."""
    data = with_modulation(synthetic_roll.sweep())
    data.attrs |= {"f_n_hz": 148.25, "zeta": 0.0123, "zeta_method": "half power", "half_power_reason": "just a remark"}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(analyses, "run_analysis", lambda case, **_: data)
        return run_case(load_case(SWEEP, overrides), out, command="wroll run lab_sweep.yaml").folder


def parsed(file: Path) -> ElementTree.Element:
    """Root of the file, which must be well-formed even as XML."""
    return ElementTree.fromstring(file.read_text(encoding="utf-8"))


def section(root: ElementTree.Element, heading: str) -> ElementTree.Element:
    return next(s for s in root.iter("section") if s.findtext("h2") == heading)


def words(element: ElementTree.Element) -> str:
    return " ".join("".join(element.itertext()).split())


def rows(element: ElementTree.Element) -> dict[str, list[str]]:
    """First cell -> the others, of every table inside."""
    lines = [[words(cell) for cell in line] for body in element.iter("tbody") for line in body]
    return {line[0]: line[1:] for line in lines}
