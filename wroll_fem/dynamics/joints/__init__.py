"""Discrete joints between degrees of freedom: friction elements, nonlinear springs and stops.

A joint acts on the difference of two displacements (or on any row of displacements), in N and m, without area and
without additional degrees of freedom. In the `System` it is an interface whose points have the area 1 m^2, so that Pa
stand for N. A constant normal force is a contact pressure whose normal row is zero.
"""

from wroll_fem.dynamics.joints.assembly import joint_force, with_joints
from wroll_fem.dynamics.joints.elastic import Gap, Spring
from wroll_fem.dynamics.joints.force import Force
from wroll_fem.dynamics.joints.friction import BoucWen, Coulomb, Friction, Iwan, Jenkins
from wroll_fem.dynamics.joints.joint import Joint

__all__ = [
    "BoucWen",
    "Coulomb",
    "Force",
    "Friction",
    "Gap",
    "Iwan",
    "Jenkins",
    "Joint",
    "Spring",
    "joint_force",
    "with_joints",
]
