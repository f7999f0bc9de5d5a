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
# # Choosing a mandrel for a coil that does not slip
#
# While nothing slips, a coil is a solid whose wraps shear against each other: how stiffly, winding tension decides.
# That shear stiffness is the least known number of a roll, and it moves the bending frequency. A good mandrel for an
# experiment is one on which a loose and a tight coil are far apart (section 2.5 of the thesis); a good mandrel for
# flight is one on which they are close.
#
# **What is solved**: modes of mandrel and homogenised coil in harmonics around the axis (`mesh.discretisation:
# fourier`), 0.7 s each.
#
# **Against what it is compared**: beam theory below (coil as mass alone) and above (no shear between the wraps);
# shells and hexahedra in three dimensions at one point; the map with modal analyses of its own cases.

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
# ## Frequency over shear stiffness (Fig. 2.13)
#
# `run_series` runs every combination of keys; the figures of a study take its list. G of 1 GPa is that of a coil as
# tight as a solid block, 10 kPa that of one which hardly holds together.

# %%
moduli = [1e4, 1e6, 1e8, 1e9] if quick else [1e4, 1e5, 1e6, 1e7, 5e7, 1e8, 3e8, 1e9]
series = wf.run_series(roll, {"coil.material.G_r_theta": moduli}, reference=mass_alone)  # G_r_z follows
wf.plot.frequency_over_shear_stiffness(series)
plt.show()

# %% [markdown]
# Both ends by beam theory. Below: the mandrel bends and the coil is only carried, $f = (1.875^2/2\pi)\,\sqrt{EI/(m
# L^4)}$. Above: plane sections across mandrel and coil, $EI = E_a I_a + E_z I_c$. A real roll stays under that: the
# coil stands free on its base, so that it is strained only as far as shear between the wraps pulls it along.

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
print(f"tightest coil: {frequencies[-2]:.2f} Hz, by beam theory without shear {highest:.2f} Hz")
assert np.isclose(frequencies[-1], lowest, rtol=0.01)
assert frequencies[0] < frequencies[-2] < highest
assert np.all(np.diff(frequencies[:-1]) > 0)

# %% [markdown]
# The same roll with shells and hexahedra, which share only the material with the harmonics:

# %%
coarse = {"mesh.discretisation": "three_dimensional", "mesh.circumferential": 12, "mesh.axial": 12, "modal.count": 2}
space = bending(wf.run(roll.changed(coarse)))
print(f"G = 1 GPa: {space:.2f} Hz in three dimensions, {frequencies[-2]:.2f} Hz in harmonics")
assert np.isclose(space, frequencies[-2], rtol=0.01)

# %% [markdown]
# ## The roll of the experiment: which Kapton? (Fig. 2.17)
#
# Reported moduli of Kapton range from 2.5 to 4 GPa. Between a loose and a tight coil on a polycarbonate tube lie tens
# of hertz; a coil looser than a few hundred kilopascals is slower than the mandrel without any coil, since it then
# brings more mass than stiffness.

# %%
kapton = wf.load_case("../configs/kapton_roll.yaml", ["mesh.discretisation=fourier", "modal.count=12"])
alone = wf.load_case("../configs/kapton_mandrel.yaml", ["mesh.discretisation=fourier", "modal.count=2"])
shear = [1e4, 1e6, 1e9] if quick else [1e4, 1e5, 1e6, 1e7, 1e8, 1e9]
keys = {"coil.material.E_theta": [2.5e9, 4e9], "coil.material.G_r_theta": shear}
band = wf.run_series(kapton, keys, reference=alone)
wf.plot.frequency_over_shear_stiffness_band(band)
plt.show()

# %% [markdown]
# ## The map of mandrels (Fig. 2.16)
#
# For every mandrel the tightest coil is the one of the case, and the loosest the softest whose lowest mode is still
# bending. What lies between them is the disparity.

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
# What the map says of the case's own mandrel, checked by modal analyses: the tightest coil, the loosest, and one that
# is a tenth looser still, whose lowest mode must be another than bending.

# %%
numbers = wf.summarise(result)
sections = {name: getattr(mapped, name) for name in ("geometry", "mandrel", "coil", "mesh")}
single = wf.Case(analysis="modal", modal={"count": 6}, **sections)
loosest = numbers["loosest_shear_modulus_pa"]


def with_shear(modulus):
    """Modes of the own mandrel with a shear modulus between the wraps."""
    return wf.run(single.changed({"coil.material.G_r_theta": modulus, "coil.material.G_r_z": modulus}))


tight, loose, looser = wf.run(single), with_shear(loosest), with_shear(0.9 * loosest)
print(f"tightest {numbers['f_tightest_hz']:.2f} Hz, loosest ({loosest:.0f} Pa) {numbers['f_loosest_hz']:.2f} Hz")
print(f"a tenth looser: lowest mode {looser['mode_kind'].values[0]}, {float(looser['mode_frequency'][0]):.1f} Hz")
assert np.isclose(bending(tight), numbers["f_tightest_hz"], rtol=1e-6)
assert np.isclose(bending(loose), numbers["f_loosest_hz"], rtol=1e-6)
assert loose["mode_kind"].values[0] == "bending"
assert looser["mode_kind"].values[0] != "bending"
