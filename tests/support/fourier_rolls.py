"""Half planes, models and cases of rolls with Fourier elements."""

import numpy as np

from wroll_fem.bodies.materials import CylindricalOrthotropic
from wroll_fem.case import Case
from wroll_fem.fem.fourier import COIL, WALL, FourierModel
from wroll_fem.mesh.axisymmetric import AxisymmetricMesh

E, NU, RHO, L = 2.7e9, 0.35, 1200.0, 0.3
PLASTIC = CylindricalOrthotropic.isotropic(E, NU, RHO)
WEB = CylindricalOrthotropic(4e9, 3e9, 0.04e9, 0.35, 0.3, 0.25, 1.4e9, 0.3e9, 0.5e9, 1400.0)


def half_plane(inner=0.01, wall=0.02, outer=0.03, length=L, cells=(1, 1, 4)):
    n_wall, n_coil, n_z = cells
    radii = np.concatenate([np.linspace(inner, wall, n_wall + 1), np.linspace(wall, outer, n_coil + 1)[1:]])
    return AxisymmetricMesh(radii, np.linspace(0.0, length, n_z + 1), n_wall)


def model(where=None, wall=PLASTIC, coil=WEB, degree=3):
    made = FourierModel(half_plane() if where is None else where, degree)
    made.set_material(WALL, wall.stiffness(), wall.rho)
    made.set_material(COIL, coil.stiffness(), coil.rho)
    return made


def case(*overrides, coil=None):
    given = {
        "analysis": "modal",
        "geometry": {"length": L, "mandrel_outer_diameter": 0.080, "mandrel_thickness": 1.5e-3},
        "mandrel": {"material": {"E": E, "nu": NU, "rho": RHO}, "tip_mass": 0.05},
        "coil": coil or {"model": "none"},
        "mesh": {"axial": 8, "grading": 1, "radial": 1, "radial_grading": 1, "discretisation": "fourier"},
    }
    return Case.model_validate(given).changed(*overrides)


def kapton(model="solid", **changed):
    # every constant of the web; changed ones by name
    constants = {
        "kind": "cylindrical_orthotropic", "E_theta": 4e9, "E_z": 4e9, "E_r": 0.04e9, "nu_theta_z": 0.35,
        "nu_theta_r": 0.35, "nu_z_r": 0.35, "G_z_theta": 1.48e9, "G_r_theta": 1.48e9, "G_r_z": 1.48e9, "rho": 1400.0,
    }  # fmt: skip
    return {"model": model, "thickness": 1.25e-3, "base": "free", "material": constants | changed}
