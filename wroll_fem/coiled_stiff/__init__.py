"""Homogenised solid coil without slip ("coiled stiff"): modal shear stress, steady response, predicted slip."""
