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
# # From a shaker record to damping
#
# Sweeps of a small roll at several levels and two winding tensions are read as a laboratory reads them: two noisy
# columns in a file. Transmissibility, resonance frequency and damping follow with error bars, then $\mu p$ and the
# elastic slip $\gamma^*$ of the interface. The records are made by the program, so that the truth is known.
#
# **What is solved**: the response to a chirp in time (the records), averaged and demodulated records (the evaluation),
# and a fit of backbones to the resonances.
#
# **Against what it is compared**: the friction, elastic slip and material damping that made the records; the backbones
# of the same roll, which are periodic motions and not sweeps.

# %%
import os
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import numpy as np

import wroll_fem as wf

quick = "WROLL_QUICK" in os.environ  # fewer levels, for a test of this notebook
scratch = TemporaryDirectory()
folder = Path(scratch.name)

# %% [markdown]
# ## The roll
#
# One bending mode of a mandrel, 120 Hz alone, with one contact area to its coil (docs/matrices.md). A real roll is
# meshed; then the sections `geometry`, `mandrel` and `coil` take the place of `structure`, and all else is the same.

# %%
MASS, AREA, ZETA = 0.2, 1e-5, 0.02  # kg, m^2, damping ratio of the material
SLIP = 1.3e-6  # m, elastic slip
FRICTION = {20: 4.0e3, 60: 12.0e3}  # winding tension in N -> mu p in Pa
MU = 0.25


def structure(pressure):
    """Case section of the mode pressed onto its coil with the pressure, Pa."""
    file = folder / f"mode_{pressure:.0f}.npz"
    np.savez(
        file, K=np.diag([MASS * (2 * np.pi * 120) ** 2, 0]), M=MASS * np.eye(2), influence=[1, 0], probe_tip=[1, 0],
        damping_ratios=[ZETA], load_preload=[0, -pressure * AREA], interface_1_operator=[[0, 1], [1, 0], [0, 0]],
        interface_1_area=AREA, interface_1_normal_stiffness=1e12, interface_1_friction_law="penalty_coulomb",
        interface_1_friction_mu=MU, interface_1_friction_elastic_slip=SLIP,
    )  # fmt: skip
    return {"file": str(file)}


def contact(slip):
    """Case section with the friction law."""
    return {"friction": {"law": "penalty_coulomb", "mu": MU, "elastic_slip": slip}}


# %% [markdown]
# ## The records
#
# A chirp at each level; both accelerometers get 1 % noise of the largest signal. A file has time in s, base in g, and
# the absolute acceleration of the tip in m/s².

# %%
warnings.simplefilter("ignore", wf.CaseWarning)  # the sweeps stand for a laboratory: their own evaluation is not used
levels = (0.02, 0.3) if quick else (0.02, 0.1, 0.3, 1.0)  # m/s^2, 0-peak
noise = np.random.default_rng(1)
conditions = []
for tension, friction in FRICTION.items():
    for level in levels:
        sweep = wf.run(wf.Case(
            analysis="sweep", structure=structure(friction / MU), contact=contact(SLIP),
            excitation={"kind": "chirp", "amplitude": level, "f_start": 105, "f_end": 195, "rate_oct_per_min": 4},
            integrator={"steps_per_cycle": 40}, solver={"method": "condensed"},
        ))  # fmt: skip
        record = sweep[["base_acceleration", "tip_acceleration"]].isel(time=slice(None, None, 2))
        base, tip = record["base_acceleration"].values, record["tip_acceleration"].values
        base = base / 9.80665 + 0.01 * level / 9.80665 * noise.standard_normal(base.size)
        tip = tip + 0.01 * np.abs(tip).max() * noise.standard_normal(tip.size)
        columns = np.transpose([record["time"].values, base, tip])
        name = f"{tension}N_{level:g}.csv"
        np.savetxt(folder / name, columns, "%.8g", ",", header="time,base,tip", comments="")
        conditions.append({"files": [name], "tension": tension, "level": level})

_, (above, below) = plt.subplots(2, 1, figsize=(8, 4.2), sharex=True, layout="constrained")
above.plot(columns[:, 0], columns[:, 1], lw=0.4)
below.plot(columns[:, 0], columns[:, 2], lw=0.4)
above.set_ylabel("Base (g)")
below.set_ylabel("Tip (m/s²)")
below.set_xlabel("Time (s)")
above.set_title(f"Record {name}: a chirp from 105 Hz to 195 Hz", loc="left", size=10)
plt.show()

# %% [markdown]
# ## Transmissibility, frequency and damping
#
# The same as `wroll lab transmissibility` with these files and settings. No signal of the generator is
# needed: base and tip are demodulated with the phase of the base.

