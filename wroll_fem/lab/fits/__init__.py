"""Fits of models to families of measured resonances."""
