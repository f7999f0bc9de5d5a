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
# # Two-mass model with friction
#
# The two-degree-of-freedom model of chapter 5 of the thesis: a primary mass (mandrel) and a secondary mass (roll),
# each on a spring and a dashpot, in frictional contact under a constant normal force, with a sinusoidal base motion. A
# set of response curves takes seconds, so the model can be fitted to measured or computed curves.
#
# **What is solved**: periodic motions by harmonic balance, with the code of the finite-element roll.
#
# **Against what it is compared**: time integration from rest to the periodic motion; the resonance of the masses stuck
# together; the energy of a cycle; known parameters, identified from curves; and the finite-element roll, which the
# model represents only in part.

# %%
import os
import warnings

import matplotlib.pyplot as plt
import numpy as np

import wroll_fem as wf

quick = "WROLL_QUICK" in os.environ  # fewer points, for a test of this notebook

# %% [markdown]
# ## Response over the friction capacity (Fig. 5.6c)
#
# The friction capacity is the limit of the friction force, $F_c = \mu F_N$. At low capacity the masses move
# independently, at high capacity as one.

# %%
case = wf.Case(
    analysis="two_dof",
    two_dof={
        "friction_capacity": [1, 2, 3, 5, 10, 20, 50, 100],
        "omega": {"start": 0.4, "stop": 2.0, "points": 200 if quick else 400},
    },  # all else is Table 5.2 of the thesis
)
family = wf.run(case)
wf.plot.two_dof(family)
plt.show()

tight = family.isel(friction_capacity=-1)
peak, stuck = float(tight["omega_peak"]), float(tight["omega_stuck"])
print(f"highest capacity: peak at {peak:.4f} rad/s, stuck together {stuck:.4f} rad/s")
print(f"energy of a cycle: base against dashpots and friction to {family.attrs['energy_balance_error']:.0e}")
assert np.isclose(tight["omega_peak"], tight["omega_stuck"], rtol=1e-4)
assert family.attrs["energy_balance_error"] < 1e-6

# %% [markdown]
# The same motion by time integration from rest to the periodic motion, at three capacities near their peaks:

# %%
model = wf.two_dof.TwoMasses()
curves = wf.transmissibility(family)
for capacity in (5.0,) if quick else (2.0, 5.0, 20.0):
    omega = float(curves["omega"].sel(omega=0.97, method="nearest"))
    settled = wf.two_dof.integrate_to_steady_state(model.preloaded(capacity), omega)
    periodic = float(curves.sel(friction_capacity=capacity, omega=omega))
    print(f"F_c = {capacity:g} N: T = {settled.transmissibility:.5f} in time, {periodic:.5f} periodic")
    assert np.isclose(settled.transmissibility, periodic, rtol=1e-4)

# %% [markdown]
# ## Damping over the friction capacity
#
# Damping is largest where friction can just dissipate the input work: $F_c$ somewhat above $\pi k_1 Y_0 / 4$ (1.18 N
# here). Below this value only the dashpot limits the peak.

# %%
wf.plot.two_dof_readings(family)
plt.show()
numbers = wf.summarise(family)
print(f"largest damping {100 * numbers['zeta_max']:.1f} % at F_c = {numbers['friction_capacity_at_zeta_max_n']:g} N")
assert np.pi / 4 * 1.5 < numbers["friction_capacity_at_zeta_max_n"] < 3

# %% [markdown]
# ## Design space (Fig. 5.7)
#
# Largest damping over mass and stiffness of the secondary mass. There is a valley where both masses alone have the
# same resonance: there they move alike, without slip.

# %%
points = 3 if quick else 7
space = wf.run(case.changed({
    "two_dof.friction_capacity": [2, 3, 5],
    "two_dof.omega.points": 50,
    "two_dof.design_space": {
        "m2": {"start": 0.3, "stop": 2.2, "points": points}, "k2": {"start": 0.4, "stop": 2.68, "points": points},
    },
}))  # fmt: skip
wf.plot.two_dof_design_space(space)
plt.show()
heavy = space["zeta_max"].isel(m2=0)  # above the valley: stiffer is better
assert (heavy.isel(k2=slice(1, None)).diff("k2") > 0).all()

# %% [markdown]
# ## Parameter identification
#
# Mass and stiffness of the secondary mass are identified from two curves with 1 % noise, from a distant initial guess.

# %%
truth = wf.two_dof.TwoMasses(m2=0.6, k2=0.9)
omega = np.linspace(0.7, 1.4, 12)
noise = np.random.default_rng(1)
measured = []
for capacity in (2.0, 6.0):
    motions = wf.two_dof.PeriodicSolver(truth.preloaded(capacity)).curve(omega)
    exact = np.array([motion.transmissibility for motion in motions])
    measured.append(wf.two_dof.Measured(omega, exact * np.exp(0.01 * noise.standard_normal(omega.size)), capacity))