# %%
files = sorted(folder.glob("*.csv"))
measured = wf.lab.evaluate("transmissibility", files, base_unit="g", tip_unit="m/s^2", conditions=conditions)
measured.plot("transmissibility")
plt.show()
measured.plot("damping")
plt.show()

rows = measured.summary
for k, name in enumerate(rows["conditions"]):
    print(f"{name:>20}: f_n = {rows['f_n_hz'][k]:7.2f} +- {rows['f_n_interval_hz'][k]:.2f} Hz, "
          f"zeta = {100 * rows['zeta'][k]:5.2f} +- {100 * rows['zeta_interval'][k]:.2f} %")  # fmt: skip
print("doubts:", *(measured.warnings or ["none"]), sep="\n  ")

# %% [markdown]
# At the lowest level the interface sticks: the damping is that of the material, and the frequency that of the stuck
# roll. Friction adds damping above the onset of sliding, and softens the roll.

# %%
count = len(levels)
for k, friction in enumerate(FRICTION.values()):
    stuck = np.sqrt(120**2 + friction * AREA / SLIP / MASS / (2 * np.pi) ** 2)
    print(f"stuck: {stuck:.2f} Hz, measured {rows['f_n_hz'][k * count]:.2f} Hz")
    assert np.isclose(rows["f_n_hz"][k * count], stuck, rtol=2e-3)
    assert np.isclose(rows["zeta"][k * count], ZETA, rtol=0.05)
    assert rows["zeta"][k * count + 1] > 1.5 * ZETA

# %% [markdown]
# ## Friction and elastic slip
#
# Backbones of the roll for several $\mu p$ and one assumed elastic slip, not that of the records: with penalty friction
# they scale to any other (docs/laboratory.md). The fit finds $\mu p$ for each tension, and $\gamma^*$.

# %%
for friction in (2e3, 5e3, 14e3):
    backbone = wf.Case(
        analysis="backbone", structure=structure(friction / MU), contact=contact(1e-6),
        backbone={"tip_smallest": 1e-8, "tip_largest": 3e-4}, output={"figures": False, "fields": "none"},
    )  # fmt: skip
    wf.run(backbone, out=folder / "backbones" / f"{friction:.0f}")

wf.save_result(measured.data, folder / "measured" / "results.nc")
model = {"kind": "backbones", "grid": str(folder / "backbones"), "level_error": 0.01}
fit = wf.lab.evaluate("fit", [folder / "measured"], model=model)
fit.plot("fit")
plt.show()

truth = {f"mu_p_{tension}_newton_pa": friction for tension, friction in FRICTION.items()} | {"elastic_slip_m": SLIP}
for name, value in truth.items():
    low, high = fit.summary["parameters_low"][name], fit.summary["parameters_high"][name]
    print(f"{name}: {fit.summary['parameters'][name]:.3g}, 95 % interval {low:.3g} to {high:.3g}, truth {value:.3g}")
    assert np.isclose(fit.summary["parameters"][name], value, rtol=0.1)
    assert low < value < high

# %% [markdown]
# Where the damping is largest, the peak of $|T|$ lies above the backbone, which is the frequency at which the motion
# lags by a quarter of a cycle: the curve is skewed and flat, and the interval of $f_n$ there is wide. The levels, not
# the frequencies, then tell the friction.
#
# ## What the data cannot tell
#
# At the lowest level nothing slides. Its resonance tells the stick stiffness $\mu p/\gamma^*$ alone, and the evaluation
# says so. Levels must reach the sliding to separate the two, and they do so best around the largest damping.

# %%
quiet = measured.data.isel(condition=[0, count])
wf.save_result(quiet, folder / "quiet" / "results.nc")
blind = wf.lab.evaluate("fit", [folder / "quiet"], model=model)
for text in blind.summary["undetermined"]:
    print(text)
assert blind.summary["undetermined"]
assert not fit.summary["undetermined"]

# %% [markdown]
# Friction and pressure always enter as a product. The coefficient follows from a pressure, for example that of the
# wound-roll model (docs/winding.md), and is as uncertain as this pressure. With the setting `model.pressure` the
# evaluation divides by it:

# %%
for tension, friction in FRICTION.items():
    pressure = friction / MU
    value = fit.summary["parameters"][f"mu_p_{tension}_newton_pa"] / pressure
    print(f"{tension} N: mu = {value:.3f} if the pressure is exact, {value / 0.9:.3f} if it is 10 % lower")
    assert np.isclose(value, MU, rtol=0.1)
