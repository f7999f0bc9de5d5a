# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # A first roll
#
# A tube of 300 mm x 80 mm x 1.5 mm with one layer of web pressed onto it, shaken at its base through the first
# bending resonance: the laboratory roll of chapter 4 of the thesis, on a coarse mesh. Between tube and layer there is
# Coulomb friction; it is the only damping.
#
# **What is solved**: shells by finite elements, reduced to what their contact points see, and 30 000 time steps of a
# chirp.
#
# **Against what it is compared**: the tube's frequency with a model in harmonics around the axis, which shares
# nothing with the shells but the material; the resonance with periodic motions found by harmonic balance, without
# time steps; and the terms of the energy balance, each computed on its own, must add up.

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import wroll_fem as wf

mesh = ["mesh.circumferential=16", "mesh.axial=12", "mesh.grading=6"]  # coarse, with small elements at the root
case = wf.load_case("../configs/lab_sweep.yaml", [*mesh, "excitation.rate_oct_per_min=6", "excitation.f_start=130"])
print(case.resolved_yaml())

# %% [markdown]
# ## How it vibrates while nothing slips
#
# Two bounds: the layer bonded to the tube, and free to slide without friction. Friction puts the resonance between
# them.

# %%
modal = wf.load_case("../configs/lab_modal.yaml", [*mesh, "modal.count=8"])
bonded = wf.run(modal)
frictionless = wf.run(modal.changed("modal.interface=frictionless"))
wf.plot.modes(bonded)
plt.show()

f_bonded, f_frictionless = (wf.summarise(result)["bending_hz"] for result in (bonded, frictionless))
print(f"first bending: {f_bonded:.2f} Hz bonded, {f_frictionless:.2f} Hz without friction")

# %% [markdown]
# Modes come in pairs, along x and along y. The tube alone once more, in harmonics around the axis:

# %%
tube = modal.changed("coil.model=none")
shells, harmonics = (
    wf.summarise(wf.run(tube.changed({"mesh.discretisation": kind})))["bending_hz"]
    for kind in ("three_dimensional", "fourier")
)
print(f"tube alone: {shells:.3f} Hz by shells, {harmonics:.3f} Hz in harmonics")
assert np.isclose(shells, harmonics, rtol=1e-3)

# %% [markdown]
# ## Through the resonance
#
# `run` returns an `xarray.Dataset` with units on every variable; `summarise` reads the numbers that `summary.json` of
# a run folder holds.

# %%
result = wf.run(case)
numbers = wf.summarise(result)
wf.plot.transmissibility(result)
plt.show()
for name in ("f_n_hz", "zeta", "peak_transmissibility", "skewness", "friction_energy_j", "energy_balance_error"):
    print(f"{name:24} {numbers[name]:.4g}")
assert f_frictionless < numbers["f_n_hz"] < f_bonded

# %% [markdown]
# ## The same resonance without time steps
#
# Harmonic balance finds the periodic motion at each frequency. A sweep that is slow enough follows it; this one, at
# six octaves per minute, arrives at its peak a little late.

# %%
steady = wf.run(case.changed({"analysis": "harmonic", "harmonic.harmonics": 5, "harmonic.samples": 64}))
wf.plot.comparison({"chirp, 6 oct/min": result, "periodic motion": steady})
plt.show()
balance = wf.summarise(steady)
print(f"peak {numbers['peak_transmissibility']:.2f} at {numbers['f_n_hz']:.2f} Hz by the chirp, "
      f"{balance['peak_transmissibility']:.2f} at {balance['f_n_hz']:.2f} Hz by harmonic balance")  # fmt: skip
assert np.isclose(numbers["peak_transmissibility"], balance["peak_transmissibility"], rtol=0.02)
assert np.isclose(numbers["f_n_hz"], balance["f_n_hz"], rtol=0.01)

# %% [markdown]
# ## Where it slips
#
# At the root, on the faces that look along the excitation: there the tube's surface stretches most in bending, and
# the layer, free at its base, wants to stay behind.

# %%
wf.plot.slip_map(result)
plt.show()
slipped = result["slipped"].isel(interface=0)
height = float(result["z_m"].where(slipped > 0).max())
share = 100 * numbers["slipping_area_fraction"][0]
print(f"{share:.0f} % of the interface slipped at some time, up to {1e3 * height:.0f} mm above the base")
assert height < 0.1 * case.geometry.length

# %% [markdown]
# ## Where the energy went
#
# What the base put in is stored or dissipated. The terms are computed apart from each other, so their sum is a check
# of the whole computation.

# %%
wf.plot.energy_ledger(result)
plt.show()
share = numbers["friction_energy_j"] / numbers["input_work_j"]
gap = numbers["energy_balance_error"]
print(f"friction took {100 * share:.1f} % of the work of the base; the balance closes to {gap:.1e}")
assert gap < 1e-5
assert 0.97 < share < 1.0

# %% [markdown]
# ## Into a folder
#
# `run(case, out=...)` does what `wroll run` does: results, summary, figures, files for ParaView, log. A second call
# reads what is there; an interrupted one goes on where it was.

# %%
with tempfile.TemporaryDirectory() as folder:
    small = wf.load_case("../configs/tiny.yaml", ["mesh.axial=12", "mesh.grading=6"])
    kept = wf.run(small, out=Path(folder) / "tiny")
    again = wf.run(small, out=Path(folder) / "tiny")  # at once
    print(*sorted(path.relative_to(folder).as_posix() for path in Path(folder).rglob("*") if path.is_file()), sep="\n")
assert again.identical(kept)
