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
# # Slip zone of a solid coil
#
# The case study of section 2.4 of the thesis: 300 wraps on a cantilevered aluminium mandrel, base excitation at the
# first natural frequency, 2 % modal damping. The coil is a homogenised solid bonded to the mandrel. It is predicted to
# slip where the shear resultant $\sigma_s = \sqrt{\sigma_{rz}^2 + \sigma_{r\theta}^2}$ exceeds the friction capacity
# $\mu P(r)$ from winding.
#
# **What is solved**: winding wrap by wrap, modes with their stress by Fourier elements, and the steady motion in these
# modes. The model is linear, so one solution serves every level, friction coefficient and damping ratio.
#
# **Against what it is compared**: the motion of the tip with the closed form of a resonant mode; the onset of slip
# with its proportionality to friction and damping; the pressure at the mandrel with its bound, the integral of $T/r$;
# in the end the linear prediction with wraps that slide, by a three-dimensional model.
# The whole model is compared with the three-dimensional one in docs/coil-slip.md, which `wroll run
# configs/case_study.yaml` uses.

# %%
import warnings

import matplotlib.pyplot as plt
import numpy as np

import wroll_fem as wf

case = wf.load_case("../configs/case_study.yaml", ["mesh.discretisation=fourier"])
model = wf.slip_model(case)

# %% [markdown]
# ## Modes and interlayer pressure

# %%
modes, roll = model.modes, model.roll
for frequency, kind, participation in zip(modes.frequencies_hz, modes.kinds, modes.participation, strict=True):
    print(f"{frequency:8.1f} Hz  {kind:8} {100 * participation**2 / modes.mass_total:5.1f} % of the mass")

print(f"pressure at the mandrel {roll.pressure[0] / 1e6:.2f} MPa, friction capacity {roll.capacity[0] / 1e6:.2f} MPa")
tension, radii = case.winding.tension_stress, roll.radius
bound = tension * np.log(radii[-1] / radii[0])  # the integral of T/r for constant T
print(f"upper bound of the pressure, without relaxation of the wraps: {bound / 1e6:.2f} MPa")
assert np.isclose(roll.hoop_bound, bound, rtol=2e-3)
assert 0 < roll.pressure[0] < bound

# %% [markdown]
# ## Slip at one level
#
# `model.run` evaluates any level, friction coefficient and damping ratio without another solution. Its result equals
# that of `wf.run` for the same case.


# %%
def slip(level_g=15.0, friction=case.winding.mu, damping=case.damping_ratio):
    """Result at levels up to `level_g`."""
    levels = [round(level_g * part, 3) for part in (0.2, 0.4, 0.6, 0.8, 1.0)]
    changes = {"excitation.amplitude_g": levels, "winding.mu": friction, "damping_ratio": damping}
    return model.run(case.changed(changes))


def contours(level_g=15.0, friction=case.winding.mu, damping=case.damping_ratio):
    """Slip zone over height and depth beside both shear components on the root section."""
    data = slip(level_g, friction, damping)
    figure, panels = plt.subplots(1, 3, figsize=(15, 4.6), layout="constrained")
    wf.plot.slip_zone(data, panels[0])
    wf.plot.root_section(data, "rz", panels[1])
    wf.plot.root_section(data, "rt", panels[2])
    print(wf.summarise(data, case)["slip_statement"])
    return figure


contours()
plt.show()

# %% [markdown]
# At its natural frequency, a mode with participation factor $p$ and tip displacement $\phi$ (unit modal mass) moves
# the tip by $p \phi / (2 \zeta)$ times the base with a phase lag of 90 degrees: $|T| = |1 + p \phi / (2 i \zeta)|$
# without the other modes.

# %%
first = int(np.argmax(np.square(modes.participation)))
alone = abs(1 + modes.participation[first] * modes.tip[first] / (2j * case.damping_ratio))
data = slip()
print(f"transmissibility {data.attrs['transmissibility']:.4f}; by the first mode alone {alone:.4f}")
assert np.isclose(data.attrs["transmissibility"], alone, rtol=1e-3)

# %% [markdown]
# ## Three-dimensional view
#
# Half of the coil near its base, cut along the excitation. With a display and trame (`pip install
# "pyvista[jupyter]"`) the scene can be rotated; otherwise it is a picture.

# %%
scene = wf.plot.slip_scene(data, top=0.06)
scene.show(jupyter_backend=wf.plot.jupyter_backend())

# %% [markdown]
# ## Sliders
#
# With ipywidgets, sliders set level, friction and damping; without it, three levels are drawn.

# %%
try:
    from ipywidgets import FloatSlider, interact
except ImportError:
    for level in (0.5, 1.0, 5.0):
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
#
# The coil slips where a line is above the red one, the capacity: near the base and near the mandrel at low levels, up
# to a seventh of the height and almost to the outer surface of the coil at 15 g.

# %%
_, panels = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
wf.plot.shear_along(data, "z", panels[0])
wf.plot.shear_along(data, "r", panels[1])
plt.show()

# %% [markdown]
# ## Influences on the onset
#
# The onset is proportional to the friction coefficient and, at resonance, to the damping ratio. It grows with the
# winding tension through the pressure, far more than in proportion: a stack under a higher pressure is stiffer
# (Pfeiffer's law), so the outer wraps compress the inner ones instead of relaxing them.

# %%
onset = float(data["slip_onset"].min())
for friction, damping in ((0.24, 0.02), (0.48, 0.04)):
    other = float(slip(friction=friction, damping=damping)["slip_onset"].min())
    print(f"friction {friction:g}, damping {damping:g}: onset {other:.3f} g, {other / onset:.3f} of {onset:.3f} g")
    expected = friction / case.winding.mu * damping / case.damping_ratio
    assert np.isclose(other / onset, expected, rtol=0.01)

