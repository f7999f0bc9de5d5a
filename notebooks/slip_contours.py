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
# # Where does a coil slip?
#
# The case study of section 2.4 of the source: 300 wraps on a cantilevered aluminium mandrel, base shaken at the first
# natural frequency, 2 % modal damping. The coil is a homogenised solid bonded to the mandrel; it *would* slip where the
# shear resultant $\sigma_s = \sqrt{\sigma_{rz}^2 + \sigma_{r\theta}^2}$ exceeds the friction capacity $\mu P(r)$ that
# winding leaves. The model is linear, so one solution serves every level, friction and damping.
#
# The fast path (harmonics around the axis, `mesh.discretisation: fourier`) takes seconds. It agrees with the
# three-dimensional model (docs/coil-slip.md), which `wroll run configs/case_study.yaml` uses.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from wroll_fem.analyses.modal_transient import CoilShape, shear_modes, slip_statement, transient_dataset
from wroll_fem.case import load_case
from wroll_fem.case.winding import completed
from wroll_fem.plotting.coil_slip import plot_root_section, plot_shear_along, plot_slip_zone
from wroll_fem.winding import wound_roll

root = next(folder for folder in (Path.cwd(), *Path.cwd().parents) if (folder / "configs").is_dir())
case = load_case(root / "configs" / "case_study.yaml", ["mesh.discretisation=fourier"])
radius = 0.5 * case.geometry.mandrel_outer_diameter
shape = CoilShape(radius, radius + case.coil.thickness, case.geometry.length)

# %% [markdown]
# ## Modes with their stress, and what winding holds

# %%
modes = shear_modes(case)
for frequency, kind, participation in zip(modes.frequencies_hz, modes.kinds, modes.participation, strict=True):
    print(f"{frequency:8.1f} Hz  {kind:8} {100 * participation**2 / modes.mass_total:5.1f} % of the mass")

roll = wound_roll(completed(case))
print(f"pressure at the mandrel {roll.pressure[0] / 1e6:.2f} MPa, friction capacity {roll.capacity[0] / 1e6:.2f} MPa")


# %% [markdown]
# ## Slip at one level
#
# `slip` answers for any level, friction and damping without solving anything again.


# %%
def slip(level_g=15.0, friction=case.winding.mu, damping=case.damping_ratio):
    """Results at levels up to `level_g`, for the figures."""
    levels = [round(level_g * part, 3) for part in (0.2, 0.4, 0.6, 0.8, 1.0)]
    return transient_dataset(
        modes, lambda r: friction * roll.pressure_at(r), shape,
        damping_ratio=damping, frequency_hz=None, levels_g=levels,
    )  # fmt: skip


def contours(level_g=15.0, friction=case.winding.mu, damping=case.damping_ratio):
    """Slip zone over height and depth beside both shear components on the root section."""
    data = slip(level_g, friction, damping)
    figure, panels = plt.subplots(1, 3, figsize=(15, 4.6), layout="constrained")
    plot_slip_zone(data, panels[0])
    plot_root_section(data, "rz", panels[1])
    plot_root_section(data, "rt", panels[2])
    print(slip_statement(data))
    return figure


contours()
plt.show()

# %% [markdown]
# ## Sliders
#
# With ipywidgets installed, level, friction and damping can be dragged; without it, four levels are drawn.

# %%
try:
    from ipywidgets import FloatSlider, interact
except ImportError:
    for level in (0.5, 1.0, 5.0, 15.0):
        contours(level)
    plt.show()
else:
    def show(**settings):
        contours(**settings)
        plt.show()

    interact(
        show,
        level_g=FloatSlider(value=15.0, min=0.25, max=15.0, step=0.25, continuous_update=False),
        friction=FloatSlider(value=case.winding.mu, min=0.05, max=1.0, step=0.01, continuous_update=False),
        damping=FloatSlider(value=case.damping_ratio, min=0.005, max=0.1, step=0.005, readout_format=".3f",
                            continuous_update=False),
    )  # fmt: skip

# %% [markdown]
# ## Shear against capacity (Fig. 2.14)

# %%
data = slip()
_, panels = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
plot_shear_along(data, "z", panels[0])
plot_shear_along(data, "r", panels[1])
plt.show()

# %% [markdown]
# ## What moves the onset
#
# The onset is proportional to friction and, at resonance, to damping. How tightly the roll is wound moves it through the
# pressure: with a stiffer stack the pressure at the mandrel approaches the integral of $T/r$.

# %%
onset = float(data["slip_onset"].min())
for friction, damping in ((0.24, 0.02), (0.48, 0.04)):
    other = float(slip(friction=friction, damping=damping)["slip_onset"].min())
    print(f"friction {friction:g}, damping {damping:g}: onset {other:.3f} g, {other / onset:.3f} of {onset:.3f} g")
    expected = friction / case.winding.mu * damping / case.damping_ratio
    assert np.isclose(other / onset, expected, rtol=0.01)

tensions = np.array([10.0, 20.0, 40.0, 80.0]) * 1e6
onsets = []
for tension in tensions:
    tight = wound_roll(completed(case.changed(f"winding.tension_stress={tension}")))
    onsets.append(float(transient_dataset(
        modes, tight.capacity_at, shape, damping_ratio=case.damping_ratio, frequency_hz=None, levels_g=[1.0],
    )["slip_onset"].min()))  # fmt: skip

_, ax = plt.subplots(figsize=(6, 4), layout="constrained")
ax.loglog(tensions / 1e6, onsets, "o-")
ax.set_xlabel("Winding stress (MPa)")
ax.set_ylabel("Onset of slip (g)")
ax.grid(True, which="both", alpha=0.3)
plt.show()
