"""Helpers shared by several tests: exact systems, synthetic rolls, fake analyses, paths."""
