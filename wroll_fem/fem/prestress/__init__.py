"""Second-order stiffness of a preloaded roll: geometric stiffness of its shells, linear buckling."""
