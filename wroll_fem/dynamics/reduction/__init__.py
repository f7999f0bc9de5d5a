"""Exact condensation on the contact degrees of freedom, and reduced-order models."""
