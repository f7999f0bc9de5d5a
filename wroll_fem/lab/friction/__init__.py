"""Friction laws fitted to shear tests."""
