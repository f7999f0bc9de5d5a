# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#       format_version: '1.3'
#       jupytext_version: 1.19.6
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # A first roll
#
# The laboratory roll of chapter 4 of the thesis, on a coarse mesh: a tube of 300 mm x 80 mm x 1.5 mm with one
# preloaded layer of web. The base is excited through the first bending resonance. Coulomb friction between tube and
# layer is the only damping.
#
# **What is solved**: shell finite elements, a reduced-order model with friction at every contact point, and 30 000
# time steps of a chirp.
#
# **Against what it is compared**: the frequency of the tube with Fourier elements, which share only the material with
# the shells; the resonance with periodic motions by harmonic balance, without time steps; and the energy balance,
# whose terms are computed independently.

# %%
import os
import tempfile
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import wroll_fem as wf

quick = "WROLL_QUICK" in os.environ  # a coarser mesh and a narrower band, for a test of this notebook
mesh = ["mesh.circumferential=16", "mesh.axial=12", "mesh.grading=6"]  # coarse, with small elements at the root
band = ["excitation.f_start=135"]
if quick:
    mesh = ["mesh.circumferential=8", "mesh.axial=8", "mesh.grading=9"]
    band = ["excitation.f_start=135", "excitation.f_end=168"]
case = wf.load_case("../configs/lab_sweep.yaml", [*mesh, *band, "excitation.rate_oct_per_min=2.5"])
print(case.resolved_yaml())

# %% [markdown]
# ## Natural frequencies without slip
#
# There are two bounds: a layer bonded to the tube, and a layer that slides without friction. With friction the
# resonance lies between them.

# %%
modal = wf.load_case("../configs/lab_modal.yaml", [*mesh, "modal.count=8"])
bonded = wf.run(modal)
frictionless = wf.run(modal.changed("modal.interface=frictionless"))
wf.plot.modes(bonded)
plt.show()

f_bonded, f_frictionless = (wf.summarise(result)["bending_hz"] for result in (bonded, frictionless))
print(f"first bending: {f_bonded:.2f} Hz bonded, {f_frictionless:.2f} Hz without friction")

# %% [markdown]
# Modes occur in pairs, along x and along y. The tube alone, with shells and with Fourier elements:

# %%
tube = modal.changed("coil.model=none", "modal.count=2")
shells, fourier = (
    wf.summarise(wf.run(tube.changed({"mesh.discretisation": kind})))["bending_hz"]
    for kind in ("three_dimensional", "fourier")
)
print(f"tube alone: {shells:.3f} Hz by shells, {fourier:.3f} Hz by Fourier elements")
assert np.isclose(shells, fourier, rtol=1e-3)

# %% [markdown]
# ## Chirp through the resonance
#
# `run` returns an `xarray.Dataset` with units on every variable. `summarise` returns the numbers of `summary.json` in
# a run folder.

# %%
result = wf.run(case)
numbers = wf.summarise(result)
wf.plot.transmissibility(result)
plt.show()
for name in ("f_n_hz", "zeta", "peak_transmissibility", "skewness", "friction_energy_j", "energy_balance_error"):
    print(f"{name:24} {numbers[name]:.4g}")
assert f_frictionless < numbers["f_n_hz"] < f_bonded

# %% [markdown]
# ## Steady state by harmonic balance
#
# Harmonic balance computes the periodic motion at each frequency. A slow sweep follows it; this one, at 2.5 octaves
# per minute, passes the peak a little late.

# %%
steady = wf.run(case.changed({"analysis": "harmonic", "harmonic.harmonics": 5, "harmonic.samples": 64}))
wf.plot.comparison({"chirp, 2.5 oct/min": result, "periodic motion": steady})
plt.show()
balance = wf.summarise(steady)
print(f"peak {numbers['peak_transmissibility']:.2f} at {numbers['f_n_hz']:.2f} Hz by the chirp, "
      f"{balance['peak_transmissibility']:.2f} at {balance['f_n_hz']:.2f} Hz by harmonic balance")  # fmt: skip
assert np.isclose(numbers["peak_transmissibility"], balance["peak_transmissibility"], rtol=0.02)
assert np.isclose(numbers["f_n_hz"], balance["f_n_hz"], rtol=0.01)

# %% [markdown]
# ## Slip zone
#
# The layer slips at the root, on the faces along the excitation. There the surface of the tube stretches most in
# bending, and the layer with its free base does not follow.

# %%
wf.plot.slip_map(result)
plt.show()
slipped = result["slipped"].isel(interface=0)
height = float(result["z_m"].where(slipped > 0).max())
share = 100 * numbers["slipping_area_fraction"][0]
print(f"{share:.0f} % of the interface slipped at some time, up to {1e3 * height:.0f} mm above the base")
assert height < 0.1 * case.geometry.length

# %% [markdown]
# ## Energy balance
#
# The work of the base is stored or dissipated. The terms are computed independently, so their sum is a check of the
# whole computation.

# %%
wf.plot.energy_ledger(result)
plt.show()
share = numbers["friction_energy_j"] / numbers["input_work_j"]
gap = numbers["energy_balance_error"]
print(f"friction dissipated {100 * share:.1f} % of the work of the base; energy balance error {gap:.1e}")
assert gap < 1e-5
assert 0.97 < share < 1.0

# %% [markdown]
# ## Run folder
#
# `run(case, out=...)` writes the same folder as `wroll run`: results, summary, figures, files for ParaView, log. A
# second call reads the stored results; an interrupted run continues.

# %%
warnings.filterwarnings("ignore", category=wf.CaseWarning)  # a short dwell with coarse steps, which the program says
with tempfile.TemporaryDirectory() as folder:
    small = wf.load_case("../configs/tiny.yaml", ["mesh.axial=12", "mesh.grading=6"])
    kept = wf.run(small, out=Path(folder) / "tiny")
    again = wf.run(small, out=Path(folder) / "tiny")  # at once
    print(*sorted(path.relative_to(folder).as_posix() for path in Path(folder).rglob("*") if path.is_file()), sep="\n")
assert again.identical(kept)
