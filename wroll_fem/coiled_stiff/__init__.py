"""Homogenised solid coil without slip ("coiled stiff"): shear stress of its modes, response, predicted slip."""
