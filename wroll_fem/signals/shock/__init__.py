"""Shocks: pulses, shock response spectra, synthesis of a shock from its spectrum."""
