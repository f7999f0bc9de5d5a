"""Homogenised solid coil without slip ("coiled stiff"): modal shear stress, steady-state response, slip criterion."""