found = wf.two_dof.fit_curves(measured, {"m2": (0.2, 2.0), "k2": (0.2, 3.0)}, starts=1, workers=1)
print(f"m2 = {found.model.m2:.3f}, k2 = {found.model.k2:.3f}; residual {100 * found.error:.1f} %")
assert np.allclose([found.model.m2, found.model.k2], [0.6, 0.9], rtol=0.02)
assert found.error < 0.015

# %% [markdown]
# ## Fit to the finite-element roll
#
# Three curves of the laboratory roll, from low to high preload. At resonance |T| of the tip is that of one degree of
# freedom times the tip participation $p$ of the bending mode. Frequencies are relative to that of the tube. Mass,
# stiffness and the three capacities are fitted.

# %%
warnings.filterwarnings("ignore", "a mode at", wf.CaseWarning)  # no fifth harmonic; see the notebook on preload
mesh = ["mesh.circumferential=16", "mesh.axial=12", "mesh.grading=6"]
if quick:
    mesh = ["mesh.circumferential=12", "mesh.axial=7", "mesh.grading=9"]
    warnings.filterwarnings("ignore", "the mesh does not resolve", wf.CaseWarning)  # ovalling of the mandrel
roll = wf.load_case("../configs/lab_harmonic.yaml", [*mesh, "harmonic.harmonics=3", "excitation.f_start=120"])
guesses = {1e4: 1.0, 1e5: 4.0} if quick else {1e4: 1.0, 3e4: 2.0, 1e5: 4.0}  # Pa: first guess of the capacity, N
pressures = list(guesses)
elements = wf.run_series(roll, {"preload.pressure": pressures})

modal = wf.load_case("../configs/lab_modal.yaml", [*mesh, "modal.count=8"])
participation = float(np.abs(wf.run(modal)["tip_participation"]).max())
own = wf.summarise(wf.run(modal.changed("coil.model=none")))["bending_hz"]
print(f"tube alone {own:.1f} Hz, tip participation {participation:.2f}")

frequency = np.linspace(125, 172, 4 if quick else 12)
measured = []
for member, guess in zip(elements, guesses.values(), strict=True):
    curve = wf.transmissibility(member.data)
    at = np.sort(np.append(frequency, member.data.attrs["f_n_hz"]))
    measured.append(wf.two_dof.Measured(at / own, curve.interp(frequency=at).values / participation, guess))

start = wf.two_dof.TwoMasses(m2=0.5, k2=0.7)
bounds = {"m2": (0.05, 2.0), "k2": (0.05, 3.0)}
fit = wf.two_dof.fit_curves(measured, bounds, model=start, capacity_bounds=(0.05, 100.0), starts=1, workers=1)
print(f"m2 = {fit.model.m2:.2f} m1, k2 = {fit.model.k2:.2f} k1, capacities {np.round(fit.capacities, 2)} N; "
      f"residual {100 * fit.error:.0f} %")  # fmt: skip

fitted = wf.run(case.changed({"two_dof": {
    "m2": fit.model.m2, "k2": fit.model.k2, "friction_capacity": fit.capacities,
    "omega": {"start": 120 / own, "stop": 175 / own, "points": 120},
}}))  # fmt: skip
_, ax = plt.subplots(figsize=(8, 4.6), layout="constrained")
for k, member in enumerate(elements):
    curve = wf.transmissibility(member.data)
    ax.plot(curve["frequency"], curve, color=f"C{k}", label=f"finite elements, {pressures[k] / 1e3:.0f} kPa")
    two = participation * wf.transmissibility(fitted).isel(friction_capacity=k)
    ax.plot(own * fitted["omega"], two, "--", color=f"C{k}", label=f"two masses, {fit.capacities[k]:.2f} N")
ax.set_xlabel("Frequency (Hz)")
ax.set_ylabel("Transmissibility |T| (–)")
ax.set_title("Two masses represent the peaks; the peaks of the roll are more skewed", loc="left", size=10)
ax.legend(fontsize=8, ncols=2)
ax.grid(True, which="both", alpha=0.3)
plt.show()

# %% [markdown]
# Peaks and frequencies agree. The capacities rise with the preload, but less than in proportion: in the roll the slip
# zone shrinks as the pressure grows, while two masses have a single contact point.

# %%
for k, member in enumerate(elements):
    f_roll, f_two = member.data.attrs["f_n_hz"], own * float(fitted["omega_peak"][k])
    zeta_roll, zeta_two = member.data.attrs["zeta"], float(fitted["zeta"][k])
    print(f"{pressures[k] / 1e3:.0f} kPa: peak at {f_roll:.1f} Hz, two masses {f_two:.1f} Hz; "
          f"damping {100 * zeta_roll:.1f} %, two masses {100 * zeta_two:.1f} %")  # fmt: skip
    assert np.isclose(f_two, f_roll, rtol=0.03)
assert np.all(np.diff(fit.capacities) > 0)
assert fit.error < 0.25
