"""Margins of a finished run: stress against yield."""
