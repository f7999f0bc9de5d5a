"""The homogenised solid coil without slip: shear stress of its modes, response, where it would slip."""
