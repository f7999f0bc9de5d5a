"""Everything that needs dolfinx: shells, solids, constraints, bodies and their natural frequencies."""
