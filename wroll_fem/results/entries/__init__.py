"""Entries of summary.json of single analyses."""
