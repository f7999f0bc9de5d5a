"""Exact condensation on the contact points, and reduced-order models."""
