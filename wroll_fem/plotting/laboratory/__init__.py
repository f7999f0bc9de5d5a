"""Figures of laboratory evaluations, one file per kind."""
