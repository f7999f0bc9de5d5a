"""Periodic motions: response curves and backbones by harmonic balance."""
