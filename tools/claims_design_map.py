"""Judge claims C26 and C27 of the source (section 2.5, Fig. 2.16) and draw the map of mandrels.

`.venv/bin/python tools/claims_design_map.py` prints one line per claim, writes its tables into docs/design-map.md and
the figure into docs/figures. About four minutes on one core: the 8 x 8 map of configs/design_map.yaml, and 3 x 3 of it
with other inputs where the source leaves them open.
"""

from __future__ import annotations

import os
import re
import time

os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import xarray as xr
from chapter4_runs import ROOT, Verdict

from wroll_fem.analyses import run_analysis
from wroll_fem.case import load_case
from wroll_fem.plotting import plot_design_map, save_figure
from wroll_fem.progress import SilentProgress

DOCS = ROOT / "docs"
NINE = ("design_map.mandrel_radius=[0.020, 0.035, 0.050]", "design_map.mandrel_thickness=[1.0e-3, 2.0e-3, 3.2e-3]")
ALUMINIUM = ("mandrel.material.E=70.0e9", "mandrel.material.nu=0.33", "mandrel.material.rho=2700")
SOFT = tuple(
    f"coil.material.{key}={value}"
    for key, value in (
        ("E_theta", 2.5e9), ("E_z", 2.5e9), ("G_z_theta", 0.9259e9), ("G_r_theta", 0.9259e9), ("G_r_z", 0.9259e9),
    )
)  # fmt: skip
OTHERS = {
    "as shipped": (),
    "tip mass of 0.05 kg": ("mandrel.tip_mass=0.05",),
    "Kapton of 2.5 GPa": SOFT,
    "coil clamped at its base": ("coil.base=clamped",),
    "loosest coil of 10 kPa everywhere": ("design_map.loosest=1.0e4",),
    "loosest coil of 1 MPa everywhere": ("design_map.loosest=1.0e6",),
    "finer (axial 16, radial 3)": ("mesh.axial=16", "mesh.radial=3"),
    "aluminium mandrel": ALUMINIUM,
}
"""Words -> changes of configs/design_map.yaml."""


def designs(*overrides: str) -> xr.Dataset:
    case = load_case(ROOT / "configs" / "design_map.yaml", overrides)
    return run_analysis(case, progress=SilentProgress())


def disparity(data: xr.Dataset) -> np.ndarray:
    return np.asarray(data["frequency_disparity"].transpose("mandrel_radius", "mandrel_thickness").values)


def monotone(values: np.ndarray) -> tuple[bool, bool]:
    """Grows with the radius, grows with a thinner wall; false where a mandrel has none."""
    return bool((np.diff(values, axis=0) > 0).all()), bool((np.diff(values, axis=1) < 0).all())


def c26(whole: xr.Dataset, nine: dict[str, xr.Dataset]) -> Verdict:
    values = disparity(whole)
    said = f"8 x 8: {values.min():.1f} to {values.max():.1f} Hz; the mandrel that was built (40 mm, 1.6 mm) "
    said += f"{whole.attrs['own_frequency_tightest'] - whole.attrs['own_frequency_loosest']:.1f} Hz; "
    small = disparity(nine["as shipped"])
    said += "3 x 3: " + " / ".join(", ".join(f"{v:.1f}" for v in row) for row in small)
    said += " Hz (radius 20 / 35 / 50 mm; wall 1, 2, 3.2 mm)"
    return Verdict(said, all(monotone(small)) and all(monotone(values)))


def c27(nine: dict[str, xr.Dataset]) -> Verdict:
    relative = {
        name: disparity(nine[words]) / nine[words]["frequency_mandrel"].values
        for name, words in (("polycarbonate", "as shipped"), ("aluminium", "aluminium mandrel"))
    }
    said = "; ".join(
        f"{name} " + " / ".join(", ".join(f"{100 * v:.1f}" for v in row) for row in values) + " %"
        for name, values in relative.items()
    )
    lower = bool((relative["polycarbonate"] > relative["aluminium"]).all())
    thinner = all(bool((np.diff(values, axis=1) < 0).all()) for values in relative.values())
    return Verdict(f"disparity over mandrel frequency, same grid: {said}", lower and thinner)


def variants(nine: dict[str, xr.Dataset]) -> list[str]:
    mandrels = "disparity, Hz: radius 20 mm, wall 3.2 mm | 35 mm, 2 mm | 50 mm, 1 mm | 40 mm, 1.6 mm"
    rows = [f"| inputs | {mandrels} | grows with radius; thinner wall |", "|---|---|---|---|---|---|"]
    for words, data in nine.items():
        values, attrs = disparity(data), data.attrs
        own = attrs["own_frequency_tightest"] - attrs["own_frequency_loosest"]
        shown = [f"{v:.1f}" if np.isfinite(v) else "none" for v in (values[0, 2], values[1, 1], values[2, 0], own)]
        trend = "; ".join("yes" if grows else "no" for grows in monotone(values))
        rows.append(f"| {words} | {' | '.join(shown)} | {trend} |")
    return rows


def put(text: str, name: str, rows: list[str]) -> str:
    """Text with the rows between the page's comments `name` and `end of name`."""
    block = f"<!-- {name} -->\n" + "\n".join(rows) + f"\n<!-- end of {name} -->"
    return re.sub(rf"<!-- {name} -->.*<!-- end of {name} -->", lambda _: block, text, flags=re.DOTALL)


def main() -> None:
    started = time.process_time()
    whole = designs()
    print(f"8 x 8 map: {time.process_time() - started:.0f} s of one core")
    nine = {words: designs(*NINE, *changes) for words, changes in OTHERS.items()}
    rows = ["| id | the source says | computed here | verdict |", "|---|---|---|---|"]
    for name, said, verdict in (
        ("C26", "the disparity grows with the mandrel's radius and with a thinner wall", c26(whole, nine)),
        ("C27", "low modulus and thin wall are the most sensitive", c27(nine)),
    ):
        print(f"{name:<5} {verdict.text():<24} {verdict.value}")
        rows.append(f"| {name} | {said} | {verdict.value} | **{verdict.text()}** |")
    print(save_figure(plot_design_map(whole), DOCS / "figures" / "design_map.png"))
    table = variants(nine)
    print("\n".join(table))
    page = DOCS / "design-map.md"
    if page.is_file():
        page.write_text(put(put(page.read_text(), "claims", rows), "variants", table))
        print(f"written: {page}")


if __name__ == "__main__":
    main()