tensions = np.array([10.0, 20.0, 40.0, 80.0]) * 1e6
wound = [model.run(case.changed({"winding.tension_stress": tension})) for tension in tensions]
onsets = np.array([float(result["slip_onset"].min()) for result in wound])
capacities = np.array([result.attrs["capacity_mandrel_pa"] for result in wound])
powers = [np.polyfit(np.log(tensions), np.log(values), 1)[0] for values in (onsets, capacities)]
print("onset and capacity at the mandrel grow as the winding stress to the power of {:.2f} and {:.2f}".format(*powers))
assert np.isclose(*powers, rtol=0.1)  # slip starts near the mandrel, so onset and capacity grow alike

_, ax = plt.subplots(figsize=(6, 4), layout="constrained")
ax.loglog(tensions / 1e6, onsets, "o-", label="onset of slip")
ax.loglog(tensions / 1e6, onsets[0] * capacities / capacities[0], "--", label="in proportion to the capacity")
ax.set_xlabel("Winding stress (MPa)")
ax.set_ylabel("Onset of slip (g)")
ax.set_title(f"Eight times the winding stress, {onsets[-1] / onsets[0]:.1f} times the onset", loc="left", fontsize=10)
ax.grid(True, which="both", alpha=0.3)
ax.legend()
plt.show()

# %% [markdown]
# ## Wraps that slide
#
# The linear model predicts where the coil would slip; stress does not redistribute and nothing is dissipated. With
# `coil.inside: slipping` the wraps slide at every point, and `slip_damping` follows the resonance over the level
# (docs/slipping-coil.md). The mesh is coarser than that of `configs/slipping_coil.yaml`.

# %%
mesh = "mesh={circumferential: 12, axial: 12, grading: 40, radial: 3, radial_grading: 10}"
with warnings.catch_warnings(record=True) as told:  # shown below
    warnings.simplefilter("always")
    sliding = wf.run(wf.load_case("../configs/slipping_coil.yaml", [mesh]), progress=False)
print(*(warning.message for warning in told), sep="\n")
summary = wf.summarise(sliding)
print(summary["slip_damping_statement"])
print(summary["slip_onset_statement"])
linear_hz = modes.frequencies_hz[first]
assert np.isclose(summary["f_stuck_hz"], linear_hz, rtol=3e-3)  # Fourier elements against hexahedra

# %% [markdown]
# Slip zone and slip work over radius and height: the wraps slide near the lower inner edge, and half of the work is
# done within a millimetre of the mandrel.

# %%
wf.plot.slip_work(sliding)
plt.show()

# %% [markdown]
# On sections near the root: at the base the slip zone is deepest across the excitation, where the wraps slide around
# the roll; a few millimetres higher slip starts along the excitation, where they slide in axial direction. The stress
# at the lower inner edge is singular, so the level of the first slip falls with the elements; its mean over the wall
# of the mandrel, 1 mm, does not.

# %%
wf.plot.slip_work_sections(sliding)
plt.show()
assert summary["slip_onset_g"] <= summary["slip_onset_averaged_g"] < 1.0  # slips at 1 g, the lowest level

# %% [markdown]
# Frequency and damping over the level. At 1 g slip takes 8 % of the motion that the linear model predicts, at 15 g two
# thirds. Frequency and damping ratio of the linear model are the same at every level.

# %%
levels = sliding["amplitude_g"].values
base = np.append(0.0, sliding["resonant_base_acceleration"].values / 9.80665)  # from rest
_, panels = plt.subplots(1, 3, figsize=(15, 4), layout="constrained", sharex=True)
shown = (
    ("Resonance frequency (Hz)", sliding["resonance_frequency"], 1.0, linear_hz, linear_hz),
    ("Damping ratio (%)", sliding["modal_damping"], 100.0, case.damping_ratio, case.damping_ratio),
    ("Tip at resonance (mm, 0-peak)", sliding["tip_amplitude"], 1e3, 0.0,
     float(sliding["tip_at_level_without_slip"][-1])),
)  # fmt: skip
for ax, (name, values, factor, at_rest, linear) in zip(panels, shown, strict=True):
    ax.plot(base, factor * np.append(at_rest, values), "-", label="wraps that slide")
    ax.plot([0.0, levels[-1]], [factor * at_rest, factor * linear], "--", label="linear prediction")
    ax.set(xlabel="Base acceleration (g, 0-peak)", ylabel=name, xlim=(0.0, levels[-1]))
    ax.grid(True, alpha=0.3)
panels[0].legend(loc="lower left")
panels[0].set_title(f"Slip lowers the resonance to {summary['f_resonance_hz'][-1]:.1f} Hz", loc="left", fontsize=10)
panels[1].set_title(f"and adds {100 * summary['zeta_friction'][-1]:.1f} % of damping", loc="left", fontsize=10)
share = summary["tip_displacement_m"][-1] / summary["tip_displacement_without_slip_m"][-1]
panels[2].set_title(f"so that {100 * share:.0f} % of the motion is left at {levels[-1]:g} g", loc="left", fontsize=10)
plt.show()

# the damping ratio is that of friction and of the material together
assert np.allclose(sliding["modal_damping"], sliding["friction_modal_damping"] + sliding["material_modal_damping"])
assert summary["tip_displacement_m"][0] > 0.9 * summary["tip_displacement_without_slip_m"][0]
assert share < 0.5
