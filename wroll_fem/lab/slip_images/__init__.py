"""Slip from high-speed images: targets on mandrel and layers, tracked from frame to frame (thesis, section 3.5)."""
