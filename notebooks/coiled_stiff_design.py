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
# # Mandrel design for a coil that does not slip
#
# Without slip, a coil is a solid whose wraps shear against each other. The interlayer shear modulus depends on the
# winding tension, is the least known property of a roll, and changes the bending frequency. A good mandrel for an
# experiment gives very different frequencies for a soft and a stiff coil (section 2.5 of the thesis); a good mandrel
# for flight gives similar ones.
#
# **What is solved**: modes of mandrel and homogenised coil by Fourier elements (`mesh.discretisation: fourier`), 0.7 s
# each.
#
# **Against what it is compared**: beam theory as a lower bound (coil as mass only) and an upper bound (no shear
# between the wraps); shells and hexahedra at one point; the map with modal analyses of its cases.

# %%
import os

import matplotlib.pyplot as plt
import numpy as np

import wroll_fem as wf

quick = "WROLL_QUICK" in os.environ  # fewer points, for a test of this notebook
roll = wf.load_case("../configs/coiled_stiff.yaml", ["mesh.discretisation=fourier", "modal.count=6"])
mass_alone = wf.load_case("../configs/coiled_stiff_mass.yaml", ["mesh.discretisation=fourier", "modal.count=2"])


def bending(result):
    """First bending frequency in Hz."""
    return wf.summarise(result)["bending_hz"]


# %% [markdown]
# ## Frequency over shear modulus (Fig. 2.13)
#
# `run_series` runs every combination of keys; figures of a study take its list. With G = 1 GPa the coil acts as a
# solid block, with 10 kPa its wraps are almost uncoupled.

# %%
moduli = [1e4, 1e8, 1e9] if quick else [1e4, 1e5, 1e6, 1e7, 5e7, 1e8, 3e8, 1e9]
series = wf.run_series(roll, {"coil.material.G_r_theta": moduli}, reference=mass_alone)  # G_r_z follows
wf.plot.frequency_over_shear_stiffness(series)
plt.show()

# %% [markdown]
# Beam theory gives two bounds. Lower bound: the mandrel bends and the coil is only mass, $f =
# (1.875^2/2\pi)\,\sqrt{EI/(m L^4)}$. Upper bound: plane sections across mandrel and coil, $EI = E_a I_a + E_z I_c$. A
# real roll stays below it, because the base of the coil is free and only shear between the wraps strains it.

# %%
tube, coil = roll.geometry, roll.coil
inner, radius = 0.5 * tube.mandrel_outer_diameter - tube.mandrel_thickness, 0.5 * tube.mandrel_outer_diameter
outer = radius + coil.thickness
metal, web = roll.mandrel.material, coil.material
mass = metal.rho * np.pi * (radius**2 - inner**2) + web.rho * np.pi * (outer**2 - radius**2)
second_moment_tube, second_moment_coil = np.pi / 4 * (radius**4 - inner**4), np.pi / 4 * (outer**4 - radius**4)


def beam(stiffness):
    """First bending frequency of a cantilever without shear, Hz."""
    return 1.8751**2 / (2 * np.pi * tube.length**2) * np.sqrt(stiffness / mass)


frequencies = [bending(member.data) for member in series]  # the reference last
lowest, highest = beam(metal.E * second_moment_tube), beam(metal.E * second_moment_tube + web.E_z * second_moment_coil)
print(f"mass alone: {frequencies[-1]:.2f} Hz, by beam theory {lowest:.2f} Hz")
print(f"stiffest coil: {frequencies[-2]:.2f} Hz, by beam theory without shear {highest:.2f} Hz")
assert np.isclose(frequencies[-1], lowest, rtol=0.01)
assert frequencies[0] < frequencies[-2] < highest
assert np.all(np.diff(frequencies[:-1]) > 0)

# %% [markdown]
# The same roll with shells and hexahedra, which share only the material with the Fourier elements:

# %%
coarse = {"mesh.discretisation": "three_dimensional", "mesh.circumferential": 12, "mesh.axial": 12, "modal.count": 2}
space = bending(wf.run(roll.changed(coarse)))
print(f"G = 1 GPa: {space:.2f} Hz in three dimensions, {frequencies[-2]:.2f} Hz by Fourier elements")
assert np.isclose(space, frequencies[-2], rtol=0.01)

# %% [markdown]
# ## The roll of the experiment: modulus of Kapton (Fig. 2.17)
#
# Reported moduli of Kapton range from 2.5 to 4 GPa. On a polycarbonate tube the frequencies of a soft and a stiff coil
# differ by tens of hertz. With a shear modulus below a few hundred kilopascals the frequency is lower than that of the
# mandrel alone, since the coil then adds more mass than stiffness.

# %%
kapton = wf.load_case("../configs/kapton_roll.yaml", ["mesh.discretisation=fourier", "modal.count=12"])
alone = wf.load_case("../configs/kapton_mandrel.yaml", ["mesh.discretisation=fourier", "modal.count=2"])
shear = [1e4, 1e9] if quick else [1e4, 1e5, 1e6, 1e7, 1e8, 1e9]
keys = {"coil.material.E_theta": [2.5e9, 4e9], "coil.material.G_r_theta": shear}
band = wf.run_series(kapton, keys, reference=alone)
wf.plot.frequency_over_shear_stiffness_band(band)
plt.show()

# %% [markdown]
# ## The map of mandrels (Fig. 2.16)
#
# For every mandrel the stiffest coil is that of the case, and the softest is the one with the lowest shear modulus
# whose fundamental mode is still bending. The disparity is the difference of their bending frequencies.

# %%
radii, walls = ([0.02, 0.05], [1e-3, 3.2e-3]) if quick else ([0.02, 0.035, 0.05], [1e-3, 2e-3, 3.2e-3])
sizes = {"design_map.mandrel_radius": radii, "design_map.mandrel_thickness": walls}
mapped = wf.load_case("../configs/design_map.yaml").changed(sizes)
result = wf.run(mapped)
wf.plot.design_map(result)
plt.show()

disparity = result["frequency_disparity"].transpose("mandrel_radius", "mandrel_thickness")
assert (disparity.diff("mandrel_radius") > 0).all()
assert (disparity.diff("mandrel_thickness") < 0).all()

# %% [markdown]
# Modal analyses check the mandrel of the case: the stiffest coil and the softest, where bending and torsion have the
# same frequency. With a shear modulus 1 % higher the fundamental mode must be bending, with 10 % less another mode.

# %%
numbers = wf.summarise(result)
sections = {name: getattr(mapped, name) for name in ("geometry", "mandrel", "coil", "mesh")}
single = wf.Case(analysis="modal", modal={"count": 6}, **sections)
softest = numbers["loosest_shear_modulus_pa"]


def with_shear(modulus):
    """Modes of the mandrel of the case with a given interlayer shear modulus."""
    return wf.run(single.changed({"coil.material.G_r_theta": modulus, "coil.material.G_r_z": modulus}))


stiff, soft, below = (wf.run(single), *(with_shear(factor * softest) for factor in (1.0, 0.9)))
print(f"stiffest {numbers['f_tightest_hz']:.2f} Hz, softest ({softest:.0f} Pa) {numbers['f_loosest_hz']:.2f} Hz")
print(f"10 % softer: fundamental mode {below['mode_kind'].values[0]}, {float(below['mode_frequency'][0]):.1f} Hz")
assert np.isclose(bending(stiff), numbers["f_tightest_hz"], rtol=1e-6)
assert np.isclose(bending(soft), numbers["f_loosest_hz"], rtol=1e-6)
assert soft["mode_kind"].values[0] == "bending"
assert below["mode_kind"].values[0] != "bending"
