"""Motions in the span of a quasi-static load path: modes, what they lack, and time stepping."""
